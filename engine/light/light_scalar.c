/* The innermost loops in plain C: the reference for the others. */
#include "light/light_kernels.h"

#include <math.h>

/* The larger; b if they cannot be compared, as vmaxps has it. */
static float scalar_max(float a, float b)
{
	return a > b ? a : b;
}

static uint32_t scalar_pick(const light_band *band, const light_chunk *chunk, light_picked *picked)
{
	const light_planes *rows = band->rows;
	uint32_t count = 0;
	for (uint32_t i = 0; i < chunk->count; i++) {
		if (chunk->first_slice[i] > band->slice || chunk->last_slice[i] < band->slice)
			continue;
		float depth = chunk->depth[i];
		float step = scalar_max(band->near_z - depth, 0.0f) - scalar_max(depth - band->far_z, 0.0f);
		float x = chunk->x[i] + step * band->along[0];
		float y = chunk->y[i] + step * band->along[1];
		float w = chunk->w[i] + step * band->along[2];
		float square = chunk->radius[i] * chunk->radius[i] * LIGHT_SQUARE_GROWTH - step * step;
		float above = w * rows->offset[band->first_row] - y * rows->inverse[band->first_row];
		float below = y * rows->inverse[band->end_row] - w * rows->offset[band->end_row];
		bool lower = below > above;
		float beyond = scalar_max(scalar_max(below, above), 0.0f);
		float left = square - beyond * beyond;
		if (!(left >= 0.0f))
			continue;
		picked->x[count] = x;
		picked->y[count] = y;
		picked->w[count] = w;
		picked->square[count] = square;
		picked->band_x[count] = x + beyond * (lower ? -rows->x[band->end_row] : rows->x[band->first_row]);
		picked->band_w[count] = w + beyond * (lower ? -rows->w[band->end_row] : rows->w[band->first_row]);
		picked->band_radius[count] = sqrtf(left);
		picked->at[count++] = i;
	}
	return count;
}

static uint32_t scalar_columns(const light_picked *picked, uint32_t count, const light_planes *columns, uint32_t first,
                               uint32_t end, uint32_t *places)
{
	uint32_t found = 0;
	for (uint32_t i = 0; i < count; i++) {
		float x = picked->band_x[i], w = picked->band_w[i], radius = picked->band_radius[i];
		float left = x * columns->inverse[first] - w * columns->offset[first];
		float right = x * columns->inverse[end] - w * columns->offset[end];
		places[found] = i;
		found += left >= -radius && right <= radius;
	}
	return found;
}

/* Which columns from first_column on a sphere reaches, a bit for each. */
static uint64_t scalar_row(float x, float w, float radius, const light_planes *columns, uint32_t first_column)
{
	uint64_t mask = 0;
	for (uint32_t c = 0; c < LIGHT_BLOCK; c++) {
		uint32_t p = first_column + c;
		float left = x * columns->inverse[p] - w * columns->offset[p];
		float right = x * columns->inverse[p + 1] - w * columns->offset[p + 1];
		mask |= (uint64_t)(left >= -radius && right <= radius) << c;
	}
	return mask;
}

static void scalar_cells(const light_band *band, const light_picked *picked, const uint32_t *places, uint32_t count,
                         const light_planes *columns, uint32_t first_column, uint64_t *masks)
{
	const light_planes *rows = band->rows;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t at = places[i];
		float x = picked->x[at], y = picked->y[at], w = picked->w[at], square = picked->square[at];
		masks[i] = 0;
		for (uint32_t r = 0; r < LIGHT_BLOCK; r++) {
			uint32_t p = band->first_row + r;
			float above = w * rows->offset[p] - y * rows->inverse[p];
			float below = y * rows->inverse[p + 1] - w * rows->offset[p + 1];
			bool lower = below > above;
			float beyond = scalar_max(scalar_max(below, above), 0.0f);
			float left = square - beyond * beyond;
			if (!(left >= 0.0f))
				continue;
			float row_x = x + beyond * (lower ? -rows->x[p + 1] : rows->x[p]);
			float row_w = w + beyond * (lower ? -rows->w[p + 1] : rows->w[p]);
			masks[i] |= scalar_row(row_x, row_w, sqrtf(left), columns, first_column) << (LIGHT_BLOCK * r);
		}
	}
}

static void scalar_count(const uint64_t *masks, uint32_t count, uint32_t counters[LIGHT_BLOCK_CELLS])
{
	for (uint32_t i = 0; i < count; i++)
		for (uint64_t left = masks[i]; left; left &= left - 1)
			counters[__builtin_ctzll(left)]++;
}

static void scalar_fill(const uint64_t *masks, const uint32_t *lights, uint32_t count,
                        uint32_t cursors[LIGHT_BLOCK_CELLS], uint32_t *ids)
{
	for (uint32_t i = 0; i < count; i++)
		for (uint64_t left = masks[i]; left; left &= left - 1)
			ids[cursors[__builtin_ctzll(left)]++] = lights[i];
}

const light_kernels light_kernels_scalar = {
	.pick = scalar_pick,
	.columns = scalar_columns,
	.cells = scalar_cells,
	.count = scalar_count,
	.fill = scalar_fill,
};
