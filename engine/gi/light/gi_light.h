/*
 * gi_light: all light sources of a scene: emitting triangles, the list of lights, the surroundings. [any-thread]
 *
 * Lights are asked in groups, each with a ray of its own: which of several groups to ask would be one more guess, whose
 * noise costs more than the rays. All groups together can find each direction from which emitted light arrives, in
 * exactly one way. If a ray finds such a direction by chance instead, gi_light_pdf (it hit an emitter) or
 * gi_environment_pdf (it hit nothing) tells with which density gi_light_sample_at chooses it: multiple importance
 * sampling needs that.
 */
#ifndef STILB_GI_LIGHT_H
#define STILB_GI_LIGHT_H

#include "base/base.h"
#include "base/base_math.h"
#include "gi/light/gi_glow.h"
#include "gi/light/gi_light_tree.h"
#include "scene/scene.h"

/* An emitting triangle in world space; it emits from its front. */
typedef struct gi_emitter {
	float position[3][3];
	float emission[3]; /* radiance, the mean of the glow if there is one; 0: it is never sampled */
	gi_glow glow;
	bool unmet; /* rays towards lights go through it: gi_part.mask */
} gi_emitter;

typedef enum gi_light_group {
	GI_LIGHT_PLACED, /* those that have a position: one of them is asked */
	GI_LIGHT_SUNS,   /* the directional lights of the list: one of them is asked */
	GI_LIGHT_AROUND, /* the surroundings */
	GI_LIGHT_GROUPS,
} gi_light_group;

typedef struct gi_lights {
	struct gi_light_shape *shapes; /* one for each emitting triangle, or for two that make a rectangle */
	uint32_t shape_count, emitter_count;
	gi_glow *glows;                 /* of those shapes that have one, in their order */
	uint32_t *shape_of;             /* [emitter_count] index in shapes of each emitting triangle's shape */
	struct gi_light_listed *listed; /* the lights of the scene's list that shine and have no face */
	uint32_t listed_count;
	gi_light_tree tree;    /* of the lights that have a position */
	uint32_t placed_count; /* lights that have a position: the tree's leaves */
	uint32_t *leaf_of;     /* [shape_count] index in tree.nodes */
	uint32_t *suns;        /* indices in listed of directional lights */
	uint32_t sun_count;
	struct gi_environment *environment; /* never NULL; black if there are no surroundings */
	bool shares_environment;            /* with other gi_lights, which own it */
} gi_lights;

/* emitters: the triangles of all parts whose material emits, in the order of their light numbers; one of area 0 is
 * never sampled. From scene come lights and surroundings; the panorama's pixels must outlive lights.
 * A light with a face is left out, since the triangles of its face are among emitters.
 * Errors: STILB_ERROR_MEMORY; STILB_ERROR_ARGUMENT: the panorama has no floats. Then lights is {0}. */
stilb_result gi_lights_create(const stilb_scene *scene, const gi_emitter *emitters, uint32_t emitter_count,
                              gi_lights *lights);

/* The lights of stilb_gi_settings.no_shadows: the list with the lights that have a face, and the surroundings, which
 * are those of lights and must outlive open; no emitting triangles. STILB_ERROR_MEMORY; then open is {0}. */
stilb_result gi_lights_create_open(const stilb_scene *scene, const gi_lights *lights, gi_lights *open);

/* Accepts {0}. */
void gi_lights_destroy(gi_lights *lights);

typedef struct gi_light_sample {
	stilb_vec3 direction; /* unit, from the surface to the light */
	float distance;       /* t_max for the shadow ray: to just before the light; +infinity for distant lights */
	/* towards the surface, W sr^-1 m^-2; of a light without a size: irradiance on a surface that faces it, W m^-2 */
	stilb_vec3 radiance;
	/* per steradian, including the choice in the group; of a light without a size: the probability of that choice */
	float pdf;
	bool delta; /* no ray can hit it, so its MIS weight is 1: a light of the list, or an emitter that is unmet */
} gi_light_sample;

/* True if there is something to ask in the group. all: asking finds all that is around; else rays that the surface
 * reflects find it as well, and what they find anyway is left to them: two colours, and of a panorama what is no
 * brighter than its mean. */
bool gi_light_is_asked(const gi_lights *lights, gi_light_group group, bool all);

/* Samples one light of a group that has any. False: it sends nothing to this point. u_choice and u in [0, 1). position:
 * the origin of the shadow ray. normal: of the surface, unit, on the lit side. all: as of gi_light_is_asked. */
bool gi_light_sample_at(const gi_lights *lights, gi_light_group group, bool all, stilb_vec3 position, stilb_vec3 normal,
                        float u_choice, stilb_vec2 u, gi_light_sample *sample);

/* gi_light_sample_at of GI_LIGHT_PLACED in two steps. The first chooses a light and returns its number, with the
 * probability of that choice, or GI_LIGHT_LEAF: none sends anything to this point. */
uint32_t gi_light_choose(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, float u_choice,
                         float *probability);

/* The shape of the light, if it is a rectangle of triangles that emit: gi_lanes.h samples it; else NULL. */
const struct gi_light_shape *gi_light_rectangle(const gi_lights *lights, uint32_t light);

/* The second step; sample->pdf does not include the choice. */
bool gi_light_sample_chosen(const gi_lights *lights, uint32_t light, stilb_vec3 position, stilb_vec2 u,
                            gi_light_sample *sample);

/* The density, per steradian, with which gi_light_sample_at chooses the direction of a ray from position that hit
 * the front of emitter `light`, < emitter_count, at this distance. */
float gi_light_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, uint32_t light, float distance);

/* The density, per steradian, with which gi_light_sample_at chooses the direction of a ray that hit nothing; 0 if
 * gi_light_is_asked with this `all` says that it does not. */
float gi_environment_pdf(const gi_lights *lights, stilb_vec3 normal, stilb_vec3 direction, bool all);

/* Radiance of the surroundings from a unit direction. */
stilb_vec3 gi_environment_radiance(const gi_lights *lights, stilb_vec3 direction);

#endif
