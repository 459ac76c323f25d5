/*
 * gi_film: the sums of every pixel's samples, and the picture made of them: planes (radiance, albedo, depth, ...).
 *
 * Sums are double and always added in the order of the samples, so that neither the size of batches nor a checkpoint
 * in between changes a bit. The planes are float, for readers, and written by gi_film_resolve.
 * Threads.  A pixel has one writer at a time, the job of its tile. gi_film_preview: [any-thread], while others
 *           write.
 */
#ifndef GI_FILM_H
#define GI_FILM_H

#include "base/base_math.h"
#include "gi/gi_render.h"

#include <stdatomic.h>

/* Sums over samples 0 .. samples - 1, in that order. */
typedef struct gi_film_pixel {
	double radiance[3], radiance_squared[3]; /* multiplied with the sample's weight, if samples have weights */
	double albedo[3], normal[3];
	double depth; /* sum over the samples that hit something */
	uint32_t samples, hits;
} gi_film_pixel;

/* Of pictures that will be denoised: the sums over the samples of a pixel's first half (gi_film_is_first_half); those
 * of the second half are the rest of the pixel's. */
typedef struct gi_film_half {
	double radiance[3]; /* as gi_film_pixel.radiance */
	double weight;      /* sum of the samples' weights */
} gi_film_half;

/* Further sums for weighted samples; gi_film_pixel.radiance is then a sum of weight x radiance. */
typedef struct gi_film_weight {
	double weight, weight_squared;
	double product[3]; /* weight x (weight x radiance) */
} gi_film_weight;

#define GI_FILM_LARGEST_BLOCK 32u /* side of a block in pixels: a progressive picture begins with one pixel of each */

typedef struct gi_film {
	uint32_t width, height;
	gi_film_pixel *pixels;
	gi_film_weight *weights; /* NULL: every sample weighs 1 */
	gi_film_half *halves;    /* NULL: the picture will not be denoised */

	/* The planes; the atomic ones may be read while they are written. */
	_Atomic float *radiance;
	_Atomic uint32_t *samples;
	float *albedo, *normal, *depth, *variance;
	float *denoised; /* [3], of gi_denoise; NULL: it has not run since samples were added */
} gi_film;

/* One sample of a pixel. */
typedef struct gi_film_sample {
	stilb_vec3 radiance;
	const float *albedo, *normal; /* [3] */
	float depth;                  /* +infinity: nothing was hit */
} gi_film_sample;

/* What a film keeps beside the sums that all have. */
typedef struct gi_film_kind {
	bool weighted, halves;
} gi_film_kind;

gi_film_kind gi_film_kind_of(const stilb_gi_settings *settings);

/* A film without samples, all black, depth +infinity. STILB_ERROR_MEMORY; then film is {0}. */
stilb_result gi_film_create(gi_film *film, uint32_t width, uint32_t height, gi_film_kind kind);

/* Accepts {0}. */
void gi_film_finish(gi_film *film);

/* Divides the samples of a pixel, however many there will be: sample 0 is in the first half, sample 1 in the second,
 * and of the samples 2^k .. 2^(k+1) - 1 their first half is in the first. Runs of 2^k samples that begin at a multiple
 * of 2^k are spread evenly by Sobol points, and each half is made of such runs. */
bool gi_film_is_first_half(uint32_t sample);

/* Adds the pixel's next sample. False: its radiance is NaN or infinite and was added as black. */
bool gi_film_add(gi_film *film, size_t pixel, const gi_film_sample *sample);

/* Frees film->denoised, which belongs to the samples so far. */
void gi_film_drop_denoised(gi_film *film);

/* Writes the pixel's values in all planes from its sums; nothing for a pixel without samples. */
void gi_film_resolve(gi_film *film, size_t pixel);

/* Estimated relative root-mean-square error of the picture: the square root of the mean variance of all numbers,
 * divided by their mean. +infinity if a pixel has less than two samples; 0 for a black picture. Not while pixels are
 * written. */
double gi_film_error(const gi_film *film);

/* Writes for each pixel the share of its samples that hit something, of the same pixels as gi_film_preview. Not while
 * pixels are written. */
void gi_film_coverage(const gi_film *film, float *share);

/* The planes, to be read while nobody writes pixels. */
stilb_gi_film gi_film_planes(const gi_film *film);

/* The body of stilb_gi_render_preview. */
void gi_film_preview(const gi_film *film, float *rgb);

/* The picture to be saved: as gi_film_preview, but denoised if it has been. Not while pixels are written. */
void gi_film_picture(const gi_film *film, float *rgb);

#endif
