/* Rings: wrap-around, copies while a thread records, threads that come and go. */
#include "test_prof_capture.h"

#include <errno.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/mman.h>

#include <cmocka.h>

static int shut_down(void **state)
{
	(void)state;
	stilb_prof_shutdown();
	return 0;
}

STILB_PROF_SITE(even_site, "even", 0);
STILB_PROF_SITE(odd_site, "odd", 0);

/* Event n: everything in it follows from n, so a mixture of two events shows. */
#define STEP 1000

static uint64_t event_duration(uint64_t n)
{
	return n * 0x9e3779b97f4a7c15u >> 33;
}

static uint32_t event_depth(uint64_t n)
{
	return (uint32_t)(n * 0x9e3779b97f4a7c15u >> 20 & 31);
}

static void event_record(uint64_t n)
{
	const uint64_t begin = (n + 1) * STEP;
	stilb_prof_close(stilb_prof_thread_ring, n % 2 ? &odd_site : &even_site, begin, begin + event_duration(n),
	                 event_depth(n)); /* leaves a depth behind that nothing was opened at: tests of events alone */
}

static bool event_is_whole(const prof_zone *zone, uint64_t n)
{
	return zone->begin == (n + 1) * STEP && zone->end - zone->begin == event_duration(n) &&
	       zone->depth == event_depth(n) && zone->site == (n % 2 ? &odd_site : &even_site) && !zone->open;
}

/* True when the closed zones of the only thread are consecutive whole events up to the last. */
static bool copy_is_whole(const prof_copy *copy)
{
	const prof_zone *zones = copy->threads[0].zones;
	const uint64_t first = copy->events_held > 0 ? zones[0].begin / STEP - 1 : 0;
	for (uint32_t i = 0; i < copy->events_held; i++)
		if (!event_is_whole(&zones[i], first + i))
			return false;
	return true;
}

static void wrap_keeps_the_newest(void **state)
{
	(void)state;
	prof_copy copy;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	for (uint64_t n = 0; n < 1000; n++) {
		event_record(n);
		assert_int_equal(prof_copy_take(&copy), 0);
		const uint32_t held = n + 1 < 64 ? (uint32_t)n + 1 : 63; /* the oldest may be about to be overwritten */
		assert_true(copy_is_whole(&copy));
		assert_true(event_is_whole(&copy.threads[0].zones[held - 1], n));
		assert_int_equal(copy.events_recorded, n + 1);
		assert_int_equal(copy.events_held, held);
		prof_copy_free(&copy);
	}
}

static void accounts_reach_the_trace(void **state)
{
	(void)state;
	capture c;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	for (int i = 0; i < 200; i++) {
		PROFILE("zone");
	}
	assert_trace(&c, 0);
	assert_int_equal(c.report.events_recorded, 200);
	assert_int_equal(c.report.events_lost, 137);
	assert_int_equal(c.report.zones, 63);
	capture_finish(&c);
}

static void ring_sizes(void **state)
{
	(void)state;
	assert_int_equal(stilb_prof_ring_events_set(0), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(32), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(100), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(1u << 25), -EINVAL);
	assert_int_equal(stilb_prof_thread_begin(NULL), 0);
	assert_int_equal(stilb_prof_thread_begin("twice"), -EALREADY);
	assert_int_equal(stilb_prof_thread_ring->mask, 65535);
}

/* ---- copies while a thread records ------------------------------------------------------------------------------- */

typedef struct writer {
	uint32_t stop; /* relaxed: no data depends on it */
	uint32_t began;
	int error;
	stilb_prof_ring *ring;
} writer;

static bool writer_goes_on(writer *w)
{
	return !__atomic_load_n(&w->stop, __ATOMIC_RELAXED);
}

static void writer_start(pthread_t *thread, void *(*run)(void *), writer *w)
{
	assert_int_equal(pthread_create(thread, NULL, run, w), 0);
	while (!__atomic_load_n(&w->began, __ATOMIC_ACQUIRE)) /* pairs with writer_begin */
		;
}

static void writer_begin(writer *w)
{
	w->error = stilb_prof_thread_begin("writer");
	w->ring = stilb_prof_thread_ring;
	__atomic_store_n(&w->began, 1, __ATOMIC_RELEASE); /* pairs with writer_start */
}

static void writer_join(pthread_t thread, writer *w)
{
	__atomic_store_n(&w->stop, 1, __ATOMIC_RELAXED);
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_int_equal(w->error, 0);
}

/* A reader's loop: goes on until the writer was seen at work often enough. On a crowded machine a second must do, and
 * twenty if it was not seen at all. */
typedef struct watch {
	uint64_t start, head;
	int wanted, seen;
} watch;

static watch watch_start(int wanted)
{
	return (watch){stilb_prof_clock_monotonic(), 0, wanted, 0};
}

static bool watch_goes_on(watch *reader, const writer *w)
{
	const uint64_t head = __atomic_load_n(&w->ring->head, __ATOMIC_RELAXED); /* a hint: no data depends on it */
	const uint64_t age = stilb_prof_clock_monotonic() - reader->start;
	reader->seen += head != reader->head;
	reader->head = head;
	return reader->seen < reader->wanted && age < UINT64_C(1000000000) * (reader->seen > 1 ? 1 : 20);
}

static void *write_events(void *data)
{
	writer *w = data;
	writer_begin(w);
	for (uint64_t n = 0; w->error == 0 && writer_goes_on(w); n++) {
		stilb_prof_clock(w->ring); /* no faster than zones are, or it laps every copy */
		stilb_prof_clock(w->ring);
		event_record(n);
	}
	stilb_prof_thread_end();
	return NULL;
}

static void copies_are_never_torn(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint64_t broken = 0;
	prof_copy last;
	assert_int_equal(stilb_prof_ring_events_set(1024), 0);
	writer_start(&thread, write_events, &w);
	for (watch reader = watch_start(2000); watch_goes_on(&reader, &w);) {
		prof_copy copy;
		broken += prof_copy_take(&copy) != 0 || !copy_is_whole(&copy);
		prof_copy_free(&copy);
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	assert_int_equal(prof_copy_take(&last), 0);
	assert_true(copy_is_whole(&last));
	assert_in_range(last.events_held, 1, 1023);
	assert_int_equal(last.threads[0].zones[last.events_held - 1].begin, last.events_recorded * STEP);
	prof_copy_free(&last);
}

/* Opens and closes event after event, one inside another: 0 (1 (2)), 3 (4 (5)), ... */
static void *write_open_events(void *data)
{
	writer *w = data;
	writer_begin(w);
	for (uint64_t n = 0; w->error == 0 && writer_goes_on(w); n += 3) {
		for (uint32_t depth = 0; depth < 3; depth++)
			stilb_prof_open(stilb_prof_thread_ring, (n + depth) % 2 ? &odd_site : &even_site, (n + depth + 1) * STEP,
			                depth);
		for (uint32_t depth = 3; depth-- > 0;)
			stilb_prof_close(stilb_prof_thread_ring, (n + depth) % 2 ? &odd_site : &even_site, (n + depth + 1) * STEP,
			                 (n + depth + 2) * STEP, depth);
	}
	stilb_prof_thread_end();
	return NULL;
}

/* Are the open zones whole, each inside the one after it? */
static bool open_events_are_whole(const prof_zone *zones, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		const uint64_t n = zones[i].begin / STEP - 1;
		if (!zones[i].open || zones[i].depth != count - 1 - i || n % 3 != zones[i].depth ||
		    zones[i].site != (n % 2 ? &odd_site : &even_site))
			return false;
		if (i > 0 && zones[i].begin + STEP != zones[i - 1].begin)
			return false;
	}
	return true;
}

/* Is a zone of the copy both open and closed? */
static bool zone_is_there_twice(const prof_thread_copy *thread, uint32_t closed)
{
	for (uint32_t i = closed; i < thread->count; i++)
		for (uint32_t k = 0; k < closed; k++)
			if (thread->zones[k].begin == thread->zones[i].begin)
				return true;
	return false;
}

static void open_zones_are_never_torn(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint64_t open = 0, broken = 0, twice = 0;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_open_events, &w);
	for (watch reader = watch_start(300000); watch_goes_on(&reader, &w);) {
		prof_zone zones[STILB_PROF_DEPTH_MAX];
		const uint32_t count = prof_copy_open(w.ring, zones);
		broken += !open_events_are_whole(zones, count);
		open += count;
	}
	for (watch reader = watch_start(10000); watch_goes_on(&reader, &w);) {
		prof_copy copy;
		broken += prof_copy_take(&copy) != 0;
		twice += zone_is_there_twice(&copy.threads[0], (uint32_t)copy.events_held);
		prof_copy_free(&copy);
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	assert_int_equal(twice, 0);
	assert_true(open > 0);
}

/* Zones named after their level. */
static void *write_zones(void *data)
{
	writer *w = data;
	writer_begin(w);
	while (w->error == 0 && writer_goes_on(w)) {
		PROFILE("0");
		for (int i = 0; i < 3; i++) {
			PROFILE("1");
			{
				PROFILE("2");
			}
			PROFILE("2 too");
		}
	}
	stilb_prof_thread_end();
	return NULL;
}

/* The name's first character is the level; parents lie one level up and began no later. */
static bool zones_are_consistent(const prof_thread_copy *thread)
{
	const prof_zone *inner = NULL;
	for (uint32_t i = 0; i < thread->count; i++) {
		const prof_zone *zone = &thread->zones[i];
		if (zone->depth != (uint32_t)(zone->site->name[0] - '0') || zone->end < zone->begin)
			return false;
		if (zone->open && inner != NULL && (inner->depth != zone->depth + 1 || inner->begin < zone->begin))
			return false;
		inner = zone->open ? zone : NULL;
	}
	return true;
}

static void open_zones_are_whole(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint64_t open = 0, broken = 0;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_zones, &w);
	for (watch reader = watch_start(10000); watch_goes_on(&reader, &w);) {
		prof_copy copy;
		broken += prof_copy_take(&copy) != 0 || !zones_are_consistent(&copy.threads[0]);
		open += copy.threads[0].count - copy.events_held;
		prof_copy_free(&copy);
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	assert_true(open > 0);
}

static void traces_of_a_busy_thread_keep_every_rule(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	assert_int_equal(stilb_prof_ring_events_set(1024), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	writer_start(&thread, write_zones, &w);
	for (int i = 0; i < 100; i++) {
		PROFILE("trace");
		capture c;
		stilb_prof_frame_mark();
		if (capture_take(&c, i % 2 ? 3 : 0) != 0) {
			writer_join(thread, &w);
			fail_msg("trace %d: %s", i, c.report.error);
		}
		assert_int_equal(c.report.threads, 2);
		capture_finish(&c);
	}
	writer_join(thread, &w);
}

/* Frames are marked by one thread and read by another. */
static void *write_frames(void *data)
{
	writer *w = data;
	writer_begin(w);
	while (writer_goes_on(w))
		stilb_prof_frame_mark();
	stilb_prof_thread_end();
	return NULL;
}

static void frames_are_never_torn(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint64_t broken = 0;
	writer_start(&thread, write_frames, &w);
	for (int i = 0; i < 1000; i++) {
		prof_copy copy;
		broken += prof_copy_take(&copy) != 0;
		for (uint32_t k = 1; k < copy.frame_count; k++)
			broken += copy.frame_begin[k] < copy.frame_begin[k - 1];
		prof_copy_free(&copy);
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
}

/* ---- threads that come and go ------------------------------------------------------------------------------------- */

typedef struct worker {
	char name[32];
	int error;
} worker;

static void *work(void *data)
{
	worker *w = data;
	w->error = stilb_prof_thread_begin(w->name);
	{
		PROFILE("work");
	}
	stilb_prof_thread_end();
	return NULL;
}

/* Runs count threads, four at a time; names repeats after that many. */
static void run_workers(unsigned count, unsigned names)
{
	for (unsigned i = 0; i < count; i += 4) {
		pthread_t thread[4];
		worker workers[4] = {0};
		for (unsigned k = 0; k < 4; k++) {
			snprintf(workers[k].name, sizeof workers[k].name, "worker %u", (i + k) % names);
			assert_int_equal(pthread_create(&thread[k], NULL, work, &workers[k]), 0);
		}
		for (unsigned k = 0; k < 4; k++) {
			assert_int_equal(pthread_join(thread[k], NULL), 0);
			assert_int_equal(workers[k].error, 0);
		}
	}
}

static void threads_of_the_same_names_share_rings(void **state)
{
	(void)state;
	uint32_t ended;
	capture c;
	run_workers(1000, 8);
	assert_int_equal(prof_ring_count(&ended), 8);
	assert_int_equal(ended, 8);
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 1000);
	assert_int_equal(c.report.events_lost, 0);
	assert_int_equal(c.report.threads, 8);
	assert_int_equal(trace_check_zones(&c.report, "worker 3", "work"), 125);
	capture_finish(&c);
}

static void threads_of_new_names_are_bounded(void **state)
{
	(void)state;
	uint32_t ended;
	capture c;
	run_workers(1000, 1000);
	assert_in_range(prof_ring_count(&ended), PROF_ENDED_MAX, PROF_ENDED_MAX + 4);
	assert_trace(&c, 0);
	assert_int_equal(c.report.events_recorded, 1000);
	assert_int_equal(c.report.events_lost + c.report.zones, 1000);
	assert_int_equal(trace_check_zones(&c.report, "worker 999", "work"), 1); /* the last ones are still there */
	assert_int_equal(trace_check_zones(&c.report, "worker 0", "work"), 0);
	capture_finish(&c);
}

static void living_threads_do_not_share(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint32_t ended;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	assert_int_equal(stilb_prof_thread_begin("writer"), 0);
	writer_start(&thread, write_zones, &w);
	assert_int_equal(prof_ring_count(&ended), 2);
	assert_int_equal(ended, 0);
	writer_join(thread, &w);
}

static void shutdown_unmaps_the_rings(void **state)
{
	(void)state;
	unsigned char resident;
	uint32_t ended;
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	void *ring = stilb_prof_thread_ring;
	assert_int_equal(mincore(ring, 1, &resident), 0);
	stilb_prof_shutdown();
	assert_null(stilb_prof_thread_ring);
	assert_int_equal(mincore(ring, 1, &resident), -1);
	assert_int_equal(errno, ENOMEM);
	assert_int_equal(prof_ring_count(&ended), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0); /* and once more */
	{
		PROFILE("zone");
	}
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 1);
	capture_finish(&c);
}

#define RING_TEST(f) cmocka_unit_test_teardown(f, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		RING_TEST(wrap_keeps_the_newest),
		RING_TEST(accounts_reach_the_trace),
		RING_TEST(ring_sizes),
		RING_TEST(copies_are_never_torn),
		RING_TEST(open_zones_are_never_torn),
		RING_TEST(open_zones_are_whole),
		RING_TEST(traces_of_a_busy_thread_keep_every_rule),
		RING_TEST(frames_are_never_torn),
		RING_TEST(threads_of_the_same_names_share_rings),
		RING_TEST(threads_of_new_names_are_bounded),
		RING_TEST(living_threads_do_not_share),
		RING_TEST(shutdown_unmaps_the_rings),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
