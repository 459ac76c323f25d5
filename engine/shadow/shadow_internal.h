/* What the files of shadow share. */
#ifndef STILB_SHADOW_INTERNAL_H
#define STILB_SHADOW_INTERNAL_H

#include "shadow/shadow.h"

#define SHADOW_BLEND 0.1f /* of a cascade's side: where the next one takes over */
#define SHADOW_LOSS 0.2f  /* of its size in the picture: along which a lamp loses its shadow where maps are too few */

/* A light with maps of its own size. */
typedef struct shadow_lamp {
	uint32_t light, maps; /* maps: 1 or 6 */
	uint32_t size;        /* texels of each map's side */
	float seen;           /* pixels that its reach has in the picture */
	float faded;          /* of stilb_shadow_of */
} shadow_lamp;

/* Where a lamp's maps lie: each from a square of STILB_SHADOW_MIN_SIZE on, which are numbered along the Z curve of the
 * lamps' first page, and so on. */
typedef struct shadow_place {
	uint32_t light, maps, size;
	uint32_t placed; /* how many of them are */
	uint64_t squares[6];
} shadow_place;

/* Squares of each of its maps. */
static inline uint64_t shadow_place_squares(const shadow_place *place)
{
	uint64_t side = place->size / STILB_SHADOW_MIN_SIZE;
	return side * side;
}

/* ---- shadow_keep.c ---- */

/* Writes the sizes and places of lamps[0 .. count - 1]: those of the plan before where these may stay. False: there is
 * no room for them so. */
bool shadow_keep(const stilb_shadow_plan *plan, shadow_lamp *lamps, uint32_t count, uint64_t room,
                 shadow_place *places);

/* ---- shadow_sun.c ---- */

/* Writes the matrices and the blends of a directional light's desc->cascades maps, each as large as a page. */
void shadow_sun_fit(const stilb_shadow_desc *desc, const stilb_shadow_view *view, const float direction[3],
                    stilb_shadow_map *maps);

/* The camera's direction and how wide it sees; false: its picture is a parallel projection, which has no width that
 * grows. */
bool shadow_lens(const stilb_shadow_view *view, double ahead[3], double *slant);

/* ---- shadow_casters.c ---- */

/* Writes the casters of a map that follows the camera, of a light in this direction, and where it ends. margin: metres
 * beside what is seen that the filter reads; room: metres by which the camera may move and the casters are still
 * enough. */
void shadow_casters_choose(const stilb_shadow_view *view, const float direction[3], float far, float margin, float room,
                           stilb_shadow_map *map);

/* ---- shadow_local.c ---- */

/* Texels that a lamp's map should have, if sizes are halved so often. */
float shadow_lamp_wanted(const shadow_lamp *lamp, uint32_t halved);

/* False: the light has no maps. frustum: the view's. Sets maps and seen. */
bool shadow_lamp_of(const stilb_shadow_view *view, const stilb_frustum *frustum, const stilb_scene_light *light,
                    shadow_lamp *lamp);
/* The matrix of map number `index` of the lamp, of lamp->size texels. */
stilb_mat4 shadow_lamp_fit(const stilb_shadow_desc *desc, const stilb_shadow_view *view, const stilb_scene_light *light,
                           const shadow_lamp *lamp, uint32_t index);

/* ---- both ---- */

/* Two unit vectors that are perpendicular to a unit one and to each other. */
static inline void shadow_axes(const float along[3], float right[3], float up[3])
{
	int least = 0;
	for (int i = 1; i < 3; i++)
		if (__builtin_fabsf(along[i]) < __builtin_fabsf(along[least]))
			least = i;
	stilb_vec3 a = stilb_vec3_make(along[0], along[1], along[2]);
	stilb_vec3 other = stilb_vec3_make(least == 0 ? 1.0f : 0.0f, least == 1 ? 1.0f : 0.0f, least == 2 ? 1.0f : 0.0f);
	stilb_vec3 r = stilb_vec3_normalize(stilb_vec3_cross(other, a)), u = stilb_vec3_cross(a, r);
	for (int i = 0; i < 3; i++) {
		right[i] = r[i];
		up[i] = u[i];
	}
}

#endif
