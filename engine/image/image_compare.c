#include "image/image_compare.h"

#include "image/image_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is compared -------------------------------------------------------------------------------------------- */

static uint32_t compare_colors(const stilb_image *image)
{
	return image->channels < 3 ? 1 : 3;
}

static bool compare_has_alpha(const stilb_image *image)
{
	return image->channels % 2 == 0;
}

static bool compare_is_as_large(const stilb_image *a, const stilb_image *b)
{
	return a->width == b->width && a->height == b->height;
}

static stilb_result compare_check_mask(const stilb_image *of, const stilb_image *mask)
{
	STILB_ASSERT(!mask || image_is_sound(mask));
	if (!mask || (compare_is_as_large(of, mask) && mask->channels == 1 && mask->format == STILB_IMAGE_U8_LINEAR))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "cannot mask a picture of %u x %u pixels by one of %u x %u with %u channels in format %d; a mask "
	                  "is as large, with one channel in U8_LINEAR",
	                  of->width, of->height, mask->width, mask->height, mask->channels, (int)mask->format);
}

static stilb_result compare_check(const stilb_image *a, const stilb_image *b, const stilb_image *mask)
{
	STILB_ASSERT(image_is_sound(a));
	STILB_ASSERT(image_is_sound(b));
	if (!compare_is_as_large(a, b))
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot compare pictures of %u x %u and %u x %u pixels", a->width,
		                  a->height, b->width, b->height);
	return compare_check_mask(a, mask);
}

static bool compare_counts(const stilb_image *mask, uint32_t x, uint32_t y)
{
	return !mask || ((const uint8_t *)mask->pixels)[(size_t)y * mask->width + x] > 0;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* |a - b|; NaN is apart from everything. */
static double compare_apart(float a, float b)
{
	if (a == b)
		return 0.0; /* also two infinities */
	double apart = fabs((double)a - (double)b);
	return isnan(apart) ? HUGE_VAL : apart;
}

/* Adds the pixel x, y to the sums, which rms holds until all pixels are there. */
static void compare_pixel(const float *a, const float *b, uint32_t x, uint32_t y, double bound,
                          stilb_image_comparison *out)
{
	bool above = false;
	for (uint32_t c = 0; c < out->channels; c++) {
		double apart = compare_apart(a[c], b[c]);
		out->rms[c] += apart * apart;
		if (apart > out->worst) {
			out->worst = apart;
			out->worst_x = x, out->worst_y = y, out->worst_channel = c;
		}
		above |= apart > bound;
		if (isfinite(b[c]) && (double)b[c] > out->largest)
			out->largest = (double)b[c];
	}
	out->above += above;
	out->pixels++;
}

static void compare_finish(stilb_image_comparison *out)
{
	double sum = 0.0, pixels = out->pixels > 0 ? (double)out->pixels : 1.0;
	for (uint32_t c = 0; c < out->channels; c++) {
		sum += out->rms[c];
		out->rms[c] = sqrt(out->rms[c] / pixels);
	}
	out->rms_all = sqrt(sum / pixels / out->channels);
}

stilb_result stilb_image_compare(const stilb_image *a, const stilb_image *b, const stilb_image *mask, double bound,
                                 stilb_image_comparison *out)
{
	STILB_ASSERT(out);
	STILB_ASSERT(bound >= 0.0);
	*out = (stilb_image_comparison){0};
	stilb_result result = compare_check(a, b, mask);
	if (result != STILB_OK)
		return result;
	if (compare_colors(a) != compare_colors(b))
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "cannot compare a picture of %u channels with one of %u: grey is no colour", a->channels,
		                  b->channels);
	float *of_a = stilb_memory_alloc((size_t)a->width * a->channels, sizeof *of_a);
	float *of_b = stilb_memory_alloc((size_t)b->width * b->channels, sizeof *of_b);
	if (of_a && of_b) {
		out->channels = compare_colors(a) + (compare_has_alpha(a) && compare_has_alpha(b));
		for (uint32_t y = 0; y < a->height; y++) {
			stilb_image_row_to_light(a, y, of_a);
			stilb_image_row_to_light(b, y, of_b);
			for (uint32_t x = 0; x < a->width; x++)
				if (compare_counts(mask, x, y))
					compare_pixel(of_a + (size_t)x * a->channels, of_b + (size_t)x * b->channels, x, y, bound, out);
		}
		compare_finish(out);
	} else {
		result = stilb_fail(STILB_ERROR_MEMORY, "cannot compare pictures of %u x %u pixels: out of memory", a->width,
		                    a->height);
	}
	free(of_a);
	free(of_b);
	return result;
}

/* ---- Khronos' number --------------------------------------------------------------------------------------------- */

/* pixelmatch's distance of two pixels of codes over white, 0..35215. */
static double fidelity_distance(const double a[4], const double b[4])
{
	double d[3];
	for (int c = 0; c < 3; c++)
		d[c] = (a[c] - 255.0) * a[3] / 255.0 - (b[c] - 255.0) * b[3] / 255.0;
	double y = 0.29889531 * d[0] + 0.58662247 * d[1] + 0.11448223 * d[2];
	double i = 0.59597799 * d[0] - 0.27417610 * d[1] - 0.32180189 * d[2];
	double q = 0.21147017 * d[0] - 0.52261711 * d[1] + 0.31114694 * d[2];
	return 0.5053 * y * y + 0.299 * i * i + 0.1957 * q * q;
}

/* Red, green, blue and alpha of a pixel of codes. */
static void fidelity_pixel(const uint8_t *codes, uint32_t channels, double pixel[4])
{
	for (uint32_t c = 0; c < 3; c++)
		pixel[c] = codes[channels < 3 ? 0 : c];
	pixel[3] = channels % 2 == 0 ? codes[channels - 1] : 255.0;
}

/* 10 log10 of the RMS over pixels; the codes are those of the pictures. */
static double fidelity_decibel(const stilb_image *candidate, const uint8_t *codes, const stilb_image *golden,
                               const uint8_t *golden_codes, const stilb_image *mask)
{
	double sum = 0.0, count = 0.0;
	for (uint32_t y = 0; y < candidate->height; y++)
		for (uint32_t x = 0; x < candidate->width; x++) {
			double a[4], b[4];
			size_t at = (size_t)y * candidate->width + x;
			fidelity_pixel(codes + at * candidate->channels, candidate->channels, a);
			if (a[3] <= 0.0 || !compare_counts(mask, x, y))
				continue;
			fidelity_pixel(golden_codes + at * golden->channels, golden->channels, b);
			double distance = fidelity_distance(a, b);
			sum += distance * distance;
			count++;
		}
	return count > 0.0 ? 10.0 * log10(sqrt(sum / count) / 35215.0) : (double)NAN;
}

stilb_result stilb_image_fidelity(const stilb_image *candidate, const stilb_image *golden, const stilb_image *mask,
                                  double *db)
{
	STILB_ASSERT(db);
	*db = (double)NAN;
	stilb_result result = compare_check(candidate, golden, mask);
	if (result != STILB_OK)
		return result;
	void *made[2] = {NULL, NULL};
	const uint8_t *codes = image_codes(candidate, &made[0]), *golden_codes = image_codes(golden, &made[1]);
	if (codes && golden_codes)
		*db = fidelity_decibel(candidate, codes, golden, golden_codes, mask);
	else
		result = stilb_fail(STILB_ERROR_MEMORY, "cannot compare pictures of %u x %u pixels: out of memory",
		                    candidate->width, candidate->height);
	free(made[0]);
	free(made[1]);
	return result;
}

/* ---- masks ------------------------------------------------------------------------------------------------------- */

typedef struct mask_edge {
	uint32_t channels;
	float step, share;
} mask_edge;

static bool mask_is_edge(const mask_edge *edge, const float *a, const float *b)
{
	for (uint32_t c = 0; c < edge->channels; c++) {
		double apart = compare_apart(a[c], b[c]), size = fmax(fabs((double)a[c]), fabs((double)b[c]));
		if (apart > 0.0 && (isinf(apart) || apart > (double)edge->step + (double)edge->share * size))
			return true;
	}
	return false;
}

/* Writes 1 to each pixel of an edge in edges, [height][width], which is 0 before. rows: two rows of the picture. */
static void mask_find(const stilb_image *picture, const mask_edge *edge, float *rows, uint8_t *edges)
{
	size_t row = (size_t)picture->width * picture->channels;
	for (uint32_t y = 0; y < picture->height; y++) {
		float *own = rows + y % 2 * row;
		const float *above = rows + (y + 1) % 2 * row;
		uint8_t *marks = edges + (size_t)y * picture->width;
		stilb_image_row_to_light(picture, y, own);
		for (uint32_t x = 0; x < picture->width; x++) {
			size_t at = (size_t)x * picture->channels;
			if (x > 0 && mask_is_edge(edge, own + at - picture->channels, own + at))
				marks[x - 1] = marks[x] = 1;
			if (y > 0 && mask_is_edge(edge, above + at, own + at))
				*(marks + x - picture->width) = marks[x] = 1;
		}
	}
}

/* Marks what is at most `distance` from a mark along a line of count bytes, stride apart. line: as many bytes. */
static void mask_widen(uint8_t *marks, uint32_t count, size_t stride, uint32_t distance, uint8_t *line)
{
	for (uint32_t i = 0; i < count; i++)
		line[i] = marks[i * stride];
	for (int back = 0; back < 2; back++) {
		uint64_t since = UINT32_MAX; /* the last mark; distance is less than that */
		for (uint32_t k = 0; k < count; k++) {
			uint32_t i = back ? count - 1 - k : k;
			since = line[i] ? 0 : since + 1;
			if (since <= distance)
				marks[i * stride] = 1;
		}
	}
}

static stilb_result mask_no_memory(const stilb_image *picture)
{
	return stilb_fail(STILB_ERROR_MEMORY, "cannot mask a picture of %u x %u pixels: out of memory", picture->width,
	                  picture->height);
}

/* A mask that leaves nothing out. */
static stilb_result mask_create(const stilb_image *picture, stilb_image *mask)
{
	stilb_result result = stilb_image_create(mask, picture->width, picture->height, 1, STILB_IMAGE_U8_LINEAR);
	if (result == STILB_OK)
		memset(mask->pixels, 255, stilb_image_size(mask));
	return result;
}

stilb_result stilb_image_mask_edges(const stilb_image *picture, float step, float share, uint32_t distance,
                                    stilb_image *mask)
{
	STILB_ASSERT(mask);
	STILB_ASSERT(image_is_sound(picture));
	STILB_ASSERT(step >= 0.0f && share >= 0.0f);
	STILB_ASSERT(distance <= STILB_IMAGE_MAX_SIDE);
	stilb_result result = mask->pixels ? compare_check_mask(picture, mask) : STILB_OK;
	if (result != STILB_OK)
		return result;
	size_t width = picture->width, height = picture->height, longer = width > height ? width : height;
	float *rows = stilb_memory_alloc(2 * width * picture->channels, sizeof *rows);
	uint8_t *edges = stilb_memory_alloc(width * height, 1), *line = stilb_memory_alloc(longer, 1);
	if (!rows || !edges || !line)
		result = mask_no_memory(picture);
	if (result == STILB_OK && !mask->pixels)
		result = mask_create(picture, mask);
	if (result == STILB_OK) {
		memset(edges, 0, width * height);
		mask_find(picture, &(mask_edge){picture->channels, step, share}, rows, edges);
		for (size_t y = 0; y < height; y++)
			mask_widen(edges + y * width, (uint32_t)width, 1, distance, line);
		for (size_t x = 0; x < width; x++)
			mask_widen(edges + x, (uint32_t)height, width, distance, line);
		for (size_t i = 0; i < width * height; i++)
			if (edges[i])
				((uint8_t *)mask->pixels)[i] = 0;
	}
	free(rows);
	free(edges);
	free(line);
	return result;
}
