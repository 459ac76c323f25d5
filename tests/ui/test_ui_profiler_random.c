/* ui: the profiler's window over random snapshots, with everything that a trace file may hold: no access outside of
 * memory (for the sanitizers to find), all vertices are finite, and texts fit their buffers. */
#include "base/base.h"
#include "support/test.h"
#include "test_ui_profiler_made.h"
#include "ui/ui_profiler_internal.h"

#include <math.h>
#include <stddef.h>

#define SNAPSHOTS 150u
#define DRAWS 12u
#define DEEPEST 70u /* levels: more than are ever drawn */

static made *recorded;
static uint64_t seed, drawn; /* the seed of the random numbers, and how many have been drawn */

/* A random number in [0, below). */
static uint64_t any(uint64_t below)
{
	return below ? stilb_random_u64(seed, drawn++) % below : 0;
}

/* A random time in [from, to]. */
static uint64_t any_ns(uint64_t from, uint64_t to)
{
	return from + any(to - from + 1);
}

static void any_zones(uint16_t level, uint64_t from, uint64_t to, uint64_t count)
{
	static const char *const NAMES[] = {
		"wait for workers", "wait for the GPU", "parked", "record", "frame", "present", "", "%s\n\t\xff\xfe"};
	uint32_t lane = recorded->snapshot.lane_count - 1;
	for (uint64_t i = 0; i < count && from <= to && recorded->lanes[lane].zone_count < 2000; i++) {
		uint64_t begin = any_ns(from, from + (to - from) / (1 + any(4)));
		uint64_t end = any(5) == 0 ? begin : any_ns(begin, to);
		uint32_t index = made_zone(recorded, level, NAMES[any(sizeof NAMES / sizeof *NAMES)], 0, 0);
		stilb_prof_zone *zone = &recorded->zones[lane][index];
		zone->begin_ns = begin;
		zone->end_ns = end;
		zone->self_ns = 0;
		zone->open = any(9) == 0;
		zone->frame = recorded->snapshot.frame_count ? (uint32_t)any(recorded->snapshot.frame_count) : STILB_PROF_NONE;
		if (level < DEEPEST && any(3) > 0)
			any_zones((uint16_t)(level + 1), begin, end, any(4));
		from = end;
	}
}

static void any_lane(uint64_t from, uint64_t to)
{
	uint32_t lane = made_lane(recorded, "a lane whose name is longer than there is room for it",
	                          any(4) == 0 ? STILB_PROF_LANE_DEVICE : STILB_PROF_LANE_THREAD);
	if (any(4) == 0)
		recorded->lanes[lane].no_switches = "perf_event_paranoid is 3";
	any_zones(0, from, to, any(60));
	for (uint64_t i = any(40); i > 0 && from < to; i--) {
		uint64_t out = any_ns(from, to), in = any_ns(out, to);
		made_switch(recorded, 0, 0, any(2));
		stilb_prof_switch *s = &recorded->switches[lane][recorded->lanes[lane].switch_count - 1];
		s->out_ns = out;
		s->in_ns = in;
		from = in;
	}
}

static void any_flows(uint64_t from, uint64_t to)
{
	uint32_t lanes = recorded->snapshot.lane_count;
	for (uint64_t i = lanes ? any(60) : 0; i > 0; i--)
		recorded->flows[recorded->snapshot.flow_count++] =
			(stilb_prof_flow){.id = i,
		                      .from_ns = any_ns(from, to),
		                      .to_ns = any_ns(from, to),
		                      .from_lane = any(5) ? (uint32_t)any(lanes) : STILB_PROF_NONE,
		                      .to_lane = any(5) ? (uint32_t)any(lanes) : STILB_PROF_NONE};
}

static void any_points(uint64_t from, uint64_t to)
{
	static const double VALUES[] = {0.0, 1.0, -1.0, 1e300, -1e300, 1e-300, 4e9, (double)INFINITY, (double)NAN};
	static const char *const NAMES[] = {"draws", "wait for it",
	                                    "a counter whose name is longer than there is room for it"};
	for (uint64_t i = any(200); i > 0; i--) {
		from = any_ns(from, from + (to - from) / 40);
		made_counter(recorded, (uint32_t)any(MADE_LANES), made_label(recorded, NAMES[any(3)]), 0.0, VALUES[any(9)]);
		stilb_prof_point *point = &recorded->points[recorded->snapshot.point_count - 1];
		point->ns = from;
		point->counter = any(5) > 0;
	}
}

static void any_snapshot(void)
{
	static const uint64_t BASES[] = {0, 1000000, UINT64_C(1) << 40, UINT64_C(1) << 62,
	                                 UINT64_MAX - (UINT64_C(1) << 41)};
	static const uint64_t LENGTHS[] = {0, 10, 100000, 10000000, UINT64_C(1) << 40};
	uint64_t from = BASES[any(5)], to = from + LENGTHS[any(5)];
	uint64_t at = from;
	recorded = made_new();
	made_label(recorded, "flow");
	for (uint64_t i = any(130); i > 0; i--) {
		uint64_t end = any_ns(at, at + (to - from) / 130);
		recorded->frames[recorded->snapshot.frame_count] = (stilb_prof_frame){1000 - i, at, end};
		recorded->snapshot.frame_count++;
		at = end;
	}
	for (uint64_t lanes = any(6); lanes > 0; lanes--)
		any_lane(from, to);
	any_flows(from, to);
	any_points(from, to);
	recorded->snapshot.begin_ns = from;
	recorded->snapshot.end_ns = to;
}

static int take(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	(void)user, (void)window;
	*snapshot = recorded->snapshot;
	return 0;
}

static void frames(void *user, stilb_prof_frame_stats *stats, double budget_ms)
{
	(void)user, (void)budget_ms;
	uint32_t all = recorded->snapshot.frame_count;
	*stats = (stilb_prof_frame_stats){.count = all < STILB_PROF_STATS_FRAMES ? all : STILB_PROF_STATS_FRAMES};
	for (uint32_t i = 0; i < stats->count; i++) {
		const stilb_prof_frame *frame = &recorded->frames[all - stats->count + i];
		stats->last = frame->number;
		stats->ms[i] = (double)(frame->end_ns - frame->begin_ns) * 1e-6;
		stats->max_ms = fmax(stats->max_ms, stats->ms[i]);
	}
	stats->p50_ms = stats->p99_ms = stats->ms[stats->count / 2];
	stats->limit_ms = any(3) ? (double)INFINITY : 2.0 * stats->p50_ms;
}

static stilb_ui_input any_input(void)
{
	stilb_ui_input input = {.width = any(3) ? 1280.0f : (float)(1 + any(1500)),
	                        .height = any(3) ? 720.0f : (float)(1 + any(1000)),
	                        .mouse_present = any(8) > 0,
	                        .mouse_down = any(2),
	                        .mouse_presses = (uint8_t)any(3),
	                        .wheel = any(3) ? 0.0f : (float)any(400) - 200.0f,
	                        .seconds = 0.1f};
	input.mouse_x = (float)any((uint64_t)input.width + 1);
	input.mouse_y = (float)any((uint64_t)input.height + 1);
	input.keys[any(STILB_UI_KEY_COUNT)] = (uint8_t)any(3);
	return input;
}

static void draw_some(stilb_ui *ui, stilb_ui_profiler *profiler)
{
	const stilb_ui_draw_list *list = stilb_ui_list(ui);
	for (uint32_t i = 0; i < DRAWS; i++) {
		stilb_ui_input input = any_input();
		if (any(6) == 0)
			stilb_ui_profiler_freeze(profiler, any(2));
		if (any(6) == 0)
			profiler->mode = (ui_profiler_mode)any(UI_PROFILER_PICKED + 1);
		stilb_ui_begin(ui, &input);
		stilb_ui_profiler_draw(profiler, ui);
		stilb_ui_end(ui);
		for (uint32_t v = 0; v < list->vertex_count; v++)
			assert_true(isfinite(list->vertices[v].position[0]) && isfinite(list->vertices[v].position[1]));
		for (uint32_t v = 0; v < list->index_count; v++)
			assert_true(list->indices[v] < list->vertex_count);
	}
}

/* The parts of a lane's time add up to the frame, and the sentence about a lost CPU gives the same time as the lane. */
static void check_sums(void)
{
	ui_profiler_data data = {0};
	for (uint32_t f = 0; f < recorded->snapshot.frame_count; f += 10) {
		uint64_t length = recorded->frames[f].end_ns - recorded->frames[f].begin_ns;
		assert_true(ui_profiler_data_build(&data, &recorded->snapshot, f));
		for (uint32_t i = 0; i < recorded->snapshot.lane_count; i++) {
			const ui_profiler_lane_sum *sum = &data.lanes[i];
			assert_int_equal(
				sum->work_ns + sum->wait_ns + sum->idle_ns + sum->asleep_ns + sum->lost_ns + sum->outside_ns, length);
		}
		const ui_profiler_wait *wait = &data.report.wait;
		if (wait->lane != STILB_PROF_NONE && wait->label == STILB_PROF_NONE && wait->preempted)
			assert_int_equal(wait->total_ns, data.lanes[wait->lane].lost_ns);
	}
	ui_profiler_data_finish(&data);
}

static void test_anything(void **state)
{
	(void)state;
	stilb_ui_desc desc = stilb_ui_desc_default();
	stilb_ui *ui;
	assert_int_equal(stilb_ui_create(&desc, &ui), STILB_OK);
	for (seed = 1; seed <= SNAPSHOTS; seed++) {
		stilb_ui_profiler *profiler;
		any_snapshot();
		check_sums();
		stilb_ui_profiler_desc profiler_desc = {.take = take, .frames = frames, .whole = any(2)};
		assert_int_equal(stilb_ui_profiler_create(&profiler_desc, &profiler), STILB_OK);
		if (any(2))
			stilb_ui_profiler_show(profiler, any(1100));
		draw_some(ui, profiler);
		stilb_ui_profiler_destroy(profiler);
		free(recorded);
	}
	stilb_ui_destroy(ui);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_anything)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
