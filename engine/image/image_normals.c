#include "image/image_normals.h"

#include "shading/shade_normal_filter.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* What a filter averages in place of normal and roughness; which member holds it depends on the filter. */
typedef union normals_texel {
	struct {
		shade_mean_direction mean;
		float alpha2; /* the average of alpha^2, for the filters that keep it apart */
	};
	shade_lean lean;
} normals_texel;

/* ---- one texel: make, mix, resolve ------------------------------------------------------------------------------- */

static normals_texel texel_from(stilb_normal_filter filter, shade_rough_normal pixel)
{
	float alpha2 = pixel.alpha * pixel.alpha;
	switch (filter) {
	case STILB_NORMAL_FILTER_LEAN:
		return (normals_texel){.lean = shade_lean_from_normal(pixel)};
	case STILB_NORMAL_FILTER_VMF:
		return (normals_texel){.mean = shade_filter_vmf_mean(pixel), .alpha2 = alpha2};
	case STILB_NORMAL_FILTER_TOKSVIG:
		return (normals_texel){.mean = shade_filter_toksvig_mean(pixel), .alpha2 = alpha2};
	default:
		return (normals_texel){.mean = shade_filter_normal_mean(pixel.normal), .alpha2 = alpha2};
	}
}

/* The mean of a and b; weight in [0, 1] is the share of b. */
static normals_texel texel_mix(stilb_normal_filter filter, normals_texel a, normals_texel b, float weight)
{
	STILB_ASSERT(weight >= 0.0f && weight <= 1.0f);
	if (filter == STILB_NORMAL_FILTER_LEAN)
		return (normals_texel){.lean = shade_lean_mix(a.lean, b.lean, weight)};
	return (normals_texel){
		.mean = shade_mean_direction_mix(a.mean, b.mean, weight),
		.alpha2 = a.alpha2 + (b.alpha2 - a.alpha2) * weight,
	};
}

static shade_rough_normal texel_resolve(stilb_normal_filter filter, normals_texel texel)
{
	switch (filter) {
	case STILB_NORMAL_FILTER_LEAN:
		return shade_lean_normal(texel.lean);
	case STILB_NORMAL_FILTER_VMF:
		return shade_filter_vmf(texel.mean);
	case STILB_NORMAL_FILTER_TOKSVIG:
		return shade_filter_toksvig(texel.mean);
	case STILB_NORMAL_FILTER_VARIANCE:
		return shade_filter_variance(texel.mean, texel.alpha2);
	default:
		return shade_filter_convolution(texel.mean, texel.alpha2);
	}
}

/* ---- levels ------------------------------------------------------------------------------------------------------ */

static shade_rough_normal pixel_load(const stilb_image *level, uint32_t x, uint32_t y)
{
	STILB_ASSERT(x < level->width && y < level->height);
	const float *p = (const float *)level->pixels + ((size_t)y * level->width + x) * 4;
	return (shade_rough_normal){
		.normal = stilb_vec3_make(p[0], p[1], p[2]),
		.alpha = shade_alpha_from_roughness(p[3]),
	};
}

static void pixel_store(stilb_image *level, uint32_t x, uint32_t y, shade_rough_normal pixel)
{
	STILB_ASSERT(x < level->width && y < level->height);
	STILB_ASSERT(level->format == STILB_IMAGE_F32_LINEAR && level->channels == 4);
	float *p = (float *)level->pixels + ((size_t)y * level->width + x) * 4;
	for (int k = 0; k < 3; k++)
		p[k] = pixel.normal[k];
	p[3] = sqrtf(pixel.alpha);
}

/* The level of the mip chain from which the next smaller one is made. */
typedef struct normals_source {
	stilb_normal_filter filter;
	const stilb_image *level;
	const normals_texel *texels; /* the averages of which level's pixels were made; NULL for level 0 */
} normals_source;

static normals_texel source_texel(const normals_source *source, uint32_t x, uint32_t y)
{
	if (source->texels)
		return source->texels[(size_t)y * source->level->width + x];
	return texel_from(source->filter, pixel_load(source->level, x, y));
}

/* The interval [low, high) that one pixel of the smaller level covers along one side, in pixels of the larger level: 2
 * pixels long, or between 2 and 3 if the larger side is odd; 1 if both sides are 1. */
typedef struct normals_span {
	double low, high;
	uint32_t first, last; /* pixels of the larger level that it touches */
} normals_span;

static normals_span span_of(uint32_t index, uint32_t smaller, uint32_t larger)
{
	STILB_ASSERT(index < smaller && smaller <= larger);
	normals_span span = {.low = (double)index * larger / smaller, .high = (index + 1.0) * larger / smaller};
	span.first = (uint32_t)span.low;
	span.last = (uint32_t)ceil(span.high) - 1;
	STILB_ASSERT(span.first <= span.last && span.last < larger);
	return span;
}

/* The share of pixel i of the larger level that lies in the interval, (0, 1]. */
static double span_share(const normals_span *span, uint32_t i)
{
	STILB_ASSERT(i >= span->first && i <= span->last);
	return fmin(i + 1.0, span->high) - fmax(i, span->low);
}

/* The average of the source's texels over the rectangle columns x rows, weighted by the area of each that is in it. */
static normals_texel average(const normals_source *source, const normals_span *columns, const normals_span *rows)
{
	normals_texel sum = {0};
	double total = 0.0;
	for (uint32_t y = rows->first; y <= rows->last; y++)
		for (uint32_t x = columns->first; x <= columns->last; x++) {
			double share = span_share(rows, y) * span_share(columns, x);
			normals_texel texel = source_texel(source, x, y);
			total += share;
			sum = total == share ? texel : texel_mix(source->filter, sum, texel, (float)(share / total));
		}
	return sum;
}

/* Fills a level from the next larger one. texels, [height][width], receives the averages of which its pixels are made;
 * the next smaller level is made from these, not from the pixels. */
static void level_make(const normals_source *source, stilb_image *level, normals_texel *texels)
{
	STILB_ASSERT(level->width <= source->level->width && level->height <= source->level->height);
	for (uint32_t y = 0; y < level->height; y++) {
		normals_span rows = span_of(y, level->height, source->level->height);
		for (uint32_t x = 0; x < level->width; x++) {
			normals_span columns = span_of(x, level->width, source->level->width);
			normals_texel *texel = &texels[(size_t)y * level->width + x];
			*texel = average(source, &columns, &rows);
			pixel_store(level, x, y, texel_resolve(source->filter, *texel));
		}
	}
}

/* ---- level 0: the input ------------------------------------------------------------------------------------------ */

static bool format_is_read(const stilb_image *image)
{
	return (unsigned)image->format < STILB_IMAGE_FORMAT_COUNT && image->format != STILB_IMAGE_F16_LINEAR &&
	       !stilb_image_format_is_blocks(image->format);
}

static stilb_result desc_check(const stilb_image_normals_desc *desc)
{
	const stilb_image *n = desc->normals, *r = desc->roughness;
	const char *why = NULL;
	if (!n || !n->pixels || (r && !r->pixels))
		why = "a picture is empty";
	else if (!format_is_read(n) || (r && !format_is_read(r)))
		why =
			"pictures of halves and blocks are not supported; stilb_image_load gives floats, stilb_image_decode texels";
	else if (n->channels < 2)
		why = "they have one channel; 2 to 4 are needed";
	else if (n->channels == 2 && desc->space == STILB_NORMAL_SPACE_OBJECT)
		why = "in object space z cannot be told from 2 channels; use 3";
	else if (desc->filter == STILB_NORMAL_FILTER_LEAN && desc->space == STILB_NORMAL_SPACE_OBJECT)
		why = "LEAN averages slopes and needs tangent space; use vMF in object space";
	else if ((unsigned)desc->filter >= STILB_NORMAL_FILTER_COUNT)
		why = "unknown filter";
	else if (!r && !(desc->constant_roughness >= 0.0f && desc->constant_roughness <= 1.0f))
		why = "constant_roughness must be in [0, 1]";
	if (why)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot filter normals: %s", why);
	if (r && (r->width != n->width || r->height != n->height))
		return stilb_fail(
			STILB_ERROR_ARGUMENT,
			"cannot filter normals: they have %u x %u pixels, the roughness has %u x %u; scale one to the "
			"other's size",
			n->width, n->height, r->width, r->height);
	return STILB_OK;
}

/* One value of a picture: a code / 255 or / 65535, or a float. */
static float value(const stilb_image *image, size_t pixel, uint32_t channel)
{
	STILB_ASSERT(format_is_read(image));
	STILB_ASSERT(channel < image->channels && pixel < (size_t)image->width * image->height);
	size_t index = pixel * image->channels + channel;
	switch (stilb_image_format_as_data(image->format)) {
	case STILB_IMAGE_U8_LINEAR:
		return (float)((const uint8_t *)image->pixels)[index] / 255.0f;
	case STILB_IMAGE_U16_LINEAR:
		return (float)((const uint16_t *)image->pixels)[index] / 65535.0f;
	default:
		return ((const float *)image->pixels)[index];
	}
}

/* The normal of a pixel, not normalised. */
static stilb_vec3 given_normal(const stilb_image *normals, size_t pixel)
{
	stilb_vec3 n = {0};
	for (uint32_t k = 0; k < 3 && k < normals->channels; k++) {
		n[k] = value(normals, pixel, k);
		if (normals->format != STILB_IMAGE_F32_LINEAR)
			n[k] = 2.0f * n[k] - 1.0f;
	}
	if (normals->channels == 2)
		n[2] = sqrtf(fmaxf(1.0f - n[0] * n[0] - n[1] * n[1], 0.0f));
	return n;
}

static stilb_result level_0_make(const stilb_image_normals_desc *desc, stilb_image *level)
{
	for (uint32_t y = 0; y < level->height; y++)
		for (uint32_t x = 0; x < level->width; x++) {
			size_t pixel = (size_t)y * level->width + x;
			stilb_vec3 n = given_normal(desc->normals, pixel);
			float length2 = stilb_vec3_dot(n, n);
			if (!(length2 >= FLT_MIN && isfinite(length2)))
				return stilb_fail(STILB_ERROR_ARGUMENT,
				                  "cannot filter normals: pixel (%u, %u) is (%g, %g, %g), which is no direction", x, y,
				                  (double)n[0], (double)n[1], (double)n[2]);
			float roughness = desc->roughness ? value(desc->roughness, pixel, 0) : desc->constant_roughness;
			if (!(roughness >= 0.0f && roughness <= 1.0f))
				return stilb_fail(STILB_ERROR_ARGUMENT,
				                  "cannot filter normals: the roughness of pixel (%u, %u) is %g, outside [0, 1]", x, y,
				                  (double)roughness);
			shade_rough_normal given = {stilb_vec3_normalize(n), shade_alpha_from_roughness(roughness)};
			pixel_store(level, x, y, given);
		}
	return STILB_OK;
}

/* ---- the chain --------------------------------------------------------------------------------------------------- */

stilb_image_normals_desc stilb_image_normals_desc_default(const stilb_image *normals)
{
	return (stilb_image_normals_desc){
		.normals = normals,
		.constant_roughness = 0.5f,
		.filter = STILB_NORMAL_FILTER_VMF,
		.space = STILB_NORMAL_SPACE_TANGENT,
	};
}

static uint32_t halved(uint32_t side)
{
	return side > 1 ? side / 2 : 1;
}

static stilb_result levels_create(stilb_image_normals *chain, uint32_t width, uint32_t height)
{
	for (;;) {
		STILB_ASSERT(chain->level_count < STILB_IMAGE_NORMALS_LEVELS);
		stilb_image *level = &chain->levels[chain->level_count];
		stilb_result created = stilb_image_create(level, width, height, 4, STILB_IMAGE_F32_LINEAR);
		if (created != STILB_OK)
			return created;
		chain->level_count++;
		if (width == 1 && height == 1)
			return STILB_OK;
		width = halved(width), height = halved(height);
	}
}

/* Makes all levels but level 0, the input. Keeps the averages (texels) of two levels at a time. */
static stilb_result levels_make(stilb_normal_filter filter, stilb_image_normals *chain)
{
	normals_texel *texels[2] = {NULL, NULL};
	stilb_result result = STILB_OK;
	for (uint32_t i = 1; i < chain->level_count && result == STILB_OK; i++) {
		stilb_image *level = &chain->levels[i];
		normals_texel **own = &texels[i % 2];
		free(*own);
		*own = stilb_memory_alloc((size_t)level->width * level->height, sizeof **own);
		normals_source source = {.filter = filter, .level = &chain->levels[i - 1], .texels = texels[(i + 1) % 2]};
		if (*own)
			level_make(&source, level, *own);
		else
			result = stilb_fail(STILB_ERROR_MEMORY, "cannot filter normals: out of memory for %u x %u pixels",
			                    level->width, level->height);
	}
	free(texels[0]);
	free(texels[1]);
	return result;
}

stilb_result stilb_image_normals_create(const stilb_image_normals_desc *desc, stilb_image_normals *chain)
{
	STILB_ASSERT(desc && chain);
	*chain = (stilb_image_normals){0};
	stilb_result result = desc_check(desc);
	if (result == STILB_OK)
		result = levels_create(chain, desc->normals->width, desc->normals->height);
	if (result == STILB_OK)
		result = level_0_make(desc, &chain->levels[0]);
	if (result == STILB_OK)
		result = levels_make(desc->filter, chain);
	if (result != STILB_OK)
		stilb_image_normals_finish(chain);
	return result;
}

void stilb_image_normals_finish(stilb_image_normals *chain)
{
	if (!chain)
		return;
	STILB_ASSERT(chain->level_count <= STILB_IMAGE_NORMALS_LEVELS);
	for (uint32_t i = 0; i < chain->level_count; i++)
		stilb_image_finish(&chain->levels[i]);
	*chain = (stilb_image_normals){0};
}
