/*
 * gi_environment: light from where no triangle is: black, two colours, or a map of latitude and longitude. Used by
 * gi_light.c alone, and by tests. [any-thread] once made.
 *
 * A map's texel has one radiance all over (as in numeric_sh.h), and is chosen as often as it is bright and large in the sky: the
 * density is then its brightness over the sum of all. Two colours are asked for about the surface's normal, as often as the
 * cosine is large: a map that is spread evenly would be worse off than the surface's own choice of directions.
 */
#ifndef STILB_GI_ENVIRONMENT_H
#define STILB_GI_ENVIRONMENT_H

#include "base/base_math.h"
#include "gi/light/gi_light.h"

typedef struct gi_environment {
	stilb_vec3 sky, ground; /* without a map */
	const float *map;       /* [height][width][channels], or NULL */
	uint32_t width, height, channels;
	float *rows;    /* [height]: the share of this row and those above it in all the light */
	float *columns; /* [height][width]: the same in a row */
	float density;  /* of a texel of brightness 1, sr^-1 */
	float mean;     /* brightness over all directions */
} gi_environment;

/* STILB_ERROR_ARGUMENT for a map that is not of floats, STILB_ERROR_MEMORY; then *out is NULL. */
stilb_result gi_environment_create(const stilb_scene *scene, gi_environment **out);
void gi_environment_destroy(gi_environment *environment);

stilb_vec3 gi_environment_at(const gi_environment *environment, stilb_vec3 direction);

/* Fills direction, distance, radiance and pdf (without the choice); false: it is black there. */
bool gi_environment_sample(const gi_environment *environment, stilb_vec3 normal, stilb_vec2 u, gi_light_sample *sample);

/* Irradiance that it may give to a surface. */
float gi_environment_importance(const gi_environment *environment, stilb_vec3 normal);

/* The density with which sample chooses the direction. */
float gi_environment_density(const gi_environment *environment, stilb_vec3 normal, stilb_vec3 direction);

#endif
