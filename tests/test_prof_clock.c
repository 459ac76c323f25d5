/* The clock where the TSC cannot be used: CLOCK_MONOTONIC, and nothing else changes. */
#include "test_prof_capture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <time.h>

#include <cmocka.h>

static void monotonic_clock(void **state)
{
	(void)state;
	capture c;
	prof_clock_force_monotonic();
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	assert_false(prof_clock_is_tsc());
	const uint64_t before = stilb_prof_clock_monotonic();
	for (int i = 0; i < 1000; i++) {
		stilb_prof_frame_mark();
		PROFILE("outer");
		PROFILE("inner");
	}
	const stilb_prof_event *event = &stilb_prof_thread_ring->events[0];
	assert_in_range(event->begin >> 12, before, stilb_prof_clock_monotonic());
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 2000);
	assert_non_null(strstr(c.text, "\"clock\":\"CLOCK_MONOTONIC\",\"hz\":1000000000,"));
	capture_finish(&c);
	stilb_prof_shutdown();
}

static void timeline_is_exact_and_monotone(void **state)
{
	(void)state;
	const uint64_t day = UINT64_C(86400) * 2596000000; /* ticks */
	prof_timeline timeline = {.base = 1000, .shift = 56};
	timeline.scale = (uint64_t)(((unsigned __int128)1000000 << 56) / 2596000); /* a millisecond at 2.596 GHz */
	assert_int_equal(prof_timeline_ns(&timeline, 999), 0);
	assert_int_equal(prof_timeline_ns(&timeline, 1000), 0);
	assert_in_range(prof_timeline_ns(&timeline, 1000 + 2596000000), 999999999, 1000000000);
	assert_in_range(prof_timeline_ns(&timeline, 1000 + 10 * day), UINT64_C(863999999999990), UINT64_C(864000000000000));
	uint64_t last = 0;
	for (uint64_t ticks = 1000; ticks < 100000; ticks++) {
		const uint64_t ns = prof_timeline_ns(&timeline, ticks);
		assert_true(ns >= last);
		last = ns;
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(monotonic_clock), /* first: the clock is chosen once */
		cmocka_unit_test(timeline_is_exact_and_monotone),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
