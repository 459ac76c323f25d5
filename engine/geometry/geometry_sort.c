/* Loops on a pool, a stable radix sort, and the welding of positions. */
#include "geometry/geometry_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DIGIT_BITS 11
#define DIGITS (1u << DIGIT_BITS)
#define CHUNK 65536u /* elements that one job counts and moves */

void geometry_for(stilb_job_pool *pool, uint32_t worker, uint32_t count, uint32_t grain, stilb_job_range_fn *fn,
                  void *context)
{
	if (pool)
		stilb_job_parallel_for(pool, count, grain, fn, context, worker);
	else if (count > 0)
		fn(0, count, worker, context);
}

typedef struct sort_pass {
	const geometry_keyed *in;
	geometry_keyed *out;
	uint32_t count, shift;
	uint32_t (*starts)[DIGITS]; /* [chunk] how many of each digit; then where the next of them goes */
} sort_pass;

static uint32_t digit_of(const sort_pass *pass, uint32_t i)
{
	return pass->in[i].key >> pass->shift & (DIGITS - 1);
}

static void sort_count(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const sort_pass *pass = context;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t last = pass->count - chunk * CHUNK < CHUNK ? pass->count : (chunk + 1) * CHUNK;
		memset(pass->starts[chunk], 0, sizeof pass->starts[chunk]);
		for (uint32_t i = chunk * CHUNK; i < last; i++)
			pass->starts[chunk][digit_of(pass, i)]++;
	}
}

static void sort_move(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const sort_pass *pass = context;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t last = pass->count - chunk * CHUNK < CHUNK ? pass->count : (chunk + 1) * CHUNK;
		for (uint32_t i = chunk * CHUNK; i < last; i++)
			pass->out[pass->starts[chunk][digit_of(pass, i)]++] = pass->in[i];
	}
}

bool geometry_sort(stilb_job_pool *pool, uint32_t worker, geometry_keyed *items, geometry_keyed *other, uint32_t count,
                   uint32_t bits, geometry_keyed **sorted)
{
	uint32_t chunks = count / CHUNK + (count % CHUNK != 0);
	sort_pass pass = {.in = items, .out = other, .count = count};
	*sorted = items;
	if (count == 0)
		return true;
	pass.starts = stilb_memory_alloc(chunks, sizeof *pass.starts);
	if (!pass.starts)
		return false;
	for (pass.shift = 0; pass.shift < bits; pass.shift += DIGIT_BITS) {
		geometry_for(pool, worker, chunks, 1, sort_count, &pass);
		uint32_t sum = 0;
		for (uint32_t digit = 0; digit < DIGITS; digit++)
			for (uint32_t chunk = 0; chunk < chunks; chunk++) {
				uint32_t n = pass.starts[chunk][digit];
				pass.starts[chunk][digit] = sum;
				sum += n;
			}
		geometry_for(pool, worker, chunks, 1, sort_move, &pass);
		*sorted = pass.out;
		pass.out = (geometry_keyed *)pass.in;
		pass.in = *sorted;
	}
	free(pass.starts);
	return true;
}

/* ---- welding ----------------------------------------------------------------------------------------------------- */

#define WELD_DISTINCT 32 /* positions of one hash that are told apart; more are an attack, and are not welded */

typedef struct weld {
	const stilb_geometry_mesh *mesh;
	geometry_keyed *items;
	uint32_t *canonical;
} weld;

/* The bits of a position; -0 becomes 0. False: it is not finite. */
static bool position_bits(const stilb_geometry_mesh *mesh, uint32_t vertex, uint32_t bits[3])
{
	const float *p = geometry_position(mesh, vertex);
	for (int k = 0; k < 3; k++) {
		float value = p[k] + 0.0f;
		if (!isfinite(value))
			return false;
		memcpy(&bits[k], &value, sizeof value);
	}
	return true;
}

static void weld_hash(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const weld *w = context;
	for (uint32_t v = begin; v < end; v++) {
		uint32_t bits[3] = {0};
		uint32_t hash = 0;
		if (position_bits(w->mesh, v, bits)) {
			uint64_t mixed = bits[0] * 0x9e3779b97f4a7c15u ^ (bits[1] + 0x7f4a7c15u) * 0xbf58476d1ce4e5b9u;
			mixed = (mixed ^ mixed >> 29 ^ bits[2]) * 0x94d049bb133111ebu;
			hash = (uint32_t)(mixed >> 32);
		}
		w->items[v] = (geometry_keyed){hash, v};
		w->canonical[v] = v;
	}
}

/* Runs of equal hashes that begin in the range. */
static void weld_runs(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const weld *w = context;
	const geometry_keyed *items = w->items;
	for (uint32_t i = begin; i < end; i++) {
		if (i > 0 && items[i - 1].key == items[i].key)
			continue;
		uint32_t distinct[WELD_DISTINCT], bits[WELD_DISTINCT][3], count = 0;
		for (uint32_t j = i; j < w->mesh->vertex_count && items[j].key == items[i].key; j++) {
			uint32_t own[3], k = 0;
			if (!position_bits(w->mesh, items[j].value, own))
				continue;
			while (k < count && memcmp(bits[k], own, sizeof own) != 0)
				k++;
			if (k < count)
				w->canonical[items[j].value] = distinct[k];
			else if (count < WELD_DISTINCT) {
				distinct[count] = items[j].value;
				memcpy(bits[count++], own, sizeof own);
			}
		}
	}
}

bool geometry_weld(const stilb_geometry_mesh *mesh, stilb_job_pool *pool, uint32_t worker, uint32_t *canonical)
{
	uint32_t count = mesh->vertex_count;
	geometry_keyed *items = stilb_memory_alloc(count, 2 * sizeof *items);
	if (!items)
		return false;
	weld w = {.mesh = mesh, .items = items, .canonical = canonical};
	geometry_for(pool, worker, count, 8192, weld_hash, &w);
	bool sorted = geometry_sort(pool, worker, items, items + count, count, 32, &w.items);
	if (sorted)
		geometry_for(pool, worker, count, 8192, weld_runs, &w);
	free(items);
	return sorted;
}
