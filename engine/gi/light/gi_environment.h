/*
 * gi_environment: light from directions without triangles: none, two colours, or a map in latitude and longitude.
 * For gi_light.c and tests. [any-thread] once created.
 *
 * A map's texel has constant radiance, as in numeric_sh.h, and is chosen with a probability proportional to its
 * brightness times its solid angle; so the density of a direction is its brightness over the integral of brightness.
 * Two colours (sky and ground) are sampled about the surface's normal with a density proportional to the cosine: that
 * gives less noise than treating them as a map.
 */
#ifndef STILB_GI_ENVIRONMENT_H
#define STILB_GI_ENVIRONMENT_H

#include "base/base_math.h"
#include "gi/light/gi_light.h"

typedef struct gi_environment {
	stilb_vec3 sky, ground; /* radiance above and below the horizon, if there is no map */
	const float *map;       /* [height][width][channels] radiance, or NULL */
	uint32_t width, height, channels;
	float sine, cosine; /* of the map's rotation about +Y */
	float *rows;        /* [height] share of all light that is in this row and those above it; the last is 1 */
	float *columns;     /* [height][width] share of a row's light that is in this texel and those left of it */
	float density;      /* density of sampling a direction, per steradian, where brightness is 1 */
	float mean;         /* mean brightness over all directions */
} gi_environment;

/* Errors: STILB_ERROR_ARGUMENT: a map that is not of floats; STILB_ERROR_MEMORY. Then *out is NULL. */
stilb_result gi_environment_create(const stilb_scene *scene, gi_environment **out);
void gi_environment_destroy(gi_environment *environment);

stilb_vec3 gi_environment_at(const gi_environment *environment, stilb_vec3 direction);

/* Samples a direction: fills sample's direction, distance, radiance and pdf. False: it is black there.
 * u in [0, 1)^2. */
bool gi_environment_sample(const gi_environment *environment, stilb_vec3 normal, stilb_vec2 u, gi_light_sample *sample);

/* The density of gi_environment_sample for a direction, per steradian. */
float gi_environment_density(const gi_environment *environment, stilb_vec3 normal, stilb_vec3 direction);

#endif
