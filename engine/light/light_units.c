/* Which cells each light of a view reaches. */
#include "light/light_lists.h"
#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

#define UNIT_GROWTH 256u /* the least number of masks that a unit has room for */

void light_units_finish(struct light_scratch *scratch)
{
	for (uint32_t u = 0; u < scratch->unit_capacity; u++) {
		free(scratch->units[u].masks);
		free(scratch->units[u].segments);
	}
	free(scratch->units);
	free(scratch->counters);
	scratch->units = NULL;
	scratch->counters = NULL;
	scratch->unit_capacity = 0;
	scratch->counter_capacity = 0;
}

static bool units_reserve(struct light_scratch *scratch)
{
	uint32_t units = light_units(&scratch->view);
	size_t counters = (size_t)units * light_blocks(&scratch->view) * LIGHT_BLOCK_CELLS;
	if (units > scratch->unit_capacity || counters > scratch->counter_capacity) {
		light_units_finish(scratch);
		scratch->units = stilb_memory_alloc(units, sizeof *scratch->units);
		scratch->counters = stilb_memory_alloc(counters, sizeof *scratch->counters);
		if (!scratch->units || !scratch->counters)
			return false;
		memset(scratch->units, 0, units * sizeof *scratch->units);
		scratch->unit_capacity = units;
		scratch->counter_capacity = counters;
	}
	return true;
}

/* Room for so many masks more, and one segment. The lights lie behind the masks. */
static bool unit_reserve(light_unit *unit, uint32_t more)
{
	if (unit->segment_count == unit->segment_capacity) {
		uint32_t capacity = 2 * unit->segment_capacity + LIGHT_LANES;
		light_segment *segments = stilb_memory_alloc(capacity, sizeof *segments);
		if (!segments)
			return false;
		if (unit->segment_count > 0)
			memcpy(segments, unit->segments, unit->segment_count * sizeof *segments);
		free(unit->segments);
		unit->segments = segments;
		unit->segment_capacity = capacity;
	}
	if (unit->count + more <= unit->capacity)
		return true;
	uint32_t capacity = 2 * (unit->count + more) + UNIT_GROWTH;
	uint64_t *masks = stilb_memory_alloc(capacity, sizeof *masks + sizeof *unit->lights);
	if (!masks)
		return false;
	uint32_t *lights = (uint32_t *)(masks + capacity);
	if (unit->count > 0) {
		memcpy(masks, unit->masks, unit->count * sizeof *masks);
		memcpy(lights, unit->lights, unit->count * sizeof *lights);
	}
	free(unit->masks);
	unit->masks = masks;
	unit->lights = lights;
	unit->capacity = capacity;
	return true;
}

static light_chunk reaching_chunk(const light_reaching *r, uint32_t first)
{
	uint32_t count = r->count - first < LIGHT_CHUNK ? r->count - first : LIGHT_CHUNK;
	return (light_chunk){r->x + first,      r->y + first,           r->w + first,          r->depth + first,
	                     r->radius + first, r->first_slice + first, r->last_slice + first, count};
}

/* The cells of a block that the view has. */
static uint64_t block_cells(const light_view *view, const light_band *band, uint32_t first_column)
{
	uint32_t columns = view->columns - first_column < LIGHT_BLOCK ? view->columns - first_column : LIGHT_BLOCK;
	uint64_t row = (1u << columns) - 1, cells = 0;
	for (uint32_t r = 0; r < band->end_row - band->first_row; r++)
		cells |= row << (LIGHT_BLOCK * r);
	return cells;
}

/* The cells of a mask that the light's cone meets. */
static uint64_t cone_cells(const light_view *view, const light_band *band, uint32_t first_column,
                           const light_cone *cone, uint64_t mask)
{
	for (uint64_t left = mask; left; left &= left - 1) {
		uint32_t bit = (uint32_t)__builtin_ctzll(left);
		if (!light_cone_meets(view, cone, first_column + bit % LIGHT_BLOCK, band->first_row + bit / LIGHT_BLOCK,
		                      band->slice))
			mask &= ~(1ull << bit);
	}
	return mask;
}

/* Adds the lights at `places`, of the chunk that begins with light `first`, to a block. */
static bool unit_add(const struct light_scratch *scratch, light_unit *unit, const light_band *band,
                     const light_picked *picked, const uint32_t *places, uint32_t count, uint32_t first, uint32_t block)
{
	const light_view *view = &scratch->view;
	uint32_t first_column = block * LIGHT_BLOCK, kept = 0;
	if (!unit_reserve(unit, count))
		return false;
	uint64_t *masks = unit->masks + unit->count;
	uint32_t *lights = unit->lights + unit->count;
	uint64_t cells = block_cells(view, band, first_column);
	scratch->kernels->cells(band, picked, places, count, &view->column_planes, first_column, masks);
	for (uint32_t i = 0; i < count; i++) {
		uint64_t mask = masks[i] & cells;
		uint32_t light = first + picked->at[places[i]];
		if (mask && scratch->reaching.cones[light].some)
			mask = cone_cells(view, band, first_column, &scratch->reaching.cones[light], mask);
		masks[kept] = mask;
		lights[kept] = light;
		kept += mask != 0;
	}
	if (kept > 0)
		unit->segments[unit->segment_count++] = (light_segment){block, kept};
	unit->count += kept;
	return true;
}

static light_band unit_band(const light_view *view, uint32_t number)
{
	uint32_t slice = number / light_bands(view), row = number % light_bands(view) * LIGHT_BLOCK;
	return (light_band){
		.rows = &view->row_planes,
		.slice = slice,
		.first_row = row,
		.end_row = view->rows - row < LIGHT_BLOCK ? view->rows : row + LIGHT_BLOCK,
		.near_z = view->near_z[slice],
		.far_z = view->far_z[slice],
		.along = {view->along[0], view->along[1], view->along[2]},
	};
}

/* Finds the masks of a unit. False: no memory. */
static bool unit_find(const struct light_scratch *scratch, light_unit *unit, uint32_t number)
{
	const light_view *view = &scratch->view;
	const light_reaching *r = &scratch->reaching;
	light_band band = unit_band(view, number);
	light_picked picked;
	uint32_t places[LIGHT_CHUNK + LIGHT_LANES];
	unit->count = 0;
	unit->segment_count = 0;
	for (uint32_t first = 0; first < r->count; first += LIGHT_CHUNK) {
		light_chunk chunk = reaching_chunk(r, first);
		uint32_t count = scratch->kernels->pick(&band, &chunk, &picked);
		for (uint32_t block = 0; count > 0 && block < light_blocks(view); block++) {
			uint32_t column = block * LIGHT_BLOCK, end = column + LIGHT_BLOCK;
			uint32_t found = scratch->kernels->columns(&picked, count, &view->column_planes, column,
			                                           end < view->columns ? end : view->columns, places);
			if (found > 0 && !unit_add(scratch, unit, &band, &picked, places, found, first, block))
				return false;
		}
	}
	return true;
}

/* Counts the unit's masks for each cell. */
static void unit_count(const struct light_scratch *scratch, light_unit *unit, uint32_t number)
{
	uint32_t blocks = light_blocks(&scratch->view), at = 0;
	uint32_t *counters = scratch->counters + (size_t)number * blocks * LIGHT_BLOCK_CELLS;
	memset(counters, 0, blocks * LIGHT_BLOCK_CELLS * sizeof *counters);
	for (uint32_t s = 0; s < unit->segment_count; s++) {
		light_segment segment = unit->segments[s];
		scratch->kernels->count(unit->masks + at, segment.count, counters + (size_t)segment.block * LIGHT_BLOCK_CELLS);
		at += segment.count;
	}
	unit->id_count = 0;
	unit->longest = 0;
	for (uint32_t i = 0; i < blocks * LIGHT_BLOCK_CELLS; i++) {
		unit->id_count += counters[i];
		unit->longest = counters[i] > unit->longest ? counters[i] : unit->longest;
	}
}

static void light_job_units(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.units");
	(void)worker;
	light_build *build = context;
	for (uint32_t number = begin; number < end; number++) {
		light_unit *unit = &build->scratch->units[number];
		if (unit_find(build->scratch, unit, number))
			unit_count(build->scratch, unit, number);
		else
			atomic_store_explicit(&build->failed, true, memory_order_relaxed);
	}
}

stilb_result light_units_fill(light_build *build)
{
	struct light_scratch *scratch = build->scratch;
	if (units_reserve(scratch)) {
		light_spread(build, light_units(&scratch->view), light_job_units);
		if (!atomic_load_explicit(&build->failed, memory_order_relaxed))
			return STILB_OK;
	}
	return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights in %u x %u x %u cells",
	                  scratch->reaching.count, scratch->view.columns, scratch->view.rows, scratch->view.slices);
}
