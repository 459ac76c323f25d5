/*
 * shadow: the shadow maps that a view needs. What each sees, where it lies, and which lights have some.
 *
 * Pages      Maps lie in square pages of equal side, the layers of one image. A directional light's map fills one;
 *            those of other lights share pages, in sizes that are powers of two.
 * Cascades   A directional light has several maps. The last one holds the whole scene, so that nothing is ever
 *            without shadow, or, with a distance, as much as lies nearer than that; the others spheres around ever
 *            smaller parts of the camera's frustum. A sphere's size depends on the camera's lens alone, and its map
 *            moves by whole texels: so a point that stands still is drawn into the same place of a texel, whatever the
 *            camera does. It ends at a distance from the camera that the sphere holds; its depth ends below the sphere.
 * Objects    With `objects` a directional light has one map, around some things near the camera and nothing else
 *            (stilb_shadow_view.near). Whatever they throw shadows on gets them, as the map's sides lie along the
 *            light; along its sides, and where `distance` ends, shadows fade. The sphere grows by steps of a quarter.
 * Casters    Of the maps that follow the camera are those models that may throw a shadow on what it sees.
 * Lamps      A spot has one map, unless its cone is wider than 120 degrees; other lamps have six, of a cube's sides. A
 *            map has as many texels as the lamp's reach has pixels in the picture, to the next power of two. What does
 *            not fit is made smaller, all by the same factor; only where maps of 64 texels are too many does a lamp
 *            have none, the ones that are seen smallest first, and it is counted. Nothing is lost in one frame: a
 *            lamp's shadow fades before its maps go, while it shrinks in the picture. What lies nearer to a lamp than a
 *            hundredth of a metre, or a thousandth of its reach if that is less, casts no shadow.
 *            With `keep` a map has its size and place of the plan before as long as it has 0.9 to 2.2 times the texels
 *            that are wanted, and in each plan at most four lamps change theirs, unless there is no room.
 * Order      Maps depend on the arguments, and with `keep` on the plan before, alone: the same for any number of
 *            workers.
 * Threads    [one-writer] for each plan.
 * Sources    Dimitrov, "Cascaded Shadow Maps" (2007); Valient, "Stable Rendering of Cascaded Shadow Maps" (2008), for
 *            spheres and whole texels.
 */
#ifndef STILB_SHADOW_H
#define STILB_SHADOW_H

#include "base/base.h"
#include "base/base_math.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_SHADOW_MIN_SIZE 64u /* texels of a map's side */
#define STILB_SHADOW_MAX_CASCADES 8u
#define STILB_SHADOW_MAX_PAGES 256u

typedef struct stilb_shadow_desc {
	uint32_t page;     /* texels of a page's side: a power of two, 64..8192 */
	uint32_t pages;    /* how many there may be, 1..STILB_SHADOW_MAX_PAGES */
	uint32_t maps;     /* how many maps there may be, >= 1 */
	uint32_t cascades; /* of each directional light, 1..STILB_SHADOW_MAX_CASCADES */
	bool objects;      /* of directional lights: the map is that of near things; cascades is 1, distance > 0 */
	float distance;    /* of directional lights: metres from the camera where shadows have faded out; 0: nowhere */
	uint32_t filter;   /* texels beside a place that are read with it, 1..3 */
	float fade;        /* of lamps: pixels that a lamp's reach has in the picture where its shadow has faded out, >= 0;
	                      from twice as many on it is whole */
	bool keep;         /* lamps' maps stay where the plan had them before, in sizes near those wanted */
} stilb_shadow_desc;

/* What is seen, and of what. */
typedef struct stilb_shadow_view {
	stilb_mat4 view_projection; /* as of stilb_render_view */
	float camera_position[3];
	uint32_t height;     /* of the picture, pixels, >= 1 */
	stilb_sphere bounds; /* around all that casts and gets shadows; radius > 0 and finite */
	stilb_sphere near;   /* with desc.objects: around what casts them; radius > 0, or 0: nothing does */
	bool others;         /* other views read the maps, too: also lamps that this one does not see have some */
} stilb_shadow_view;

#define STILB_SHADOW_CASTER_PLANES 10u /* of a pyramid swept along a line: five faces and edges at most */

typedef struct stilb_shadow_map {
	stilb_mat4 view_projection; /* world to clip space: depth 1 is near the light, 0 far */
	float eye[3];               /* the light's place; of a directional light far away */
	uint32_t light;             /* index among the view's */
	uint16_t page, area[4];     /* left, top, width, height in the page, texels */
	float blend;                /* of a cascade: texels at its sides, inside of the filter's, where the next one takes
	                               over; of the last one 0, or where shadows fade out */
	/* [caster_count] what lies behind one of these throws no shadow on what the view sees; 0: all that the map sees is
	 * drawn. They hold somewhat more, so that a map can stay while the camera turns. Not of the map that holds all. */
	stilb_plane casters[STILB_SHADOW_CASTER_PLANES];
	uint32_t caster_count;
	float caster_margin; /* metres beside what is seen that are read, too */
	float far; /* of a cascade: metres from the camera where it ends; of the last one 0, or where shadows end */
} stilb_shadow_map;

/* The maps of a light, first .. first + count - 1: cascades in their order; one; or six: +X -X +Y -Y +Z -Z. count 0: it
 * has none. */
typedef struct stilb_shadow_of {
	uint32_t first, count;
	float faded;   /* the share of its shadow that has gone, 0 <= faded < 1 */
	bool left_out; /* it is seen, and there was no room for its maps */
} stilb_shadow_of;

/* {0} is empty. */
typedef struct stilb_shadow_plan {
	stilb_shadow_map *maps;  /* [map_count] those of a light follow each other */
	stilb_shadow_of *lights; /* [light_count] */
	uint32_t map_count, light_count, page_count;
	uint32_t left_out; /* lights that are seen, and there was no room for their maps */
	uint32_t faded;    /* lamps that are seen, so small that their shadows have faded out */
	uint32_t halved;   /* how often the sizes of lamps' maps were halved to fit */
	struct shadow_lamp *lamps;
	struct shadow_place *places, *next_places; /* of lamps; of the plan before, scratch */
	uint32_t place_count, first_page, page;    /* of lamps; a page's side */
} stilb_shadow_plan;

/* Plans the maps of lights[0 .. count - 1], which have no mistake (stilb_scene_light_mistake). BAKED ones, dark ones,
 * and those that reach nothing that the view sees have none. STILB_ERROR_MEMORY: the plan is empty. [one-writer] */
stilb_result stilb_shadow_plan_make(stilb_shadow_plan *plan, const stilb_shadow_desc *desc,
                                    const stilb_shadow_view *view, const stilb_scene_light *lights, uint32_t count);

/* True if casters that were chosen for `kept`, an earlier map that is `now` but for them, are enough for the view, for
 * which `now` was planned. [any-thread] */
bool stilb_shadow_casters_hold(const stilb_shadow_map *kept, const stilb_shadow_map *now,
                               const stilb_shadow_view *view);

/* True if a sphere may throw a shadow into the map that the view sees, as far as its casters say. [any-thread] */
bool stilb_shadow_casters_have(const stilb_shadow_map *map, stilb_sphere sphere);

/* Frees it and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_shadow_plan_finish(stilb_shadow_plan *plan);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
