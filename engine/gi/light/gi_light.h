/*
 * gi_light: where light comes from: emitting triangles, lights without a size, the surroundings. [any-thread]
 *
 * Every direction that emitted light can come from is found in one way by gi_light_sample_at and, where it hits a triangle or
 * nothing, weighed by gi_light_pdf: what multiple importance sampling needs.
 */
#ifndef STILB_GI_LIGHT_H
#define STILB_GI_LIGHT_H

#include "base/base.h"
#include "base/base_math.h"
#include "scene/scene.h"

/* An emitting triangle in world space; its front shines. */
typedef struct gi_emitter {
	float position[3][3];
	float emission[3];
} gi_emitter;

#define GI_LIGHT_ENVIRONMENT UINT32_MAX

typedef struct gi_lights {
	struct gi_light_shape *shapes; /* emitting triangles; two that make a rectangle are one shape */
	uint32_t shape_count, emitter_count;
	uint32_t *shape_of;        /* [emitter_count] */
	stilb_scene_light *points; /* lights without a size; the sun among them */
	uint32_t point_count;
	struct gi_light_node *nodes; /* the tree of the lights with a place, gi_light_tree.h */
	uint32_t placed_count;
	uint32_t *leaf_of; /* [shape_count] of nodes */
	uint32_t
		*distant; /* directional lights, by their number in points, and at last GI_LIGHT_ENVIRONMENT if it shines */
	uint32_t distant_count;
	struct gi_environment *environment; /* never NULL: black where there is no light */
} gi_lights;

/* emitters: the triangles of all parts whose material emits, in the order of their light numbers; one without an area is
 * never asked. From scene come its lights, sun, sky and environment (which must stay). STILB_ERROR_MEMORY,
 * STILB_ERROR_ARGUMENT (an environment map that is no map); then lights is {0}. */
stilb_result gi_lights_create(const stilb_scene *scene, const gi_emitter *emitters, uint32_t emitter_count,
                              gi_lights *lights);

/* Accepts {0}. */
void gi_lights_destroy(gi_lights *lights);

typedef struct gi_light_sample {
	stilb_vec3 direction; /* unit, from the surface to the light */
	float distance;       /* for the shadow ray: to the light, less what that may be off; +infinity: there is no end */
	stilb_vec3 radiance;  /* towards the surface; of a light without a size: its irradiance across the beam */
	float pdf;  /* per steradian, the choice of the light included; without a size: the probability of the choice */
	bool delta; /* without a size: no other way finds it, MIS weight 1 */
} gi_light_sample;

/* Asks one light; false: it gives this point nothing. u_choice and u in [0, 1). position: the ray's origin. normal: of the
 * surface, on the side that is lit. */
bool gi_light_sample_at(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, float u_choice, stilb_vec2 u,
                        gi_light_sample *sample);

/* The density, per steradian, with which gi_light_sample_at chooses the direction of a ray from there that hit the front of
 * emitter `light` at this distance. */
float gi_light_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, uint32_t light, float distance);

/* ... and of one that hit nothing. */
float gi_environment_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, stilb_vec3 direction);

/* Radiance of the surroundings. */
stilb_vec3 gi_environment_radiance(const gi_lights *lights, stilb_vec3 direction);

#endif
