/*
 * gi_film: what every pixel has gathered so far, and the picture made of it.
 *
 * Sums are kept in double, so that a sample more or less at a time, or a checkpoint in between, changes no bit; what is
 * read, the planes, is float and written by gi_film_resolve.
 * Threads.  A pixel has one writer at a time (its tile's job). gi_film_preview: [any-thread], while others write.
 */
#ifndef GI_FILM_H
#define GI_FILM_H

#include "base/base_math.h"
#include "gi/gi_render.h"

#include <stdatomic.h>

/* Sums over samples 0 .. samples - 1, in that order. */
typedef struct gi_film_pixel {
	double radiance[3], radiance_squared[3]; /* weighted, where samples have weights */
	double albedo[3], normal[3];
	double depth; /* of those that hit something */
	uint32_t samples, hits;
} gi_film_pixel;

/* What weighted samples need besides. The radiance sums are those of weight x radiance then. */
typedef struct gi_film_weight {
	double weight, weight_squared;
	double product[3]; /* weight x (weight x radiance) */
} gi_film_weight;

#define GI_FILM_LARGEST_BLOCK 32u /* pixels, a side: the coarsest grid of a progressive picture */

typedef struct gi_film {
	uint32_t width, height;
	gi_film_pixel *pixels;
	gi_film_weight *weights; /* NULL: every sample weighs 1 */

	/* The planes; the atomic ones are read while they are written. */
	_Atomic float *radiance;
	_Atomic uint32_t *samples;
	float *albedo, *normal, *depth, *variance;
} gi_film;

/* One sample. */
typedef struct gi_film_sample {
	stilb_vec3 radiance;
	const float *albedo, *normal; /* [3] */
	float depth;                  /* +infinity: nothing was hit */
} gi_film_sample;

/* All black and without samples. Then film is {0} on STILB_ERROR_MEMORY. */
stilb_result gi_film_create(gi_film *film, uint32_t width, uint32_t height, bool weighted);

/* Accepts {0}. */
void gi_film_finish(gi_film *film);

/* The pixel's next sample. False: its radiance was no finite number and counts as black. */
bool gi_film_add(gi_film *film, size_t pixel, const gi_film_sample *sample);

/* Brings the planes of a pixel up to its sums. */
void gi_film_resolve(gi_film *film, size_t pixel);

/* Square root of the mean variance of the picture's numbers, relative to their mean: an estimate of the relative RMSE.
 * +infinity where a pixel has less than two samples; 0 for a black picture. Not while pixels are written. */
double gi_film_error(const gi_film *film);

/* stilb_gi_render_preview. */
void gi_film_preview(const gi_film *film, float *rgb);

#endif
