/* The source of a prefiltered cube: its texels, a cube as a panorama, and the source's light on the rings. */
#include "numeric/numeric_prefilter_internal.h"

#include "shading/shade_environment.h"
#include "shading/shade_firefly.h"

#include <string.h>

/* ---- texels ------------------------------------------------------------------------------------------------------ */

typedef int32_t source_lanes __attribute__((vector_size(16)));

/* NaN and what is below 0 become 0. */
static stilb_vec4 source_valid(stilb_vec4 values)
{
	stilb_vec4 zero = {0.0f, 0.0f, 0.0f, 0.0f},
			   most = {PREFILTER_VALUE_MAX, PREFILTER_VALUE_MAX, PREFILTER_VALUE_MAX, PREFILTER_VALUE_MAX};
	source_lanes positive = values > zero, beyond = values > most;
	return (stilb_vec4)(((source_lanes)values & positive & ~beyond) | ((source_lanes)most & beyond));
}

stilb_vec4 numeric_prefilter_texel(const stilb_numeric_prefilter *work, const stilb_image *image, uint32_t x,
                                   uint32_t y)
{
	STILB_ASSERT(x < image->width && y < image->height);
	size_t index = ((size_t)y * image->width + x) * image->channels;
	uint32_t green = image->channels >= 3 ? 1 : 0, blue = 2 * green;
	stilb_vec4 texel;
	if (image->format == STILB_IMAGE_F32_LINEAR) {
		const float *values = (const float *)image->pixels + index;
		texel = (stilb_vec4){values[0], values[green], values[blue], 1.0f};
	} else {
		const uint16_t *values = (const uint16_t *)image->pixels + index;
		texel = (stilb_vec4){stilb_image_half_to_float(values[0]), stilb_image_half_to_float(values[green]),
		                     stilb_image_half_to_float(values[blue]), 1.0f};
	}
	texel = source_valid(texel);
	float range = work->settings.firefly_range;
	return range > 0.0f ? texel * shade_firefly_weight(shade_luminance(texel), range) : texel;
}

/* ---- cubes ------------------------------------------------------------------------------------------------------- */

/* Between the centres of four texels of a face; at its sides, where some of them would lie in other faces, of two. */
stilb_vec4 numeric_prefilter_look(const stilb_numeric_prefilter *work, stilb_vec3 direction)
{
	shade_cube_place place = shade_cube_place_of(direction);
	const stilb_image *face = &work->source[place.face];
	float last = (float)(face->width - 1), half = 0.5f * (float)face->width;
	float x = fminf(fmaxf((place.s + 1.0f) * half - 0.5f, 0.0f), last);
	float y = fminf(fmaxf((place.t + 1.0f) * half - 0.5f, 0.0f), last);
	uint32_t left = (uint32_t)x, top = (uint32_t)y;
	uint32_t right = left + (left + 1 < face->width), bottom = top + (top + 1 < face->width);
	float across = x - (float)left, down = y - (float)top;
	stilb_vec4 above = numeric_prefilter_texel(work, face, left, top) * (1.0f - across) +
	                   numeric_prefilter_texel(work, face, right, top) * across;
	stilb_vec4 below = numeric_prefilter_texel(work, face, left, bottom) * (1.0f - across) +
	                   numeric_prefilter_texel(work, face, right, bottom) * across;
	return above * (1.0f - down) + below * down;
}

void numeric_prefilter_unwrap_row(stilb_numeric_prefilter *work, uint32_t y)
{
	const stilb_image *to = &work->unwrapped;
	stilb_vec4 *row = (stilb_vec4 *)to->pixels + (size_t)y * to->width;
	float theta = (float)(M_PI * (y + 0.5) / to->height), step = (float)(2.0 * M_PI / to->width);
	float sine = sinf(theta), cosine = cosf(theta);
	for (uint32_t x = 0; x < to->width; x++) {
		float phi = ((float)x + 0.5f) * step; /* from +Z, the panorama's left side, towards -X */
		row[x] = numeric_prefilter_look(work, stilb_vec3_make(-sine * sinf(phi), cosine, sine * cosf(phi)));
	}
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static const stilb_image *source_map(const stilb_numeric_prefilter *work)
{
	return work->is_cube ? &work->unwrapped : &work->source[0];
}

void numeric_prefilter_read(const stilb_numeric_prefilter *work, uint32_t y, uint32_t begin, uint32_t end,
                            stilb_vec4 *values)
{
	if (work->is_cube) {
		memcpy(values, (stilb_vec4 *)work->unwrapped.pixels + (size_t)y * work->unwrapped.width + begin,
		       (end - begin) * sizeof *values);
		return;
	}
	for (uint32_t x = begin; x < end; x++)
		values[x - begin] = numeric_prefilter_texel(work, &work->source[0], x, y);
}

/* ---- rings ------------------------------------------------------------------------------------------------------- */

#define GATHER_COLUMNS 128u /* of the source at a time */

/* What a row of the source gives to a ring: the solid angle of each of its texels, times the weight of the ring among
 * the four around the row; and the same across a pole, where the ring is reached half a turn away. */
typedef struct gather_weights {
	float here, across;
} gather_weights;

/* Rows that are higher than half the distance of two rings count in parts that are not. */
static gather_weights gather_weigh(const prefilter_grid *in, uint32_t ring, const stilb_image *map, uint32_t y)
{
	double rings = 2.0 * in->pairs, below = cos(M_PI * y / map->height);
	uint32_t parts = 1 + (uint32_t)(2.0 * rings / map->height);
	gather_weights sum = {0.0f, 0.0f};
	for (uint32_t i = 0; i < parts; i++) {
		double above = below;
		below = cos(M_PI * (y + (i + 1.0) / parts) / map->height);
		double at = acos(0.5 * (above + below)) * M_1_PI * rings - 0.5; /* half of its light is on each side */
		float solid = (float)((above - below) * 2.0 * M_PI / map->width);
		double mirrored = at < 0.5 * rings ? -1.0 - at : 2.0 * rings - 1.0 - at;
		sum.here += solid * prefilter_cubic((float)(at - ring));
		sum.across += solid * prefilter_cubic((float)(mirrored - ring));
	}
	return sum;
}

/* The rings first to first + PREFILTER_BLOCK - 1, which lie in rows of waves one after the other, and the light that
 * some columns of the source give them. */
typedef struct gather_block {
	uint32_t first, columns;
	stilb_vec4 *rows[PREFILTER_BLOCK];
	bool crosses;
	stilb_vec4 here[PREFILTER_BLOCK][GATHER_COLUMNS], across[PREFILTER_BLOCK][GATHER_COLUMNS];
} gather_block;

static void gather_read(const stilb_numeric_prefilter *work, gather_block *block, uint32_t begin, uint32_t end)
{
	const stilb_image *map = source_map(work);
	double rows = (double)map->height / (2.0 * work->in.pairs);
	uint32_t first = (uint32_t)fmax((block->first - 1.5) * rows, 0.0);
	uint32_t last = (uint32_t)fmin((block->first + PREFILTER_BLOCK + 1.5) * rows + 1.0, map->height);
	memset(block->here, 0, sizeof block->here);
	memset(block->across, 0, sizeof block->across);
	block->crosses = false;
	for (uint32_t y = first; y < last; y++) {
		stilb_vec4 values[GATHER_COLUMNS];
		numeric_prefilter_read(work, y, begin, end, values);
		for (uint32_t q = 0; q < PREFILTER_BLOCK; q++) {
			gather_weights weights = gather_weigh(&work->in, block->first + q, map, y);
			for (uint32_t x = 0; x < end - begin && weights.here != 0.0f; x++)
				block->here[q][x] += values[x] * weights.here;
			for (uint32_t x = 0; x < end - begin && weights.across != 0.0f; x++)
				block->across[q][x] += values[x] * weights.across;
			block->crosses |= weights.across != 0.0f;
		}
	}
}

/* Adds a texel's light to the four points around the place `at` of a ring. Every second value is of this ring. */
static void gather_spread(stilb_vec4 *ring, uint32_t columns, uint32_t left, const float weights[4], stilb_vec4 value)
{
	for (uint32_t k = 0; k < 4; k++)
		ring[(size_t)2 * ((left + k - 1u) & (columns - 1))] += value * weights[k];
}

/* Texels that are wider than half the distance of two points count in parts. */
static void gather_write(const stilb_image *map, const gather_block *block, uint32_t begin, uint32_t end)
{
	uint32_t parts = 1 + 2 * block->columns / map->width, half = block->columns / 2;
	float share = 1.0f / (float)parts;
	for (uint32_t i = 0; i < (end - begin) * parts; i++) {
		uint32_t x = i / parts;
		double at = (begin + (i + 0.5) / parts) / map->width * block->columns;
		uint32_t left = (uint32_t)at;
		float t = (float)(at - left), weights[4];
		for (uint32_t k = 0; k < 4; k++)
			weights[k] = share * prefilter_cubic(t + 1.0f - (float)k);
		for (uint32_t q = 0; q < PREFILTER_BLOCK; q++)
			gather_spread(block->rows[q], block->columns, left, weights, block->here[q][x]);
		for (uint32_t q = 0; q < PREFILTER_BLOCK && block->crosses; q++)
			gather_spread(block->rows[q], block->columns, left + half, weights, block->across[q][x]);
	}
}

void numeric_prefilter_gather(stilb_numeric_prefilter *work, uint32_t pair)
{
	const prefilter_grid *in = &work->in;
	const stilb_image *map = source_map(work);
	prefilter_wave *rows = in->waves + (size_t)pair * in->columns;
	memset(rows, 0, sizeof *rows * PREFILTER_BLOCK * in->columns);
	for (uint32_t south = 0; south < 2; south++) {
		gather_block block = {.first = south == 1 ? 2 * in->pairs - PREFILTER_BLOCK - pair : pair,
		                      .columns = in->columns};
		for (uint32_t q = 0; q < PREFILTER_BLOCK; q++) {
			prefilter_wave *row = rows + (south == 1 ? PREFILTER_BLOCK - 1 - q : q) * (size_t)in->columns;
			block.rows[q] = south == 1 ? &row->im : &row->re;
		}
		for (uint32_t begin = 0; begin < map->width; begin += GATHER_COLUMNS) {
			uint32_t end = begin + GATHER_COLUMNS < map->width ? begin + GATHER_COLUMNS : map->width;
			gather_read(work, &block, begin, end);
			gather_write(map, &block, begin, end);
		}
	}
	for (uint32_t q = 0; q < PREFILTER_BLOCK; q++)
		numeric_prefilter_transform(work, in->columns, rows + (size_t)q * in->columns, false);
}
