/* Builds a view's lists: the lights that reach it, the cells of each, and from these the lights of each cell. */
#include "light/light.h"
#include "light/light_lists.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const light_kernels *light_kernels_for(stilb_isa isa)
{
	STILB_ASSERT(isa < STILB_ISA_COUNT);
#if defined(__x86_64__)
	if (isa == STILB_ISA_AVX512)
		return &light_kernels_avx512;
	if (isa == STILB_ISA_AVX2)
		return &light_kernels_avx2;
#endif
	return &light_kernels_scalar;
}

/* Makes room for `count` elements of which the array holds none. What is more than half as large again is given back.
 * */
static bool lists_reserve(uint32_t **array, uint32_t *capacity, uint64_t count)
{
	uint64_t least = count + LIGHT_LANES;
	if (*array && *capacity >= least && *capacity <= least + least / 4 + 1024)
		return true;
	free(*array);
	*capacity = 0;
	uint64_t room = least + least / 8;
	*array = room < UINT32_MAX ? stilb_memory_alloc((size_t)room, sizeof **array) : NULL;
	*capacity = *array ? (uint32_t)room : 0;
	return *array;
}

/* Writes the lists of a row's cells. end: of the lists of its band; those before `from` are written. */
static void row_fill(const struct light_scratch *scratch, const light_row *row, uint32_t *cursors, uint32_t from,
                     uint32_t end, uint32_t *ids)
{
	uint32_t columns = scratch->view.columns;
	for (uint32_t i = 0; i < row->count; i++) /* gaps end here */
		row->numbers[i] -= scratch->reaching.chunks[row->numbers[i] / LIGHT_CHUNK].gap;
	uint64_t pairs = cursors[columns] - from, tests = (uint64_t)row->count * columns;
	if (pairs * LIGHT_DENSE > tests)
		scratch->kernels->fill_dense(row->numbers, row->spans, row->count, cursors, columns, end, ids);
	else
		light_fill(row->numbers, row->spans, row->count, cursors, ids);
}

/* Writes the lists of bands begin .. end - 1. */
static void light_job_lists(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.lists");
	(void)worker;
	const light_build *build = context;
	const struct light_scratch *scratch = build->scratch;
	stilb_light_lists *lists = build->lists;
	const light_view *view = &scratch->view;
	uint32_t count = light_bands(view) * view->slices;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t number = count - 1 - i; /* in about the order in which they were made */
		const light_band *band = &scratch->bands[number];
		uint32_t slice = number / light_bands(view), first = light_band_row(view, number % light_bands(view));
		uint32_t last = light_band_row(view, number % light_bands(view) + 1), id = (uint32_t)band->first_id;
		uint32_t band_end = (uint32_t)(band->first_id + band->id_count);
		for (uint32_t r = first; r < last; r++) {
			uint32_t *cursors = light_counters(scratch, slice, r), from = id;
			uint32_t *starts = lists->starts + ((size_t)slice * view->rows + r) * view->columns;
			for (uint32_t c = 0; c < view->columns; c++) {
				uint32_t length = cursors[c];
				cursors[c] = starts[c] = id;
				id += length;
			}
			cursors[view->columns] = id;
			row_fill(scratch, &band->rows[r - first], cursors, from, band_end, lists->ids);
		}
		STILB_ASSERT(id == band_end);
	}
}

/* Finds the lights and their cells for an irradiance that a light may send where it is left out; *pairs: of light and
 * cell; *longest: list. */
static stilb_result build_find(light_build *build, double irradiance, uint64_t *pairs, uint32_t *longest)
{
	build->irradiance = irradiance;
	stilb_result result = light_reaching_find(build);
	if (result == STILB_OK)
		result = light_bands_fill(build);
	*pairs = 0;
	*longest = 0;
	const light_view *view = &build->scratch->view;
	for (uint32_t b = 0; result == STILB_OK && b < light_bands(view) * view->slices; b++) {
		light_band *band = &build->scratch->bands[b];
		band->first_id = *pairs;
		*pairs += band->id_count;
		*longest = band->longest > *longest ? band->longest : *longest;
	}
	return result;
}

/* Lamps whose light does not end. */
static uint64_t build_endless(const light_build *build)
{
	const light_reaching *r = &build->scratch->reaching;
	uint64_t endless = 0;
	for (uint32_t c = 0; c < r->chunk_count; c++)
		for (uint32_t i = 0; i < r->chunks[c].everywhere_count; i++) {
			uint32_t index = r->everywhere[c * LIGHT_CHUNK + i];
			endless += build->lights[index].kind != STILB_SCENE_LIGHT_DIRECTIONAL;
		}
	return endless;
}

/* With a tolerance, the lists without one say how many lights a cell has at most, and each may send as large a part of
 * it where it is left out. */
static stilb_result build_spans(light_build *build, uint64_t *pairs)
{
	const stilb_light_grid *grid = build->grid;
	stilb_light_lists *lists = build->lists;
	uint64_t cells = (uint64_t)lists->columns * lists->rows * lists->slices;
	uint32_t longest;
	stilb_result result = build_find(build, 0.0, pairs, &longest);
	if (result != STILB_OK || !(grid->tolerance > 0.0f))
		return result;
	uint64_t endless = build_endless(build), most = longest + endless, all = *pairs + endless * cells;
	if (most == 0)
		return STILB_OK;
	double share = (double)grid->tolerance / ((double)grid->peak * (double)most);
	result = build_find(build, share, pairs, &longest);
	uint64_t kept = *pairs + build_endless(build) * cells, left_out = all > kept ? all - kept : 0;
	lists->left_out = left_out < UINT32_MAX ? (uint32_t)left_out : UINT32_MAX;
	return result;
}

/* Writes the lists. */
static stilb_result build_write(light_build *build, uint64_t pairs)
{
	struct light_scratch *scratch = build->scratch;
	stilb_light_lists *lists = build->lists;
	const light_reaching *r = &scratch->reaching;
	lists->everywhere_count = r->everywhere_count;
	lists->light_count = r->everywhere_count + r->count;
	uint64_t cells = (uint64_t)lists->columns * lists->rows * lists->slices;
	if (!lists_reserve(&lists->lights, &scratch->light_capacity, lists->light_count) ||
	    !lists_reserve(&lists->starts, &scratch->start_capacity, cells + 1) || pairs > UINT32_MAX ||
	    !lists_reserve(&lists->ids, &scratch->id_capacity, pairs))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %llu pairs of light and cell",
		                  (unsigned long long)pairs);
	lists->id_count = (uint32_t)pairs;
	lists->starts[cells] = (uint32_t)pairs;
	uint32_t *own = lists->lights + lists->everywhere_count, *everywhere = lists->lights;
	for (uint32_t c = 0; c < r->chunk_count; c++) {
		size_t first = (size_t)c * LIGHT_CHUNK;
		memcpy(own + first - r->chunks[c].gap, r->index + first, r->chunks[c].count * sizeof *own);
		memcpy(everywhere, r->everywhere + first, r->chunks[c].everywhere_count * sizeof *everywhere);
		everywhere += r->chunks[c].everywhere_count;
	}
	light_spread(build, light_bands(&scratch->view) * lists->slices, light_job_lists);
	return STILB_OK;
}

static void lists_clear(stilb_light_lists *lists)
{
	lists->light_count = lists->everywhere_count = lists->id_count = lists->left_out = 0;
	lists->columns = lists->rows = lists->slices = 0;
}

/* Finds the instruction set on the first call. */
static stilb_result scratch_make(stilb_light_lists *lists)
{
	stilb_isa isa;
	stilb_result result = stilb_cpu_isa(&isa);
	if (result != STILB_OK)
		return result;
	lists->scratch = stilb_memory_alloc(1, sizeof *lists->scratch);
	if (!lists->scratch)
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory");
	memset(lists->scratch, 0, sizeof *lists->scratch);
	lists->scratch->kernels = light_kernels_for(isa);
	lists->scratch->serial_below = LIGHT_SERIAL_BELOW;
	return STILB_OK;
}

stilb_result stilb_light_lists_build(stilb_light_lists *lists, const stilb_light_grid *grid,
                                     const stilb_scene_light *lights, uint32_t count, const uint32_t *candidates,
                                     uint32_t candidate_count, stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("light");
	STILB_ASSERT(lists && grid);
	STILB_ASSERT(lights || count == 0);
	STILB_ASSERT(!pool || worker <= stilb_job_pool_worker_count(pool));
	light_build build = {.lists = lists,
	                     .grid = grid,
	                     .lights = lights,
	                     .candidates = candidates,
	                     .count = candidates ? candidate_count : count,
	                     .pool = pool,
	                     .worker = worker};
	uint64_t pairs;
	lists_clear(lists);
	stilb_result result = lists->scratch ? STILB_OK : scratch_make(lists);
	build.scratch = lists->scratch;
	if (result == STILB_OK)
		result = light_view_make(&build.scratch->view, grid, lists);
	if (result == STILB_OK)
		result = build_spans(&build, &pairs);
	if (result == STILB_OK)
		result = build_write(&build, pairs);
	if (result != STILB_OK)
		lists_clear(lists);
	return result;
}

void stilb_light_lists_finish(stilb_light_lists *lists)
{
	if (!lists)
		return;
	if (lists->scratch) {
		light_view_finish(&lists->scratch->view);
		light_reaching_finish(&lists->scratch->reaching);
		light_bands_finish(lists->scratch);
	}
	free(lists->scratch);
	free(lists->lights);
	free(lists->starts);
	free(lists->ids);
	*lists = (stilb_light_lists){0};
}
