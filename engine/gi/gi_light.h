/*
 * gi_light: where light comes from: emitting triangles, lights without a size, the surroundings. [any-thread]
 *
 * Every direction that emitted light can come from is found in one way by gi_light_sample and, where it hits a triangle or
 * nothing, weighed by gi_light_pdf: what multiple importance sampling needs.
 */
#ifndef STILB_GI_LIGHT_H
#define STILB_GI_LIGHT_H

#include "base/base_math.h"
#include "scene/scene.h"

struct gi_surface;
struct stilb_gi_scene;

typedef struct gi_lights gi_lights; /* see gi_light.c's header comment; the struct follows here */

struct gi_lights {
	uint32_t count; /* triangles first, then lights without a size, then the surroundings if they shine */
	uint32_t triangle_count;
	struct gi_light_triangle *triangles;
	stilb_scene_light *points; /* point, spot, directional: the sun among them */
	uint32_t point_count;
	struct gi_environment *environment; /* never NULL: black where there is no light */
	struct gi_light_choice *choice;     /* which light to ask */
};

typedef struct gi_light_sample {
	stilb_vec3 direction; /* unit, from the surface to the light */
	float distance;       /* to it; +infinity for directional lights and the surroundings */
	stilb_vec3 radiance;  /* towards the surface; of a light without a size: its irradiance across the beam */
	float pdf;  /* per steradian, the choice of the light included; without a size: the probability of the choice */
	bool delta; /* without a size: no other way finds it, MIS weight 1 */
} gi_light_sample;

/* Asks one light; false: it gives this point nothing. u_choice and u in [0, 1). position: the ray's origin. */
bool gi_light_sample_at(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, float u_choice, stilb_vec2 u,
                        gi_light_sample *sample);

/* The density with which gi_light_sample_at chooses this direction from there: it hit triangle light `light`
 * (part's first_light + triangle) at distance; cosine is that of the light's normal and the direction back. */
float gi_light_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, uint32_t light, float distance,
                   float cosine, stilb_vec3 direction);

/* ... and it hit nothing. */
float gi_environment_pdf(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, stilb_vec3 direction);

/* Radiance of the surroundings. */
stilb_vec3 gi_environment_radiance(const gi_lights *lights, stilb_vec3 direction);

#endif
