/*
 * gi_environment: light from directions without triangles: none, two colours, or a map in latitude and longitude.
 * For gi_light.c and tests. [any-thread] once created.
 *
 * A map's texel has constant radiance, as in numeric_sh.h, and is chosen with a probability proportional to its weight
 * times its solid angle; so the density of a direction is its weight over the integral of weights. The weight is the
 * texel's brightness; or, where rays that surfaces reflect find what is around them as well, how much brighter than the
 * mean it is: what is left to these rays they would find anyway, and questions go where they would rarely go.
 * Source: Karlik et al., "MIS Compensation" (2019), 5.2.
 * Two colours (sky and ground) are sampled about the surface's normal with a density proportional to the cosine: that
 * gives less noise than treating them as a map.
 */
#ifndef STILB_GI_ENVIRONMENT_H
#define STILB_GI_ENVIRONMENT_H

#include "base/base_math.h"
#include "gi/light/gi_light.h"

/* How texels of a map are chosen. */
typedef struct gi_environment_choice {
	float *rows;    /* [height] share of all weight that is in this row and those above it; the last is 1 */
	float *columns; /* [height][width] share of a row's weight that is in this texel and those left of it */
	float density;  /* of sampling a direction, per steradian, where the weight is 1; 0: no texel has any */
	float floor;    /* the weight of a texel is its brightness less this, and not below 0 */
} gi_environment_choice;

typedef struct gi_environment {
	stilb_vec3 sky, ground; /* radiance above and below the horizon, if there is no map */
	const float *map;       /* [height][width][channels] radiance, or NULL */
	uint32_t width, height, channels;
	float sine, cosine;               /* of the map's rotation about +Y */
	gi_environment_choice choices[2]; /* of a map: [0: by brightness; 1: by what is above the mean] */
	float mean;                       /* mean brightness over all directions */
} gi_environment;

/* Errors: STILB_ERROR_ARGUMENT: a map that is not of floats; STILB_ERROR_MEMORY. Then *out is NULL. */
stilb_result gi_environment_create(const stilb_scene *scene, gi_environment **out);
void gi_environment_destroy(gi_environment *environment);

stilb_vec3 gi_environment_at(const gi_environment *environment, stilb_vec3 direction);

/* True if there is something to sample. all: by brightness; else what is above the mean alone, which of two colours is
 * nothing. */
bool gi_environment_is_sampled(const gi_environment *environment, bool all);

/* Samples a direction where there is something: fills sample's direction, distance, radiance and pdf. False: it is
 * black there. u in [0, 1)^2. */
bool gi_environment_sample(const gi_environment *environment, bool all, stilb_vec3 normal, stilb_vec2 u,
                           gi_light_sample *sample);

/* The density of gi_environment_sample for a direction, per steradian. */
float gi_environment_density(const gi_environment *environment, bool all, stilb_vec3 normal, stilb_vec3 direction);

#endif
