/*
 * bake_unwrap: grows charts, then lays them flat in rounds: those whose map is not good are cut in two and come again
 * in the next round. A round's charts are jobs; what they are depends on the round before alone.
 */
#include "bake/bake_unwrap.h"

#include "bake/unwrap/bake_grow.h"
#include "bake/unwrap/bake_patch.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

typedef enum piece_state {
	PIECE_PENDING, /* not yet flat */
	PIECE_GOOD,
	PIECE_CUT, /* its map was not good: `parts` pieces take its place */
} piece_state;

/* Triangles order[first] .. order[first + count - 1] of an unwrapping. */
typedef struct unwrap_piece {
	uint32_t first, count, parts;
	float size[2];
	piece_state state;
} unwrap_piece;

typedef struct unwrapping {
	bake_topology topology;
	stilb_bake_uv *uv;
	uint32_t *chart;               /* [triangle_count] the piece, in the round that runs */
	uint32_t *order;               /* [triangle_count] piece by piece */
	uint32_t *local;               /* [triangle_count] memory of bake_patch_begin */
	uint32_t *part;                /* [triangle_count] of a piece that was cut: which part */
	unwrap_piece *pieces;          /* [piece_count] */
	uint32_t piece_count, pending; /* pending: the first piece that the round works on */
	/* There was no memory for a piece. Relaxed: it is read after the loop over pieces, which orders it. */
	_Atomic bool failed;
} unwrapping;

stilb_bake_unwrap_options stilb_bake_unwrap_options_default(void)
{
	return (stilb_bake_unwrap_options){.cone = 0.96f, .crease = 1.05f};
}

void stilb_bake_uv_finish(stilb_bake_uv *uv)
{
	free(uv->corners);
	free(uv->chart);
	free(uv->triangles);
	free(uv->charts);
	*uv = (stilb_bake_uv){0};
}

/* ---- one piece --------------------------------------------------------------------------------------------------- */

/* Gives each connected part of the sides 0 and 1 of a piece a number from 2 on, by their first triangles. Returns how
 * many there are. */
static uint32_t number_parts(unwrapping *u, const bake_patch *patch, uint32_t piece)
{
	uint32_t parts = 0, *stack = patch->corner; /* which nobody needs any more */
	for (uint32_t i = 0; i < patch->count; i++) {
		uint32_t side = u->part[patch->triangles[i]], depth = 0;
		if (side > 1)
			continue;
		stack[depth++] = patch->triangles[i];
		u->part[patch->triangles[i]] = 2 + parts;
		while (depth > 0) {
			uint32_t t = stack[--depth];
			for (uint32_t k = 0; k < 3; k++) {
				uint32_t twin = u->topology.twin[3 * t + k];
				if (twin == BAKE_NONE || u->chart[twin / 3] != piece || u->part[twin / 3] != side)
					continue;
				u->part[twin / 3] = 2 + parts;
				stack[depth++] = twin / 3;
			}
		}
		parts++;
	}
	return parts;
}

/* Marks the half of the patch whose middles are farther along its longer side than the mean of all: 1, the others 0;
 * then each connected part gets a number. Returns how many parts there are, at least two. */
static uint32_t cut_piece(unwrapping *u, const bake_patch *patch, uint32_t piece)
{
	double mean[3] = {0.0, 0.0, 0.0}, low[3], high[3];
	for (int k = 0; k < 3; k++) {
		low[k] = HUGE_VAL;
		high[k] = -HUGE_VAL;
	}
	for (uint32_t i = 0; i < patch->count; i++)
		for (int k = 0; k < 3; k++) {
			const double(*p)[3] = (const double(*)[3]) & u->topology.place[3 * (size_t)patch->triangles[i]];
			double middle = (p[0][k] + p[1][k] + p[2][k]) / 3.0;
			mean[k] += middle / patch->count;
			low[k] = fmin(low[k], middle);
			high[k] = fmax(high[k], middle);
		}
	int axis = 0;
	for (int k = 1; k < 3; k++)
		if (high[k] - low[k] > high[axis] - low[axis])
			axis = k;
	uint32_t beyond = 0;
	for (uint32_t i = 0; i < patch->count; i++) {
		uint32_t t = patch->triangles[i];
		const double(*p)[3] = (const double(*)[3]) & u->topology.place[3 * (size_t)t];
		u->part[t] = (p[0][axis] + p[1][axis] + p[2][axis]) / 3.0 > mean[axis];
		beyond += u->part[t];
	}
	for (uint32_t i = 0; i < patch->count && (beyond == 0 || beyond == patch->count); i++)
		u->part[patch->triangles[i]] = 2 * i >= patch->count; /* all middles are the same, or nearly */
	return number_parts(u, patch, piece);
}

/* Flattens the patch by the map that stretches least. *good: one is there. */
static stilb_result flatten(bake_patch *patch, bool *good)
{
	bool projected;
	bake_patch_project(patch);
	stilb_result result = bake_patch_is_good(patch, &projected);
	*good = projected || patch->count == 1;
	if (result != STILB_OK || patch->count == 1 || (projected && patch->level))
		return result;
	double stretch = projected ? bake_patch_stretch(patch) : HUGE_VAL;
	double(*saved)[2] = stilb_memory_alloc(patch->vertex_count, sizeof *saved);
	if (!saved)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a chart of %u triangles", patch->count);
	memcpy(saved, patch->at, patch->vertex_count * sizeof *saved);
	result = bake_patch_conform(patch);
	if (result == STILB_OK)
		result = bake_patch_is_good(patch, good);
	if (projected && (!*good || bake_patch_stretch(patch) > stretch)) {
		memcpy(patch->at, saved, patch->vertex_count * sizeof *saved);
		*good = true;
	}
	free(saved);
	return result;
}

static void store_corners(unwrapping *u, const bake_patch *patch, const float size[2])
{
	for (uint32_t i = 0; i < 3 * patch->count; i++)
		for (int k = 0; k < 2; k++) {
			float at = (float)patch->at[patch->corner[i]][k];
			u->uv->corners[3 * (size_t)patch->triangles[i / 3] + i % 3][k] = at < size[k] ? at : size[k];
		}
}

static stilb_result unwrap_piece_flat(unwrapping *u, uint32_t index)
{
	unwrap_piece *piece = &u->pieces[index];
	bake_patch patch;
	bool good = false;
	stilb_result result =
		bake_patch_begin(&u->topology, &u->order[piece->first], piece->count, u->chart, u->local, &patch);
	if (result != STILB_OK)
		return result;
	result = flatten(&patch, &good);
	if (result == STILB_OK && good) {
		result = bake_patch_settle(&patch, piece->size);
		store_corners(u, &patch, piece->size);
		piece->state = PIECE_GOOD;
	} else if (result == STILB_OK) {
		piece->parts = cut_piece(u, &patch, index);
		piece->state = PIECE_CUT;
	}
	bake_patch_finish(&patch);
	return result;
}

/* stilb_job_range_fn */
static void unwrap_pieces(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	unwrapping *u = context;
	(void)worker;
	PROFILE("bake.unwrap");
	for (uint32_t i = begin; i < end; i++)
		if (unwrap_piece_flat(u, u->pending + i) != STILB_OK)
			atomic_store_explicit(&u->failed, true, memory_order_relaxed); /* relaxed: see unwrapping.failed */
}

/* ---- rounds ------------------------------------------------------------------------------------------------------ */

/* Sorts the triangles of a cut piece by part, in the same range, and appends the parts as pieces. counts: memory for as
 * many numbers as there are parts, and sorted for as many as triangles. */
static void append_parts(unwrapping *u, const unwrap_piece *cut, uint32_t *counts, uint32_t *sorted)
{
	memset(counts, 0, cut->parts * sizeof *counts);
	for (uint32_t i = 0; i < cut->count; i++)
		counts[u->part[u->order[cut->first + i]] - 2]++;
	for (uint32_t p = 0, first = cut->first; p < cut->parts; p++) {
		u->pieces[u->piece_count++] = (unwrap_piece){.first = first, .count = counts[p]};
		uint32_t count = counts[p];
		counts[p] = first - cut->first;
		first += count;
	}
	for (uint32_t i = 0; i < cut->count; i++) {
		uint32_t t = u->order[cut->first + i];
		sorted[counts[u->part[t] - 2]++] = t;
	}
	memcpy(&u->order[cut->first], sorted, cut->count * sizeof *sorted);
}

/* Makes pieces of what was cut. False: no memory. */
static bool next_round(unwrapping *u)
{
	uint32_t end = u->piece_count, parts = 0, most = 0;
	for (uint32_t i = u->pending; i < end; i++)
		if (u->pieces[i].state == PIECE_CUT) {
			parts += u->pieces[i].parts;
			most = u->pieces[i].count > most ? u->pieces[i].count : most;
		}
	unwrap_piece *more = realloc(u->pieces, ((size_t)end + parts + 1) * sizeof *more);
	uint32_t *memory = stilb_memory_alloc((size_t)2 * most, sizeof *memory);
	u->pieces = more ? more : u->pieces;
	for (uint32_t i = u->pending; i < end && more && memory; i++) {
		unwrap_piece cut = u->pieces[i];
		if (cut.state == PIECE_CUT)
			append_parts(u, &cut, memory, memory + most);
	}
	free(memory);
	u->pending = end;
	for (uint32_t i = end; i < u->piece_count; i++)
		for (uint32_t k = 0; k < u->pieces[i].count; k++)
			u->chart[u->order[u->pieces[i].first + k]] = i;
	return more && memory;
}

/* The first pieces: the grown charts. False: no memory. */
static bool first_round(unwrapping *u, uint32_t chart_count)
{
	u->pieces = calloc((size_t)chart_count + 1, sizeof *u->pieces);
	if (!u->pieces)
		return false;
	u->piece_count = chart_count;
	for (uint32_t t = 0; t < u->topology.triangle_count; t++)
		if (u->chart[t] != BAKE_NONE)
			u->pieces[u->chart[t]].count++;
	for (uint32_t i = 1; i < chart_count; i++)
		u->pieces[i].first = u->pieces[i - 1].first + u->pieces[i - 1].count;
	for (uint32_t i = 0; i < chart_count; i++)
		u->pieces[i].count = 0;
	for (uint32_t t = 0; t < u->topology.triangle_count; t++)
		if (u->chart[t] != BAKE_NONE) {
			unwrap_piece *piece = &u->pieces[u->chart[t]];
			u->order[piece->first + piece->count++] = t;
		}
	return true;
}

/* Numbers the good pieces as charts, in the order of their first triangles in `order`. */
static bool store_charts(unwrapping *u)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < u->piece_count; i++)
		count += u->pieces[i].state == PIECE_GOOD;
	u->uv->charts = stilb_memory_alloc(count, sizeof *u->uv->charts);
	if (!u->uv->charts)
		return false;
	for (uint32_t i = 0; i < u->piece_count; i++) {
		const unwrap_piece *piece = &u->pieces[i];
		if (piece->state != PIECE_GOOD)
			continue;
		for (uint32_t k = 0; k < piece->count; k++)
			u->uv->chart[u->order[piece->first + k]] = u->uv->chart_count;
		u->uv->charts[u->uv->chart_count++] =
			(stilb_bake_chart){piece->first, piece->count, piece->size[0], piece->size[1]};
	}
	return true;
}

static bool unwrap_rounds(unwrapping *u, const stilb_bake_unwrap_options *options, stilb_job_pool *pool,
                          uint32_t worker)
{
	uint32_t chart_count;
	if (bake_grow(&u->topology, options, u->chart, &chart_count) != STILB_OK || !first_round(u, chart_count))
		return false;
	while (u->pending < u->piece_count) {
		stilb_job_parallel_for(pool, u->piece_count - u->pending, 1, unwrap_pieces, u, worker);
		if (atomic_load_explicit(&u->failed, memory_order_relaxed) || !next_round(u)) /* relaxed: unwrapping.failed */
			return false;
	}
	return store_charts(u);
}

stilb_result stilb_bake_unwrap(const stilb_bake_mesh *mesh, const stilb_bake_unwrap_options *options,
                               stilb_job_pool *pool, uint32_t worker, stilb_bake_uv *uv)
{
	STILB_ASSERT(mesh && pool && uv);
	STILB_ASSERT(mesh->triangle_count <= UINT32_MAX / 3 - 1);
	stilb_bake_unwrap_options standard = stilb_bake_unwrap_options_default();
	const stilb_bake_unwrap_options *used = options ? options : &standard;
	STILB_ASSERT(used->cone > 0.0f && used->cone < 1.5707964f && used->crease > 0.0f);
	size_t count = mesh->triangle_count;
	unwrapping u = {.uv = uv};
	*uv = (stilb_bake_uv){.triangle_count = mesh->triangle_count};
	stilb_result result = bake_topology_create(mesh, &u.topology);
	if (result != STILB_OK)
		return result;
	uv->flat = u.topology.flat;
	uv->invalid = u.topology.invalid;
	uv->odd_edges = u.topology.odd_edges;
	uv->corners = calloc(3 * count + 1, sizeof *uv->corners);
	uv->chart = u.chart = stilb_memory_alloc(count, sizeof *u.chart);
	uv->triangles = u.order = stilb_memory_alloc(count, sizeof *u.order);
	u.local = stilb_memory_alloc(count, sizeof *u.local);
	u.part = stilb_memory_alloc(count, sizeof *u.part);
	bool good = uv->corners && u.chart && u.order && u.local && u.part && unwrap_rounds(&u, used, pool, worker);
	free(u.local);
	free(u.part);
	free(u.pieces);
	bake_topology_finish(&u.topology);
	if (good)
		return STILB_OK;
	stilb_bake_uv_finish(uv);
	return stilb_fail(STILB_ERROR_MEMORY, "out of memory to unwrap %u triangles", mesh->triangle_count);
}

/* ---- what comes of it -------------------------------------------------------------------------------------------- */

double stilb_bake_stretch(const stilb_bake_mesh *mesh, const stilb_bake_uv *uv)
{
	double sum = 0.0, area = 0.0, map_area = 0.0;
	for (uint32_t t = 0; t < uv->triangle_count; t++) {
		double p[3][3], n[3], squares = 0.0;
		if (uv->chart[t] == STILB_BAKE_NO_CHART)
			continue;
		for (int i = 0; i < 3; i++) {
			size_t offset = mesh->indices[3 * (size_t)t + (size_t)i] * mesh->position_step;
			const float *position = (const float *)((const char *)mesh->positions + offset);
			for (int k = 0; k < 3; k++)
				p[i][k] = (double)position[k];
		}
		const float(*at)[2] = (const float(*)[2]) & uv->corners[3 * (size_t)t];
		double ax = (double)at[0][0], ay = (double)at[0][1], bx = (double)at[1][0], by = (double)at[1][1],
			   cx = (double)at[2][0], cy = (double)at[2][1];
		double area2 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
		if (!(area2 > 0.0)) /* rounded to nothing: a millimetre on a map of 10 km */
			continue;
		for (int k = 0; k < 3; k++) {
			double s = (p[0][k] * (by - cy) + p[1][k] * (cy - ay) + p[2][k] * (ay - by)) / area2;
			double r = (p[0][k] * (cx - bx) + p[1][k] * (ax - cx) + p[2][k] * (bx - ax)) / area2;
			squares += s * s + r * r;
			int x = (k + 1) % 3, y = (k + 2) % 3;
			n[k] = (p[1][x] - p[0][x]) * (p[2][y] - p[0][y]) - (p[1][y] - p[0][y]) * (p[2][x] - p[0][x]);
		}
		double own = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		sum += 0.5 * squares * own;
		area += own;
		map_area += 0.5 * area2;
	}
	return area > 0.0 ? sqrt(sum / area) * sqrt(map_area / area) : 1.0;
}
