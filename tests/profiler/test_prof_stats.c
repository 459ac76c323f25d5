/* Tables of snapshots, compared with sums that are computed in a simple, slow way, with cut zones and recursion;
 * sorting; errors; cost. */
#include "profiler/prof_stats.h"

#include "profiler/read/prof_sort.h"
#include "support/failing_memory.h"
#include "support/prof_made.h"
#include "support/test.h"

#include <errno.h>
#include <inttypes.h>
#include <stddef.h>
#include <time.h>

/* ---- the table, computed in a simple, slow way ------------------------------------------------------------------- */

typedef struct window {
	const made *m;
	stilb_prof_stats_range range;
} window;

static uint64_t window_end(const window *w)
{
	return w->range.end_ns > 0 ? w->range.end_ns : UINT64_MAX;
}

static uint64_t window_begin(const window *w)
{
	return w->range.end_ns > 0 ? w->range.begin_ns : 0;
}

static uint64_t window_duration(const window *w, const stilb_prof_zone *zone)
{
	return made_overlap(zone->begin_ns, zone->end_ns, window_begin(w), window_end(w));
}

static bool window_has(const window *w, uint32_t lane, const stilb_prof_zone *zone)
{
	const stilb_prof_stats_range *r = &w->range;
	if (r->lane_count > 0 && (lane < r->first_lane || lane >= r->first_lane + r->lane_count))
		return false;
	if (r->frame_count > 0 && (zone->frame < r->first_frame || zone->frame >= r->first_frame + r->frame_count))
		return false;
	return window_duration(w, zone) > 0 || (zone->begin_ns >= window_begin(w) && zone->begin_ns < window_end(w));
}

static uint64_t window_off_cpu(const window *w, uint32_t lane, const stilb_prof_zone *zone)
{
	uint64_t sum = 0;
	for (uint32_t s = 0; s < w->m->lanes[lane].switch_count; s++) {
		const stilb_prof_switch *off = &w->m->switches[lane][s];
		uint64_t begin = zone->begin_ns > window_begin(w) ? zone->begin_ns : window_begin(w);
		uint64_t end = zone->end_ns < window_end(w) ? zone->end_ns : window_end(w);
		sum += end > begin ? made_overlap(begin, end, off->out_ns, off->in_ns) : 0;
	}
	return sum;
}

/* True if no ancestor of the zone has the same label and is in the window, too. */
static bool window_outermost(const window *w, uint32_t lane, const stilb_prof_zone *zone)
{
	for (uint32_t p = zone->parent; p != STILB_PROF_NONE; p = w->m->zones[lane][p].parent)
		if (w->m->zones[lane][p].label == zone->label && window_has(w, lane, &w->m->zones[lane][p]))
			return false;
	return true;
}

static int compare_u64(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* Computes the row of a label, zone by zone; false: no call. The caller frees *durations. */
static bool long_way(const window *w, uint32_t label, stilb_prof_lane_kind kind, stilb_prof_row *row,
                     uint64_t **durations)
{
	*row = (stilb_prof_row){.label = label, .kind = kind};
	*durations = NULL;
	for (uint32_t l = 0; l < w->m->snapshot.lane_count; l++)
		for (uint32_t i = 0; i < w->m->lanes[l].zone_count; i++) {
			const stilb_prof_zone *zone = &w->m->zones[l][i];
			if (w->m->lanes[l].kind != kind || zone->label != label || !window_has(w, l, zone))
				continue;
			*durations = made_more(*durations, row->calls, sizeof **durations);
			(*durations)[row->calls++] = window_duration(w, zone);
			row->self_ns += window_duration(w, zone);
			for (uint32_t c = i + 1; c < i + zone->size; c++)
				if (w->m->zones[l][c].parent == i)
					row->self_ns -= window_duration(w, &w->m->zones[l][c]);
			row->inclusive_ns += window_outermost(w, l, zone) ? window_duration(w, zone) : 0;
			row->off_cpu_ns += window_outermost(w, l, zone) ? window_off_cpu(w, l, zone) : 0;
		}
	if (row->calls == 0)
		return false;
	qsort(*durations, row->calls, sizeof **durations, compare_u64);
	row->min_ns = (*durations)[0];
	row->max_ns = (*durations)[row->calls - 1];
	row->p50_ns = (*durations)[(uint32_t)(0.5 * (row->calls - 1) + 0.5)];
	row->p99_ns = (*durations)[(uint32_t)(0.99 * (row->calls - 1) + 0.5)];
	return true;
}

static void assert_rows(stilb_prof_stats *stats, const window *w)
{
	uint32_t rows = 0;
	assert_int_equal(stilb_prof_stats_take(stats, &w->m->snapshot, &w->range), 0);
	for (uint32_t label = 0; label < MADE_LABELS; label++)
		for (int kind = 0; kind < 2; kind++) {
			stilb_prof_row expected;
			uint64_t *durations;
			const stilb_prof_row *row = NULL;
			bool any = long_way(w, label, (stilb_prof_lane_kind)kind, &expected, &durations);
			for (uint32_t i = 0; i < stats->row_count; i++)
				if (stats->rows[i].label == label && (int)stats->rows[i].kind == kind)
					row = &stats->rows[i];
			assert_int_equal(!any, !row);
			if (row) {
				rows++;
				assert_memory_equal(row->durations_ns, durations, row->calls * sizeof *durations);
				expected.durations_ns = row->durations_ns;
				assert_int_equal(row->calls, expected.calls);
				assert_int_equal(row->inclusive_ns, expected.inclusive_ns);
				assert_int_equal(row->self_ns, expected.self_ns);
				assert_int_equal(row->off_cpu_ns, expected.off_cpu_ns);
				assert_true(row->min_ns == expected.min_ns && row->p50_ns == expected.p50_ns &&
				            row->p99_ns == expected.p99_ns && row->max_ns == expected.max_ns);
			}
			free(durations);
		}
	assert_int_equal(rows, stats->row_count);
}

static void as_the_long_way(void **state)
{
	(void)state;
	stilb_prof_stats stats = {0};
	for (uint64_t seed = 0; seed < 150; seed++) {
		made m;
		made_random random = {.state = seed};
		made_by_chance(&m, seed);
		window w = {.m = &m};
		assert_rows(&stats, &w);
		w.range.lane_count = 1;
		w.range.first_lane = (uint32_t)made_below(&random, m.snapshot.lane_count);
		assert_rows(&stats, &w);
		w.range.lane_count = 0;
		for (uint32_t f = 0; f < m.snapshot.frame_count; f++) {
			w.range = (stilb_prof_stats_range){.first_frame = f, .frame_count = 1};
			assert_rows(&stats, &w);
			w.range = (stilb_prof_stats_range){.begin_ns = m.frames[f].begin_ns, .end_ns = m.frames[f].end_ns};
			assert_rows(&stats, &w);
		}
		for (int i = 0; i < 20; i++) {
			uint64_t length = m.snapshot.end_ns - m.snapshot.begin_ns, at = made_below(&random, length);
			w.range = (stilb_prof_stats_range){.begin_ns = m.snapshot.begin_ns + at,
			                                   .end_ns = m.snapshot.begin_ns + at + made_below(&random, length)};
			w.range.frame_count = i % 3 == 0 ? m.snapshot.frame_count : 0;
			assert_rows(&stats, &w);
		}
		made_finish(&m);
	}
	stilb_prof_stats_finish(&stats);
}

/* The sum of the self times of all rows, in any range of time, is the time spent in outermost zones in that range. */
static void self_times_add_up(void **state)
{
	(void)state;
	stilb_prof_stats stats = {0};
	made m;
	made_by_chance(&m, 9);
	for (uint64_t begin = m.snapshot.begin_ns; begin < m.snapshot.end_ns; begin += 97) {
		stilb_prof_stats_range range = {.begin_ns = begin, .end_ns = begin + 97};
		uint64_t in_zones = 0, self = 0;
		for (uint32_t l = 0; l < m.snapshot.lane_count; l++)
			for (uint32_t i = 0; i < m.lanes[l].zone_count; i += m.zones[l][i].size)
				in_zones += made_overlap(m.zones[l][i].begin_ns, m.zones[l][i].end_ns, begin, begin + 97);
		assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, &range), 0);
		for (uint32_t r = 0; r < stats.row_count; r++)
			self += stats.rows[r].self_ns;
		assert_int_equal(self, in_zones);
	}
	stilb_prof_stats_finish(&stats);
	made_finish(&m);
}

static void recursion_counts_once(void **state)
{
	(void)state;
	stilb_prof_stats stats = {0};
	made m;
	made_init(&m, 1);
	made_push(&m, 0, 1, 0); /* cull 0..100 { record 10..90 { cull 20..60 } } cull 100..110 */
	made_push(&m, 0, 2, 10);
	made_push(&m, 0, 1, 20);
	made_pop(&m, 0, 60);
	made_pop(&m, 0, 90);
	made_pop(&m, 0, 100);
	made_push(&m, 0, 1, 100);
	made_pop(&m, 0, 110);
	made_derive(&m);
	assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, NULL), 0);
	assert_int_equal(stats.row_count, 2);
	const stilb_prof_row *cull = &stats.rows[0];
	assert_int_equal(cull->label, 1);
	assert_int_equal(cull->calls, 3);
	assert_int_equal(cull->inclusive_ns, 110);
	assert_int_equal(cull->self_ns, 20 + 40 + 10);
	assert_true(cull->min_ns == 10 && cull->p50_ns == 40 && cull->p99_ns == 100 && cull->max_ns == 100);
	stilb_prof_stats_finish(&stats);
	made_finish(&m);
}

/* ---- order ------------------------------------------------------------------------------------------------------- */

static uint64_t value(const stilb_prof_row *row, stilb_prof_order order)
{
	uint64_t values[] = {row->inclusive_ns, row->self_ns, row->off_cpu_ns, row->calls,
	                     row->p50_ns,       row->p99_ns,  row->max_ns,     0};
	return values[order];
}

static void rows_are_sorted(void **state)
{
	(void)state;
	stilb_prof_stats stats = {0};
	made m;
	made_by_chance(&m, 21);
	assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, NULL), 0);
	assert_true(stats.row_count > 5);
	for (int order = -1; order <= STILB_PROF_BY_NAME; order++) {
		if (order >= 0) /* -1: the order in which stilb_prof_stats_take leaves the rows */
			stilb_prof_stats_sort(&stats, &m.snapshot, (stilb_prof_order)order);
		for (uint32_t i = 1; i < stats.row_count; i++) {
			const stilb_prof_row *a = &stats.rows[i - 1], *b = &stats.rows[i];
			stilb_prof_order by = order < 0 ? STILB_PROF_BY_INCLUSIVE : (stilb_prof_order)order;
			assert_true(value(a, by) >= value(b, by));
			assert_true(value(a, by) > value(b, by) || strcmp(m.labels[a->label].name, m.labels[b->label].name) <= 0);
		}
	}
	stilb_prof_stats_finish(&stats);
	made_finish(&m);
}

static void values_are_sorted(void **state)
{
	(void)state;
	enum { COUNT = 3000 };
	static uint64_t values[COUNT], expected[COUNT], scratch[COUNT];
	made_random random = {.state = 4};
	for (size_t count = 0; count < COUNT; count += count < 100 ? 1 : 571)
		for (int bits = 1; bits <= 64; bits += 7) {
			for (size_t i = 0; i < count; i++)
				values[i] = expected[i] = made_u64(&random) >> (64 - bits);
			prof_sort(values, scratch, count);
			if (count > 0)
				qsort(expected, count, sizeof *expected, compare_u64);
			assert_memory_equal(values, expected, count * sizeof *values);
		}
}

/* ---- errors and memory ------------------------------------------------------------------------------------------- */

static void ranges_that_are_not_there(void **state)
{
	(void)state;
	static const stilb_prof_stats_range wrong[] = {
		{.first_lane = 2, .lane_count = 1},
		{.lane_count = 3},
		{.first_frame = 3, .frame_count = 1},
		{.first_frame = UINT32_MAX, .frame_count = 2},
		{.frame_count = 4},
		{.first_lane = 1, .lane_count = UINT32_MAX},
	};
	stilb_prof_stats stats = {0};
	made m;
	made_init(&m, 2);
	for (uint64_t i = 0; i < 3; i++)
		made_frame(&m, i, 100 * i, 100 * i + 100);
	assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, NULL), 0);
	assert_int_equal(stats.row_count, 0);
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, &wrong[i]), -EINVAL);
		assert_true(!stats.rows && stats.row_count == 0);
	}
	stilb_prof_stats_finish(&stats);
	stilb_prof_stats_finish(&stats);
	made_finish(&m);
}

static void no_memory(void **state)
{
	(void)state;
	made m;
	made_by_chance(&m, 2);
	int failures = 0;
	for (;; failures++) {
		stilb_prof_stats stats = {0};
		fail_allocation = failures;
		int error = stilb_prof_stats_take(&stats, &m.snapshot, NULL);
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		assert_int_equal(error, failed ? -ENOMEM : 0);
		assert_int_equal(stats.row_count == 0, failed);
		if (failed) /* and it can be used again */
			assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, NULL), 0);
		stilb_prof_stats_finish(&stats);
		if (!failed)
			break;
	}
	assert_true(failures >= 6);
	made_finish(&m);
}

static uint64_t now_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* One frame of a thousand zones, again and again: no allocation but the first ones. The time is printed, the best of
 * many. */
static void a_frame_costs_little(void **state)
{
	(void)state;
	stilb_prof_stats stats = {0};
	uint64_t best = UINT64_MAX;
	made m;
	made_init(&m, 2);
	made_frame(&m, 0, 0, 1000000);
	for (uint32_t l = 0; l < 2; l++) {
		made_push(&m, l, 0, 0);
		for (uint64_t i = 0; i < 500; i++) {
			made_push(&m, l, 1 + i % 12, 100 + i * 1000);
			made_pop(&m, l, 100 + i * 1000 + 300 + i * 37 % 601);
		}
		made_pop(&m, l, 1000000);
	}
	made_derive(&m);
	stilb_prof_stats_range range = {.frame_count = 1};
	assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, &range), 0);
	allocations = 0;
	for (int i = 0; i < 300; i++) {
		uint64_t from = now_ns();
		assert_int_equal(stilb_prof_stats_take(&stats, &m.snapshot, &range), 0);
		uint64_t took = now_ns() - from;
		best = took < best ? took : best;
	}
	assert_int_equal(allocations, 0);
	print_message("1,002 zones: %.1f us\n", (double)best * 1e-3);
	stilb_prof_stats_finish(&stats);
	made_finish(&m);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(as_the_long_way),
		cmocka_unit_test(self_times_add_up),
		cmocka_unit_test(recursion_counts_once),
		cmocka_unit_test(rows_are_sorted),
		cmocka_unit_test(values_are_sorted),
		cmocka_unit_test(ranges_that_are_not_there),
		cmocka_unit_test(no_memory),
		cmocka_unit_test(a_frame_costs_little),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
