/* Which cells each light of a view reaches. */
#include "light/light_lists.h"
#include "light/light_scalar.h"
#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

void light_bands_finish(struct light_scratch *scratch)
{
	for (uint32_t b = 0; b < scratch->band_capacity; b++)
		free(scratch->bands[b].rows[0].numbers);
	free(scratch->bands);
	free(scratch->counters);
	scratch->bands = NULL;
	scratch->counters = NULL;
	scratch->band_capacity = 0;
	scratch->counter_capacity = 0;
}

static bool bands_reserve(struct light_scratch *scratch)
{
	const light_view *view = &scratch->view;
	uint32_t bands = light_bands(view) * view->slices;
	size_t counters = (size_t)view->slices * view->rows * (view->columns + 1);
	if (bands <= scratch->band_capacity && counters <= scratch->counter_capacity)
		return true;
	light_bands_finish(scratch);
	scratch->bands = stilb_memory_alloc(bands, sizeof *scratch->bands);
	if (!scratch->bands)
		return false;
	memset(scratch->bands, 0, bands * sizeof *scratch->bands);
	scratch->band_capacity = bands;
	scratch->counters = stilb_memory_alloc(counters, sizeof *scratch->counters);
	if (!scratch->counters)
		return false;
	scratch->counter_capacity = counters;
	return true;
}

/* Room for so many lights more in each row. */
static bool band_reserve(light_band *band, uint32_t more)
{
	uint32_t most = 0;
	for (uint32_t r = 0; r < LIGHT_BAND_ROWS; r++)
		most = band->rows[r].count > most ? band->rows[r].count : most;
	if (most + more <= band->capacity)
		return true;
	uint32_t capacity = 2 * most + more;
	size_t size = sizeof(uint32_t) + sizeof(light_span);
	uint32_t *memory = stilb_memory_alloc((size_t)capacity * LIGHT_BAND_ROWS, size);
	if (!memory)
		return false;
	uint32_t *old = band->rows[0].numbers;
	for (uint32_t r = 0; r < LIGHT_BAND_ROWS; r++) {
		light_row *row = &band->rows[r];
		uint32_t *numbers = memory + (size_t)capacity * r;
		light_span *spans = (light_span *)(memory + (size_t)capacity * (LIGHT_BAND_ROWS + r));
		if (row->count > 0) {
			memcpy(numbers, row->numbers, row->count * sizeof *numbers);
			memcpy(spans, row->spans, row->count * sizeof *spans);
		}
		row->numbers = numbers;
		row->spans = spans;
	}
	free(old);
	band->capacity = capacity;
	return true;
}

static light_cone_row cone_in_row(const light_rays *rays, const light_cone *cone, const light_slab *slab, uint32_t row)
{
	light_cone_row out = {.rays = rays,
	                      .cone = cone,
	                      .y0 = rays->edge_y[row],
	                      .y1 = rays->edge_y[row + 1],
	                      .near_z = slab->near_z,
	                      .far_z = slab->far_z};
	float y = 0.5f * (out.y0 + out.y1), z = 0.5f * (slab->near_z + slab->far_z);
	if (isinf(z))
		z = 2.0f * slab->near_z + 1.0f;
	for (int i = 0; i < 3; i++) {
		out.across[i] = cone->base[i] + y * rays->base_y[i] + z * (rays->ray[i] + y * rays->ray_y[i]);
		out.across_x[i] = rays->base_x[i] + z * rays->ray_x[i];
	}
	float along = scalar_dot(out.across, cone->axis), along_x = scalar_dot(out.across_x, cone->axis);
	for (int i = 0; i < 3; i++) {
		out.across[i] -= along * cone->axis[i];
		out.across_x[i] -= along_x * cone->axis[i];
	}
	return out;
}

static light_chunk reaching_chunk(const light_reaching *r, uint32_t number)
{
	uint32_t first = number * LIGHT_CHUNK;
	return (light_chunk){.x = r->x + first,
	                     .y = r->y + first,
	                     .w = r->w + first,
	                     .depth = r->depth + first,
	                     .radius = r->radius + first,
	                     .first_slice = r->first_slice + first,
	                     .last_slice = r->last_slice + first,
	                     .number = r->number + first,
	                     .count = r->chunks[number].count};
}

/* Shortens the spans of lights with cones to the cells that these meet, and takes the flags away. */
static void spans_trim(const struct light_scratch *scratch, const light_slab *slab, uint32_t row, uint32_t *numbers,
                       light_span *spans, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		if (numbers[i] < LIGHT_WITH_CONE)
			continue;
		numbers[i] -= LIGHT_WITH_CONE;
		const light_cone *cone = &scratch->reaching.cones[numbers[i]];
		light_cone_row cone_row = cone_in_row(&scratch->view.rays, cone, slab, row);
		spans[i] = scratch->kernels->trim(&cone_row, spans[i]);
	}
}

/* Adds what the picked lights reach to the band that begins with first_row. False: no memory. */
static bool band_add(const struct light_scratch *scratch, light_band *band, const light_slab *slab, uint32_t first_row,
                     uint32_t end_row, const light_picked *picked)
{
	light_picked narrowed;
	scratch->kernels->narrow(slab, first_row, end_row, picked, &narrowed);
	if (narrowed.count == 0)
		return true;
	if (!band_reserve(band, narrowed.count + LIGHT_LANES))
		return false;
	for (uint32_t r = first_row; r < end_row; r++) {
		light_row *row = &band->rows[r - first_row];
		uint32_t *numbers = row->numbers + row->count;
		light_span *spans = row->spans + row->count;
		uint32_t count = scratch->kernels->spans(slab, &narrowed, r, numbers, spans);
		spans_trim(scratch, slab, r, numbers, spans, count);
		row->count += count;
	}
	return true;
}

/* Some bands of one slice: what one job works on. */
typedef struct light_unit {
	uint32_t slice, first_band, end_band;
	light_band *bands; /* of the slice */
} light_unit;

static light_unit unit_at(const struct light_scratch *scratch, uint32_t number)
{
	uint32_t units = light_units(&scratch->view), bands = light_bands(&scratch->view);
	uint32_t slice = scratch->view.slices - 1 - number / units, unit = number % units; /* the last have most lights */
	return (light_unit){.slice = slice,
	                    .first_band = unit * bands / units,
	                    .end_band = (unit + 1) * bands / units,
	                    .bands = scratch->bands + (size_t)slice * bands};
}

/* Adds what the picked lights reach to the unit's bands, and empties picked. False: no memory. */
static bool unit_add(const struct light_scratch *scratch, const light_unit *unit, const light_slab *slab,
                     light_picked *picked)
{
	for (uint32_t b = unit->first_band; b < unit->end_band; b++)
		if (!band_add(scratch, &unit->bands[b], slab, light_band_row(&scratch->view, b),
		              light_band_row(&scratch->view, b + 1), picked))
			return false;
	picked->count = 0;
	return true;
}

/* Finds the spans of a unit. False: no memory. */
static bool unit_find(const struct light_scratch *scratch, const light_unit *unit)
{
	const light_view *view = &scratch->view;
	const light_reaching *r = &scratch->reaching;
	light_slab slab = {.rows = &view->row_planes,
	                   .columns = &view->column_planes,
	                   .slice = unit->slice,
	                   .near_z = view->depths.near_z[unit->slice],
	                   .far_z = view->depths.far_z[unit->slice],
	                   .along = {view->along[0], view->along[1], view->along[2]}};
	light_slab_inverses(view, unit->slice, &slab.inverse_near, &slab.inverse_far);
	uint32_t first_row = light_band_row(view, unit->first_band), end_row = light_band_row(view, unit->end_band);
	light_picked picked;
	picked.count = 0;
	for (uint32_t c = 0; c < r->chunk_count; c++) {
		light_chunk chunk = reaching_chunk(r, c);
		if (picked.count + chunk.count > LIGHT_PICKED && !unit_add(scratch, unit, &slab, &picked))
			return false;
		scratch->kernels->pick(&slab, first_row, end_row, &chunk, &picked);
	}
	return unit_add(scratch, unit, &slab, &picked);
}

/* Counts the lights of each cell of a row: where spans begin and end, then the sums of that. */
static void row_count(light_band *band, const light_row *row, uint32_t columns, uint32_t *counters)
{
	uint32_t length = 0;
	memset(counters, 0, (columns + 1) * sizeof *counters);
	for (uint32_t i = 0; i < row->count; i++) {
		counters[row->spans[i].first]++;
		counters[row->spans[i].last + 1]--;
	}
	for (uint32_t c = 0; c < columns; c++) {
		length += counters[c];
		counters[c] = length;
		band->id_count += length;
	}
}

static void light_job_units(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("light.units");
	(void)worker;
	light_build *build = context;
	struct light_scratch *scratch = build->scratch;
	const light_view *view = &scratch->view;
	for (uint32_t number = begin; number < end; number++) {
		light_unit unit = unit_at(scratch, number);
		for (uint32_t b = unit.first_band; b < unit.end_band; b++)
			for (uint32_t r = 0; r < LIGHT_BAND_ROWS; r++)
				unit.bands[b].rows[r].count = 0;
		if (!unit_find(scratch, &unit)) {
			atomic_store_explicit(&build->failed, true, memory_order_relaxed);
			return;
		}
		for (uint32_t b = unit.first_band; b < unit.end_band; b++) {
			light_band *band = &unit.bands[b];
			uint32_t first = light_band_row(view, b), last = light_band_row(view, b + 1);
			band->id_count = 0;
			for (uint32_t r = first; r < last; r++)
				row_count(band, &band->rows[r - first], view->columns, light_counters(scratch, unit.slice, r));
		}
	}
}

stilb_result light_bands_fill(light_build *build)
{
	struct light_scratch *scratch = build->scratch;
	const light_view *view = &scratch->view;
	if (bands_reserve(scratch)) {
		light_spread(build, light_units(view) * view->slices, light_job_units);
		if (!atomic_load_explicit(&build->failed, memory_order_relaxed))
			return STILB_OK;
	}
	return stilb_fail(STILB_ERROR_MEMORY, "light lists: no memory for %u lights in %u x %u x %u cells",
	                  scratch->reaching.count, view->columns, view->rows, view->slices);
}
