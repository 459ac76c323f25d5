/*
 * bake_check: whether a map of a patch is one to one. It is if no triangle is turned over, no two sides of the border
 * cross, and one loop of the border alone runs counter-clockwise: how often places are covered changes by one at the
 * border and nowhere else, it is 0 far away, and inside of loops that cross nothing it is at most 1 then.
 */
#include "bake/unwrap/bake_patch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SQUEEZED 1e-4        /* of a triangle's area, the mean scale taken out: smaller in the map counts as nothing */
#define TOUCH 1e-6           /* of the patch's extent: sides that are closer touch */
#define CELLS_MOST 1024      /* of the grid that finds neighbours, each way */
#define SIDE_CELLS_MOST 256u /* of a side, on the mean */

static bool nothing_turned(const bake_patch *patch)
{
	double sum = 0.0;
	for (uint32_t t = 0; t < patch->count; t++)
		sum += bake_patch_area2(patch, t);
	double least = SQUEEZED * sum / patch->area;
	if (!(sum > 0.0) || !(sum < HUGE_VAL))
		return false;
	for (uint32_t t = 0; t < patch->count; t++)
		if (!(bake_patch_area2(patch, t) > least * patch->topology->area[patch->triangles[t]]))
			return false;
	return true;
}

/* ---- loops ------------------------------------------------------------------------------------------------------- */

/* How many loops of the border run counter-clockwise. next: [vertex_count] memory. */
static uint32_t loops_around(const bake_patch *patch, uint32_t *next)
{
	uint32_t loops = 0;
	memset(next, 0xff, patch->vertex_count * sizeof *next);
	for (uint32_t i = 0; i < patch->border_count; i++)
		next[patch->border[i][0]] = patch->border[i][1];
	for (uint32_t i = 0; i < patch->border_count; i++) {
		double area2 = 0.0;
		for (uint32_t v = patch->border[i][0]; next[v] != BAKE_NONE;) {
			uint32_t to = next[v];
			next[v] = BAKE_NONE;
			area2 += patch->at[v][0] * patch->at[to][1] - patch->at[to][0] * patch->at[v][1];
			v = to;
		}
		loops += area2 > 0.0;
	}
	return loops;
}

/* ---- crossings --------------------------------------------------------------------------------------------------- */

static double side_of(const double a[2], const double b[2], const double p[2])
{
	return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* True if the ends are on different sides, and both farther away than `touch`. */
static bool passes_over(double first, double second, double length, double touch)
{
	double most = touch * length;
	return (first > most && second < -most) || (first < -most && second > most);
}

/* True if side c d lies along a b, to where it goes, for more than `touch`: what is left of both is covered twice.
 * Along a b, but the other way round, is what lies on its other side. */
static bool runs_along(const double a[2], const double b[2], const double c[2], const double d[2], double touch)
{
	double x = b[0] - a[0], y = b[1] - a[1], length = hypot(x, y), most = touch * length;
	if (!(length > 0.0) || fabs(side_of(a, b, c)) > most || fabs(side_of(a, b, d)) > most)
		return false;
	double from = ((c[0] - a[0]) * x + (c[1] - a[1]) * y) / length,
		   to = ((d[0] - a[0]) * x + (d[1] - a[1]) * y) / length;
	return fmin(to, length) - fmax(from, 0.0) > touch;
}

/* True if the patch covers something twice where these sides meet: they cross, or run along each other. Where an end of
 * each lies on the other, or nearly, they touch, as the sides of a fan do whose triangles meet at places that differ by
 * rounding. */
static bool sides_cross(const bake_patch *patch, uint32_t i, uint32_t j, double touch)
{
	const uint32_t *s = patch->border[i], *t = patch->border[j];
	if (s[0] == t[0] || s[0] == t[1] || s[1] == t[0] || s[1] == t[1])
		return false;
	const double *a = patch->at[s[0]], *b = patch->at[s[1]], *c = patch->at[t[0]], *d = patch->at[t[1]];
	double ca = side_of(a, b, c), da = side_of(a, b, d), ac = side_of(c, d, a), bc = side_of(c, d, b);
	bool opposite = passes_over(ca, da, 0.0, 0.0) && passes_over(ac, bc, 0.0, 0.0);
	if (opposite && (passes_over(ca, da, hypot(b[0] - a[0], b[1] - a[1]), touch) ||
	                 passes_over(ac, bc, hypot(d[0] - c[0], d[1] - c[1]), touch)))
		return true;
	return runs_along(a, b, c, d, touch) || runs_along(c, d, a, b, touch);
}

/* A grid over the border's box; a side is in all cells of its own box. */
typedef struct side_grid {
	double low[2], per_cell[2]; /* cells a unit */
	uint32_t cells;             /* each way */
	double touch;               /* sides that are closer touch */
	uint32_t *first, *sides;    /* those of cell c: sides[first[c]] .. sides[first[c + 1] - 1] */
} side_grid;

static uint32_t grid_cell(const side_grid *grid, double x, int axis)
{
	double cell = (x - grid->low[axis]) * grid->per_cell[axis];
	return cell > 0.0 ? cell < grid->cells - 1 ? (uint32_t)cell : grid->cells - 1 : 0;
}

static void grid_box(const bake_patch *patch, const side_grid *grid, uint32_t side, uint32_t box[4])
{
	const double *a = patch->at[patch->border[side][0]], *b = patch->at[patch->border[side][1]];
	for (int k = 0; k < 2; k++) {
		box[k] = grid_cell(grid, fmin(a[k], b[k]), k);
		box[2 + k] = grid_cell(grid, fmax(a[k], b[k]), k);
	}
}

static void grid_size(const bake_patch *patch, side_grid *grid)
{
	double high[2] = {-HUGE_VAL, -HUGE_VAL};
	grid->low[0] = grid->low[1] = HUGE_VAL;
	for (uint32_t i = 0; i < patch->border_count; i++)
		for (int k = 0; k < 2; k++) {
			grid->low[k] = fmin(grid->low[k], patch->at[patch->border[i][0]][k]);
			high[k] = fmax(high[k], patch->at[patch->border[i][0]][k]);
		}
	grid->touch = TOUCH * fmax(high[0] - grid->low[0], high[1] - grid->low[1]);
	grid->cells = (uint32_t)fmin(sqrt((double)patch->border_count) + 1.0, (double)CELLS_MOST);
	for (int k = 0; k < 2; k++)
		grid->per_cell[k] = high[k] > grid->low[k] ? grid->cells / (high[k] - grid->low[k]) : 0.0;
}

/* True if sides are in so many cells that the search would take too long: long ones all over a star, for example. Such
 * a chart counts as no good, and is cut. */
static bool grid_is_crowded(const bake_patch *patch, const side_grid *grid)
{
	uint64_t entries = 0, most = (uint64_t)patch->border_count * SIDE_CELLS_MOST;
	uint32_t box[4];
	for (uint32_t i = 0; i < patch->border_count && entries <= most; i++) {
		grid_box(patch, grid, i, box);
		entries += (uint64_t)(box[2] - box[0] + 1) * (box[3] - box[1] + 1);
	}
	return entries > most || entries > UINT32_MAX;
}

/* Sorts the sides into cells; the grid is not crowded. */
static bool grid_fill(const bake_patch *patch, side_grid *grid)
{
	uint32_t cells = grid->cells * grid->cells, box[4];
	grid->first = calloc((size_t)cells + 2, sizeof *grid->first);
	for (int pass = 0; pass < 2 && grid->first; pass++) {
		for (uint32_t i = 0; i < patch->border_count; i++) {
			grid_box(patch, grid, i, box);
			for (uint32_t y = box[1]; y <= box[3]; y++)
				for (uint32_t x = box[0]; x <= box[2]; x++) {
					uint32_t *at = &grid->first[y * grid->cells + x + 2 - (uint32_t)pass];
					if (pass == 1)
						grid->sides[*at] = i;
					(*at)++;
				}
		}
		for (uint32_t c = 0; c < cells && pass == 0; c++)
			grid->first[c + 2] += grid->first[c + 1];
		if (pass == 0)
			grid->sides = stilb_memory_alloc(grid->first[cells + 1], sizeof *grid->sides);
		if (!grid->sides)
			break;
	}
	return grid->first && grid->sides;
}

static bool grid_crosses(const bake_patch *patch, const side_grid *grid)
{
	for (uint32_t c = 0; c < grid->cells * grid->cells; c++)
		for (uint32_t i = grid->first[c]; i < grid->first[c + 1]; i++)
			for (uint32_t j = grid->first[c]; j < i; j++)
				if (sides_cross(patch, grid->sides[i], grid->sides[j], grid->touch))
					return true;
	return false;
}

stilb_result bake_patch_is_good(const bake_patch *patch, bool *good)
{
	*good = nothing_turned(patch);
	if (!*good || patch->count == 1)
		return STILB_OK;
	side_grid grid = {0};
	uint32_t *next = stilb_memory_alloc(patch->vertex_count, sizeof *next);
	grid_size(patch, &grid);
	*good = !grid_is_crowded(patch, &grid);
	bool there = next && (!*good || grid_fill(patch, &grid));
	if (there && *good)
		*good = loops_around(patch, next) == 1 && !grid_crosses(patch, &grid);
	free(next);
	free(grid.first);
	free(grid.sides);
	return there ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "out of memory for a chart of %u triangles", patch->count);
}
