/* What a tolerance leaves out of the cells' lists: of each cell the weakest lights, as many as together stay within it.
 */
#include "light/light_lists.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PRUNE_BUCKETS 64u    /* of irradiances that are left out: two for each factor of two, the last with all below */
#define PRUNE_SHIFT 22u      /* of a float's bits: its exponent and one bit more are left */
#define PRUNE_AT_ONCE 512u   /* lights */
#define PRUNE_ROUNDING 1.001 /* more than a GPU rounds a light by */

/* A sphere around a cell. */
typedef struct prune_cell {
	double center[3], radius;
} prune_cell;

/* The corners between two columns of a row: at its upper and lower edge, near and far. */
typedef struct prune_edge {
	double corners[4][3], sum[3];
	double size; /* of the largest coordinate */
} prune_edge;

static prune_edge prune_edge_of(const light_view *view, uint32_t column, uint32_t row, uint32_t slice)
{
	const light_rays *r = &view->rays;
	double x = (double)r->edge_x[column], depths[2] = {(double)view->depths.near_z[slice], 0.0};
	prune_edge edge = {0};
	depths[1] = (double)view->depths.far_z[slice];
	for (int i = 0; i < 3; i++)
		for (int side = 0; side < 2; side++) {
			double y = (double)r->edge_y[row + side];
			double base = view->base[i] + x * (double)r->base_x[i] + y * (double)r->base_y[i];
			double along = (double)r->ray[i] + x * (double)r->ray_x[i] + y * (double)r->ray_y[i];
			for (int end = 0; end < 2; end++) {
				double at = base + depths[end] * along;
				edge.corners[2 * side + end][i] = at;
				edge.sum[i] += at;
				edge.size = light_larger(edge.size, fabs(at));
			}
		}
	return edge;
}

/* Between two edges. */
static prune_cell prune_cell_of(const light_view *view, const prune_edge *left, const prune_edge *right)
{
	prune_cell cell = {0};
	double square = 0.0;
	for (int i = 0; i < 3; i++)
		cell.center[i] = 0.125 * (left->sum[i] + right->sum[i]);
	for (int c = 0; c < 8; c++) {
		const double *corner = (c < 4 ? left : right)->corners[c & 3];
		double apart = 0.0;
		for (int i = 0; i < 3; i++)
			apart += (corner[i] - cell.center[i]) * (corner[i] - cell.center[i]);
		square = light_larger(square, apart);
	}
	cell.radius = sqrt(square);
	double size = 3.0 * light_larger(left->size, right->size) + cell.radius;
	cell.radius += LIGHT_RELATIVE * (view->growth * size + view->reach);
	return cell;
}

/* The most that a light sends to a point of the cell, W m^-2. */
static double prune_irradiance(const prune_cell *cell, const stilb_scene_light *light)
{
	double square = 0.0;
	for (int i = 0; i < 3; i++) {
		double apart = (double)light->position[i] - cell->center[i];
		square += apart * apart;
	}
	return PRUNE_ROUNDING * light_irradiance(light, light_larger(sqrt(square) - cell->radius, 0.0));
}

/* False if no point of the cell is so far from the light that it could go; quickly. */
static bool prune_may_go(const prune_cell *cell, const float *light)
{
	double square = 0.0, far = (double)light[3] + cell->radius;
	for (int i = 0; i < 3; i++) {
		double apart = (double)light[i] - cell->center[i];
		square += apart * apart;
	}
	return square >= far * far;
}

/* How many buckets the irradiance, at most `most`, is below that one's. */
static uint32_t prune_bucket(double irradiance, double most)
{
	float values[2] = {(float)irradiance, (float)most};
	uint32_t bits[2];
	memcpy(bits, values, sizeof bits);
	uint32_t below = (bits[1] >> PRUNE_SHIFT) - (bits[0] >> PRUNE_SHIFT);
	return below < PRUNE_BUCKETS ? below : PRUNE_BUCKETS - 1;
}

/* Moves the lights that stay in a cell's list to its front, in their order, and returns their number. sent: what each
 * sends at most, [count]. What go may send `most` together: whole buckets go from the weakest on; of the first that is
 * too much, those that still fit, in their order. */
static uint32_t prune_list(const double *sent, double most, uint32_t *ids, uint32_t count)
{
	double sums[PRUNE_BUCKETS] = {0}, left = most;
	for (uint32_t i = 0; i < count; i++)
		if (sent[i] <= most)
			sums[prune_bucket(sent[i], most)] += sent[i];
	uint32_t whole = PRUNE_BUCKETS, kept = 0; /* from this bucket on all go */
	while (whole > 0 && sums[whole - 1] <= left)
		left -= sums[--whole];
	for (uint32_t i = 0; i < count; i++) {
		uint32_t bucket = sent[i] <= most ? prune_bucket(sent[i], most) : 0;
		bool weak = sent[i] <= most && (bucket >= whole || (bucket + 1 == whole && sent[i] <= left));
		if (!weak)
			ids[kept++] = ids[i];
		else if (bucket < whole)
			left -= sent[i];
	}
	return kept;
}

/* The same of lists of any length, PRUNE_AT_ONCE lights at a time, of which each may use as large a share of what may
 * be left out as it has of the lights. */
static uint32_t prune_cell_list(const light_build *build, const prune_cell *cell, uint32_t *ids, uint32_t count)
{
	const uint32_t *own = build->lists->lights + build->lists->everywhere_count;
	const float *weak = build->scratch->weak;
	uint32_t kept = 0;
	for (uint32_t first = 0; first < count; first += PRUNE_AT_ONCE) {
		double sent[PRUNE_AT_ONCE], weakest = (double)INFINITY;
		uint32_t some = count - first < PRUNE_AT_ONCE ? count - first : PRUNE_AT_ONCE, left = some;
		double most = build->prunable * ((double)some / (double)count);
		for (uint32_t i = 0; i < some; i++) {
			uint32_t id = ids[first + i];
			bool may_go = prune_may_go(cell, weak + 4 * (size_t)id);
			sent[i] = may_go ? prune_irradiance(cell, &build->lights[own[id]]) : (double)INFINITY;
			weakest = light_smaller(weakest, sent[i]);
		}
		if (weakest <= most)
			left = prune_list(sent, most, ids + first, some);
		memmove(ids + kept, ids + first, left * sizeof *ids);
		kept += left;
	}
	return kept;
}

/* Rows begin .. end - 1 of all slices: counters get the new lengths. */
static void light_job_prune(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.prune");
	(void)worker;
	const light_build *build = context;
	const light_view *view = &build->scratch->view;
	stilb_light_lists *lists = build->lists;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t slice = i / view->rows, row = i % view->rows;
		uint32_t *lengths = light_counters(build->scratch, slice, row);
		const uint32_t *starts = lists->starts + (size_t)i * view->columns;
		for (uint32_t c = 0; c < view->columns; c++)
			lengths[c] = starts[c + 1] - starts[c];
		if (isinf(view->depths.far_z[slice])) /* cells without an end keep their lights */
			continue;
		prune_edge right = {0};
		uint32_t right_of = 0; /* the column whose left edge it is */
		for (uint32_t c = 0; c < view->columns; c++) {
			if (lengths[c] == 0)
				continue;
			prune_edge left = right_of == c && c > 0 ? right : prune_edge_of(view, c, row, slice);
			right = prune_edge_of(view, c + 1, row, slice);
			right_of = c + 1;
			prune_cell cell = prune_cell_of(view, &left, &right);
			lengths[c] = prune_cell_list(build, &cell, lists->ids + starts[c], lengths[c]);
		}
	}
}

/* Chunks begin .. end - 1 of the lights: where they are, and beyond which distance they are weak enough to go. */
static void light_job_weak(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const light_build *build = context;
	const stilb_light_lists *lists = build->lists;
	uint32_t count = lists->light_count - lists->everywhere_count;
	for (uint32_t i = begin * LIGHT_CHUNK; i < end * LIGHT_CHUNK && i < count; i++) {
		const stilb_scene_light *light = &build->lights[lists->lights[lists->everywhere_count + i]];
		float *weak = build->scratch->weak + 4 * (size_t)i;
		memcpy(weak, light->position, sizeof light->position);
		weak[3] = (float)(light_reach(light, build->prunable) * (1.0 - LIGHT_RELATIVE));
	}
}

static bool prune_reserve(struct light_scratch *scratch, uint32_t count)
{
	if (count <= scratch->weak_capacity)
		return true;
	free(scratch->weak);
	scratch->weak = stilb_memory_alloc((size_t)count + count / 4, 4 * sizeof *scratch->weak);
	scratch->weak_capacity = scratch->weak ? count + count / 4 : 0;
	return scratch->weak;
}

stilb_result light_prune(light_build *build)
{
	const light_view *view = &build->scratch->view;
	stilb_light_lists *lists = build->lists;
	uint32_t rows = view->rows * view->slices, next = 0, count = lists->light_count - lists->everywhere_count;
	if (!prune_reserve(build->scratch, count))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights", count);
	light_spread(build, (count + LIGHT_CHUNK - 1) / LIGHT_CHUNK, light_job_weak);
	light_spread(build, rows, light_job_prune);
	for (uint32_t i = 0; i < rows; i++) {
		const uint32_t *lengths = light_counters(build->scratch, i / view->rows, i % view->rows);
		uint32_t *starts = lists->starts + (size_t)i * view->columns;
		for (uint32_t c = 0; c < view->columns; c++) {
			memmove(lists->ids + next, lists->ids + starts[c], lengths[c] * sizeof *lists->ids);
			starts[c] = next; /* the next cell's old start is still there */
			next += lengths[c];
		}
	}
	lists->starts[(size_t)rows * view->columns] = next;
	lists->id_count = next;
	return STILB_OK;
}
