/*
 * The table of a snapshot: a row for each name of zones. One pass over the zones adds up the rows and stores the
 * duration of each zone. Then the durations are distributed to their rows and sorted, which gives exact percentiles.
 *
 * Parents come before children, so an ancestor of the same row is seen first: while the walk is inside its subtree, the
 * row's inclusive time is not added again. Zones are cut to the range of time; the self time of a zone that is cut is
 * what remains of it minus what remains of its children.
 */
#include "profiler/prof_stats.h"

#include "profiler/prof_array.h"
#include "profiler/read/prof_sort.h"

#include <assert.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PROF_INSERTION_MAX 48 /* up to so many values, insertion sort is faster */

/* State of a row while it is added up. */
typedef struct prof_sum {
	uint32_t lane;  /* the lane whose zones `until` counts */
	uint32_t until; /* zones of that lane before this index are inside a zone of the row */
	size_t place;   /* index in `sorted` at which the row's next duration goes */
} prof_sum;

typedef struct prof_sample {
	uint64_t duration_ns;
	uint32_t row;
} prof_sample;

typedef struct prof_stats_memory {
	uint32_t *row_of; /* by label and kind: 1 + the row, 0: none yet */
	stilb_prof_row *rows;
	prof_sum *sums;
	prof_sample *samples; /* one per zone, in the order of the walk */
	uint64_t *sorted;     /* the durations row by row, then scratch of the same size for sorting */
	size_t row_of_capacity, row_capacity, sum_capacity, sample_capacity, sorted_capacity;
	size_t sample_count;
	uint32_t row_count;
} prof_stats_memory;

typedef struct prof_walk {
	prof_stats_memory *memory;
	const stilb_prof_snapshot *snapshot;
	const stilb_prof_lane *lane;
	uint32_t lane_index;
	uint32_t first_frame, frame_count;
	uint64_t begin_ns, end_ns;
} prof_walk;

/* ---- sorting ----------------------------------------------------------------------------------------------------- */

static void prof_sort_insertion(uint64_t *values, size_t count)
{
	for (size_t i = 1; i < count; i++) {
		uint64_t value = values[i];
		size_t at = i;
		for (; at > 0 && values[at - 1] > value; at--)
			values[at] = values[at - 1];
		values[at] = value;
	}
}

/* Radix sort by bytes, the lowest first. Bytes that are equal in all values are skipped. */
void prof_sort(uint64_t *values, uint64_t *scratch, size_t count)
{
	assert(count == 0 || (values && scratch && values != scratch));
	if (count <= PROF_INSERTION_MAX) {
		prof_sort_insertion(values, count);
		return;
	}
	uint64_t differs = 0, *from = values, *to = scratch;
	for (size_t i = 1; i < count; i++)
		differs |= values[i] ^ values[0];
	for (uint32_t shift = 0; shift < 64; shift += 8) {
		size_t place[256] = {0}, sum = 0;
		if ((differs >> shift & 255) == 0)
			continue;
		for (size_t i = 0; i < count; i++)
			place[from[i] >> shift & 255]++;
		for (size_t digit = 0; digit < 256; digit++) {
			size_t these = place[digit];
			place[digit] = sum;
			sum += these;
		}
		for (size_t i = 0; i < count; i++)
			to[place[from[i] >> shift & 255]++] = from[i];
		uint64_t *swap = from;
		from = to;
		to = swap;
	}
	if (from != values)
		memcpy(values, from, count * sizeof *values);
}

/* ---- adding up --------------------------------------------------------------------------------------------------- */

static bool prof_stats_row_add(prof_stats_memory *memory, uint32_t label, stilb_prof_lane_kind kind)
{
	size_t count = (size_t)memory->row_count + 1;
	if (!prof_array_room(&memory->rows, sizeof *memory->rows, count, &memory->row_capacity) ||
	    !prof_array_room(&memory->sums, sizeof *memory->sums, count, &memory->sum_capacity))
		return false;
	memory->rows[count - 1] = (stilb_prof_row){.label = label, .kind = kind};
	memory->sums[count - 1] = (prof_sum){.lane = STILB_PROF_NONE};
	memory->row_count++;
	return true;
}

/* The entry of row_of for the label on lanes of this kind. */
static uint32_t *prof_walk_row_of(const prof_walk *walk, uint32_t label)
{
	assert(label < walk->snapshot->label_count);
	return &walk->memory->row_of[2 * (size_t)label + (walk->lane->kind == STILB_PROF_LANE_DEVICE)];
}

/* The row of the label, made if there is none. NULL: no memory. */
static stilb_prof_row *prof_walk_row(prof_walk *walk, uint32_t label)
{
	uint32_t *row = prof_walk_row_of(walk, label);
	if (*row == 0) {
		if (!prof_stats_row_add(walk->memory, label, walk->lane->kind))
			return NULL;
		*row = walk->memory->row_count;
	}
	return &walk->memory->rows[*row - 1];
}

static bool prof_stats_sample_add(prof_stats_memory *memory, uint32_t row, uint64_t duration_ns)
{
	assert(row < memory->row_count);
	if (!prof_array_room(&memory->samples, sizeof *memory->samples, memory->sample_count + 1, &memory->sample_capacity))
		return false;
	memory->samples[memory->sample_count++] = (prof_sample){duration_ns, row};
	return true;
}

static bool prof_walk_has(const prof_walk *walk, const stilb_prof_zone *zone)
{
	bool in_time = zone->begin_ns < walk->end_ns && (zone->end_ns > walk->begin_ns || zone->begin_ns >= walk->begin_ns);
	return in_time && (walk->frame_count == 0 || zone->frame - walk->first_frame < walk->frame_count);
}

static bool prof_walk_is_cut(const prof_walk *walk, const stilb_prof_zone *zone)
{
	assert(walk->begin_ns <= walk->end_ns && zone->begin_ns <= zone->end_ns);
	return zone->begin_ns < walk->begin_ns || zone->end_ns > walk->end_ns;
}

static uint64_t prof_walk_duration(const prof_walk *walk, const stilb_prof_zone *zone)
{
	uint64_t begin = zone->begin_ns > walk->begin_ns ? zone->begin_ns : walk->begin_ns;
	uint64_t end = zone->end_ns < walk->end_ns ? zone->end_ns : walk->end_ns;
	return end > begin ? end - begin : 0;
}

/* The off-CPU time of a zone that is cut. */
static uint64_t prof_walk_off_cpu(const prof_walk *walk, const stilb_prof_zone *zone)
{
	const stilb_prof_lane *lane = walk->lane;
	uint64_t begin = zone->begin_ns > walk->begin_ns ? zone->begin_ns : walk->begin_ns;
	uint64_t end = zone->end_ns < walk->end_ns ? zone->end_ns : walk->end_ns;
	uint32_t low = 0, high = lane->switch_count;
	uint64_t sum = 0;
	while (low < high) { /* the first that ends after begin */
		uint32_t middle = low + (high - low) / 2;
		if (lane->switches[middle].in_ns > begin)
			high = middle;
		else
			low = middle + 1;
	}
	for (; low < lane->switch_count && lane->switches[low].out_ns < end; low++) {
		uint64_t out = lane->switches[low].out_ns, in = lane->switches[low].in_ns;
		sum += (in < end ? in : end) - (out > begin ? out : begin);
	}
	return sum;
}

/* Subtracts the part of a zone that lies in the range of time from its parent's self time. Only if the parent is cut:
 * from self_ns of a whole zone the snapshot has subtracted its children already. */
static void prof_walk_leave_parent(prof_walk *walk, const stilb_prof_zone *zone)
{
	if (zone->parent == STILB_PROF_NONE)
		return;
	const stilb_prof_zone *parent = &walk->lane->zones[zone->parent];
	if (prof_walk_is_cut(walk, parent) && prof_walk_has(walk, parent)) /* it came before, so it has a row */
		walk->memory->rows[*prof_walk_row_of(walk, parent->label) - 1].self_ns -= prof_walk_duration(walk, zone);
}

static bool prof_walk_add(prof_walk *walk, uint32_t index)
{
	assert(index < walk->lane->zone_count);
	const stilb_prof_zone *zone = &walk->lane->zones[index];
	uint64_t duration = prof_walk_duration(walk, zone);
	bool cut = prof_walk_is_cut(walk, zone);
	stilb_prof_row *row = prof_walk_row(walk, zone->label);
	if (!row || !prof_stats_sample_add(walk->memory, (uint32_t)(row - walk->memory->rows), duration))
		return false;
	row->calls++;
	row->self_ns += cut ? duration : zone->self_ns;
	prof_sum *sum = &walk->memory->sums[row - walk->memory->rows];
	if (sum->lane == walk->lane_index && index < sum->until)
		return true;
	*sum = (prof_sum){.lane = walk->lane_index, .until = index + zone->size};
	row->inclusive_ns += duration;
	row->off_cpu_ns += cut ? prof_walk_off_cpu(walk, zone) : zone->off_cpu_ns;
	return true;
}

/* The first zone that may be in the range of time: the outermost one around its begin, or the first after it. */
static uint32_t prof_walk_start(const prof_walk *walk)
{
	const stilb_prof_lane *lane = walk->lane;
	uint32_t low = 0, high = lane->zone_count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (lane->zones[middle].begin_ns >= walk->begin_ns)
			high = middle;
		else
			low = middle + 1;
	}
	if (low == 0)
		return 0;
	for (low--; lane->zones[low].parent != STILB_PROF_NONE;)
		low = lane->zones[low].parent;
	return low;
}

static bool prof_walk_lane(prof_walk *walk, uint32_t lane)
{
	walk->lane = &walk->snapshot->lanes[lane];
	walk->lane_index = lane;
	for (uint32_t i = prof_walk_start(walk); i < walk->lane->zone_count && walk->begin_ns < walk->end_ns;) {
		const stilb_prof_zone *zone = &walk->lane->zones[i];
		if (zone->begin_ns >= walk->end_ns)
			break;
		if (zone->end_ns < walk->begin_ns) {
			i += zone->size; /* skips its children too */
			continue;
		}
		if (prof_walk_has(walk, zone) && !prof_walk_add(walk, i))
			return false;
		prof_walk_leave_parent(walk, zone);
		i++;
	}
	return true;
}

/* ---- percentiles ------------------------------------------------------------------------------------------------- */

uint64_t prof_quantile(const uint64_t *sorted, size_t count, uint32_t percent)
{
	assert(count > 0 && percent <= 100 && sorted[0] <= sorted[count - 1]);
	return sorted[((count - 1) * percent + 50) / 100];
}

/* Distributes the durations to their rows. */
static void prof_stats_deal(prof_stats_memory *memory)
{
	size_t place = 0;
	for (uint32_t r = 0; r < memory->row_count; r++) {
		memory->rows[r].durations_ns = memory->sorted + place;
		memory->sums[r].place = place;
		place += memory->rows[r].calls;
	}
	assert(place == memory->sample_count && "each call has one duration");
	for (size_t i = 0; i < memory->sample_count; i++)
		memory->sorted[memory->sums[memory->samples[i].row].place++] = memory->samples[i].duration_ns;
}

static bool prof_stats_quantiles(prof_stats_memory *memory)
{
	if (!prof_array_room(&memory->sorted, sizeof *memory->sorted, 2 * memory->sample_count + 1,
	                     &memory->sorted_capacity))
		return false;
	prof_stats_deal(memory);
	for (uint32_t r = 0; r < memory->row_count; r++) {
		stilb_prof_row *row = &memory->rows[r];
		uint64_t *durations = &memory->sorted[memory->sums[r].place - row->calls];
		prof_sort(durations, &memory->sorted[memory->sample_count], row->calls);
		assert(row->calls > 0 && durations == row->durations_ns);
		row->min_ns = durations[0];
		row->p50_ns = prof_quantile(durations, row->calls, 50);
		row->p99_ns = prof_quantile(durations, row->calls, 99);
		row->max_ns = durations[row->calls - 1];
	}
	return true;
}

/* ---- the calls --------------------------------------------------------------------------------------------------- */

static int prof_stats_prepare(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot)
{
	stats->rows = NULL;
	stats->row_count = 0;
	if (!stats->memory && !(stats->memory = calloc(1, sizeof(prof_stats_memory))))
		return -ENOMEM;
	prof_stats_memory *memory = stats->memory;
	memory->row_count = 0;
	memory->sample_count = 0;
	size_t keys = 2 * (size_t)snapshot->label_count + 1;
	if (!prof_array_room(&memory->row_of, sizeof *memory->row_of, keys, &memory->row_of_capacity))
		return -ENOMEM;
	/* NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): there is room for at least one key */
	memset(memory->row_of, 0, keys * sizeof *memory->row_of);
	return 0;
}

static bool prof_range_is_there(const stilb_prof_stats_range *range, const stilb_prof_snapshot *snapshot)
{
	return (range->lane_count == 0 || (range->lane_count <= snapshot->lane_count &&
	                                   range->first_lane <= snapshot->lane_count - range->lane_count)) &&
	       (range->frame_count == 0 || (range->frame_count <= snapshot->frame_count &&
	                                    range->first_frame <= snapshot->frame_count - range->frame_count));
}

int stilb_prof_stats_take(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot,
                          const stilb_prof_stats_range *range)
{
	assert(stats && snapshot);
	static const stilb_prof_stats_range all;
	const stilb_prof_stats_range *r = range ? range : &all;
	int error = prof_stats_prepare(stats, snapshot);
	if (error != 0)
		return error;
	if (!prof_range_is_there(r, snapshot))
		return -EINVAL;
	prof_walk walk = {.memory = stats->memory,
	                  .snapshot = snapshot,
	                  .first_frame = r->first_frame,
	                  .frame_count = r->frame_count,
	                  .begin_ns = r->end_ns > 0 ? r->begin_ns : 0,
	                  .end_ns = r->end_ns > 0 ? r->end_ns : UINT64_MAX};
	uint32_t first = r->lane_count > 0 ? r->first_lane : 0;
	uint32_t end = r->lane_count > 0 ? first + r->lane_count : snapshot->lane_count;
	for (uint32_t lane = first; lane < end; lane++)
		if (!prof_walk_lane(&walk, lane))
			return -ENOMEM;
	if (!prof_stats_quantiles(walk.memory))
		return -ENOMEM;
	stats->rows = walk.memory->rows;
	stats->row_count = walk.memory->row_count;
	stilb_prof_stats_sort(stats, snapshot, STILB_PROF_BY_INCLUSIVE);
	return 0;
}

typedef struct prof_order {
	const stilb_prof_snapshot *snapshot;
	stilb_prof_order order;
} prof_order;

static uint64_t prof_row_value(const stilb_prof_row *row, stilb_prof_order order)
{
	switch (order) {
	case STILB_PROF_BY_INCLUSIVE:
		return row->inclusive_ns;
	case STILB_PROF_BY_SELF:
		return row->self_ns;
	case STILB_PROF_BY_OFF_CPU:
		return row->off_cpu_ns;
	case STILB_PROF_BY_CALLS:
		return row->calls;
	case STILB_PROF_BY_P50:
		return row->p50_ns;
	case STILB_PROF_BY_P99:
		return row->p99_ns;
	case STILB_PROF_BY_MAX:
		return row->max_ns;
	case STILB_PROF_BY_NAME:
		break;
	}
	return 0;
}

static int prof_compare_rows(const void *left, const void *right, void *user)
{
	const stilb_prof_row *a = left, *b = right;
	const prof_order *by = user;
	uint64_t x = prof_row_value(a, by->order), y = prof_row_value(b, by->order);
	if (x != y)
		return x < y ? 1 : -1;
	int names = strcmp(by->snapshot->labels[a->label].name, by->snapshot->labels[b->label].name);
	if (names != 0)
		return names;
	if (a->kind != b->kind)
		return a->kind < b->kind ? -1 : 1;
	return (a->label > b->label) - (a->label < b->label);
}

void stilb_prof_stats_sort(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot, stilb_prof_order order)
{
	assert(stats && snapshot && order <= STILB_PROF_BY_NAME);
	for (uint32_t i = 0; i < stats->row_count; i++)
		assert(stats->rows[i].label < snapshot->label_count && "the snapshot that the rows were taken from");
	prof_order by = {snapshot, order};
	if (stats->row_count > 1)
		qsort_r(stats->rows, stats->row_count, sizeof *stats->rows, prof_compare_rows, &by);
}

void stilb_prof_stats_finish(stilb_prof_stats *stats)
{
	assert(stats);
	prof_stats_memory *memory = stats->memory;
	if (memory) {
		free(memory->row_of);
		free(memory->rows);
		free(memory->sums);
		free(memory->samples);
		free(memory->sorted);
		free(memory);
	}
	*stats = (stilb_prof_stats){0};
}
