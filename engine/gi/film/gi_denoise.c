#include "gi/film/gi_denoise.h"

#include "gi/film/gi_denoise_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>

#define ROWS 16u           /* of pixels in a job */
#define VARIANCE_AROUND 2u /* pixels in each direction in which the variance is scaled */
#define STRENGTH_AROUND 4u /* pixels in each direction in which the strength is found */
#define LEAST_ALBEDO 0.02f /* what radiance is divided by at least */
#define LARGEST 1e15f      /* radiance that the sums of squares can hold */

/* One call of gi_denoise. */
typedef struct denoise {
	gi_film *film;
	gi_denoise_picture picture;
	float *sums[4];         /* planes of sums over squares of pixels: two quotients' numerators and denominators */
	float *planes;          /* all of them */
	gi_denoise_tile *tiles; /* one for each thread */
	float *out;             /* [3] */
	uint32_t around;        /* of box_columns and box_rows */
	uint32_t tiles_x;
} denoise;

/* ---- the film as planes ------------------------------------------------------------------------------------------ */

/* The weights' sum of a pixel's samples. */
static double pixel_weight(const gi_film *film, size_t pixel)
{
	return film->weights ? film->weights[pixel].weight : film->pixels[pixel].samples;
}

/* False: the pixel is kept as it is. */
static bool pixel_halves(const denoise *d, size_t pixel)
{
	const gi_film_half *half = &d->film->halves[pixel];
	const gi_film_pixel *sums = &d->film->pixels[pixel];
	double whole = pixel_weight(d->film, pixel), rest = whole - half->weight;
	bool good = sums->hits > 0 && half->weight > 0.0 && rest > 0.0;
	for (int c = 0; c < 3 && good; c++) {
		float first = (float)(half->radiance[c] / half->weight);
		float second = (float)((sums->radiance[c] - half->radiance[c]) / rest);
		d->picture.half[0][c][pixel] = first;
		d->picture.half[1][c][pixel] = second;
		d->picture.variance[c][pixel] = d->film->variance[3 * pixel + (size_t)c];
		good = fabsf(first) < LARGEST && fabsf(second) < LARGEST && d->picture.variance[c][pixel] < LARGEST * LARGEST;
	}
	d->picture.share[pixel] = good ? (float)(half->weight / whole) : 0.0f;
	return good;
}

static void pixel_features(const denoise *d, size_t pixel)
{
	const gi_film *film = d->film;
	double hit = (double)film->pixels[pixel].hits / film->pixels[pixel].samples;
	for (size_t c = 0; c < 3; c++) {
		float albedo = film->albedo[3 * pixel + c];
		d->picture.feature[GI_DENOISE_ALBEDO + c][pixel] = albedo;
		d->picture.feature[GI_DENOISE_NORMAL + c][pixel] = film->normal[3 * pixel + c];
		d->picture.albedo[c][pixel] = fmaxf(albedo + (float)(1.0 - hit), LEAST_ALBEDO); /* what is behind counts as 1 */
	}
	d->picture.feature[GI_DENOISE_NEARNESS][pixel] = (float)(hit / (double)film->depth[pixel]);
}

/* The halves' difference, and what the samples' spread says that its square is, summed over the channels. */
static void pixel_spread(const denoise *d, size_t pixel)
{
	const gi_denoise_picture *picture = &d->picture;
	float share = picture->share[pixel], seen = 0.0f, said = 0.0f;
	for (int c = 0; c < 3; c++) {
		float unit = 1.0f / picture->albedo[c][pixel];
		float difference = (picture->half[0][c][pixel] - picture->half[1][c][pixel]) * unit;
		seen += difference * difference;
		said += picture->variance[c][pixel] * unit * unit * (1.0f / share + 1.0f / (1.0f - share));
	}
	d->sums[0][pixel] = seen;
	d->sums[1][pixel] = said;
}

/* stilb_job_range_fn over rows, as all below */
static void planes_fill(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	size_t width = d->picture.width;
	(void)worker;
	for (size_t pixel = begin * width; pixel < end * width; pixel++) {
		d->sums[0][pixel] = d->sums[1][pixel] = 0.0f;
		if (!pixel_halves(d, pixel))
			continue;
		pixel_features(d, pixel);
		pixel_spread(d, pixel);
	}
}

/* ---- sums over squares ------------------------------------------------------------------------------------------- */

/* sums[2] and [3] become the sums of [0] and [1] over the pixels beside each in its row. */
static void box_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	uint32_t width = d->picture.width, around = d->around;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		for (int k = 0; k < 2; k++) {
			const float *from = d->sums[k] + (size_t)y * width;
			float *to = d->sums[2 + k] + (size_t)y * width;
			for (uint32_t x = 0; x < width; x++) {
				uint32_t first = x > around ? x - around : 0, last = width - x > around ? x + around : width - 1;
				float sum = 0.0f;
				for (uint32_t u = first; u <= last; u++)
					sum += from[u];
				to[x] = sum;
			}
		}
}

/* sums[0] and [1] become those of [2] and [3] over the pixels above and below. */
static void box_columns(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	uint32_t width = d->picture.width, height = d->picture.height, around = d->around;
	(void)worker;
	for (uint32_t y = begin; y < end; y++)
		for (int k = 0; k < 2; k++) {
			uint32_t first = y > around ? y - around : 0, last = height - y > around ? y + around : height - 1;
			float *restrict to = d->sums[k] + (size_t)y * width;
			for (uint32_t x = 0; x < width; x++)
				to[x] = 0.0f;
			for (uint32_t v = first; v <= last; v++) {
				const float *from = d->sums[2 + k] + (size_t)v * width;
				for (uint32_t x = 0; x < width; x++)
					to[x] += from[x];
			}
		}
}

static void variance_scale(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	size_t width = d->picture.width;
	(void)worker;
	for (size_t pixel = begin * width; pixel < end * width; pixel++) {
		float seen = d->sums[0][pixel], said = d->sums[1][pixel], scale = seen < said ? seen / said : 1.0f;
		for (int c = 0; c < 3 && d->picture.share[pixel] > 0.0f; c++)
			d->picture.variance[c][pixel] *= scale;
	}
}

/* ---- the filter and its strength --------------------------------------------------------------------------------- */

/* stilb_job_range_fn over tiles */
static void tiles_filter(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	uint32_t side = gi_denoise_tile_side();
	gi_denoise_tile *tile = (gi_denoise_tile *)((char *)d->tiles + worker * gi_denoise_tile_size());
	for (uint32_t i = begin; i < end; i++) {
		PROFILE("gi.denoise.tile");
		gi_denoise_tile_filter(&d->picture, i % d->tiles_x * side, i / d->tiles_x * side, tile);
	}
}

/* Numerator and denominator of each pixel's share s (gi_denoise.h), of both halves and all channels. */
static void strength_fill(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	size_t width = d->picture.width;
	(void)worker;
	for (size_t pixel = begin * width; pixel < end * width; pixel++) {
		float wanted = 0.0f, step = 0.0f;
		for (int c = 0; c < 3 && d->picture.share[pixel] > 0.0f; c++)
			for (int k = 0; k < 2; k++) {
				float own = d->picture.half[k][c][pixel], other = d->picture.half[!k][c][pixel];
				float change = d->picture.filtered[k][c][pixel] - own;
				wanted += (other - own) * change;
				step += change * change;
			}
		d->sums[0][pixel] = wanted;
		d->sums[1][pixel] = step;
	}
}

static void strength_apply(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const denoise *d = context;
	const gi_denoise_picture *picture = &d->picture;
	stilb_gi_film film = gi_film_planes(d->film);
	size_t width = picture->width;
	(void)worker;
	for (size_t pixel = begin * width; pixel < end * width; pixel++) {
		float share = picture->share[pixel], wanted = d->sums[0][pixel], step = d->sums[1][pixel];
		float strength = wanted > 0.0f && step > 0.0f ? fminf(wanted / step, 1.0f) : 0.0f;
		strength /= 2.0f - strength;
		for (size_t c = 0; c < 3; c++) {
			float input = film.radiance[3 * pixel + c], output = input;
			if (share > 0.0f)
				output = picture->filtered[0][c][pixel] * share + picture->filtered[1][c][pixel] * (1.0f - share);
			d->out[3 * pixel + c] = input + strength * (output - input);
		}
	}
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

#define PLANES (6 + 6 + 3 + 1 + 3 + GI_DENOISE_FEATURES + 4)

static stilb_result denoise_init(denoise *d, gi_film *film, uint32_t threads)
{
	size_t pixels = (size_t)film->width * film->height;
	*d = (denoise){.film = film, .picture = {.width = film->width, .height = film->height}};
	d->planes = stilb_memory_alloc(PLANES * pixels, sizeof *d->planes);
	d->out = stilb_memory_alloc(pixels, sizeof(float[3]));
	d->tiles = stilb_memory_alloc(threads, gi_denoise_tile_size());
	if (!d->planes || !d->out || !d->tiles)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for denoising %u x %u pixels", film->width, film->height);
	float *next = d->planes;
	for (int c = 0; c < 3; c++) {
		for (int k = 0; k < 2; k++) {
			d->picture.half[k][c] = next;
			d->picture.filtered[k][c] = next + pixels;
			next += 2 * pixels;
		}
		d->picture.variance[c] = next;
		d->picture.albedo[c] = next + pixels;
		next += 2 * pixels;
	}
	d->picture.share = next;
	for (int i = 0; i < GI_DENOISE_FEATURES; i++)
		d->picture.feature[i] = next += pixels;
	for (int i = 0; i < 4; i++)
		d->sums[i] = next += pixels;
	STILB_ASSERT(next + pixels == d->planes + PLANES * pixels);
	return STILB_OK;
}

/* Scales nearness so that the largest is 1, as the other features are about 1 at most. */
static void nearness_scale(const denoise *d)
{
	size_t pixels = (size_t)d->picture.width * d->picture.height;
	float *nearness = d->picture.feature[GI_DENOISE_NEARNESS], most = 0.0f;
	for (size_t i = 0; i < pixels; i++)
		if (d->picture.share[i] > 0.0f && nearness[i] > most)
			most = nearness[i];
	for (size_t i = 0; i < pixels && most > 0.0f; i++)
		if (d->picture.share[i] > 0.0f)
			nearness[i] /= most;
}

static void denoise_run(denoise *d, stilb_job_pool *pool, uint32_t caller)
{
	uint32_t height = d->picture.height, side = gi_denoise_tile_side();
	d->tiles_x = (d->picture.width + side - 1) / side;
	stilb_job_parallel_for(pool, height, ROWS, planes_fill, d, caller);
	nearness_scale(d);
	d->around = VARIANCE_AROUND;
	stilb_job_parallel_for(pool, height, ROWS, box_rows, d, caller);
	stilb_job_parallel_for(pool, height, ROWS, box_columns, d, caller);
	stilb_job_parallel_for(pool, height, ROWS, variance_scale, d, caller);
	stilb_job_parallel_for(pool, d->tiles_x * ((height + side - 1) / side), 1, tiles_filter, d, caller);
	d->around = STRENGTH_AROUND;
	stilb_job_parallel_for(pool, height, ROWS, strength_fill, d, caller);
	stilb_job_parallel_for(pool, height, ROWS, box_rows, d, caller);
	stilb_job_parallel_for(pool, height, ROWS, box_columns, d, caller);
	stilb_job_parallel_for(pool, height, ROWS, strength_apply, d, caller);
}

stilb_result gi_denoise(gi_film *film, stilb_job_pool *pool, uint32_t caller)
{
	STILB_ASSERT(film && film->halves && pool);
	PROFILE("gi.denoise");
	denoise d;
	gi_film_drop_denoised(film);
	stilb_result result = denoise_init(&d, film, stilb_job_pool_worker_count(pool) + 1);
	if (result == STILB_OK)
		denoise_run(&d, pool, caller);
	else
		free(d.out);
	film->denoised = result == STILB_OK ? d.out : NULL;
	free(d.planes);
	free(d.tiles);
	return result;
}
