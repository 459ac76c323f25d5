/* The innermost loops for one light: what vectors leave over, and the reference for them. */
#ifndef LIGHT_SCALAR_H
#define LIGHT_SCALAR_H

#include "light/light_kernels.h"

#include <math.h>

/* The larger, the smaller; b if they cannot be compared, as vmaxps has it. */
static inline float scalar_max(float a, float b)
{
	return a > b ? a : b;
}

static inline float scalar_min(float a, float b)
{
	return a < b ? a : b;
}

/* Distance by which a point lies outside of two planes between rows; *lower: outside the second. */
static inline float scalar_beyond(const light_slab *slab, uint32_t first_row, uint32_t end_row, float y, float w,
                                  bool *lower)
{
	const light_planes *rows = slab->rows;
	float above = w * rows->offset[first_row] - y * rows->inverse[first_row];
	float below = y * rows->inverse[end_row] - w * rows->offset[end_row];
	*lower = below > above;
	return scalar_max(scalar_max(below, above), 0.0f);
}

static inline bool scalar_in_rows(const light_slab *slab, uint32_t first_row, uint32_t end_row, float y, float w,
                                  float square)
{
	bool lower;
	float beyond = scalar_beyond(slab, first_row, end_row, y, w, &lower);
	return beyond * beyond <= square;
}

static inline void scalar_pick_one(const light_slab *slab, uint32_t first_row, uint32_t end_row,
                                   const light_chunk *chunk, uint32_t i, light_picked *picked)
{
	if (chunk->first_slice[i] > slab->slice || chunk->last_slice[i] < slab->slice)
		return;
	float depth = chunk->depth[i], radius = chunk->radius[i];
	float step = scalar_max(slab->near_z - depth, 0.0f) - scalar_max(depth - slab->far_z, 0.0f);
	float x = chunk->x[i] + step * slab->along[0];
	float y = chunk->y[i] + step * slab->along[1];
	float w = chunk->w[i] + step * slab->along[2];
	float square = radius * radius * LIGHT_SQUARE_GROWTH - step * step;
	uint32_t at = picked->count;
	picked->x[at] = x;
	picked->y[at] = y;
	picked->w[at] = w;
	picked->square[at] = square;
	picked->number[at] = chunk->number[i];
	picked->count += scalar_in_rows(slab, first_row, end_row, y, w, square);
}

/* The span of a sphere too near to the eye for tangents: by the distance from each plane. */
static inline bool scalar_span_near(const light_columns *columns, float x, float w, float square, light_span *span)
{
	float radius = sqrtf(square);
	uint32_t first = columns->count, last = 0;
	for (uint32_t c = 0; c < columns->count; c++) {
		float left = x * columns->planes.inverse[c] - w * columns->planes.offset[c];
		float right = x * columns->planes.inverse[c + 1] - w * columns->planes.offset[c + 1];
		if (left >= -radius && right <= radius) {
			first = first < c ? first : c;
			last = c;
		}
	}
	*span = (light_span){(uint16_t)first, (uint16_t)last};
	return first <= last;
}

/* True if the sphere is far enough from the eye for tangents. */
static inline bool scalar_is_far(const light_columns *columns, float w, float square)
{
	return w * w > columns->ww * square * LIGHT_TANGENT_LIMIT && w > 0.0f;
}

/* The planes n that touch the sphere solve (x - n w)^2 = r^2 (xx - 2 xw n + ww n^2). */
static inline bool scalar_span_far(const light_slab *slab, float x, float w, float square, light_span *span)
{
	const light_columns *columns = slab->columns;
	float inverse = 1.0f / (w * w - columns->ww * square);
	float middle = (x * w - columns->xw * square) * inverse;
	float gradient = columns->xx * (w * w) - (columns->xw + columns->xw) * (x * w) + columns->ww * (x * x);
	float root = scalar_max(gradient - columns->area * square, 0.0f);
	float radius = sqrtf(square), half = radius * sqrtf(root) * inverse;
	half = half + (fabsf(middle) + half) * LIGHT_TANGENT_GROWTH;
	float reach = radius * columns->length, low = x - reach, high = x + reach;
	float least = scalar_min(low * slab->inverse_near, low * slab->inverse_far);
	float most = scalar_max(high * slab->inverse_near, high * slab->inverse_far);
	float first = scalar_max(middle - half, least) * columns->scale + (columns->shift - LIGHT_COLUMN_GROWTH);
	float last = scalar_min(middle + half, most) * columns->scale + (columns->shift + LIGHT_COLUMN_GROWTH);
	float end = (float)columns->count;
	if (!(first < end && last >= 0.0f && first <= last))
		return false;
	span->first = (uint16_t)(int32_t)scalar_max(first, 0.0f);
	span->last = (uint16_t)(int32_t)scalar_min(last, end - 1.0f);
	return true;
}

/* Adds a light's span of a row to those at *count. */
static inline void scalar_span_one(const light_slab *slab, const light_picked *picked, uint32_t i, uint32_t row,
                                   uint32_t *numbers, light_span *spans, uint32_t *count)
{
	const light_planes *rows = slab->rows;
	float y = picked->y[i], w = picked->w[i], square = picked->square[i];
	bool lower;
	float beyond = scalar_beyond(slab, row, row + 1, y, w, &lower);
	float left = square - beyond * beyond;
	if (!(left >= 0.0f))
		return;
	float row_x = picked->x[i] + beyond * (lower ? -rows->x[row + 1] : rows->x[row]);
	float row_w = w + beyond * (lower ? -rows->w[row + 1] : rows->w[row]);
	if (scalar_is_far(slab->columns, row_w, left) ? scalar_span_far(slab, row_x, row_w, left, &spans[*count])
	                                              : scalar_span_near(slab->columns, row_x, row_w, left, &spans[*count]))
		numbers[(*count)++] = picked->number[i];
}

static inline float scalar_dot(const float a[3], const float b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A convex cone and a cell are apart if a plane through the apex has the cone on one side and the cell on the other. Of
 * the planes that touch the cone, the one that looks to the cell's middle is tried. The cell is the hull of its
 * corners. */
static inline bool scalar_cone_meets(const light_cone_row *row, uint32_t column)
{
	const light_rays *rays = row->rays;
	const light_cone *cone = row->cone;
	float x0 = rays->edge_x[column], x1 = rays->edge_x[column + 1], x = 0.5f * (x0 + x1), normal[3];
	for (int i = 0; i < 3; i++)
		normal[i] = row->across[i] + x * row->across_x[i];
	float length = sqrtf(scalar_dot(normal, normal));
	float toward = cone->cosine / scalar_max(length, LIGHT_ACROSS_MIN);
	for (int i = 0; i < 3; i++)
		normal[i] = toward * normal[i] - cone->sine * cone->axis[i];
	float base_x = scalar_dot(normal, rays->base_x), base_y = scalar_dot(normal, rays->base_y);
	float ray_x = scalar_dot(normal, rays->ray_x), ray_y = scalar_dot(normal, rays->ray_y);
	float base = scalar_dot(normal, cone->base) + scalar_min(x0 * base_x, x1 * base_x) +
	             scalar_min(row->y0 * base_y, row->y1 * base_y);
	float ray = scalar_dot(normal, rays->ray) + scalar_min(x0 * ray_x, x1 * ray_x) +
	            scalar_min(row->y0 * ray_y, row->y1 * ray_y);
	return base + (ray < 0.0f ? row->far_z : row->near_z) * ray <= cone->slack;
}

#endif
