/*
 * The calibration of job_sys_ticks against a clock and a counter that the test makes up: the thread is stopped for 4 ms
 * at every place between two readings of them, once, or again and again.
 */
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include "jobs/job_sys.h"
#include "support/test.h"

enum { TICKS_IN_8_NS = 21, READING_NS = 25, STOP_NS = 4000000, MOST_READINGS = 20000, NEVER = UINT32_MAX };

/* Time passes only when a thread reads it: READING_NS before each reading, and STOP_NS at a stop. A stop comes
 * before reading number stop_first, counted from 0, and before every stop_every-th from there on (NEVER: only once). */
static struct world {
	uint64_t now_ns;
	uint32_t readings, stop_first, stop_every;
} world;

static void pass_time(void)
{
	if (world.readings >= world.stop_first && (world.readings - world.stop_first) % world.stop_every == 0)
		world.now_ns += STOP_NS;
	world.readings++;
	world.now_ns += READING_NS;
}

static uint64_t made_up_ticks(void)
{
	pass_time();
	return world.now_ns * TICKS_IN_8_NS / 8;
}

static int made_up_clock(clockid_t clock, struct timespec *now)
{
	(void)clock;
	pass_time();
	*now = (struct timespec){.tv_sec = (time_t)(world.now_ns / 1000000000u),
	                         .tv_nsec = (long)(world.now_ns % 1000000000u)};
	return 0;
}

#define job_sys_ticks made_up_ticks
#define clock_gettime made_up_clock
#include "jobs/job_sys.c"
#undef clock_gettime
#undef job_sys_ticks

/* Measures in a new world, and expects the true rate within the 2 % that job_sys.h promises. */
static void measure_with_stops(uint32_t first, uint32_t every)
{
	world = (struct world){.now_ns = 1234567, .stop_first = first, .stop_every = every};
	uint64_t rate = measure(), truth = ((uint64_t)TICKS_IN_8_NS << 20) / 8;
	if (rate < truth - truth / 50 || rate > truth + truth / 50)
		fail_msg("stopped before reading %u: %.2f times the true rate", first, (double)rate / (double)truth);
	assert_true(world.readings < MOST_READINGS);
}

static void test_undisturbed(void **state)
{
	(void)state;
	measure_with_stops(NEVER, NEVER);
	assert_true(world.now_ns < 1234567 + 2 * CALIBRATION_NS);
	uint32_t last = world.readings;
	/* A stop at any place does no harm. */
	for (uint32_t stop = 0; stop <= last; stop++)
		measure_with_stops(stop, NEVER);
}

static void test_stopped_again_and_again(void **state)
{
	(void)state;
	for (uint32_t every = 1; every <= 12; every++)
		for (uint32_t first = 0; first < every; first++)
			measure_with_stops(first, every);
}

static void test_conversion(void **state)
{
	(void)state;
	world = (struct world){.stop_first = NEVER, .stop_every = NEVER};
	uint64_t million = job_sys_ticks_in(1000000);
	assert_in_range(million, 1000000 * TICKS_IN_8_NS / 8 * 49 / 50, 1000000 * TICKS_IN_8_NS / 8 * 51 / 50);
	assert_int_equal(job_sys_ticks_in(0), 0);
	assert_in_range(job_sys_ticks_in(UINT32_MAX) / 4294, million * 49 / 50, million * 51 / 50);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_undisturbed),
		cmocka_unit_test(test_stopped_again_and_again),
		cmocka_unit_test(test_conversion),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
