#include "gi/film/gi_film.h"

#include "shading/shade_firefly.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FILM_FIREFLY_RANGE 1.0f /* luminance at which a sample's weight is half, if bright samples weigh less */

/* ---- life -------------------------------------------------------------------------------------------------------- */

gi_film_kind gi_film_kind_of(const stilb_gi_settings *settings)
{
	return (gi_film_kind){.weighted = settings->firefly_weight, .halves = settings->denoise};
}

stilb_result gi_film_create(gi_film *film, uint32_t width, uint32_t height, gi_film_kind kind)
{
	STILB_ASSERT(film && width > 0 && height > 0);
	size_t count = (size_t)width * height;
	*film = (gi_film){.width = width, .height = height};
	/* So much memory comes as pages that are zero and not there until they are touched: a large picture begins at once,
	 * and a part of it takes a part of the memory. Huge pages would each hold pixels of every part. */
	film->pixels = calloc(count, sizeof *film->pixels);
	film->weights = kind.weighted ? calloc(count, sizeof *film->weights) : NULL;
	film->halves = kind.halves ? calloc(count, sizeof *film->halves) : NULL;
	film->radiance = calloc(3 * count, sizeof *film->radiance);
	film->samples = calloc(count, sizeof *film->samples);
	film->albedo = calloc(count, sizeof(float[3]));
	film->normal = calloc(count, sizeof(float[3]));
	film->depth = calloc(count, sizeof *film->depth);
	film->variance = calloc(count, sizeof(float[3]));
	bool whole = film->pixels && film->radiance && film->samples && film->albedo && film->normal && film->depth &&
	             film->variance && (film->weights || !kind.weighted) && (film->halves || !kind.halves);
	if (!whole) {
		gi_film_finish(film);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a picture of %u x %u pixels; render a smaller one",
		                  width, height);
	}
	for (size_t i = 0; i < count; i++)
		film->depth[i] = INFINITY;
	return STILB_OK;
}

void gi_film_drop_denoised(gi_film *film)
{
	free(film->denoised);
	film->denoised = NULL;
}

void gi_film_finish(gi_film *film)
{
	free(film->pixels);
	free(film->weights);
	free(film->halves);
	free(film->radiance);
	free(film->samples);
	free(film->albedo);
	free(film->normal);
	free(film->depth);
	free(film->variance);
	gi_film_drop_denoised(film);
	*film = (gi_film){0};
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

bool gi_film_is_first_half(uint32_t sample)
{
	if (sample < 2)
		return sample == 0;
	return !(sample >> (30 - __builtin_clz(sample)) & 1u); /* the bit below the highest one that is set */
}

static double film_weight_of(stilb_vec3 radiance)
{
	double weight = (double)shade_firefly_weight(fmaxf(shade_luminance(radiance), 0.0f), FILM_FIREFLY_RANGE);
	STILB_ASSERT(weight > 0.0 && weight <= 1.0);
	return weight;
}

static void film_add_weighted(gi_film *film, size_t index, stilb_vec3 radiance, double weight)
{
	STILB_ASSERT(film->weights);
	gi_film_pixel *pixel = &film->pixels[index];
	gi_film_weight *weights = &film->weights[index];
	weights->weight += weight;
	weights->weight_squared += weight * weight;
	for (int c = 0; c < 3; c++) {
		double weighted = weight * (double)radiance[c];
		pixel->radiance[c] += weighted;
		pixel->radiance_squared[c] += weighted * weighted;
		weights->product[c] += weight * weighted;
	}
}

static void film_add_plain(gi_film_pixel *pixel, stilb_vec3 radiance)
{
	for (int c = 0; c < 3; c++) {
		double value = (double)radiance[c];
		pixel->radiance[c] += value;
		pixel->radiance_squared[c] += value * value;
	}
}

static void film_add_half(gi_film_half *half, stilb_vec3 radiance, double weight)
{
	for (int c = 0; c < 3; c++)
		half->radiance[c] += weight * (double)radiance[c];
	half->weight += weight;
}

bool gi_film_add(gi_film *film, size_t index, const gi_film_sample *sample)
{
	STILB_ASSERT(index < (size_t)film->width * film->height);
	STILB_ASSERT(sample->albedo && sample->normal);
	gi_film_pixel *pixel = &film->pixels[index];
	stilb_vec3 radiance = sample->radiance;
	bool good = isfinite(radiance[0]) && isfinite(radiance[1]) && isfinite(radiance[2]);
	if (!good)
		radiance = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	double weight = film->weights ? film_weight_of(radiance) : 1.0;
	if (film->weights)
		film_add_weighted(film, index, radiance, weight);
	else
		film_add_plain(pixel, radiance);
	if (film->halves && gi_film_is_first_half(pixel->samples))
		film_add_half(&film->halves[index], radiance, weight);
	for (int c = 0; c < 3; c++) {
		pixel->albedo[c] += (double)sample->albedo[c];
		pixel->normal[c] += (double)sample->normal[c];
	}
	if (sample->depth < INFINITY) {
		pixel->depth += (double)sample->depth;
		pixel->hits++;
	}
	pixel->samples++;
	return good;
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

/* Variance of the mean m of n values x with weights w, from the pixel's sums: n / (n - 1) times the sum of
 * (w x - m w)^2 over the square of the sum of w. With all w = 1 this is the sample variance divided by n. Source: the
 * delta method for a ratio of means. */
static double film_variance(const gi_film_pixel *pixel, const gi_film_weight *w, int channel, double mean)
{
	if (pixel->samples < 2)
		return 0.0;
	double n = pixel->samples;
	double squares =
		pixel->radiance_squared[channel] - 2.0 * mean * w->product[channel] + mean * mean * w->weight_squared;
	return fmax(squares, 0.0) / (w->weight * w->weight) * (n / (n - 1.0));
}

static gi_film_weight film_weight(const gi_film *film, size_t index)
{
	if (film->weights)
		return film->weights[index];
	const gi_film_pixel *pixel = &film->pixels[index];
	double n = pixel->samples;
	return (gi_film_weight){n, n, {pixel->radiance[0], pixel->radiance[1], pixel->radiance[2]}};
}

void gi_film_resolve(gi_film *film, size_t index)
{
	STILB_ASSERT(index < (size_t)film->width * film->height);
	STILB_ASSERT(film->pixels[index].hits <= film->pixels[index].samples);
	const gi_film_pixel *pixel = &film->pixels[index];
	if (pixel->samples == 0)
		return;
	double n = pixel->samples;
	gi_film_weight weight = film_weight(film, index);
	for (int c = 0; c < 3; c++) {
		size_t at = 3 * index + (size_t)c;
		double mean = pixel->radiance[c] / weight.weight;
		/* Relaxed: a preview may show the three channels from before and after this call, mixed, which is harmless. */
		atomic_store_explicit(&film->radiance[at], (float)mean, memory_order_relaxed);
		film->variance[at] = (float)film_variance(pixel, &weight, c, mean);
		film->albedo[at] = (float)(pixel->albedo[c] / n);
		film->normal[at] = (float)(pixel->normal[c] / n);
	}
	film->depth[index] = pixel->hits ? (float)(pixel->depth / pixel->hits) : INFINITY;
	/* Release: pairs with film_shown's acquire: who sees the new count of samples sees radiance as well. */
	atomic_store_explicit(&film->samples[index], pixel->samples, memory_order_release);
}

stilb_gi_film gi_film_planes(const gi_film *film)
{
	/* radiance is _Atomic float, as stilb_gi_render_preview reads it during a run; now nobody writes it, so the caller
	 * may read it as plain floats. */
	return (stilb_gi_film){.width = film->width,
	                       .height = film->height,
	                       .radiance = (const float *)film->radiance,
	                       .albedo = film->albedo,
	                       .normal = film->normal,
	                       .depth = film->depth,
	                       .variance = film->variance,
	                       .denoised = film->denoised,
	                       .samples = (const uint32_t *)film->samples};
}

double gi_film_error(const gi_film *film)
{
	STILB_ASSERT(film->pixels);
	size_t count = (size_t)film->width * film->height;
	double variance = 0.0, mean = 0.0;
	for (size_t i = 0; i < count; i++) {
		if (film->pixels[i].samples < 2)
			return HUGE_VAL;
		for (size_t c = 3 * i; c < 3 * i + 3; c++) {
			variance += (double)film->variance[c];
			mean += (double)atomic_load_explicit(&film->radiance[c], memory_order_relaxed); /* nobody writes it now */
		}
	}
	double numbers = 3.0 * (double)count;
	return variance > 0.0 ? sqrt(variance / numbers) / (mean / numbers) : 0.0;
}

/* The pixel whose radiance a preview shows at (x, y): that pixel itself if it has samples, else the top left pixel of
 * the smallest block around it whose top left pixel has some. */
static size_t film_shown(const gi_film *film, uint32_t x, uint32_t y)
{
	STILB_ASSERT(x < film->width && y < film->height);
	for (uint32_t block = 1; block <= GI_FILM_LARGEST_BLOCK; block *= 2) {
		size_t at = (size_t)(y & ~(block - 1)) * film->width + (x & ~(block - 1));
		/* Acquire: pairs with gi_film_resolve's release, so that the pixel's radiance is seen as well. */
		if (atomic_load_explicit(&film->samples[at], memory_order_acquire) > 0)
			return at;
	}
	return (size_t)y * film->width + x;
}

void gi_film_preview(const gi_film *film, float *rgb)
{
	STILB_ASSERT(film->radiance);
	for (uint32_t y = 0; y < film->height; y++) {
		for (uint32_t x = 0; x < film->width; x++) {
			size_t shown = film_shown(film, x, y);
			for (size_t c = 0; c < 3; c++) /* relaxed: gi_film_resolve says why */
				*rgb++ = atomic_load_explicit(&film->radiance[3 * shown + c], memory_order_relaxed);
		}
	}
}

void gi_film_picture(const gi_film *film, float *rgb)
{
	if (!film->denoised) {
		gi_film_preview(film, rgb);
		return;
	}
	for (uint32_t y = 0; y < film->height; y++)
		for (uint32_t x = 0; x < film->width; x++, rgb += 3)
			memcpy(rgb, film->denoised + 3 * film_shown(film, x, y), sizeof(float[3]));
}

void gi_film_coverage(const gi_film *film, float *share)
{
	STILB_ASSERT(film->pixels && share);
	for (uint32_t y = 0; y < film->height; y++)
		for (uint32_t x = 0; x < film->width; x++) {
			const gi_film_pixel *pixel = &film->pixels[film_shown(film, x, y)];
			*share++ = pixel->samples > 0 ? (float)((double)pixel->hits / pixel->samples) : 0.0f;
		}
}
