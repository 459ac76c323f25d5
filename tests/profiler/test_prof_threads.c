/* Threads that record without having called stilb_prof_thread_begin: rings made at the first event, names, ends, no
 * memory, allocators with zones. */
#include "test_prof_records.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

/* All are set while no other thread runs. */
static bool refuse_rings;      /* mmap gives no memory for rings */
static bool profile_allocator; /* realloc records a zone */
static uint32_t asked;         /* number of calls of mmap */

static int shut_down(void **state)
{
	(void)state;
	refuse_rings = profile_allocator = false;
	stilb_prof_record_set(true);
	stilb_prof_switches_set(false);
	stilb_prof_shutdown();
	return 0;
}

/* ---- memory that is refused, and an allocator with zones --------------------------------------------------------- */

void *__real_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);
void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_mmap(void *address, size_t size, int protection, int flags, int file, off_t offset)
{
	asked++;
	if (!refuse_rings)
		return __real_mmap(address, size, protection, flags, file, offset);
	errno = ENOMEM;
	return MAP_FAILED;
}

void *__wrap_realloc(void *memory, size_t size)
{
	if (!profile_allocator)
		return __real_realloc(memory, size);
	PROFILE("allocate");
	return __real_realloc(memory, size);
}

/* ---- the lanes as text ------------------------------------------------------------------------------------------- */

/* Writes all lanes as text: "name: events|open zones; name: ...". */
static void lanes_text(char *text, size_t size)
{
	prof_copy copy = {0};
	size_t used = 0;
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	text[0] = 0;
	for (uint32_t i = 0; i < copy.lane_count; i++) {
		char names[512];
		record_names(&copy, i, names, sizeof names);
		used += (size_t)snprintf(text + used, size - used, "%s%s: %s", i > 0 ? "; " : "", copy.lanes[i].name, names);
		assert_true(used < size);
	}
	prof_copy_free(&copy);
}

#define assert_lanes(expected)                                                                                         \
	do {                                                                                                               \
		char lanes_[1024];                                                                                             \
		lanes_text(lanes_, sizeof lanes_);                                                                             \
		assert_string_equal(lanes_, expected);                                                                         \
	} while (0)

static uint64_t without_ring(void)
{
	prof_copy copy = {0};
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	uint64_t count = copy.without_ring;
	prof_copy_free(&copy);
	return count;
}

static void run_thread(void *(*run)(void *), void *data)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, run, data), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
}

/* ---- the first event --------------------------------------------------------------------------------------------- */

STILB_PROF_SITE(hook_site, "hook", 0);
STILB_PROF_FLOW(flow_job, "job", 0);

static void *first_zone(void *unused)
{
	PROFILE("outer");
	PROFILE("inner");
	return unused;
}

static void *first_hook(void *unused)
{
	stilb_prof_zone_begin(&hook_site);
	stilb_prof_zone_end();
	return unused;
}

static void *first_counter(void *unused)
{
	PROFILE_COUNTER("counter", 1);
	return unused;
}

static void *first_instant(void *unused)
{
	PROFILE_INSTANT("instant");
	return unused;
}

static void *first_flow(void *unused)
{
	stilb_prof_flow_end(flow_job, stilb_prof_flow_begin(flow_job));
	return unused;
}

/* Threads that run one after another get the same name ("thread 1") and go on in the ring of the one before. */
static void the_first_event_makes_a_ring(void **state)
{
	(void)state;
	run_thread(first_zone, NULL);
	assert_lanes("thread 1: inner outer");
	run_thread(first_hook, NULL);
	run_thread(first_counter, NULL);
	run_thread(first_instant, NULL);
	run_thread(first_flow, NULL);
	assert_lanes("thread 1: inner outer hook counter instant job job");
}

static void the_main_thread_is_main(void **state)
{
	(void)state;
	first_zone(NULL);
	assert_lanes("main: inner outer");
}

static void while_off_no_ring_is_made(void **state)
{
	(void)state;
	uint32_t ended;
	stilb_prof_record_set(false);
	run_thread(first_zone, NULL);
	assert_int_equal(prof_ring_count(&ended), 0);
	assert_int_equal(without_ring(), 0);
}

static void a_thread_that_has_ended_may_begin_again(void **state)
{
	(void)state;
	first_zone(NULL);
	stilb_prof_thread_end();
	first_hook(NULL);
	assert_lanes("main: inner outer hook");
}

static void *keep_errno(void *kept)
{
	errno = EXDEV;
	first_zone(NULL);
	*(bool *)kept = errno == EXDEV;
	return NULL;
}

/* A zone leaves errno as it is: it may stand between a call that fails and the program's look at errno. */
static void errno_is_kept(void **state)
{
	(void)state;
	bool kept[2] = {false};
	stilb_prof_switches_set(true); /* on most machines perf_event_open then fails and sets errno */
	run_thread(keep_errno, &kept[0]);
	stilb_prof_switches_set(false);
	refuse_rings = true;
	stilb_prof_shutdown();
	run_thread(keep_errno, &kept[1]);
	refuse_rings = false;
	assert_true(kept[0] && kept[1]);
}

static void *last_page(void *resident)
{
	first_zone(NULL);
	char *last = (char *)&stilb_prof_thread_ring->events[stilb_prof_thread_ring->mask];
	*(int *)resident = mincore((void *)((uintptr_t)last & ~(uintptr_t)4095), 1, resident);
	return NULL;
}

/* A program may have a thousand threads that record little. */
static void such_a_ring_takes_memory_as_it_fills(void **state)
{
	(void)state;
	int resident = 1;
	run_thread(last_page, &resident);
	assert_int_equal(resident, 0);
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

typedef struct meeting {
	pthread_barrier_t all_have_begun, all_were_seen;
} meeting;

static void *meet(void *data)
{
	meeting *m = data;
	first_hook(NULL);
	pthread_barrier_wait(&m->all_have_begun);
	pthread_barrier_wait(&m->all_were_seen);
	return NULL;
}

static void *meet_named(void *data)
{
	pthread_setname_np(pthread_self(), "loader");
	return meet(data);
}

/* Threads that live at the same time have lanes of their own; after them the numbers begin again. */
static void names_are_given(void **state)
{
	(void)state;
	pthread_t threads[4];
	meeting m;
	for (int round = 0; round < 2; round++) {
		pthread_barrier_init(&m.all_have_begun, NULL, 5);
		pthread_barrier_init(&m.all_were_seen, NULL, 5);
		for (int i = 0; i < 4; i++)
			assert_int_equal(pthread_create(&threads[i], NULL, i == 2 ? meet_named : meet, &m), 0);
		pthread_barrier_wait(&m.all_have_begun);
		prof_copy copy = {0};
		uint32_t loaders = 0;
		assert_int_equal(prof_copy_take(&copy, NULL), 0);
		assert_int_equal(copy.lane_count, 4);
		for (uint32_t i = 0, number = 1; i < 4; i++) {
			char name[32];
			snprintf(name, sizeof name, "thread %u", number);
			assert_int_equal(record_count(&copy, i, "hook"), round + 1);
			if (strcmp(copy.lanes[i].name, "loader") == 0)
				loaders++;
			else
				assert_string_equal(copy.lanes[i].name, name);
			number += strcmp(copy.lanes[i].name, name) == 0;
		}
		assert_int_equal(loaders, 1);
		prof_copy_free(&copy);
		pthread_barrier_wait(&m.all_were_seen);
		for (int i = 0; i < 4; i++)
			pthread_join(threads[i], NULL);
		pthread_barrier_destroy(&m.all_have_begun);
		pthread_barrier_destroy(&m.all_were_seen);
	}
}

static void *begin_late(void *errors)
{
	int *error = errors;
	first_hook(NULL);
	error[0] = stilb_prof_thread_begin("worker 1");
	first_hook(NULL);
	error[1] = stilb_prof_thread_begin("worker 2");
	return NULL;
}

/* A thread that already records may call stilb_prof_thread_begin: it keeps its ring, and its lane gets the new name and
 * moves to the place of that name. */
static void a_name_may_come_later(void **state)
{
	(void)state;
	int error[2] = {-1, -1};
	stilb_prof_lane_handle *lane;
	assert_int_equal(stilb_prof_lane_create("worker 2", &lane), 0);
	assert_int_equal(stilb_prof_lane_create("GPU", &lane), 0);
	run_thread(begin_late, error);
	assert_int_equal(error[0], 0);
	assert_int_equal(error[1], -EALREADY);
	assert_lanes("worker 1: hook hook; worker 2: ; GPU: ");
}

/* ---- ends -------------------------------------------------------------------------------------------------------- */

static void *begin_and_exit(void *unused)
{
	stilb_prof_thread_begin("forgetful");
	return unused;
}

static void threads_leave_their_rings_when_they_exit(void **state)
{
	(void)state;
	uint32_t ended;
	for (int i = 0; i < 300; i++)
		run_thread(first_hook, NULL);
	run_thread(begin_and_exit, NULL); /* without stilb_prof_thread_end */
	assert_int_equal(prof_ring_count(&ended), 2);
	assert_int_equal(ended, 2);
	prof_copy copy = {0};
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(record_count(&copy, 0, "hook"), 300);
	assert_true(copy.lanes[0].ended_ns >= copy.lanes[0].begun_ns);
	prof_copy_free(&copy);
}

typedef struct survivor {
	sem_t go, done;
	bool exit;
} survivor;

static void *survive(void *data)
{
	survivor *s = data;
	PROFILE("life");
	do {
		{
			PROFILE("step");
		}
		sem_post(&s->done);
		while (sem_wait(&s->go) != 0)
			;
	} while (!s->exit);
	return NULL;
}

static void survivor_step(survivor *s)
{
	sem_post(&s->go);
	while (sem_wait(&s->done) != 0)
		;
}

/* Threads that live on after stilb_prof_shutdown keep their rings, which are empty then. */
static void a_living_thread_survives_a_shutdown(void **state)
{
	(void)state;
	pthread_t thread;
	survivor s = {.exit = false};
	uint32_t ended;
	sem_init(&s.go, 0, 0);
	sem_init(&s.done, 0, 0);
	assert_int_equal(pthread_create(&thread, NULL, survive, &s), 0);
	while (sem_wait(&s.done) != 0)
		;
	survivor_step(&s);
	first_hook(NULL);
	assert_lanes("main: hook; thread 1: step step|life"); /* the main thread's lane is always the first */
	stilb_prof_shutdown();
	assert_lanes("thread 1: |life");
	survivor_step(&s);
	first_hook(NULL);
	assert_lanes("main: hook; thread 1: step|life");
	prof_copy copy = {0};
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(copy.events_recorded, 2);
	assert_int_equal(copy.events_held, 2);
	assert_int_not_equal(copy.lanes[0].index, copy.lanes[1].index); /* so the ids of their flows differ */
	prof_copy_free(&copy);
	s.exit = true;
	sem_post(&s.go);
	pthread_join(thread, NULL);
	assert_lanes("main: hook; thread 1: step life");
	stilb_prof_shutdown();
	assert_int_equal(prof_ring_count(&ended), 0);
	sem_destroy(&s.go);
	sem_destroy(&s.done);
}

/* ---- no memory --------------------------------------------------------------------------------------------------- */

static void record_six_events(void)
{
	PROFILE("outer");
	PROFILE_BEGIN("inner");
	PROFILE_NEXT("nothing to end");
	PROFILE_END();
	PROFILE_COUNTER("counter", 1);
	PROFILE_INSTANT("instant");
	stilb_prof_flow_end(flow_job, stilb_prof_flow_begin(flow_job)); /* begin returns 0, for which end does nothing */
	stilb_prof_zone_begin(&hook_site);
	stilb_prof_zone_end();
}

static void what_is_lost_is_counted(void **state)
{
	(void)state;
	refuse_rings = true;
	asked = 0;
	assert_int_equal(stilb_prof_thread_begin("main"), -ENOMEM);
	assert_int_equal(asked, 1);
	for (int i = 0; i < 100; i++)
		record_six_events();
	assert_int_equal(asked, 2); /* mmap is not tried again at each event */
	assert_int_equal(without_ring(), 600);
	refuse_rings = false;
	for (int i = 0; i < 424; i++)
		first_hook(NULL);
	assert_int_equal(without_ring(), 1024);
	first_hook(NULL); /* tries again */
	assert_lanes("main: hook");
	assert_int_equal(without_ring(), 1024);
	stilb_prof_snapshot snapshot = {0};
	assert_int_equal(stilb_prof_snapshot_take(&snapshot, NULL), 0);
	assert_int_equal(snapshot.without_ring, 1024);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	assert_int_equal(without_ring(), 0);
}

static void *take_a_snapshot(void *error)
{
	prof_copy copy = {0};
	*(int *)error = prof_copy_take(&copy, NULL);
	prof_copy_free(&copy);
	return NULL;
}

/* An allocator with zones, which the profiler calls itself: no deadlock and no second ring. Zones that come while the
 * ring is being made or the lock is held are counted as lost. */
static void an_allocator_may_record(void **state)
{
	(void)state;
	int error = -1;
	profile_allocator = true;
	run_thread(first_hook, NULL);
	profile_allocator = false;
	assert_lanes("thread 1: hook");
	assert_int_equal(without_ring(), 1); /* the zone of the allocation while the ring was made */
	profile_allocator = true;
	run_thread(take_a_snapshot, &error);
	profile_allocator = false;
	assert_int_equal(error, 0);
	assert_lanes("thread 1: hook");
	assert_in_range(without_ring(), 2, 4); /* in the copy, which holds the lock */
}

/* ---- schedstat --------------------------------------------------------------------------------------------------- */

static bool refuse_perf; /* perf_event_open fails, as in a container; set while no other thread runs */

prof_switches __real_prof_switches_open(const char *name);
prof_switches __wrap_prof_switches_open(const char *name);

prof_switches __wrap_prof_switches_open(const char *name)
{
	if (!refuse_perf)
		return __real_prof_switches_open(name);
	return (prof_switches){.refused = "by this test", .schedstat = prof_schedstat_open(name)};
}

static void *mark_frames(void *unused)
{
	stilb_prof_frame_mark();
	stilb_prof_frame_mark();
	return unused;
}

/* The thread that marks frames records the counters of all threads under a lock. Its own ring is made first, because
 * that takes the same lock to open the thread's schedstat. */
static void marking_frames_may_be_the_first_event(void **state)
{
	(void)state;
	uint32_t handle = prof_schedstat_open("watched");
	if (handle == 0)
		skip();
	refuse_perf = true;
	run_thread(mark_frames, NULL);
	refuse_perf = false;
	prof_schedstat_close(handle);
	prof_copy copy = {0};
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	assert_int_equal(record_count(&copy, 0, "watched: ran ms"), 2);
	prof_copy_free(&copy);
}

#define THREAD_TEST(f) cmocka_unit_test_teardown(f, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		THREAD_TEST(the_first_event_makes_a_ring),
		THREAD_TEST(the_main_thread_is_main),
		THREAD_TEST(while_off_no_ring_is_made),
		THREAD_TEST(a_thread_that_has_ended_may_begin_again),
		THREAD_TEST(errno_is_kept),
		THREAD_TEST(such_a_ring_takes_memory_as_it_fills),
		THREAD_TEST(names_are_given),
		THREAD_TEST(a_name_may_come_later),
		THREAD_TEST(threads_leave_their_rings_when_they_exit),
		THREAD_TEST(a_living_thread_survives_a_shutdown),
		THREAD_TEST(what_is_lost_is_counted),
		THREAD_TEST(an_allocator_may_record),
		THREAD_TEST(marking_frames_may_be_the_first_event),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
