/* ui: the data of the profiler's window: walking a lane (a thread's zones), merging narrow zones, the report of a frame
 * and the counters, on snapshots made by hand. */
#include "support/test.h"
#include "test_ui_profiler_made.h"
#include "ui/ui_profiler_data.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#define ASSERT_NS(ns, us) assert_int_equal((ns), made_ns(us))

/* ---- walking ----------------------------------------------------------------------------------------------------- */

/* Two trees with a gap, a child that touches its parent's ends, and a zone without length. */
static made *made_tree(void)
{
	made *m = made_new();
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "a", 10, 50);
	made_zone(m, 1, "b", 10, 20);
	made_zone(m, 1, "nothing", 25, 25);
	made_zone(m, 1, "c", 30, 50);
	made_zone(m, 2, "d", 30, 35);
	made_zone(m, 0, "e", 60, 70);
	return m;
}

static void test_walk(void **state)
{
	(void)state;
	static const struct {
		double begin_us, end_us;
		const char *name;
	} expected[] = {{0, 10, NULL}, {10, 20, "b"},  {20, 25, "a"}, {25, 30, "a"}, {30, 35, "d"},
	                {35, 50, "c"}, {50, 60, NULL}, {60, 70, "e"}, {70, 80, NULL}};
	made *m = made_tree();
	ui_profiler_walk walk = ui_profiler_walk_begin(&m->lanes[0], 0, made_ns(80));
	ui_profiler_stretch stretch = {0};
	uint64_t at = 0;
	for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
		assert_true(ui_profiler_walk_next(&walk, &stretch));
		assert_int_equal(stretch.begin_ns, at);
		at = stretch.end_ns;
		ASSERT_NS(stretch.end_ns, expected[i].end_us);
		if (!expected[i].name)
			assert_int_equal(stretch.zone, STILB_PROF_NONE);
		else
			assert_string_equal(m->labels[m->zones[0][stretch.zone].label].name, expected[i].name);
	}
	assert_false(ui_profiler_walk_next(&walk, &stretch));
	free(m);
}

/* A walk that begins at any time gives the same stretches as the one from the start. */
static void test_walk_from_anywhere(void **state)
{
	(void)state;
	made *m = made_tree();
	for (uint64_t ns = 0; ns < made_ns(80); ns += 500) {
		ui_profiler_walk walk = ui_profiler_walk_begin(&m->lanes[0], 0, made_ns(80));
		ui_profiler_stretch stretch;
		do
			assert_true(ui_profiler_walk_next(&walk, &stretch));
		while (stretch.end_ns <= ns);
		assert_int_equal(ui_profiler_zone_at(&m->lanes[0], ns), stretch.zone);
	}
	m->lanes[0].zone_count = 0;
	assert_int_equal(ui_profiler_zone_at(&m->lanes[0], 5), STILB_PROF_NONE);
	free(m);
}

static void test_off_cpu(void **state)
{
	(void)state;
	made *m = made_tree();
	uint64_t preempted;
	made_switch(m, 5, 12, false);
	made_switch(m, 20, 22, true);
	made_switch(m, 45, 65, true);
	ASSERT_NS(ui_profiler_off_cpu(&m->lanes[0], 0, made_ns(80), &preempted), 29);
	ASSERT_NS(preempted, 22);
	ASSERT_NS(ui_profiler_off_cpu(&m->lanes[0], made_ns(10), made_ns(21), &preempted), 3);
	ASSERT_NS(preempted, 1);
	ASSERT_NS(ui_profiler_off_cpu(&m->lanes[0], made_ns(22), made_ns(45), &preempted), 0);
	free(m);
}

/* ---- merging ----------------------------------------------------------------------------------------------------- */

/* At every scale each zone is in exactly one span. */
static uint32_t spans_zones(const ui_profiler_spans *spans)
{
	uint32_t zones = 0;
	for (uint32_t i = 0; i < spans->count; i++)
		zones += spans->spans[i].count;
	return zones;
}

static void test_spans(void **state)
{
	(void)state;
	made *m = made_new();
	ui_profiler_spans spans = {0};
	const stilb_prof_lane *lane = &m->lanes[made_lane(m, "main", STILB_PROF_LANE_THREAD)];
	made_zone(m, 0, "record", 0, 1000);
	for (int i = 0; i < 100; i++) { /* 1 us long, 2 us apart, with a zone nested in each */
		made_zone(m, 1, i == 40 ? "long" : "segment", i * 3, i * 3 + (i == 40 ? 1.5 : 1));
		made_zone(m, 2, "inner", i * 3, i * 3 + 0.5);
	}
	made_zone(m, 1, "wide", 400, 600);
	made_zone(m, 1, "segment", 601, 602);

	assert_true(ui_profiler_spans_build(&spans, lane, 0, made_ns(1000), 0.0)); /* nothing is narrow */
	assert_int_equal(spans.count, 203);
	assert_int_equal(spans_zones(&spans), 203);

	assert_true(ui_profiler_spans_build(&spans, lane, 0, made_ns(1000), 5000.0));
	assert_int_equal(spans_zones(&spans), 203);
	assert_int_equal(spans.count, 4); /* record, a hundred segments, wide, one segment */
	const ui_profiler_span *run = &spans.spans[1];
	assert_int_equal(run->count, 200);
	assert_int_equal(run->level, 1);
	assert_int_equal(run->label, STILB_PROF_NONE);
	assert_string_equal(m->labels[lane->zones[run->zone].label].name, "long");
	ASSERT_NS(run->begin_ns, 0);
	ASSERT_NS(run->end_ns, 298);
	assert_string_equal(m->labels[spans.spans[2].label].name, "wide");
	assert_string_equal(m->labels[spans.spans[3].label].name, "segment");

	assert_true(ui_profiler_spans_build(&spans, lane, 0, made_ns(1000), 1400.0)); /* zones narrow, but far apart */
	assert_int_equal(spans_zones(&spans), 203);
	assert_int_equal(spans.count, 104); /* "long" is not narrow, so it and the zone in it are two spans */
	for (uint32_t i = 0; i < spans.count; i++)
		assert_true(spans.spans[i].label != STILB_PROF_NONE);

	assert_true(ui_profiler_spans_build(&spans, lane, made_ns(450), made_ns(500), 10.0)); /* only zones in this time */
	assert_int_equal(spans.count, 2);
	ui_profiler_spans_finish(&spans);
	free(m);
}

/* Narrow zones of two different parents are not merged with each other if the parents are not narrow. */
static void test_spans_stay_in_parents(void **state)
{
	(void)state;
	made *m = made_new();
	ui_profiler_spans spans = {0};
	const stilb_prof_lane *lane = &m->lanes[made_lane(m, "main", STILB_PROF_LANE_THREAD)];
	made_zone(m, 0, "a", 0, 10);
	made_zone(m, 1, "x", 9, 10);
	made_zone(m, 0, "b", 10.5, 20);
	made_zone(m, 1, "x", 10.5, 11);
	assert_true(ui_profiler_spans_build(&spans, lane, 0, made_ns(20), 2000.0));
	assert_int_equal(spans.count, 4);
	for (uint32_t i = 0; i < spans.count; i++)
		for (uint32_t j = 0; j < spans.count; j++)
			if (spans.spans[i].level == 1 && spans.spans[j].level == 0)
				assert_true(spans.spans[i].begin_ns >= spans.spans[j].begin_ns ||
				            spans.spans[i].end_ns <= spans.spans[j].end_ns);
	ui_profiler_spans_finish(&spans);
	free(m);
}

/* ---- reports ----------------------------------------------------------------------------------------------------- */

/* A frame of 10 ms: main waits for worker 1 in record, the GPU is busy for half of it. */
static made *made_record_wait(void)
{
	made *m = made_new();
	made_frame(m, 41, -0.0, 1000);
	made_frame(m, 42, 1000, 11000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 990);
	made_zone(m, 0, "frame", 1010, 10990);
	made_zone(m, 1, "cull", 1100, 2900);
	made_zone(m, 1, "record", 3000, 8000);
	made_zone(m, 2, "record segment", 3000, 4800);
	made_zone(m, 2, "wait for workers", 4900, 8000);
	made_zone(m, 1, "replay", 8100, 10900);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "parked", 1000, 3100);
	made_zone(m, 0, "job", 3100, 7990);
	made_zone(m, 1, "record segment", 3110, 5500);
	made_zone(m, 1, "record segment", 5510, 7980);
	made_zone(m, 0, "parked", 8000, 11000);
	made_lane(m, "worker 2", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "parked", 1000, 3100);
	made_zone(m, 0, "job", 3100, 5000);
	made_zone(m, 0, "parked", 5010, 11000);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "frame", 2000, 7000);
	made_zone(m, 1, "main", 2000, 6500);
	return m;
}

static void test_report(void **state)
{
	(void)state;
	made *m = made_record_wait();
	ui_profiler_data data = {0};
	const ui_profiler_report *report = &data.report;
	assert_int_equal(ui_profiler_frame_find(&m->snapshot, 40), STILB_PROF_NONE);
	assert_int_equal(ui_profiler_frame_find(&m->snapshot, 43), STILB_PROF_NONE);
	assert_int_equal(ui_profiler_frame_find(&m->snapshot, 42), 1);
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 1));
	assert_int_equal(report->lane, 0);
	assert_int_equal(report->limit, UI_PROFILER_LIMIT_CPU);
	assert_string_equal(m->labels[report->stage_label].name, "record");
	ASSERT_NS(report->stage_ns, 5000);
	ASSERT_NS(report->gpu_ns, 5000);
	ASSERT_NS(data.lanes[0].work_ns, 9980 - 3100);
	ASSERT_NS(data.lanes[0].wait_ns, 3100);
	ASSERT_NS(data.lanes[0].outside_ns, 20);
	ASSERT_NS(data.lanes[1].idle_ns, 5100);
	ASSERT_NS(data.lanes[1].work_ns, 4890);
	assert_int_equal(report->wait.lane, 0);
	assert_int_equal(report->wait.for_lane, 1);
	ASSERT_NS(report->wait.total_ns, 3100);
	ASSERT_NS(report->wait.begin_ns, 4900);
	assert_string_equal(report->verdict, "CPU-limited: record decides, 5.00 ms of 10.00 ms.");
	assert_string_equal(report->wait_text, "In record, main waited 3.10 ms for worker 1, which was in record segment.");
	assert_int_equal(report->events, 14); /* 6 of main, 4 of worker 1 and its children, ... without the GPU's */
	assert_int_equal(report->cost_ns, 280);
	ui_profiler_data_finish(&data);
	free(m);
}

static void assert_wait_text(made *m, uint32_t frame, const char *expected)
{
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, frame));
	assert_string_equal(data.report.wait_text, expected);
	ui_profiler_data_finish(&data);
	free(m);
}

static void assert_verdict(made *m, ui_profiler_limit limit, const char *expected)
{
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	assert_string_equal(data.report.verdict, expected);
	assert_int_equal(data.report.limit, limit);
	ui_profiler_data_finish(&data);
	free(m);
}

/* The worker that was waited for had lost its CPU to another thread: the article's third experiment. */
static void test_wait_for_preempted(void **state)
{
	(void)state;
	made *m = made_record_wait();
	m->snapshot.lane_count = 2;
	made_switch(m, 5000, 7800, true);
	m->snapshot.lane_count = 4;
	assert_wait_text(
		m, 1,
		"In record, main waited 3.10 ms for worker 1, which was in record segment but had lost the CPU for "
		"2.80 ms.");
}

/* The worker that was waited for began its work late. */
static void test_wait_for_late(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 10000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 10000);
	made_zone(m, 1, "cull", 0, 9000);
	made_zone(m, 2, "wait for workers", 1000, 5000);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "parked", 0, 3000);
	made_zone(m, 0, "job", 3000, 5000);
	assert_wait_text(m, 0, "In cull, main waited 4.00 ms for worker 1, which began 2.00 ms late and was in job.");
}

/* The worker was done, but main went on late: it was woken late, or had lost the CPU. */
static void test_wait_goes_on_late(void **state)
{
	(void)state;
	for (int lost = 0; lost < 2; lost++) {
		made *m = made_record_wait();
		m->zones[1][3].end_ns = made_ns(6000); /* the last segment ends early, and so does the job around it */
		m->zones[1][1].end_ns = made_ns(6010);
		m->switches[0][0] = (stilb_prof_switch){made_ns(4950), made_ns(7990), lost != 0};
		m->lanes[0].switch_count = 1;
		assert_wait_text(
			m, 1,
			lost ? "In record, main waited 3.10 ms for worker 1, which was in record segment; main had lost the "
				   "CPU itself and went on 1.99 ms after that."
				 : "In record, main waited 3.10 ms for worker 1, which was in record segment; main went on 1.99 "
				   "ms after that.");
	}
}

/* Main is said to have lost the CPU only if that took more than half of the 1.99 ms. */
static void test_wait_goes_on_late_for_half(void **state)
{
	(void)state;
	for (int most = 0; most < 2; most++) {
		made *m = made_record_wait();
		m->zones[1][3].end_ns = made_ns(6000);
		m->zones[1][1].end_ns = made_ns(6010);
		m->switches[0][0] = (stilb_prof_switch){made_ns(most ? 6900 : 7100), made_ns(8000), true};
		m->lanes[0].switch_count = 1;
		assert_wait_text(
			m, 1,
			most ? "In record, main waited 3.10 ms for worker 1, which was in record segment; main had lost the "
				   "CPU itself and went on 1.99 ms after that."
				 : "In record, main waited 3.10 ms for worker 1, which was in record segment; main went on 1.99 "
				   "ms after that.");
	}
}

/* Many short waits for the same reason are one group, and are reported like one long wait. */
static void test_wait_in_pieces(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 10000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 10000);
	made_zone(m, 1, "cull", 0, 5000);
	made_zone(m, 2, "wait for workers", 100, 400);
	made_zone(m, 1, "record", 5000, 9900);
	for (int i = 0; i < 10; i++)
		made_zone(m, 2, "wait for workers", 5000 + i * 200, 5000 + i * 200 + 50 + i);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	for (int i = 0; i < 10; i++)
		made_zone(m, 0, "one", 5000 + i * 200, 5000 + i * 200 + 30);
	made_lane(m, "worker 2", STILB_PROF_LANE_THREAD);
	for (int i = 0; i < 10; i++)
		made_zone(m, 0, "two", 5000 + i * 200, 5000 + i * 200 + 40);
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	assert_string_equal(
		data.report.wait_text,
		"In record, main waited 545 µs for worker 2 in 10 pieces, which was in two; main went on 145 µs after "
		"that.");
	ASSERT_NS(data.report.wait.begin_ns, 6800); /* that of the group's longest wait */
	ui_profiler_data_finish(&data);
	free(m);
}

static void test_wait_for_gpu(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 10000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 10000);
	made_zone(m, 1, "frame begin", 0, 5000);
	made_zone(m, 2, "wait for the GPU", 0, 4800);
	made_zone(m, 1, "record", 5000, 10000);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "frame", 0, 4700);
	made_zone(m, 1, "main", 0, 4600);
	made_zone(m, 0, "frame", 5200, 9700);
	made_zone(m, 1, "overlay", 5200, 5500);
	made_zone(m, 1, "main", 5500, 9700);
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	assert_string_equal(data.report.wait_text,
	                    "In frame begin, main waited 4.80 ms for the GPU, which was busy with main.");
	ui_profiler_data_finish(&data);
	assert_verdict(m, UI_PROFILER_LIMIT_GPU,
	               "GPU-limited: the GPU was busy for 9.20 ms of 10.00 ms; main decides, 8.80 ms.");
}

/* A zone called "wait ..." in a device's lane is a wait of the device, and not a pass that could limit the frame. */
static void test_gpu_that_waits(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 10000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 10000);
	made_zone(m, 1, "wait for the GPU", 0, 9000);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "wait for the display", 0, 9000);
	assert_verdict(m, UI_PROFILER_LIMIT_GPU,
	               "GPU-limited: the GPU was busy for 9.00 ms of 10.00 ms; wait for the GPU decides, 9.00 ms.");
}

/* A frame that the CPU made slow and that begins with a wait for the GPU to finish the frame before. */
static void test_gpu_with_time_to_spare(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 20000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 20000);
	made_zone(m, 1, "frame begin", 0, 2000);
	made_zone(m, 2, "wait for the GPU", 0, 2000);
	made_zone(m, 1, "record", 2000, 20000);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "frame", 0, 1900);
	assert_verdict(m, UI_PROFILER_LIMIT_CPU, "CPU-limited: record decides, 18.00 ms of 20.00 ms.");
}

static void test_display(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_zone(m, 1, "record", 0, 4000);
	made_zone(m, 1, "present", 4000, 16000);
	made_switch(m, 5000, 15500, false);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "scene", 100, 15900);
	ui_profiler_data data = {0}; /* presenting that waits for a busy GPU */
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	assert_string_equal(data.report.wait_text, "In present, main slept 10.50 ms while the GPU was busy.");
	assert_int_equal(data.report.limit, UI_PROFILER_LIMIT_GPU);
	ui_profiler_data_finish(&data);
	m->zones[1][0].end_ns = made_ns(8000);
	assert_verdict(m, UI_PROFILER_LIMIT_DISPLAY, "Held back by the display: present waits 12.00 ms of 16.00 ms.");
}

/* Waits hidden in presenting: for the display, or for a GPU that is busy. */
static void test_queue_present(void **state)
{
	(void)state;
	for (int busy = 0; busy < 2; busy++) {
		made *m = made_new();
		made_frame(m, 7, 0, 16000);
		made_lane(m, "main", STILB_PROF_LANE_THREAD);
		made_zone(m, 0, "frame", 0, 16000);
		made_zone(m, 1, "record", 0, 4000);
		made_zone(m, 1, "present", 4000, 16000);
		made_zone(m, 2, "queue present", 4100, 15900);
		made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
		made_zone(m, 0, "scene", 0, busy ? 15800 : 3000);
		ui_profiler_data data = {0};
		assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
		assert_int_equal(data.report.limit, busy ? UI_PROFILER_LIMIT_GPU : UI_PROFILER_LIMIT_DISPLAY);
		assert_string_equal(data.report.wait_text,
		                    busy ? "In present, main waited 11.80 ms for the GPU, which was busy with scene."
		                         : "In present, main waited 11.80 ms for the display.");
		ui_profiler_data_finish(&data);
		free(m);
	}
}

static void test_lost_cpu(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_zone(m, 1, "record", 0, 16000);
	made_switch(m, 5000, 5900, true);
	made_switch(m, 7000, 7200, false);
	assert_wait_text(m, 0, "In record, main lost the CPU to other threads for 900 µs.");

	m = made_new(); /* waits in several zones of work, but for one reason */
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_zone(m, 1, "cull", 0, 5000);
	made_zone(m, 1, "record", 5000, 16000);
	made_zone(m, 2, "wait for workers", 14000, 15500);
	made_switch(m, 3000, 4000, true);
	made_switch(m, 6000, 8000, true);
	assert_wait_text(m, 0,
	                 "main lost the CPU to other threads for 3.00 ms in 2 pieces, 2.00 ms of it at once in record.");
}

static uint64_t sum_of(const ui_profiler_lane_sum *sum)
{
	return sum->work_ns + sum->wait_ns + sum->idle_ns + sum->asleep_ns + sum->lost_ns + sum->outside_ns;
}

/* A lost CPU is counted inside zones and outside them, in the lane's parts as in the sentence; and the parts add up to
 * the frame. */
static void test_lane_sums(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 10000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 4000);
	made_zone(m, 1, "record", 0, 2000);
	made_zone(m, 1, "wait for workers", 2000, 3500);
	made_switch(m, 500, 1000, true);
	made_switch(m, 2500, 3000, true); /* inside a wait: counts as wait, not as lost */
	made_switch(m, 5000, 8000, true);
	made_switch(m, 8500, 9000, false);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	made_zone(m, 0, "scene", 1000, 9000);
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	ASSERT_NS(data.lanes[0].work_ns, 2000);
	ASSERT_NS(data.lanes[0].wait_ns, 1500);
	ASSERT_NS(data.lanes[0].idle_ns, 0);
	ASSERT_NS(data.lanes[0].asleep_ns, 500);
	ASSERT_NS(data.lanes[0].lost_ns, 3500);
	ASSERT_NS(data.lanes[0].outside_ns, 2500);
	ASSERT_NS(sum_of(&data.lanes[0]), 10000);
	ASSERT_NS(data.report.wait.total_ns, 3500);
	assert_string_equal(data.report.wait_text,
	                    "main lost the CPU to other threads for 3.50 ms in 2 pieces, 3.00 ms of it at once.");
	assert_string_equal(
		data.report.verdict,
		"CPU-limited: what lies outside all zones decides, 6.00 ms of 10.00 ms, 2.50 ms of it on a CPU.");
	ASSERT_NS(data.lanes[1].work_ns, 8000);
	ASSERT_NS(data.lanes[1].outside_ns, 2000);
	ui_profiler_data_finish(&data);
	free(m);
}

/* All time lost to other threads is counted, even if the thread slept in more zones than there are groups of waits. */
static void test_lost_cpu_among_many_sleeps(void **state)
{
	(void)state;
	static char names[60][8];
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	for (int i = 0; i < 60; i++) {
		snprintf(names[i], sizeof names[i], "%d", i);
		made_zone(m, 1, names[i], 100 * i, 100 * i + 50);
		made_switch(m, 100 * i + 10, 100 * i + 20, false);
	}
	made_switch(m, 9000, 9500, true);
	made_switch(m, 10000, 10700, true);
	ui_profiler_data data = {0};
	assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
	ASSERT_NS(data.lanes[0].lost_ns, 1200);
	ASSERT_NS(data.report.wait.total_ns, 1200);
	ui_profiler_data_finish(&data);
	free(m);
}

/* If the main thread does not wait, a worker's wait is reported; being parked is not a wait. */
static void test_worker_lost_cpu(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "job", 0, 4000);
	made_switch(m, 1000, 3000, true);
	made_zone(m, 0, "parked", 4000, 16000);
	assert_wait_text(m, 0, "In job, worker 1 lost the CPU to other threads for 2.00 ms.");
}

/* The thread that runs frames is found in whichever lane it is; a wait outside all zones of work has no in_label. */
static void test_frame_thread(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "parked", 0, 14000);
	made_zone(m, 0, "job", 14000, 15000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_zone(m, 1, "record", 0, 13000);
	made_zone(m, 1, "wait for the moon", 14000, 15000);
	assert_wait_text(m, 0, "main waited 1.00 ms for the moon.");
}

static void test_no_wait(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 16000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "frame", 0, 16000);
	made_zone(m, 1, "wait for workers", 0, 300);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "parked", 0, 16000);
	assert_wait_text(m, 0, "No thread was held up for longer than 320 µs.");
}

static void test_empty_frames(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 0, 0, 0); /* a frame of length 0 */
	assert_verdict(m, UI_PROFILER_LIMIT_UNKNOWN, "Nothing was recorded in this frame.");
	m = made_new();
	made_frame(m, 0, 0, 100);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_lane(m, "GPU", STILB_PROF_LANE_DEVICE);
	assert_verdict(m, UI_PROFILER_LIMIT_UNKNOWN, "Nothing was recorded in this frame.");
	m = made_new();
	made_frame(m, 0, 0, 100);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_zone(m, 0, "short", 0, 10);
	assert_verdict(m, UI_PROFILER_LIMIT_CPU, "CPU-limited: what lies outside all zones decides, 90.0 µs of 100 µs.");
}

/* ---- counters ---------------------------------------------------------------------------------------------------- */

/* All points of one name form one counter, though two sites and two threads recorded them; NaN and infinity are left
 * out. */
static void test_counters(void **state)
{
	(void)state;
	made *m = made_new();
	made_frame(m, 7, 0, 1000);
	made_lane(m, "main", STILB_PROF_LANE_THREAD);
	made_lane(m, "worker 1", STILB_PROF_LANE_THREAD);
	uint32_t draws = made_label(m, "draws"), memory = made_label(m, "memory"), again = made_label(m, "again");
	m->labels[again].name = "draws";
	made_counter(m, 0, draws, 100, 10);
	made_counter(m, 1, again, 200, -2.5);
	made_counter(m, 0, memory, 250, 7);
	made_counter(m, 0, draws, 300, (double)NAN);
	made_counter(m, 0, draws, 310, (double)INFINITY);
	made_counter(m, 0, draws, 400, 11);
	m->points[m->snapshot.point_count++] = (stilb_prof_point){.ns = made_ns(500), .label = memory}; /* an instant */
	ui_profiler_data data = {0};
	for (int twice = 0; twice < 2; twice++) {
		assert_true(ui_profiler_data_build(&data, &m->snapshot, 0));
		assert_int_equal(data.counter_count, 2);
		const ui_profiler_counter *counter = &data.counters[0];
		assert_int_equal(counter->label, draws);
		assert_int_equal(counter->count, 3);
		assert_true(counter->minimum == -2.5 && counter->maximum == 11.0);
		const uint32_t expected[] = {0, 1, 5};
		for (uint32_t i = 0; i < 3; i++)
			assert_int_equal(data.points[counter->first + i], expected[i]);
		assert_int_equal(ui_profiler_counter_at(&data, &m->snapshot, counter, made_ns(99)), STILB_PROF_NONE);
		assert_int_equal(ui_profiler_counter_at(&data, &m->snapshot, counter, made_ns(100)), counter->first);
		assert_int_equal(ui_profiler_counter_at(&data, &m->snapshot, counter, made_ns(399)), counter->first + 1);
		assert_int_equal(ui_profiler_counter_at(&data, &m->snapshot, counter, made_ns(9999)), counter->first + 2);
		counter = &data.counters[1];
		assert_int_equal(counter->label, memory);
		assert_int_equal(counter->count, 1);
		assert_int_equal(data.points[counter->first], 2);
	}
	ui_profiler_data_finish(&data);
	free(m);
}

static void test_parts(void **state)
{
	(void)state;
	ui_profiler_lane_sum sum = {.work_ns = 5, .wait_ns = 1000, .lost_ns = 300, .outside_ns = 80};
	ui_profiler_part parts[UI_PROFILER_PARTS];
	assert_int_equal(ui_profiler_parts(STILB_PROF_LANE_THREAD, &sum, 100, parts), 3);
	assert_string_equal(parts[0].name, "work");
	assert_string_equal(parts[1].name, "wait");
	assert_string_equal(parts[2].name, "lost the CPU");
	assert_true(parts[2].lost && parts[2].ns == 300);
	assert_int_equal(ui_profiler_parts(STILB_PROF_LANE_THREAD, &sum, 0, parts), 4);
	assert_string_equal(parts[3].name, "outside zones");
	assert_int_equal(ui_profiler_parts(STILB_PROF_LANE_DEVICE, &sum, 50, parts), 4);
	assert_string_equal(parts[0].name, "busy");
	assert_string_equal(parts[2].name, "idle");
	assert_int_equal(parts[2].ns, 80);
	assert_int_equal(ui_profiler_parts(STILB_PROF_LANE_THREAD, &(ui_profiler_lane_sum){0}, 0, parts), 1);
	assert_string_equal(parts[0].name, "work");
}

static void test_kinds(void **state)
{
	(void)state;
	assert_int_equal(ui_profiler_kind_of("wait for workers"), UI_PROFILER_WAIT);
	assert_int_equal(ui_profiler_kind_of("waiting"), UI_PROFILER_WAIT);
	assert_int_equal(ui_profiler_kind_of("parked"), UI_PROFILER_IDLE);
	assert_int_equal(ui_profiler_kind_of("record"), UI_PROFILER_WORK);
	assert_int_equal(ui_profiler_kind_of(""), UI_PROFILER_WORK);
}

static void test_time_text(void **state)
{
	(void)state;
	static const struct {
		uint64_t ns;
		const char *text;
	} rows[] = {{0, "0 ns"},           {999, "999 ns"},        {1000, "1.0 µs"},
	            {99949, "99.9 µs"},    {99950, "100 µs"},      {999499, "999 µs"},
	            {999500, "1.00 ms"},   {16666666, "16.67 ms"}, {999499999, "999.50 ms"},
	            {2000000000, "2.00 s"}};
	char text[32];
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		assert_string_equal(ui_profiler_time_text(text, sizeof text, rows[i].ns), rows[i].text);
}

/* ---- history ----------------------------------------------------------------------------------------------------- */

static void test_history(void **state)
{
	(void)state;
	stilb_prof_frame_stats history = {.count = 100, .last = 129};
	float average[STILB_PROF_STATS_FRAMES];
	for (int i = 0; i < 100; i++)
		history.ms[i] = i == 90 ? 50.0 : 10.0 + 0.001 * (i % 10);
	assert_int_equal(ui_profiler_slowest(&history), 90);
	assert_int_equal(ui_profiler_frame_number(&history, 90), 120);
	history.ms[20] = 50.0; /* as slow as frame 90, but longer ago */
	assert_int_equal(ui_profiler_slowest(&history), 90);
	history.ms[20] = 10.0;
	ui_profiler_average(&history, average);
	assert_float_equal(average[0], 10.0f, 1e-5f);
	assert_float_equal(average[1], 10.0005f, 1e-5f);
	assert_float_equal(average[89], 10.0045f, 1e-5f);
	assert_float_equal(average[90], 14.0045f, 1e-5f);
	assert_float_equal(average[99], 14.0045f, 1e-5f);
	history.count = 1;
	assert_int_equal(ui_profiler_slowest(&history), 0);
	assert_int_equal(ui_profiler_frame_number(&history, 0), 129);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_walk),
		cmocka_unit_test(test_walk_from_anywhere),
		cmocka_unit_test(test_off_cpu),
		cmocka_unit_test(test_spans),
		cmocka_unit_test(test_spans_stay_in_parents),
		cmocka_unit_test(test_report),
		cmocka_unit_test(test_wait_for_preempted),
		cmocka_unit_test(test_wait_for_late),
		cmocka_unit_test(test_wait_goes_on_late),
		cmocka_unit_test(test_wait_goes_on_late_for_half),
		cmocka_unit_test(test_wait_in_pieces),
		cmocka_unit_test(test_wait_for_gpu),
		cmocka_unit_test(test_gpu_that_waits),
		cmocka_unit_test(test_gpu_with_time_to_spare),
		cmocka_unit_test(test_display),
		cmocka_unit_test(test_queue_present),
		cmocka_unit_test(test_lost_cpu),
		cmocka_unit_test(test_lane_sums),
		cmocka_unit_test(test_lost_cpu_among_many_sleeps),
		cmocka_unit_test(test_worker_lost_cpu),
		cmocka_unit_test(test_frame_thread),
		cmocka_unit_test(test_no_wait),
		cmocka_unit_test(test_empty_frames),
		cmocka_unit_test(test_counters),
		cmocka_unit_test(test_parts),
		cmocka_unit_test(test_kinds),
		cmocka_unit_test(test_time_text),
		cmocka_unit_test(test_history),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
