/* The records of each macro: zones, counters, instants, flows, lanes of devices; and sites. */
#include "support/test.h"
#include "test_prof_records.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

static int begin_thread(void **state)
{
	(void)state;
	return stilb_prof_thread_begin("main");
}

static int shut_down(void **state)
{
	(void)state;
	stilb_prof_record_set(true);
	stilb_prof_shutdown();
	return 0;
}

/* The record of the last event of the first lane. */
static prof_record last_record(void)
{
	prof_copy copy = {0};
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_true(copy.lanes[0].event_count > 0);
	prof_record record = record_at(&copy, 0, copy.lanes[0].event_count - 1);
	prof_copy_free(&copy);
	return record;
}

/* ---- sites ------------------------------------------------------------------------------------------------------- */

static uint32_t sites_named(const char *name, const stilb_prof_site **found)
{
	uint32_t count = 0;
	for (const stilb_prof_site *site = stilb_prof_site_next(NULL); site; site = stilb_prof_site_next(site)) {
		assert_non_null(site->name);
		if (strcmp(site->name, name) != 0)
			continue;
		*found = site;
		count++;
	}
	return count;
}

__attribute__((noinline, used)) static void never_called(void)
{
	PROFILE_COLOR("listed before it runs", 0x123456);
	PROFILE_PRECISE("listed as precise");
	PROFILE_COUNTER("listed as counter", 1);
}

static void sites_are_listed(void **state)
{
	(void)state;
	const stilb_prof_site *site = NULL;
	assert_int_equal(sizeof(stilb_prof_site), 64);
	assert_int_equal(_Alignof(stilb_prof_site), 64);
	assert_int_equal(sites_named("listed before it runs", &site), 1);
	assert_string_equal(site->function, "never_called");
	assert_string_equal(strrchr(site->file, '/') + 1, "test_prof_zones.c");
	assert_int_equal(site->color, 0x123456);
	assert_int_equal(site->kind, STILB_PROF_KIND_ZONE);
	assert_true(site->line > 0);
	assert_int_equal(sites_named("listed as precise", &site), 1);
	assert_int_equal(site->kind, STILB_PROF_KIND_PRECISE);
	assert_int_equal(sites_named("listed as counter", &site), 1);
	assert_int_equal(site->kind, STILB_PROF_KIND_COUNTER);
}

static void sites_are_made_once(void **state)
{
	(void)state;
	char name[] = "made";
	const stilb_prof_site *site = stilb_prof_site_make(name, 0xff0000), *found = NULL;
	name[0] = 'f';
	assert_string_equal(site->name, "made"); /* stilb_prof_site_make has copied the name */
	assert_int_equal(site->color, 0xff0000);
	assert_ptr_equal(stilb_prof_site_make("made", 0xff0000), site);
	assert_ptr_not_equal(stilb_prof_site_make("made", 0x00ff00), site);
	assert_int_equal(sites_named("made", &found), 2);
	stilb_prof_zone_begin(site);
	stilb_prof_zone_end();
	assert_ptr_equal(last_record().site, site);
}

/* Several threads make sites of the same names at the same time; then of more names than there is room for. */
static void *make_many(void *sites)
{
	for (int i = 0; i < 100; i++) {
		char name[32];
		snprintf(name, sizeof name, "name %d", i);
		((const stilb_prof_site **)sites)[i] = stilb_prof_site_make(name, 0);
	}
	return NULL;
}

static void sites_are_bounded(void **state)
{
	(void)state;
	static const stilb_prof_site *sites[4][100];
	const stilb_prof_site *found = NULL;
	pthread_t threads[4];
	for (int i = 0; i < 4; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, make_many, sites[i]), 0);
	for (int i = 0; i < 4; i++)
		assert_int_equal(pthread_join(threads[i], NULL), 0);
	for (int i = 1; i < 4; i++)
		assert_memory_equal(sites[0], sites[i], sizeof sites[0]);
	assert_int_equal(sites_named("name 99", &found), 1);
	for (int i = 0; i < 2000; i++) {
		char name[32];
		snprintf(name, sizeof name, "one of too many %d", i);
		found = stilb_prof_site_make(name, 0);
	}
	assert_string_equal(found->name, "more names");
	assert_ptr_equal(stilb_prof_site_make("name 50", 0), sites[0][50]); /* those made before stay */
	stilb_prof_zone_begin(found);
	stilb_prof_zone_end();
	assert_ptr_equal(last_record().site, found);
}

/* Sites of C++ code lie anywhere in the image. */
static void sites_outside_the_section(void **state)
{
	(void)state;
	static const stilb_prof_site elsewhere = STILB_PROF_SITE_INIT_("elsewhere", "", 0, STILB_PROF_KIND_ZONE);
	static stilb_prof_site writable = STILB_PROF_SITE_INIT_("writable", "", 0, STILB_PROF_KIND_ZONE);
	stilb_prof_zone_begin(&elsewhere);
	stilb_prof_zone_end();
	stilb_prof_zone_begin(&writable);
	stilb_prof_zone_end();
	assert_records("elsewhere writable");
}

/* ---- zones ------------------------------------------------------------------------------------------------------- */

STILB_PROF_SITE(hook_site, "hook", 0);
STILB_PROF_SITE(deep_site, "deep", 0);

__attribute__((noinline)) static void function_zone(void)
{
	PROFILE_FUNCTION();
	PROFILE("second");
	PROFILE("third");
}

static int leave_by_return(int i)
{
	PROFILE("loop");
	while (true) {
		PROFILE("pass");
		if (i-- == 0)
			return 1;
	}
}

static void leave_by_goto(void)
{
	for (int i = 0; i < 2; i++) {
		PROFILE("left");
		if (i == 0)
			continue;
		goto out;
	}
out:;
	PROFILE("out");
}

static void scopes_nest(void **state)
{
	(void)state;
	function_zone();
	leave_by_return(1);
	leave_by_goto();
	assert_records("third second function_zone pass pass loop left left out");
}

/* The recorded times of a zone enclose the work done in it. */
static void zones_last_as_long_as_they_did(void **state)
{
	(void)state;
	uint64_t before = prof_clock_now();
	uint64_t begin, end;
	{
		PROFILE("zone");
		begin = prof_clock_now();
		while (prof_clock_now() - begin < 100000)
			;
		end = prof_clock_now();
	}
	prof_record record = last_record();
	assert_in_range(record.begin, before, begin);
	assert_in_range(record.end, end, prof_clock_now());
	assert_int_equal(record.depth, 0);
}

static void begin_and_end(void **state)
{
	(void)state;
	PROFILE_END(); /* without a begin */
	PROFILE_BEGIN("a");
	{
		PROFILE("b");
		PROFILE_BEGIN("c");
		PROFILE_END();
		stilb_prof_zone_begin(&hook_site);
		stilb_prof_zone_end();
	}
	assert_int_equal(stilb_prof_thread_ring->depth, 1);
	PROFILE_END();
	PROFILE_END();
	assert_records("c hook b a");
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
}

/* The end of a PROFILE scope also closes zones that were begun in it and not ended: they give no events, and the depth
 * is right again. */
static void a_missing_end_is_healed(void **state)
{
	(void)state;
	{
		PROFILE("outer");
		PROFILE_BEGIN("forgotten");
		PROFILE_BEGIN("forgotten too");
	}
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_records("outer");
}

static void steps_share_one_clock_read(void **state)
{
	(void)state;
	prof_copy copy = {0};
	{
		PROFILE("one");
		PROFILE_NEXT("two");
		{
			PROFILE("inside");
		}
		PROFILE_NEXT("three");
	}
	PROFILE_BEGIN("four");
	PROFILE_NEXT("five");
	PROFILE_END();
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_records("one inside two three four five");
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	static const uint32_t depths[] = {0, 1, 0, 0, 0, 0};
	for (uint32_t i = 0; i < 6; i++)
		assert_int_equal(record_at(&copy, 0, i).depth, depths[i]);
	assert_int_equal(record_at(&copy, 0, 0).end, record_at(&copy, 0, 2).begin);
	assert_int_equal(record_at(&copy, 0, 2).end, record_at(&copy, 0, 3).begin);
	assert_int_equal(record_at(&copy, 0, 4).end, record_at(&copy, 0, 5).begin);
	prof_copy_free(&copy);
}

static void next_without_a_zone_does_nothing(void **state)
{
	(void)state;
	PROFILE_NEXT("nothing to end");
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_records("");
}

static void precise_zones_are_zones(void **state)
{
	(void)state;
	{
		PROFILE_PRECISE("precise");
		PROFILE_PRECISE("inside");
	}
	assert_records("inside precise");
	prof_record record = last_record();
	assert_int_equal(record.site->kind, STILB_PROF_KIND_PRECISE);
	assert_true(record.end > record.begin);
}

static void open_zones_are_seen(void **state)
{
	(void)state;
	{
		PROFILE("outer");
		{
			PROFILE("done");
		}
		PROFILE("inner");
		PROFILE_NEXT("instead");
		assert_records("done inner|outer instead");
	}
	assert_records("done inner instead outer");
}

/* PROFILE_END and PROFILE_NEXT without an open zone make no ring; a zone that is open when its thread gives up its ring
 * is dropped. */
static void without_a_ring_nothing_ends(void **state)
{
	(void)state;
	{
		PROFILE("cut off");
		stilb_prof_thread_end();
		PROFILE_END();
		PROFILE_NEXT("nothing to end");
		assert_int_equal(stilb_prof_thread_ring->session, 0);
	}
	assert_records("");
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	{
		PROFILE("again");
	}
	assert_records("again");
}

/* A scope that began while recording was off, and ends after the thread got a ring, records nothing. */
static void a_zone_older_than_its_ring_is_dropped(void **state)
{
	(void)state;
	stilb_prof_thread_end();
	stilb_prof_record_set(false);
	{
		PROFILE("unseen");
		stilb_prof_record_set(true);
		assert_int_equal(stilb_prof_thread_begin("main"), 0);
		stilb_prof_zone_begin(&hook_site);
	}
	stilb_prof_zone_end();
	assert_records("hook");
}

static void zones_of_another_ring_are_dropped(void **state)
{
	(void)state;
	prof_copy copy = {0};
	{
		PROFILE("outer");
		PROFILE("inner");
		stilb_prof_thread_end();
		assert_int_equal(stilb_prof_thread_begin("another"), 0);
		{
			PROFILE("whole");
		}
	}
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lane_count, 2);
	assert_int_equal(copy.lanes[0].event_count, 0);
	assert_int_equal(copy.lanes[1].event_count, 1);
	assert_int_equal(record_count(&copy, 1, "whole"), 1);
	prof_copy_free(&copy);
}

static void recurse(int depth)
{
	PROFILE("recurse");
	if (depth > 1)
		recurse(depth - 1);
}

static void zones_too_deep_are_counted(void **state)
{
	(void)state;
	prof_copy copy = {0};
	for (int i = 0; i < 100; i++)
		stilb_prof_zone_begin(&deep_site);
	PROFILE_NEXT("too deep as well");
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lanes[0].open_count, STILB_PROF_DEPTH_MAX);
	for (int i = 0; i < 100; i++)
		stilb_prof_zone_end();
	recurse(100);
	recurse(3);
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(record_count(&copy, 0, "deep"), 64);
	assert_int_equal(record_count(&copy, 0, "recurse"), 64 + 3);
	assert_int_equal(copy.too_deep, 36 + 1 + 36);
	prof_copy_free(&copy);
}

static void durations_saturate(void **state)
{
	(void)state;
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	uint64_t now = prof_clock_now();
	stilb_prof_open(ring, &hook_site, now, 0);
	stilb_prof_close(ring, 0, now + (UINT64_C(1) << 50));
	assert_int_equal(ring->events[0].end >> 18, STILB_PROF_DURATION_MAX);
	stilb_prof_open(ring, &hook_site, now, 0);
	stilb_prof_close(ring, 0, now - 1); /* the clock stepped back */
	assert_int_equal(ring->events[1].end >> 18, 0);
}

/* ---- off and on -------------------------------------------------------------------------------------------------- */

static int evaluated;

static int evaluate(void)
{
	return ++evaluated;
}

static void off_records_nothing(void **state)
{
	(void)state;
	stilb_prof_record_set(false);
	{
		PROFILE("unseen");
		PROFILE_BEGIN("unseen");
		PROFILE_NEXT("unseen");
		PROFILE_END();
		PROFILE_INSTANT("unseen");
		PROFILE_COUNTER("unseen", evaluate());
	}
	assert_records("");
	assert_int_equal(evaluated, 0);
	stilb_prof_record_set(true);
	{
		PROFILE("seen");
		PROFILE_COUNTER("counter", evaluate());
	}
	assert_records("counter seen");
	assert_int_equal(evaluated, 1);
}

/* The end of a zone whose begin was not recorded must not end another zone, whose begin was. */
static void ends_are_not_mistaken(void **state)
{
	(void)state;
	{
		PROFILE("lost");
		stilb_prof_record_set(false);
		PROFILE_BEGIN("off");
		stilb_prof_record_set(true);
		PROFILE_END();
		{
			PROFILE("whole");
		}
	}
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_records("whole");
	PROFILE_BEGIN("open");
	stilb_prof_record_set(false);
	assert_records("whole"); /* while recording is off, no zone is open */
	PROFILE_END();
	stilb_prof_record_set(true);
	assert_records("whole");
	PROFILE_BEGIN("new");
	assert_records("whole|new");
	PROFILE_END();
	assert_records("whole new");
}

static void on_twice_is_on(void **state)
{
	(void)state;
	PROFILE_BEGIN("kept");
	stilb_prof_record_set(true);
	PROFILE_END();
	assert_records("kept");
}

/* ---- counters and instants --------------------------------------------------------------------------------------- */

static double counted(double value)
{
	PROFILE_COUNTER("counter", value);
	return last_record().value;
}

static void counters_keep_40_bits(void **state)
{
	(void)state;
	static const double exact[] = {0.0,     -0.0, 1, -1, 0.5, 1e6, 17179869184.0, 2199023255552.0, -2199023255551.0,
	                               0x1p1000};
	for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++) {
		double value = counted(exact[i]);
		assert_memory_equal(&value, &exact[i], sizeof value);
	}
	for (double value = 1e-300; value < 1e300; value *= 1234.567891) {
		assert_true(fabs(counted(value) - value) <= value * 0x1p-41);
		assert_true(fabs(counted(-value) + value) <= value * 0x1p-41);
	}
	assert_true(isinf(counted(HUGE_VAL)) && isinf(counted(-HUGE_VAL)));
	assert_true(isnan(counted((double)NAN)));
}

static void counters_and_instants_have_a_time(void **state)
{
	(void)state;
	uint64_t before = prof_clock_now();
	PROFILE_COUNTER("counter", 3);
	prof_record counter = last_record();
	PROFILE_INSTANT("instant");
	prof_record instant = last_record();
	assert_in_range(counter.begin, before, instant.begin);
	assert_int_equal(counter.end, counter.begin);
	assert_in_range(instant.begin, counter.begin, prof_clock_now());
	assert_int_equal(instant.site->kind, STILB_PROF_KIND_INSTANT);
	assert_records("counter instant");
}

/* ---- flows ------------------------------------------------------------------------------------------------------- */

STILB_PROF_FLOW(job_flow, "job", 0x00ff00);

typedef struct job {
	uint64_t id;
	int error;
} job;

static void *run_job(void *data)
{
	job *j = data;
	j->error = stilb_prof_thread_begin("worker");
	{
		PROFILE("run");
		stilb_prof_flow_end(job_flow, j->id);
	}
	stilb_prof_thread_end();
	return NULL;
}

static void flows_go_from_thread_to_thread(void **state)
{
	(void)state;
	pthread_t thread;
	prof_copy copy = {0};
	for (int i = 0; i < 70000; i++) /* more frames than the 16 bits in a flow's id can number */
		stilb_prof_frame_mark();
	job j = {0};
	{
		PROFILE("submit");
		j.id = stilb_prof_flow_begin(job_flow);
	}
	assert_int_not_equal(j.id, 0);
	assert_int_equal(pthread_create(&thread, NULL, run_job, &j), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_int_equal(j.error, 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lane_count, 2);
	prof_record from = record_at(&copy, 0, 0), to = record_at(&copy, 1, 0);
	assert_int_equal(from.site->kind, STILB_PROF_KIND_FLOW_BEGIN);
	assert_int_equal(to.site->kind, STILB_PROF_KIND_FLOW_END);
	assert_string_equal(from.site->name, "job");
	assert_string_equal(to.site->name, "job");
	assert_int_equal(from.flow, j.id);
	assert_int_equal(to.flow, j.id);
	assert_int_equal(from.depth, 1); /* one zone is open around each */
	assert_int_equal(to.depth, 1);
	assert_in_range(to.begin, from.begin, prof_clock_now());
	assert_int_equal(prof_flow_frame(j.id, 69999), 69999);
	assert_int_equal(prof_flow_frame(j.id, 70500), 69999); /* also when 500 more frames have begun */
	prof_copy_free(&copy);
}

static void flows_have_numbers_of_their_own(void **state)
{
	(void)state;
	enum { COUNT = 3 << 20 }; /* the 20-bit sequence number in the ids comes round twice */
	stilb_prof_frame_mark();
	uint64_t last = 0;
	for (int i = 0; i < COUNT; i++) {
		uint64_t id = stilb_prof_flow_begin(job_flow);
		if (id == 0 || id == last || id >> 46 != 0 || prof_flow_frame(id, 0) != 0)
			fail_msg("flow %d has the number %llx", i, (unsigned long long)id);
		last = id;
	}
}

static void flows_without_a_begin_do_nothing(void **state)
{
	(void)state;
	stilb_prof_flow_end(job_flow, 0);
	assert_int_equal(stilb_prof_flow_begin(&hook_site), 0); /* not a flow */
	stilb_prof_flow_end(&hook_site, 1);
	assert_records("");
	stilb_prof_record_set(false);
	assert_int_equal(stilb_prof_flow_begin(job_flow), 0);
	stilb_prof_record_set(true);
	assert_records("");
}

/* ---- lanes of devices -------------------------------------------------------------------------------------------- */

STILB_PROF_SITE(gpu_frame, "gpu frame", 0);
STILB_PROF_SITE(gpu_pass, "gpu pass", 0);

static void lanes_hold_zones_timed_elsewhere(void **state)
{
	(void)state;
	prof_copy copy = {0};
	stilb_prof_lane_handle *lane = NULL, *again = NULL;
	assert_int_equal(stilb_prof_lane_create("GPU", &lane), 0);
	uint64_t now = stilb_prof_clock_monotonic();
	stilb_prof_lane_zone(lane, &gpu_pass, 1, now - 900, now - 500);
	stilb_prof_lane_zone(lane, &gpu_frame, 0, now - 1000, now);
	stilb_prof_lane_zone(lane, &gpu_frame, 0, now, now - 5); /* ends before it begins */
	stilb_prof_lane_zone(lane, &gpu_frame, STILB_PROF_DEPTH_MAX, now, now);
	stilb_prof_lane_zone(NULL, &gpu_frame, 0, now, now);
	stilb_prof_record_set(false);
	stilb_prof_lane_zone(lane, &gpu_frame, 0, now, now);
	stilb_prof_record_set(true);
	stilb_prof_lane_destroy(lane);
	stilb_prof_lane_destroy(NULL);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lane_count, 2);
	assert_true(copy.lanes[1].device);
	assert_false(copy.lanes[0].device);
	assert_int_equal(copy.lanes[1].tid, 0);
	assert_string_equal(copy.lanes[1].name, "GPU");
	assert_int_equal(copy.lanes[1].event_count, 3);
	assert_int_equal(copy.too_deep, 1);
	prof_record pass = record_at(&copy, 1, 0), frame = record_at(&copy, 1, 1), odd = record_at(&copy, 1, 2);
	assert_int_equal(pass.begin, now - 900);
	assert_int_equal(pass.end, now - 500);
	assert_int_equal(pass.depth, 1);
	assert_int_equal(frame.begin, now - 1000);
	assert_int_equal(frame.end, now);
	assert_int_equal(odd.end, odd.begin);
	assert_int_equal(stilb_prof_lane_create("GPU", &again), 0);
	assert_ptr_equal(again, lane); /* a new lane of that name takes over the ring of the old one */
	assert_int_equal(stilb_prof_lane_create("main", &lane), 0);
	assert_ptr_not_equal(lane, again);
	prof_copy_free(&copy);
}

/* A thread does not take over a device's ring, nor a device a thread's: their times are on different clocks. */
static void lanes_and_threads_do_not_mix(void **state)
{
	(void)state;
	prof_copy copy = {0};
	stilb_prof_lane_handle *lane = NULL;
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_lane_create("main", &lane), 0);
	stilb_prof_lane_destroy(lane);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lane_count, 2);
	assert_false(copy.lanes[0].device);
	assert_true(copy.lanes[1].device);
	prof_copy_free(&copy);
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

static void threads_have_names_and_numbers(void **state)
{
	(void)state;
	char name[200], cut[PROF_NAME_MAX];
	prof_copy copy = {0};
	memset(name, 'n', sizeof name);
	name[sizeof name - 1] = 0;
	memset(cut, 'n', sizeof cut);
	cut[sizeof cut - 1] = 0;
	stilb_prof_thread_end();
	uint64_t before = stilb_prof_clock_monotonic();
	assert_int_equal(stilb_prof_thread_begin(name), 0);
	stilb_prof_thread_end();
	uint64_t between = stilb_prof_clock_monotonic();
	assert_int_equal(stilb_prof_thread_begin(NULL), 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_string_equal(copy.lanes[1].name, cut);
	assert_string_equal(copy.lanes[2].name, "thread");
	assert_int_equal(copy.lanes[2].tid, gettid());
	assert_in_range(copy.lanes[1].begun_ns, before, between);
	assert_in_range(copy.lanes[1].ended_ns, copy.lanes[1].begun_ns, between);
	assert_in_range(copy.lanes[2].begun_ns, between, stilb_prof_clock_monotonic());
	assert_int_equal(copy.lanes[2].ended_ns, 0);
	stilb_prof_thread_end(); /* the same when the ring is taken over */
	assert_int_equal(stilb_prof_thread_begin(name), 0);
	uint64_t again = copy.lanes[2].begun_ns;
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_true(copy.lanes[1].begun_ns > again);
	assert_int_equal(copy.lanes[1].ended_ns, 0);
	prof_copy_free(&copy);
}

#define ZONE_TEST(f) cmocka_unit_test_setup_teardown(f, begin_thread, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sites_are_listed),
		ZONE_TEST(sites_are_made_once),
		ZONE_TEST(sites_outside_the_section),
		ZONE_TEST(scopes_nest),
		ZONE_TEST(zones_last_as_long_as_they_did),
		ZONE_TEST(begin_and_end),
		ZONE_TEST(a_missing_end_is_healed),
		ZONE_TEST(steps_share_one_clock_read),
		ZONE_TEST(next_without_a_zone_does_nothing),
		ZONE_TEST(precise_zones_are_zones),
		ZONE_TEST(open_zones_are_seen),
		ZONE_TEST(without_a_ring_nothing_ends),
		ZONE_TEST(a_zone_older_than_its_ring_is_dropped),
		ZONE_TEST(zones_of_another_ring_are_dropped),
		ZONE_TEST(zones_too_deep_are_counted),
		ZONE_TEST(durations_saturate),
		ZONE_TEST(off_records_nothing),
		ZONE_TEST(ends_are_not_mistaken),
		ZONE_TEST(on_twice_is_on),
		ZONE_TEST(counters_keep_40_bits),
		ZONE_TEST(counters_and_instants_have_a_time),
		ZONE_TEST(flows_go_from_thread_to_thread),
		ZONE_TEST(flows_have_numbers_of_their_own),
		ZONE_TEST(flows_without_a_begin_do_nothing),
		ZONE_TEST(lanes_hold_zones_timed_elsewhere),
		ZONE_TEST(lanes_and_threads_do_not_mix),
		ZONE_TEST(threads_have_names_and_numbers),
		ZONE_TEST(sites_are_bounded), /* last: the names stay */
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
