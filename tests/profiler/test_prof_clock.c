/* Clocks: the conversion of ticks to nanoseconds. With the argument "monotonic": as if the TSC could not be used. */
#include "support/test.h"
#include "test_prof_records.h"

#include <stdlib.h>
#include <time.h>

static prof_timeline timeline;

static void sleep_ms(long ms)
{
	nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

/* Converts ticks to nanoseconds of CLOCK_MONOTONIC by the timeline. */
static uint64_t timeline_at(uint64_t ticks)
{
	return timeline.epoch_ns + prof_timeline_ns(&timeline, ticks);
}

static void zones_are_timed_by_the_clock(void **state)
{
	(void)state;
	prof_copy copy = {0};
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	uint64_t before = stilb_prof_clock_monotonic();
	{
		PROFILE("outer");
		PROFILE_PRECISE("inner");
		sleep_ms(5);
	}
	uint64_t after = stilb_prof_clock_monotonic();
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	prof_clock_timeline(&timeline, copy.frames, copy.frame_count);
	for (int i = 0; i < 2; i++) {
		prof_record record = record_at(&copy, 0, (size_t)i);
		assert_in_range(timeline_at(record.begin), before - 2000, after - 5000000 + 2000);
		assert_in_range(timeline_at(record.end), before + 5000000 - 2000, after + 2000);
	}
	prof_copy_free(&copy);
	stilb_prof_shutdown();
}

static void a_clock_in_nanoseconds_is_not_converted(void **state)
{
	(void)state;
	prof_anchor wrong = {stilb_prof_clock_monotonic(), 0};
	prof_clock_timeline(&timeline, &wrong, 1);
	uint64_t now = stilb_prof_clock_monotonic();
	assert_string_equal(timeline.clock, "CLOCK_MONOTONIC");
	assert_true(timeline.hz == 1e9);
	assert_int_equal(prof_clock_now() / 1000000000, now / 1000000000);
	assert_int_equal(timeline_at(now), now);
	assert_int_equal(timeline_at(now + 123456789), now + 123456789);
	assert_true(prof_clock_bias_ns() == 0);
}

/* The timeline's lines go through every anchor (a moment on both clocks) that is far enough from the one before, and
 * through no other. */
static void lines_go_from_anchor_to_anchor(void **state)
{
	(void)state;
	prof_anchor anchors[5];
	sleep_ms(60);
	anchors[0] = prof_clock_anchor();
	sleep_ms(5);
	anchors[1] = prof_clock_anchor();
	sleep_ms(60);
	anchors[2] = prof_clock_anchor();
	anchors[3] = (prof_anchor){anchors[2].ticks, anchors[2].ns + 60000000}; /* a clock that stood still */
	anchors[0].ns += 700;                                                   /* CLOCK_MONOTONIC was corrected */
	anchors[1].ns += 900000;
	anchors[2].ns -= 700;
	prof_clock_timeline(&timeline, anchors, 4);
	assert_string_equal(timeline.clock, "rdtsc");
	assert_int_equal(timeline.count, 3);
	assert_in_range(timeline_at(anchors[2].ticks), anchors[2].ns - 1, anchors[2].ns);
	assert_in_range(timeline_at(anchors[0].ticks), anchors[0].ns - 1, anchors[0].ns); /* also backwards */
	assert_in_range(timeline_at(anchors[1].ticks), anchors[1].ns - 905000, anchors[1].ns - 895000);
	sleep_ms(60);
	prof_clock_timeline(&timeline, anchors, 3);
	assert_int_equal(timeline.count, 4); /* the present moment is far enough from the last anchor to end a line, too */
	assert_int_equal(timeline_at(0), timeline.epoch_ns);
	uint64_t now = timeline_at(prof_clock_now());
	assert_in_range(now, stilb_prof_clock_monotonic() - 1000000, stilb_prof_clock_monotonic() + 2000);
	for (int i = 0; i < 3; i++) {
		uint64_t last = timeline_at(anchors[i].ticks - 50000);
		for (uint64_t ticks = anchors[i].ticks - 50000; ticks < anchors[i].ticks + 50000; ticks++) {
			uint64_t ns = timeline_at(ticks);
			assert_true(ns == last || ns == last + 1);
			last = ns;
		}
	}
}

static void more_frames_than_are_remembered(void **state)
{
	(void)state;
	prof_copy copy = {0};
	for (int i = 0; i < PROF_FRAMES_MAX + 10; i++)
		stilb_prof_frame_mark();
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	/* Stretches the frames, so that there are as many lines as possible. */
	for (uint32_t i = 0; i < copy.frame_count; i++) {
		uint64_t back = (uint64_t)(copy.frame_count - i) * 50000001;
		copy.frames[i].ns -= back;
		copy.frames[i].ticks -= (uint64_t)((double)back * timeline.hz / 1e9);
	}
	uint64_t oldest = copy.frames[0].ns;
	prof_clock_timeline(&timeline, copy.frames, copy.frame_count);
	assert_true(timeline.count < sizeof timeline.lines / sizeof timeline.lines[0]);
	assert_true(oldest < timeline.epoch_ns); /* anchors before the clock was first read are left out */
	assert_int_equal(timeline_at(copy.frames[0].ticks), timeline.epoch_ns);
	prof_copy_free(&copy);
	stilb_prof_shutdown();
}

static void costs_are_measured_once(void **state)
{
	(void)state;
	double zone = prof_clock_zone_cost_ns(), bias = prof_clock_bias_ns();
	assert_true(zone > 0.5 && zone < 20000);
	assert_true(bias >= 0 && bias < 1000);
	assert_true(prof_clock_zone_cost_ns() == zone);
	assert_true(prof_clock_bias_ns() == bias);
	print_message("a zone costs %.2f ns and reads %.1f ns short\n", zone, bias);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest monotonic[] = {
		cmocka_unit_test(zones_are_timed_by_the_clock),
		cmocka_unit_test(a_clock_in_nanoseconds_is_not_converted),
		cmocka_unit_test(costs_are_measured_once),
	};
	const struct CMUnitTest tsc[] = {
		cmocka_unit_test(zones_are_timed_by_the_clock),
		cmocka_unit_test(lines_go_from_anchor_to_anchor),
		cmocka_unit_test(more_frames_than_are_remembered),
		cmocka_unit_test(costs_are_measured_once),
	};
	if (argc > 1 && strcmp(argv[1], "monotonic") == 0) {
		prof_clock_force_monotonic();
		return cmocka_run_group_tests(monotonic, NULL, NULL);
	}
	if (!prof_clock_is_tsc()) {
		print_message("the TSC of this machine is not invariant\n");
		return 77;
	}
	return cmocka_run_group_tests(tsc, NULL, NULL);
}
