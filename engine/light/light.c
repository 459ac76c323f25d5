/* Builds a view's lists: the lights that reach it, the cells of each, and from these the lights of each cell. */
#include "light/light.h"
#include "light/light_lists.h"
#include "light/light_reached.h"
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

/* Finds the lights and their cells. *pairs: of light and cell. */
static stilb_result build_spans(light_build *build, uint64_t *pairs)
{
	stilb_result result = light_reaching_find(build);
	if (result == STILB_OK)
		result = light_bands_fill(build);
	*pairs = 0;
	const light_view *view = &build->scratch->view;
	for (uint32_t b = 0; result == STILB_OK && b < light_bands(view) * view->slices; b++) {
		light_band *band = &build->scratch->bands[b];
		band->first_id = *pairs;
		*pairs += band->id_count;
	}
	return result;
}

static bool build_is_endless(const stilb_scene_light *light)
{
	return light->kind != STILB_SCENE_LIGHT_DIRECTIONAL && light->falloff == STILB_SCENE_LIGHT_PHYSICAL &&
	       light->use != STILB_SCENE_LIGHT_BAKED && light_reach(light, 0.0) > 0.0;
}

/* Shares the tolerance: half of it ends lamps that have no end, each where it sends the same part of that half. The
 * other half, or all if there are none, is for what is left out of the lists. Returns the number of these lamps. */
static uint64_t build_share(light_build *build)
{
	const stilb_light_grid *grid = build->grid;
	uint64_t endless = 0;
	if (!(grid->tolerance > 0.0f))
		return 0;
	for (uint32_t i = 0; build->lights && i < build->count; i++)
		endless += build_is_endless(&build->lights[build->candidates ? build->candidates[i] : i]);
	double all = (double)grid->tolerance / (double)grid->peak;
	build->prunable = endless > 0 ? 0.5 * all : all;
	build->irradiance = endless > 0 ? 0.5 * all / (double)endless : 0.0;
	return endless;
}

/* Pairs of lamps without an end and cells that are in the lists. */
static uint64_t build_endless_pairs(const light_build *build)
{
	const stilb_light_lists *lists = build->lists;
	const uint32_t *own = lists->lights + lists->everywhere_count;
	uint64_t pairs = 0, cells = (uint64_t)lists->columns * lists->rows * lists->slices;
	for (uint32_t i = 0; i < lists->everywhere_count; i++)
		pairs += build_is_endless(&build->lights[lists->lights[i]]) ? cells : 0;
	for (uint32_t i = 0; i < lists->id_count; i++)
		pairs += build_is_endless(&build->lights[own[lists->ids[i]]]);
	return pairs;
}

/* Writes the lights that reach the view. */
static stilb_result build_lights(const light_build *build)
{
	struct light_scratch *scratch = build->scratch;
	stilb_light_lists *lists = build->lists;
	const light_reaching *r = &scratch->reaching;
	lists->everywhere_count = r->everywhere_count;
	lists->light_count = r->everywhere_count + r->count;
	if (!lists_reserve(&lists->lights, &scratch->light_capacity, lists->light_count))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights", lists->light_count);
	uint32_t *own = lists->lights + lists->everywhere_count, *everywhere = lists->lights;
	for (uint32_t c = 0; c < r->chunk_count; c++) {
		size_t first = (size_t)c * LIGHT_CHUNK;
		memcpy(own + first - r->chunks[c].gap, r->index + first, r->chunks[c].count * sizeof *own);
		memcpy(everywhere, r->everywhere + first, r->chunks[c].everywhere_count * sizeof *everywhere);
		everywhere += r->chunks[c].everywhere_count;
	}
	return STILB_OK;
}

/* Writes the lists. */
static stilb_result build_write(light_build *build, uint64_t pairs)
{
	struct light_scratch *scratch = build->scratch;
	stilb_light_lists *lists = build->lists;
	uint64_t cells = (uint64_t)lists->columns * lists->rows * lists->slices;
	stilb_result result = build_lights(build);
	if (result != STILB_OK)
		return result;
	if (!lists_reserve(&lists->starts, &scratch->start_capacity, cells + 1) || pairs > UINT32_MAX ||
	    !lists_reserve(&lists->ids, &scratch->id_capacity, pairs))
		return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %llu pairs of light and cell",
		                  (unsigned long long)pairs);
	lists->id_count = (uint32_t)pairs;
	lists->starts[cells] = (uint32_t)pairs;
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

/* What is asked for. */
static light_build build_of(stilb_light_lists *lists, const stilb_light_grid *grid, const stilb_scene_light *lights,
                            uint32_t count, const uint32_t *candidates, uint32_t candidate_count, stilb_job_pool *pool,
                            uint32_t worker)
{
	STILB_ASSERT(lists && grid);
	STILB_ASSERT(lights || count == 0);
	STILB_ASSERT(!pool || worker <= stilb_job_pool_worker_count(pool));
	return (light_build){.lists = lists,
	                     .grid = grid,
	                     .lights = lights,
	                     .candidates = candidates,
	                     .count = candidates ? candidate_count : count,
	                     .pool = pool,
	                     .worker = worker};
}

/* Shares the tolerance and cuts the view into cells. *endless: lamps that the tolerance ends. */
static stilb_result build_begin(light_build *build, uint64_t *endless)
{
	stilb_light_lists *lists = build->lists;
	*endless = build_share(build);
	lists_clear(lists);
	stilb_result result = lists->scratch ? STILB_OK : scratch_make(lists);
	build->scratch = lists->scratch;
	return result == STILB_OK ? light_view_make(&build->scratch->view, build->grid, lists) : result;
}

stilb_result stilb_light_lists_build(stilb_light_lists *lists, const stilb_light_grid *grid,
                                     const stilb_scene_light *lights, uint32_t count, const uint32_t *candidates,
                                     uint32_t candidate_count, stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("light");
	light_build build = build_of(lists, grid, lights, count, candidates, candidate_count, pool, worker);
	uint64_t pairs, endless, kept = 0;
	stilb_result result = build_begin(&build, &endless);
	if (result == STILB_OK)
		result = build_spans(&build, &pairs);
	if (result == STILB_OK)
		result = build_write(&build, pairs);
	if (result == STILB_OK && build.prunable > 0.0) {
		kept = endless > 0 ? build_endless_pairs(&build) : 0;
		result = light_prune(&build);
		uint64_t cells = (uint64_t)lists->columns * lists->rows * lists->slices;
		uint64_t left_out = endless * cells - kept + (pairs - lists->id_count);
		lists->left_out = left_out < UINT32_MAX ? (uint32_t)left_out : UINT32_MAX;
	}
	if (result != STILB_OK)
		lists_clear(lists);
	return result;
}

stilb_result stilb_light_reached_find(stilb_light_lists *lists, const stilb_light_grid *grid,
                                      const stilb_scene_light *lights, uint32_t count, const uint32_t *candidates,
                                      uint32_t candidate_count, stilb_job_pool *pool, uint32_t worker)
{
	PROFILE("light");
	light_build build = build_of(lists, grid, lights, count, candidates, candidate_count, pool, worker);
	uint64_t endless;
	stilb_result result = build_begin(&build, &endless);
	if (result == STILB_OK)
		result = light_reaching_find(&build);
	if (result == STILB_OK)
		result = build_lights(&build);
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
		free(lists->scratch->weak);
	}
	free(lists->scratch);
	free(lists->lights);
	free(lists->starts);
	free(lists->ids);
	*lists = (stilb_light_lists){0};
}
