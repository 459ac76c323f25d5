/* Rings: wrap-around, windows, copies while a thread records, threads that come and go. */
#include "support/test.h"
#include "test_prof_records.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/mman.h>

static int shut_down(void **state)
{
	(void)state;
	stilb_prof_record_set(true);
	stilb_prof_shutdown();
	return 0;
}

STILB_PROF_SITE(even_site, "even", 0);
STILB_PROF_SITE(odd_site, "odd", 0);

/* The tests record numbered events. All members of event n are computed from n, so a copy that mixes two events is
 * detected. Event n ends at about (n + 1) * STEP ticks, so ends ascend, as they must. */
#define STEP 1000

static uint64_t event_duration(uint64_t n)
{
	return n * 0x9e3779b97f4a7c15u >> 55;
}

static uint32_t event_depth(uint64_t n)
{
	return (uint32_t)(n * 0x9e3779b97f4a7c15u >> 20 & 31);
}

static void event_record(uint64_t n)
{
	stilb_prof_write(stilb_prof_thread_ring, n % 2 ? &odd_site : &even_site, (n + 1) * STEP, event_depth(n),
	                 event_duration(n));
}

static bool event_is_whole(const prof_record *record, uint64_t n)
{
	return record->begin == (n + 1) * STEP && record->end - record->begin == event_duration(n) &&
	       record->depth == event_depth(n) && record->site == (n % 2 ? &odd_site : &even_site);
}

/* True if the events of the only thread are consecutive, and none is a mixture of two (see STEP). */
static bool copy_is_whole(const prof_copy *copy)
{
	size_t count = copy->lanes[0].event_count;
	uint64_t first = count > 0 ? record_at(copy, 0, 0).begin / STEP - 1 : 0;
	for (size_t i = 0; i < count; i++) {
		prof_record record = record_at(copy, 0, i);
		if (!event_is_whole(&record, first + i))
			return false;
	}
	return true;
}

static void wrap_keeps_the_newest(void **state)
{
	(void)state;
	prof_copy copy = {0};
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	for (uint64_t n = 0; n < 1000; n++) {
		event_record(n);
		assert_int_equal(prof_copy_take(&copy, NULL), 0);
		uint32_t held = n + 1 < 64 ? (uint32_t)n + 1 : 63; /* the oldest may be about to be overwritten */
		assert_true(copy_is_whole(&copy));
		prof_record last = record_at(&copy, 0, held - 1);
		assert_true(event_is_whole(&last, n));
		assert_int_equal(copy.lanes[0].event_count, held);
		assert_int_equal(copy.events_recorded, n + 1);
		assert_int_equal(copy.events_held, held);
	}
	prof_copy_free(&copy);
}

static void ring_sizes(void **state)
{
	(void)state;
	assert_int_equal(stilb_prof_ring_events_set(0), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(32), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(100), -EINVAL);
	assert_int_equal(stilb_prof_ring_events_set(1u << 27), -EINVAL);
	assert_int_equal(stilb_prof_thread_begin(NULL), 0);
	assert_int_equal(stilb_prof_thread_begin("twice"), -EALREADY);
	assert_int_equal(stilb_prof_thread_ring->mask, 65535);
}

static bool is_resident(void *address)
{
	unsigned char resident = 0;
	assert_int_equal(mincore((void *)((uintptr_t)address & ~(uintptr_t)4095), 1, &resident), 0);
	return resident & 1;
}

/* A large ring is address space until it is written to; a small one is in memory at once. */
static void large_rings_cost_what_is_used(void **state)
{
	(void)state;
	if (getenv("STILB_EMULATED"))
		skip(); /* qemu-user maps memory in its own way */
	uint32_t sizes[] = {65536, 1u << 26};
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_prof_ring_events_set(sizes[i]), 0);
		assert_int_equal(stilb_prof_thread_begin(i == 0 ? "small" : "large"), 0);
		stilb_prof_event *events = stilb_prof_thread_ring->events;
		assert_int_equal(is_resident(&events[sizes[i] - 1]), i == 0);
		assert_int_equal(is_resident(&events[sizes[i] / 2]), i == 0);
		event_record(0);
		assert_true(is_resident(&events[0]));
		stilb_prof_thread_end();
	}
}

/* ---- windows ----------------------------------------------------------------------------------------------------- */

STILB_PROF_SITE(long_site, "long", 0);

/* A hundred zones in each frame, named after its number, and one from the start of frame 3 to that of frame 6. */
static void window_frames(uint32_t frames)
{
	for (uint32_t i = 0; i < frames; i++) {
		stilb_prof_frame_mark();
		if (i == 3)
			stilb_prof_zone_begin(&long_site);
		if (i == 6)
			stilb_prof_zone_end();
		for (int k = 0; k < 100; k++) {
			stilb_prof_zone_begin(i % 2 ? &odd_site : &even_site);
			stilb_prof_zone_end();
		}
	}
}

static void windows_hold_what_overlaps_them(void **state)
{
	(void)state;
	prof_copy copy = {0};
	stilb_prof_window window = {.last_frames = 2};
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	window_frames(10); /* ten marks make 9 whole frames */

	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.lanes[0].event_count, 300); /* those of frames 7 and 8, and of the frame in progress */
	assert_int_equal(copy.window_first, 7);
	assert_int_equal(copy.window_count, 2);
	assert_int_equal(copy.events_held, 1001);
	assert_int_equal(copy.events_recorded, 1001);

	window = (stilb_prof_window){.first_frame = 4, .frame_count = 1};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(record_count(&copy, 0, "even"), 100);
	assert_int_equal(record_count(&copy, 0, "long"), 1); /* it began before the window and ended after it */
	assert_int_equal(copy.lanes[0].event_count, 101);
	assert_int_equal(copy.window_first, 4);
	assert_int_equal(copy.window_count, 1);
	assert_int_equal(copy.begin.ticks, copy.frames[4].ticks);
	assert_int_equal(copy.end.ns, copy.frames[5].ns);

	window = (stilb_prof_window){.first_frame = 6, .frame_count = 1};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(record_count(&copy, 0, "long"), 1); /* it began before the window and ended first in it */
	assert_int_equal(copy.lanes[0].event_count, 101);

	window = (stilb_prof_window){.first_frame = 8, .frame_count = 100}; /* frame 9, the last, has not ended */
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.lanes[0].event_count, 100);
	assert_int_equal(copy.window_count, 1);

	window = (stilb_prof_window){.first_frame = 9, .frame_count = 1};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.lanes[0].event_count, 0);
	assert_int_equal(copy.window_count, 0);

	window = (stilb_prof_window){.last_frames = 10};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.lanes[0].event_count, 1001);
	assert_int_equal(copy.window_count, 9);
	prof_copy_free(&copy);
}

/* Frames that are no longer remembered are not in the window; those that are, are whole. */
static void windows_end_where_memory_does(void **state)
{
	(void)state;
	prof_copy copy = {0};
	assert_int_equal(stilb_prof_ring_events_set(1024), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	window_frames(2000);
	stilb_prof_window window = {.first_frame = 900, .frame_count = 200};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.frame_count, 1023);
	assert_int_equal(copy.first_frame, 977);
	assert_int_equal(copy.window_first, 0);
	assert_int_equal(copy.window_count, 1100 - 977);
	assert_int_equal(copy.lanes[0].event_count, 0); /* the ring does not go back that far */
	window = (stilb_prof_window){.first_frame = 0, .frame_count = 900};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.window_count, 0);
	window = (stilb_prof_window){.last_frames = 9};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	assert_int_equal(copy.lanes[0].event_count, 1000);
	prof_copy_free(&copy);
}

/* Times of a device's lane are on CLOCK_MONOTONIC, not in ticks of the TSC. */
static void windows_of_devices(void **state)
{
	(void)state;
	prof_copy copy = {0};
	stilb_prof_lane_handle *lane;
	assert_int_equal(stilb_prof_lane_create("GPU", &lane), 0);
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		uint64_t now = stilb_prof_clock_monotonic();
		stilb_prof_lane_zone(lane, i % 2 ? &odd_site : &even_site, 0, now, now);
	}
	stilb_prof_window window = {.first_frame = 5, .frame_count = 1};
	assert_int_equal(prof_copy_take(&copy, &window), 0);
	char names[64];
	record_names(&copy, 0, names, sizeof names);
	assert_string_equal(names, "odd");
	prof_copy_free(&copy);
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

/* The loop of a reading thread: goes on until its copies have met the writer at work often enough. On a crowded machine
 * it ends after a second, or after twenty if they have not met it at all. */
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
	uint64_t head = __atomic_load_n(&w->ring->head, __ATOMIC_RELAXED); /* only tells that the writer goes on */
	uint64_t age = stilb_prof_clock_monotonic() - reader->start;
	reader->seen += head != reader->head;
	reader->head = head;
	return reader->seen < reader->wanted && age < UINT64_C(1000000000) * (reader->seen > 1 ? 1 : 20);
}

static void *write_events(void *data)
{
	writer *w = data;
	writer_begin(w);
	for (uint64_t n = 0; w->error == 0 && writer_goes_on(w); n++) {
		stilb_prof_clock(w->ring); /* slows the writer to the speed of zones; otherwise it would lap every copy */
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
	prof_copy copy = {0};
	assert_int_equal(stilb_prof_ring_events_set(1024), 0);
	writer_start(&thread, write_events, &w);
	for (watch reader = watch_start(2000); watch_goes_on(&reader, &w);)
		broken += prof_copy_take(&copy, NULL) != 0 || !copy_is_whole(&copy);
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_true(copy_is_whole(&copy));
	assert_in_range(copy.events_held, 1, 1023);
	assert_int_equal(record_at(&copy, 0, copy.events_held - 1).begin, copy.events_recorded * STEP);
	prof_copy_free(&copy);
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
			stilb_prof_close(stilb_prof_thread_ring, depth, (n + depth + 2) * STEP);
	}
	stilb_prof_thread_end();
	return NULL;
}

/* True if the open zones are whole, each inside the one before it. */
static bool open_events_are_whole(const stilb_prof_open_zone *zones, uint32_t count)
{
	for (uint32_t depth = 0; depth < count; depth++) {
		uint64_t n = zones[depth].begin / STEP - 1;
		if (n % 3 != depth || zones[depth].site != (n % 2 ? &odd_site : &even_site))
			return false;
		if (depth > 0 && zones[depth - 1].begin + STEP != zones[depth].begin)
			return false;
	}
	return true;
}

/* True if some zone of the copy is both among the open zones and among the events of ended ones. */
static bool zone_is_there_twice(const prof_copy *copy)
{
	const prof_lane_copy *lane = &copy->lanes[0];
	for (uint32_t depth = 0; depth < lane->open_count; depth++)
		for (size_t i = 0; i < lane->event_count; i++)
			if (record_at(copy, 0, i).begin == lane->open[depth].begin)
				return true;
	return false;
}

static void open_zones_are_never_torn(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	uint64_t open = 0, broken = 0, twice = 0;
	prof_copy copy = {0};
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_open_events, &w);
	for (watch reader = watch_start(300000); watch_goes_on(&reader, &w);) {
		stilb_prof_open_zone zones[STILB_PROF_DEPTH_MAX];
		uint32_t count = prof_copy_open(w.ring, zones);
		broken += !open_events_are_whole(zones, count);
		open += count;
	}
	for (watch reader = watch_start(10000); watch_goes_on(&reader, &w);) {
		broken += prof_copy_take(&copy, NULL) != 0;
		twice += zone_is_there_twice(&copy);
	}
	writer_join(thread, &w);
	prof_copy_free(&copy);
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

/* The name's first character is the level; an open zone began no earlier than the one around it. */
static bool zones_are_consistent(const prof_copy *copy)
{
	const prof_lane_copy *lane = &copy->lanes[0];
	for (size_t i = 0; i < lane->event_count; i++) {
		prof_record record = record_at(copy, 0, i);
		if (record.depth != (uint32_t)(record.site->name[0] - '0') || record.end < record.begin)
			return false;
	}
	for (uint32_t depth = 0; depth < lane->open_count; depth++)
		if (depth != (uint32_t)(lane->open[depth].site->name[0] - '0') ||
		    (depth > 0 && lane->open[depth].begin < lane->open[depth - 1].begin))
			return false;
	return true;
}

static void open_zones_are_whole(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	prof_copy copy = {0};
	uint64_t open = 0, broken = 0;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_zones, &w);
	for (watch reader = watch_start(10000); watch_goes_on(&reader, &w);) {
		broken += prof_copy_take(&copy, NULL) != 0 || !zones_are_consistent(&copy);
		open += copy.lanes[0].open_count;
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	assert_true(open > 0);
	prof_copy_free(&copy);
}

/* Recording goes off and on all the time; what is seen stays whole. */
static void sessions_are_never_mixed(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	prof_copy copy = {0};
	uint64_t broken = 0;
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_zones, &w);
	for (watch reader = watch_start(3000); watch_goes_on(&reader, &w);) {
		broken += prof_copy_take(&copy, NULL) != 0;
		for (size_t i = 0; i < copy.lanes[0].event_count; i++)
			broken += record_at(&copy, 0, i).end < record_at(&copy, 0, i).begin;
		stilb_prof_record_set(false);
		stilb_prof_record_set(true);
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	prof_copy_free(&copy);
}

/* Windows are found by looking at events here and there while they are overwritten. */
static void windows_of_a_busy_thread(void **state)
{
	(void)state;
	pthread_t thread;
	writer w = {0};
	prof_copy copy = {0};
	uint64_t broken = 0;
	stilb_prof_window window = {.last_frames = 1};
	assert_int_equal(stilb_prof_ring_events_set(64), 0);
	writer_start(&thread, write_zones, &w);
	for (watch reader = watch_start(2000); watch_goes_on(&reader, &w);) {
		stilb_prof_frame_mark();
		broken += prof_copy_take(&copy, &window) != 0 || !zones_are_consistent(&copy);
		for (size_t i = 0; i < copy.lanes[0].event_count; i++)
			broken += record_at(&copy, 0, i).end < copy.begin.ticks;
	}
	writer_join(thread, &w);
	assert_int_equal(broken, 0);
	prof_copy_free(&copy);
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
	prof_copy copy = {0};
	uint64_t broken = 0;
	writer_start(&thread, write_frames, &w);
	for (int i = 0; i < 1000; i++) {
		broken += prof_copy_take(&copy, NULL) != 0;
		for (uint32_t k = 1; k < copy.frame_count; k++)
			broken += copy.frames[k].ticks < copy.frames[k - 1].ticks || copy.frames[k].ns < copy.frames[k - 1].ns;
	}
	writer_join(thread, &w);
	prof_copy_free(&copy);
	assert_int_equal(broken, 0);
}

/* A function that copies call with their lock held is wrapped here, so that a test can hold a copy at that point. */
static uint32_t copy_held, copy_waits;

uint32_t __real_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);
uint32_t __wrap_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);

uint32_t __wrap_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events)
{
	if (__atomic_exchange_n(&copy_held, 0, __ATOMIC_ACQ_REL) != 0) { /* only the first; pairs with the test's stores */
		__atomic_store_n(&copy_waits, 1, __ATOMIC_RELEASE);
		while (__atomic_load_n(&copy_waits, __ATOMIC_ACQUIRE) != 0)
			sched_yield();
	}
	return __real_prof_switches_copy(switches, since_ns, events);
}

static void *take_a_copy(void *data)
{
	prof_copy copy = {0};
	*(int *)data = prof_copy_take(&copy, NULL);
	prof_copy_free(&copy);
	return NULL;
}

/* A snapshot that is taken each frame does not wait for a capture that copies full rings. */
static void copies_do_not_wait_for_each_other(void **state)
{
	(void)state;
	pthread_t thread;
	stilb_prof_lane_handle *lane;
	prof_copy copy = {0};
	int error = -1;
	assert_int_equal(stilb_prof_lane_create("GPU", &lane), 0);
	__atomic_store_n(&copy_held, 1, __ATOMIC_RELEASE); /* pairs with the exchange above */
	assert_int_equal(pthread_create(&thread, NULL, take_a_copy, &error), 0);
	while (__atomic_load_n(&copy_waits, __ATOMIC_ACQUIRE) == 0) /* pairs with the store above */
		sched_yield();
	assert_int_equal(prof_copy_take(&copy, NULL), 0); /* would hang here if it waited for the other copy */
	stilb_prof_record_set(false);                     /* so would this */
	stilb_prof_record_set(true);
	__atomic_store_n(&copy_waits, 0, __ATOMIC_RELEASE); /* pairs with the load above */
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_int_equal(error, 0);
	prof_copy_free(&copy);
}

/* ---- threads that come and go ------------------------------------------------------------------------------------ */

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
	prof_copy copy = {0};
	run_workers(1000, 8);
	assert_int_equal(prof_ring_count(&ended), 8);
	assert_int_equal(ended, 8);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.events_recorded, 1000);
	assert_int_equal(copy.events_held, 1000);
	assert_int_equal(copy.lane_count, 8);
	for (uint32_t i = 0; i < 8; i++)
		assert_int_equal(record_count(&copy, i, "work"), 125);
	prof_copy_free(&copy);
}

static void threads_of_new_names_are_bounded(void **state)
{
	(void)state;
	uint32_t ended, last = 0;
	prof_copy copy = {0};
	run_workers(1000, 1000);
	assert_in_range(prof_ring_count(&ended), PROF_ENDED_MAX, PROF_ENDED_MAX + 4);
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.events_recorded, 1000);
	assert_int_equal(copy.events_held, copy.lane_count); /* one each: the others are accounted for as lost */
	for (uint32_t i = 0; i < copy.lane_count; i++) {
		assert_string_not_equal(copy.lanes[i].name, "worker 0");
		last += strcmp(copy.lanes[i].name, "worker 999") == 0;
	}
	assert_int_equal(last, 1); /* the events of the threads that ended last are still there */
	prof_copy_free(&copy);
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
	assert_ptr_not_equal(stilb_prof_thread_ring, ring);
	assert_int_equal(mincore(ring, 1, &resident), -1);
	assert_int_equal(errno, ENOMEM);
	assert_int_equal(prof_ring_count(&ended), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0); /* a thread may begin again after its end */
	{
		PROFILE("zone");
	}
	assert_records("zone");
}

/* Lanes whose names end in numbers are in the order of these. Made as lanes of devices, which need no threads. */
static void lanes_stand_by_their_numbers(void **state)
{
	(void)state;
	static const char *const begun[] = {"main",     "worker 10", "worker 2",  "GPU",
	                                    "worker 1", "worker",    "worker 02", "worker 3"};
	static const char *const expected[] = {"main",      "worker 1",  "worker 2", "worker 3",
	                                       "worker 02", "worker 10", "GPU",      "worker"};
	uint32_t count = sizeof begun / sizeof *begun;
	prof_copy copy = {0};
	for (uint32_t i = 0; i < count; i++) {
		stilb_prof_lane_handle *lane;
		assert_int_equal(stilb_prof_lane_create(begun[i], &lane), 0);
	}
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.lane_count, count);
	for (uint32_t i = 0; i < count; i++)
		assert_string_equal(copy.lanes[i].name, expected[i]);
	prof_copy_free(&copy);
}

#define RING_TEST(f) cmocka_unit_test_teardown(f, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		RING_TEST(wrap_keeps_the_newest),
		RING_TEST(ring_sizes),
		RING_TEST(large_rings_cost_what_is_used),
		RING_TEST(windows_hold_what_overlaps_them),
		RING_TEST(windows_end_where_memory_does),
		RING_TEST(windows_of_devices),
		RING_TEST(copies_are_never_torn),
		RING_TEST(open_zones_are_never_torn),
		RING_TEST(open_zones_are_whole),
		RING_TEST(sessions_are_never_mixed),
		RING_TEST(windows_of_a_busy_thread),
		RING_TEST(frames_are_never_torn),
		RING_TEST(copies_do_not_wait_for_each_other),
		RING_TEST(threads_of_the_same_names_share_rings),
		RING_TEST(threads_of_new_names_are_bounded),
		RING_TEST(living_threads_do_not_share),
		RING_TEST(lanes_stand_by_their_numbers),
		RING_TEST(shutdown_unmaps_the_rings),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
