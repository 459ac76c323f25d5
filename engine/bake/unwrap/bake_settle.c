/*
 * bake_settle: turns a chart so that its box is smallest. One side of the smallest box lies along a side of the convex
 * hull: Freeman and Shapira, "Determining the Minimum-Area Encasing Rectangle for an Arbitrary Closed Curve" (1975).
 * The hull is Andrew's (1979).
 */
#include "bake/unwrap/bake_patch.h"

#include <math.h>
#include <stdlib.h>

#define HULL_MOST 512 /* sides of the hull that are tried, evenly spread */

static int by_place(const void *a, const void *b)
{
	const double *l = a, *r = b;
	if (l[0] != r[0])
		return l[0] < r[0] ? -1 : 1;
	return l[1] < r[1] ? -1 : l[1] > r[1];
}

static double turn_of(const double a[2], const double b[2], const double c[2])
{
	return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The convex hull of sorted points, counter-clockwise; room for count + 1 in hull. Returns how many it has. */
static uint32_t hull_of(double (*points)[2], uint32_t count, double (*hull)[2])
{
	uint32_t n = 0, lower = 1;
	for (int half = 0; half < 2; half++) {
		for (uint32_t k = 0; k < count; k++) {
			const double *p = points[half ? count - 1 - k : k];
			if (half && k == 0)
				continue;
			while (n > lower && turn_of(hull[n - 2], hull[n - 1], p) <= 0.0)
				n--;
			hull[n][0] = p[0];
			hull[n++][1] = p[1];
		}
		lower = n;
	}
	return n > 1 ? n - 1 : n; /* the last one is the first */
}

typedef struct box_turn {
	double x[2];            /* unit: the direction that becomes the x axis */
	double low[2], high[2]; /* along x and across it */
	double area;
} box_turn;

static box_turn box_along(double (*hull)[2], uint32_t count, double dx, double dy)
{
	box_turn box = {{dx, dy}, {HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}, 0.0};
	for (uint32_t i = 0; i < count; i++) {
		double p[2] = {hull[i][0] * dx + hull[i][1] * dy, hull[i][1] * dx - hull[i][0] * dy};
		for (int k = 0; k < 2; k++) {
			box.low[k] = fmin(box.low[k], p[k]);
			box.high[k] = fmax(box.high[k], p[k]);
		}
	}
	box.area = (box.high[0] - box.low[0]) * (box.high[1] - box.low[1]);
	return box;
}

/* Of equal boxes the first; the map as it is comes before all. */
static box_turn smallest_box(double (*hull)[2], uint32_t count)
{
	box_turn best = box_along(hull, count, 1.0, 0.0);
	uint32_t step = 1 + count / HULL_MOST;
	for (uint32_t i = 0; i < count; i += step) {
		const double *a = hull[i], *b = hull[(i + 1) % count];
		double dx = b[0] - a[0], dy = b[1] - a[1], length = sqrt(dx * dx + dy * dy);
		if (!(length > 0.0))
			continue;
		box_turn box = box_along(hull, count, dx / length, dy / length);
		if (box.area < best.area * (1.0 - 1e-9))
			best = box;
	}
	if (best.high[0] - best.low[0] >= best.high[1] - best.low[1])
		return best;
	return box_along(hull, count, -best.x[1], best.x[0]);
}

stilb_result bake_patch_settle(bake_patch *patch, float size[2])
{
	uint32_t count = patch->border_count;
	double(*points)[2] = stilb_memory_alloc(count, sizeof *points);
	double(*hull)[2] = stilb_memory_alloc((size_t)2 * count + 2, sizeof *hull);
	if (!points || !hull) {
		free(points);
		free(hull);
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a chart of %u triangles", patch->count);
	}
	for (uint32_t i = 0; i < count; i++)
		for (int k = 0; k < 2; k++)
			points[i][k] = patch->at[patch->border[i][0]][k];
	qsort(points, count, sizeof *points, by_place);
	box_turn box = smallest_box(hull, hull_of(points, count, hull));
	free(points);
	free(hull);
	double area2 = 0.0;
	for (uint32_t t = 0; t < patch->count; t++)
		area2 += bake_patch_area2(patch, t);
	double scale = sqrt(2.0 * patch->area / area2);
	for (uint32_t v = 0; v < patch->vertex_count; v++) {
		double *at = patch->at[v], x = at[0], y = at[1];
		at[0] = fmax(x * box.x[0] + y * box.x[1] - box.low[0], 0.0) * scale;
		at[1] = fmax(y * box.x[0] - x * box.x[1] - box.low[1], 0.0) * scale;
	}
	for (int k = 0; k < 2; k++)
		size[k] = (float)((box.high[k] - box.low[k]) * scale);
	return STILB_OK;
}
