/*
 * What a pool of many threads does, counted on one thread: the workers are made up, and the test plays them one after
 * the other. So the numbers are exact, whatever the machine.
 */
#include <linux/futex.h>
#include <pthread.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/syscall.h>

#include "jobs/job_internal.h"

#include "job_pool_fixture.h"
#include "support/test.h"

enum { ASLEEP = 2, CHOSEN = 3 }; /* job_parker.state, see job_park.c */

/* ---- made-up workers ------------------------------------------------------------------------------------------- */

static _Atomic bool made_up; /* no thread is started for a worker */
/* Wake-ups of parkers by the calling thread, and by all. */
static _Thread_local uint32_t wakes_here;
static counter wakes;
static stilb_job_pool *watched_pool; /* the one whose parkers count */

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data)
{
	return made_up ? 0 : __real_pthread_create(thread, attributes, fn, data);
}

int __real_pthread_join(pthread_t thread, void **result);
int __wrap_pthread_join(pthread_t thread, void **result);
int __wrap_pthread_join(pthread_t thread, void **result)
{
	return made_up ? 0 : __real_pthread_join(thread, result);
}

static bool is_parker(const void *word)
{
	for (uint32_t i = 0; watched_pool && i <= watched_pool->worker_count; i++)
		if (word == &watched_pool->slot[i].parker.state)
			return true;
	return false;
}

static void count_wake(void)
{
	count_up(&wakes);
	wakes_here++;
}

long __real_syscall(long number, ...);
long __wrap_syscall(long number, ...);
long __wrap_syscall(long number, ...)
{
	va_list list;
	long argument[6];
	va_start(list, number);
	for (int i = 0; i < 6; i++)
		argument[i] = va_arg(list, long); /* those that the caller did not pass are not read by the kernel either */
	va_end(list);
	if (number == SYS_futex && argument[1] == FUTEX_WAKE_PRIVATE && is_parker((void *)argument[0]))
		count_wake();
	return __real_syscall(number, argument[0], argument[1], argument[2], argument[3], argument[4], argument[5]);
}

uint32_t __wrap_stilb_job_cpu_count(void);
uint32_t __wrap_stilb_job_cpu_count(void)
{
	return STILB_JOB_MAX_WORKERS + 1; /* so that no pool has more threads than CPUs */
}

static stilb_job_pool *wide_pool(uint32_t workers)
{
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE};
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static void count_wakes(stilb_job_pool *pool)
{
	watched_pool = pool;
	atomic_store_explicit(&wakes, 0, memory_order_release);
	wakes_here = 0;
}

static stilb_job_pool *made_up_pool(uint32_t workers)
{
	made_up = true;
	stilb_job_pool *pool = wide_pool(workers);
	for (uint32_t i = 0; i <= workers; i++)
		job_slot_set_mine(&pool->slot[i]);
	count_wakes(pool);
	return pool;
}

static void made_up_destroy(stilb_job_pool *pool)
{
	watched_pool = NULL;
	stilb_job_pool_destroy(pool);
	made_up = false;
}

static void sleep_all(stilb_job_pool *pool)
{
	for (uint32_t i = 1; i <= pool->worker_count; i++) {
		job_slot *slot = &pool->slot[i];
		job_idle_enter(&pool->idle, &(job_idler){.parker = &slot->parker, .scope = job_scope_all, .worker = true},
		               false);
		atomic_store_explicit(&slot->parker.state, ASLEEP, memory_order_relaxed);
	}
}

/* The next worker that has been woken, which is now awake; NULL if there is none. */
static job_slot *next_woken(stilb_job_pool *pool)
{
	for (uint32_t i = 1; i <= pool->worker_count; i++) {
		job_slot *slot = &pool->slot[i];
		if (atomic_load_explicit(&slot->parker.state, memory_order_relaxed) != CHOSEN)
			continue;
		assert_int_equal(job_idle_leave(&pool->idle, &slot->parker), JOB_IDLE_CHOSEN);
		slot->spinning = true;
		slot->look_far = true; /* as in job_work_park */
		return slot;
	}
	return NULL;
}

/* Takes the workers that still sleep off the list. */
static void rise_all(stilb_job_pool *pool)
{
	for (uint32_t i = 1; i <= pool->worker_count; i++) {
		job_slot *slot = &pool->slot[i];
		if (atomic_load_explicit(&slot->parker.state, memory_order_relaxed) == ASLEEP)
			job_idle_leave(&pool->idle, &slot->parker);
		job_work_spin_stop(slot);
	}
}

/* ---- waking ---------------------------------------------------------------------------------------------------- */

/* A loop whose helpers come while slices run: each slice first plays the workers that have been woken. */
typedef struct wake_tree {
	stilb_job_pool *pool;
	uint32_t ran[64];  /* how often each index ran */
	uint32_t sent[16]; /* wake-ups sent until the first slices of the owner, or of the n-th helper, ran */
	uint32_t threads;  /* the owner and the helpers that have come */
} wake_tree;

static void play_woken(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	wake_tree *tree = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		tree->ran[i]++;
	for (job_slot *slot; (slot = next_woken(tree->pool));) {
		tree->sent[tree->threads++] = count_of(&wakes);
		job_loop_help(slot, &job_scope_all, NULL);
	}
}

/* Runs a loop of so many slices, of which nobody knows how long they take, while 15 workers sleep. */
static wake_tree run_tree(uint32_t slices)
{
	stilb_job_pool *pool = made_up_pool(15);
	wake_tree tree = {.pool = pool};
	sleep_all(pool);
	stilb_job_parallel_for(pool, slices, 1, play_woken, &tree, 0);
	for (uint32_t i = 0; i < slices; i++)
		assert_int_equal(tree.ran[i], 1);
	rise_all(pool);
	made_up_destroy(pool);
	return tree;
}

static void test_loop_wakes_as_many_as_it_has_slices_for(void **state)
{
	static const struct {
		uint32_t slices, wakes;
	} loops[] = {{1, 0}, {2, 1}, {3, 2}, {4, 3}, {64, 15}};
	(void)state;
	for (size_t i = 0; i < sizeof loops / sizeof loops[0]; i++) {
		run_tree(loops[i].slices);
		assert_int_equal(count_of(&wakes), loops[i].wakes);
	}
}

static void test_owner_wakes_one_and_helpers_two(void **state)
{
	(void)state;
	wake_tree tree = run_tree(64);
	for (uint32_t i = 0; i < 7; i++) /* after which 15 threads are awake */
		assert_int_equal(tree.sent[i], 1 + 2 * i);
	assert_int_equal(tree.sent[8], 15);
}

static void nothing(void *data, uint32_t worker)
{
	(void)data, (void)worker;
}

static void submit_nothing(void *data, uint32_t worker)
{
	assert_int_equal(stilb_job_submit(data, nothing, NULL, NULL, worker), 0);
}

/* Puts so many jobs into the deque of the owner while 15 workers sleep, and returns how many wake-ups have been sent
 * when the first worker to be woken has stolen one. */
static uint32_t wakes_of_a_steal(uint32_t jobs)
{
	stilb_job_pool *pool = made_up_pool(15);
	sleep_all(pool);
	for (uint32_t i = 0; i < jobs; i++)
		submit_nothing(pool, 0);
	assert_int_equal(count_of(&wakes), 1);
	job_work_help(next_woken(pool), &job_scope_all, NULL);
	uint32_t sent = count_of(&wakes);
	rise_all(pool);
	made_up_destroy(pool);
	return sent;
}

static void test_thieves_wake_two(void **state)
{
	(void)state;
	assert_int_equal(wakes_of_a_steal(1), 1);
	assert_int_equal(wakes_of_a_steal(2), 2);
	assert_int_equal(wakes_of_a_steal(4), 2);
	assert_int_equal(wakes_of_a_steal(5), 3); /* four are left, two for each */
	assert_int_equal(wakes_of_a_steal(64), 3);
}

/* Workers that have been woken, and have not come yet, count as thieves on their way. */
static void test_thieves_are_limited(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_up_pool(15);
	sleep_all(pool);
	for (uint32_t i = 0; i < 64; i++)
		submit_nothing(pool, 0);
	job_slot *first = next_woken(pool);
	job_idle_wake_spinners(&pool->idle, 15, 2);
	job_idle_wake_spinners(&pool->idle, 15, 2); /* the first thief is a spinner, too, until it has stolen */
	assert_int_equal(count_of(&wakes), 5);
	job_work_help(first, &job_scope_all, NULL);
	assert_int_equal(count_of(&wakes), 6);
	rise_all(pool);
	made_up_destroy(pool);
}

static void test_spinners_are_limited(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_up_pool(15);
	sleep_all(pool);
	job_idle_wake_spinners(&pool->idle, 15, 2);
	assert_int_equal(count_of(&wakes), 2);
	job_idle_wake_spinners(&pool->idle, 3, 2); /* there is room for one more */
	assert_int_equal(count_of(&wakes), 3);
	job_lock_take(&pool->idle.lock); /* which woken threads do not need */
	for (uint32_t i = 0; i < 3; i++)
		assert_non_null(next_woken(pool));
	job_lock_give(&pool->idle.lock);
	assert_null(next_woken(pool));
	rise_all(pool);
	made_up_destroy(pool);
}

/* Wakes sent by the first worker of 15 that is woken for a phase. */
static uint32_t wakes_for_a_phase(bool with_loop)
{
	stilb_job_pool *pool = made_up_pool(15);
	sleep_all(pool);
	stilb_job_phase_begin(pool);
	assert_int_equal(count_of(&wakes), 1);
	job_slot *first = next_woken(pool);
	job_active_set(first, JOB_ACTIVE_LOOPS);
	atomic_store_explicit(&first->loop[0].claim, with_loop, memory_order_relaxed);
	job_pool_wake_for_phase(first);
	atomic_store_explicit(&first->loop[0].claim, 0, memory_order_relaxed);
	uint32_t sent = count_of(&wakes) - 1;
	stilb_job_phase_end(pool);
	rise_all(pool);
	made_up_destroy(pool);
	return sent;
}

/* It has nothing else to do but to help with a loop. */
static void test_who_is_woken_for_a_phase_wakes_the_others(void **state)
{
	(void)state;
	assert_int_equal(wakes_for_a_phase(false), 14);
	assert_int_equal(wakes_for_a_phase(true), JOB_WAKE_FAN);
}

static void wait_microsecond(void *data, uint32_t worker)
{
	(void)data, (void)worker;
	for (uint64_t start = job_sys_ticks(), time = job_sys_ticks_in(1000); job_sys_ticks() - start < time;)
		;
}

/* A thief of tiny jobs stays away longer each time while its victim works at them, but not after a larger job. */
static void test_thieves_of_tiny_jobs_stay_away(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_up_pool(1);
	job_slot *thief = &pool->slot[1];
	job_pool_pause_stealing(thief); /* nothing is there to stay away from */
	assert_int_equal(thief->steal_doublings, 0);
	assert_int_equal(stilb_job_submit(pool, wait_microsecond, NULL, NULL, 0), 0);
	for (uint32_t i = 0; i < JOB_STEAL_DOUBLINGS + 3; i++) {
		uint32_t doublings = i < JOB_STEAL_DOUBLINGS ? i : JOB_STEAL_DOUBLINGS;
		assert_int_equal(thief->steal_doublings, doublings);
		submit_nothing(pool, 0);
		uint64_t start = job_sys_ticks();
		job_pool_pause_stealing(thief);
		assert_true(job_sys_ticks() - start >= job_sys_ticks_in(JOB_STEAL_PAUSE_NS) << doublings);
	}
	job_pool_pause_stealing(thief); /* the owner has done nothing meanwhile */
	assert_int_equal(thief->steal_doublings, 0);
	submit_nothing(pool, 0);
	job_pool_pause_stealing(thief);
	assert_int_equal(thief->steal_doublings, 1);
	assert_true(job_work_help(thief, &job_scope_all, NULL)); /* the oldest job takes a microsecond */
	assert_int_equal(thief->steal_doublings, 0);
	while (job_work_help(&pool->slot[0], &job_scope_all, NULL))
		;
	rise_all(pool);
	made_up_destroy(pool);
}

/* ---- looking for work ------------------------------------------------------------------------------------------ */

static bool is_active(stilb_job_pool *pool, job_active_kind kind, uint32_t thread)
{
	return job_active_from(pool, kind, thread) == thread;
}

static uint32_t count_active(stilb_job_pool *pool, job_active_kind kind)
{
	uint32_t count = 0;
	for (uint32_t i = job_active_from(pool, kind, 0); i <= pool->worker_count; i = job_active_from(pool, kind, i + 1))
		count++;
	return count;
}

static bool always(job_slot *slot, void *context)
{
	(void)slot, (void)context;
	return true;
}

/* Plays worker i as it goes to sleep, and wakes up at once. */
static void nap(stilb_job_pool *pool, uint32_t i)
{
	assert_int_equal(job_work_park(&pool->slot[i], &job_scope_all, always, NULL), JOB_IDLE_NOT_CHOSEN);
}

static void no_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end, (void)worker, (void)context;
}

static void run_loop(void *data, uint32_t worker)
{
	stilb_job_parallel_for(data, 2, 1, no_slice, NULL, worker);
}

/* For the first and the last thread of each word of bits: it is active from its first job until it sleeps, and the job
 * that it submits is seen by all. */
static void test_only_threads_with_work_are_looked_at(void **state)
{
	static const uint32_t thieves[] = {1, 63, 64, 127, 128, 192, 255, 256};
	(void)state;
	stilb_job_pool *pool = made_up_pool(256);
	assert_int_equal(count_active(pool, JOB_ACTIVE_JOBS), 1);
	assert_int_equal(count_active(pool, JOB_ACTIVE_LOOPS), 0);
	for (size_t i = 0; i < sizeof thieves / sizeof thieves[0]; i++) {
		job_slot *thief = &pool->slot[thieves[i]], *other = &pool->slot[thieves[i] - 1];
		assert_false(is_active(pool, JOB_ACTIVE_JOBS, thief->index));
		submit_nothing(pool, 0);
		assert_true(job_work_help(thief, &job_scope_all, NULL));
		assert_true(is_active(pool, JOB_ACTIVE_JOBS, thief->index));
		submit_nothing(pool, thief->index);
		assert_true(job_work_exists(other, &job_scope_all));
		assert_true(job_work_help(other, &job_scope_all, NULL));
		assert_false(job_work_exists(other, &job_scope_all));
		nap(pool, thief->index);
		assert_false(is_active(pool, JOB_ACTIVE_JOBS, thief->index));
		if (other->index > 0)
			nap(pool, other->index);
		assert_int_equal(count_active(pool, JOB_ACTIVE_JOBS), 1);
	}
	made_up_destroy(pool);
}

static void test_only_threads_with_loops_are_helped(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_up_pool(100);
	job_slot *worker = &pool->slot[99];
	assert_int_equal(stilb_job_submit(pool, run_loop, pool, NULL, 0), 0);
	assert_false(is_active(pool, JOB_ACTIVE_LOOPS, 99));
	assert_true(job_work_help(worker, &job_scope_all, NULL));
	assert_true(is_active(pool, JOB_ACTIVE_LOOPS, 99));
	assert_int_equal(count_active(pool, JOB_ACTIVE_LOOPS), 1);
	nap(pool, 99);
	assert_int_equal(count_active(pool, JOB_ACTIVE_LOOPS), 0);
	made_up_destroy(pool);
}

typedef struct round_trip {
	uint32_t visits, order[64], seen[32];
} round_trip;

static bool note_visit(job_slot *slot, uint32_t thread, void *context)
{
	round_trip *trip = context;
	(void)slot;
	trip->order[trip->visits++] = thread;
	trip->seen[thread]++;
	return false;
}

/* Each look visits all threads, and in time begins at each of them. */
static void test_looks_begin_anywhere_and_miss_nobody(void **state)
{
	enum { THREADS = 32, ROUNDS = 1000 };
	(void)state;
	stilb_job_pool *pool = made_up_pool(THREADS - 1);
	uint32_t first[THREADS] = {0}, same = 0;
	for (uint32_t i = 0; i < THREADS; i++)
		job_active_begin(&pool->slot[i], JOB_ACTIVE_JOBS);
	for (uint32_t round = 0; round < ROUNDS; round++) {
		round_trip trip = {0}, other = {0};
		job_visit_active(&pool->slot[10], JOB_ACTIVE_JOBS, 8, THREADS, note_visit, &trip);
		job_visit_active(&pool->slot[11], JOB_ACTIVE_JOBS, 8, THREADS, note_visit, &other);
		assert_int_equal(trip.visits, THREADS - 8);
		for (uint32_t i = 0; i < THREADS; i++)
			assert_int_equal(trip.seen[i], i >= 8);
		first[trip.order[0]]++;
		same += trip.order[0] == other.order[0];
	}
	for (uint32_t i = 8; i < THREADS; i++)
		assert_true(first[i] > ROUNDS / THREADS / 2);
	assert_true(same < ROUNDS / 8); /* two threads begin at different places */
	made_up_destroy(pool);
}

/* ---- teams ----------------------------------------------------------------------------------------------------- */

/* The last level of cache of each CPU of a made-up machine, where CPUs have the numbers of threads. NULL: none is. */
static const uint32_t *made_up_caches;

void __real_job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache);
void __wrap_job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache);
void __wrap_job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache)
{
	if (!made_up_caches)
		__real_job_cpu_sort(cpus, count, cpu_dirs, cache);
	else
		memcpy(cache, made_up_caches, count * sizeof *cache);
}

uint32_t __real_job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max);
uint32_t __wrap_job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max);
uint32_t __wrap_job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max)
{
	if (!made_up_caches)
		return __real_job_cpu_others(list, here, cpus, max);
	for (uint32_t i = 0; i < max; i++)
		cpus[i] = here + 1 + i;
	return max;
}

/* Checks where the teams of a pool with so many threads begin; first[] ends with the number of threads. */
static void check_teams(const uint32_t *caches, uint32_t threads, const uint32_t *first)
{
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = {.worker_count = threads - 1, .affinity = STILB_JOB_AFFINITY_AUTO};
	made_up = true;
	made_up_caches = caches;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	for (uint32_t i = 0; i < threads; i++) {
		first += i == first[1];
		assert_int_equal(pool->slot[i].team->begin, first[0]);
		assert_int_equal(pool->slot[i].team->end, first[1]);
	}
	made_up_caches = NULL;
	job_slot_set_mine(&pool->slot[0]);
	made_up_destroy(pool);
}

static void test_teams_share_a_cache(void **state)
{
	(void)state;
	static const uint32_t one[20], fours[20] = {0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 1, 1, 1, 1, 2, 2, 2, 2},
								   sixes[20] = {0, 0, 0, 0, 0, 0, 6, 6, 6, 6, 6, 6, 9, 9, 9, 9, 9, 9, 7, 7};
	uint32_t alone[20];
	for (uint32_t i = 0; i < 20; i++)
		alone[i] = i;
	check_teams(one, 20, (const uint32_t[]){0, 8, 16, 20});
	check_teams(fours, 20, (const uint32_t[]){0, 4, 8, 12, 16, 20});
	check_teams(sixes, 20, (const uint32_t[]){0, 6, 12, 18, 20});
	check_teams(alone, 20, (const uint32_t[]){0, 4, 8, 12, 16, 20});
}

/* ---- wide loops ------------------------------------------------------------------------------------------------ */

/* A loop on a pool of two teams of eight, in whose first slice the test plays the other threads. */
typedef struct far_loop {
	stilb_job_pool *pool;
	uint32_t slices, first_of[16]; /* the first slice that each thread ran; UINT32_MAX: none */
	uint32_t looks;                /* by thread 8 until it had helped */
	bool played, drained;          /* drained: the other team's slices are done before thread 8 comes */
} far_loop;

static void play_far(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	far_loop *loop = context;
	(void)end;
	if (loop->first_of[worker] == UINT32_MAX)
		loop->first_of[worker] = begin;
	if (loop->played)
		return;
	loop->played = true;
	if (loop->drained) {
		job_loop *part = &loop->pool->team[1].part;
		uint32_t left = (uint32_t)atomic_load_explicit(&part->claim, memory_order_relaxed);
		atomic_fetch_sub_explicit(&part->claim, left, memory_order_relaxed);
		atomic_fetch_add_explicit(&part->done, left, memory_order_relaxed);
		atomic_fetch_add_explicit(&loop->pool->team[0].part.done, 1, memory_order_relaxed); /* gathered there */
	}
	while (!job_loop_help(&loop->pool->slot[8], &job_scope_all, NULL))
		loop->looks++;
}

static far_loop run_far(uint32_t slices, bool drained)
{
	far_loop loop = {.pool = made_up_pool(15), .slices = slices, .drained = drained};
	memset(loop.first_of, 0xff, sizeof loop.first_of);
	stilb_job_parallel_for(loop.pool, slices, 1, play_far, &loop, 0);
	made_up_destroy(loop.pool);
	return loop;
}

static void test_each_team_has_its_part(void **state)
{
	(void)state;
	far_loop loop = run_far(64, false);
	assert_int_equal(loop.looks, 0);
	assert_int_equal(loop.first_of[0], 0);
	assert_int_equal(loop.first_of[8], 32);
}

static void test_teams_help_one_another(void **state)
{
	(void)state;
	far_loop loop = run_far(64, true);
	assert_int_equal(loop.looks, JOB_NEAR_LOOKS - 1);
	assert_in_range(loop.first_of[8], 1, 31);
}

/* Three slices are not enough for two teams: the loop is its own team's, and others find it in their last look of
 * JOB_NEAR_LOOKS. */
static void test_short_loops_stay_in_their_team(void **state)
{
	(void)state;
	far_loop loop = run_far(3, false);
	assert_int_equal(loop.looks, JOB_NEAR_LOOKS - 1);
	assert_int_equal(loop.first_of[0], 0);
	assert_int_equal(loop.first_of[8], 1);
}

enum { COVER_MOST = 300 };

typedef struct cover {
	stilb_job_pool *pool;
	uint32_t count, grain;
	counter ran[COVER_MOST], wrong, helped;
} cover;

static void cover_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	cover *c = context;
	if (begin % c->grain != 0 || end > c->count || end - begin > c->grain || begin >= end)
		count_up(&c->wrong);
	for (uint32_t i = begin; i < end; i++)
		count_up(&c->ran[i]);
	if (worker != 0)
		count_up(&c->helped);
	if (begin % 16 == 0)
		sched_yield(); /* so that others get to their slices */
}

static void cover_run(cover *c, uint32_t worker)
{
	stilb_job_parallel_for(c->pool, c->count, c->grain, cover_slice, c, worker);
	for (uint32_t i = 0; i < COVER_MOST; i++)
		if (atomic_exchange_explicit(&c->ran[i], 0, memory_order_acq_rel) != (i < c->count))
			count_up(&c->wrong);
}

static void cover_nested(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	cover *outer = context, inner = {.pool = outer->pool, .count = 40, .grain = 1};
	for (uint32_t i = begin; i < end; i++)
		cover_run(&inner, worker);
	if (count_of(&inner.wrong) > 0)
		count_up(&outer->wrong);
}

static void *cover_from_outside(void *data)
{
	cover *outer = data, mine = {.pool = outer->pool, .count = 200, .grain = 1};
	for (int i = 0; i < 10; i++)
		cover_run(&mine, STILB_JOB_OUTSIDE);
	if (count_of(&mine.wrong) > 0)
		count_up(&outer->wrong);
	return NULL;
}

static void cover_as_job(void *data, uint32_t worker)
{
	cover *outer = data, mine = {.pool = outer->pool, .count = 100, .grain = 1};
	cover_run(&mine, worker);
	if (count_of(&mine.wrong) > 0)
		count_up(&outer->wrong);
}

/* On a machine of these caches: loops of every number of slices around those at which they become wide; nested loops,
 * loops of several jobs at once and of a thread outside the pool; and loops of a cancelled pool, which run to their
 * end. */
static void check_wide_loops(const uint32_t *caches, uint32_t threads)
{
	static const uint32_t grains[] = {1, 2, 7};
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = {.worker_count = threads - 1, .affinity = STILB_JOB_AFFINITY_AUTO};
	made_up_caches = caches;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	cover c = {.pool = pool, .grain = 1};
	for (uint32_t i = 0; i < sizeof grains / sizeof grains[0]; i++)
		for (c.grain = grains[i], c.count = 1; c.count <= COVER_MOST; c.count += c.count < 40 ? 1 : 37)
			cover_run(&c, 0);
	c.count = COVER_MOST;
	uint64_t start = now_ns();
	while (count_of(&c.helped) == 0 && now_ns() - start < 10000000000u) /* ten seconds guard against a hang */
		cover_run(&c, 0);
	assert_true(count_of(&c.helped) > 0);
	assert_int_equal(count_of(&c.wrong), 0);
	stilb_job_parallel_for(pool, 2 * threads, 1, cover_nested, &c, 0);
	pthread_t outside = outside_start(cover_from_outside, &c);
	stilb_job_group group = {0};
	for (int i = 0; i < 20; i++)
		assert_int_equal(stilb_job_submit(pool, cover_as_job, &c, &group, 0), 0);
	stilb_job_wait(pool, &group, 0);
	pthread_join(outside, NULL);
	stilb_job_pool_cancel(pool);
	c.grain = 1;
	c.count = COVER_MOST;
	cover_run(&c, 0);
	assert_int_equal(count_of(&c.wrong), 0);
	stilb_job_pool_destroy(pool);
	made_up_caches = NULL;
}

static void test_wide_loops_run_each_index_once(void **state)
{
	(void)state;
	static const uint32_t one[20], sixes[20] = {0, 0, 0, 0, 0, 0, 6, 6, 6, 6, 6, 6, 9, 9, 9, 9, 9, 9, 7, 7};
	check_wide_loops(one, 9);
	check_wide_loops(one, 16);
	check_wide_loops(sixes, 20);
}

/* ---- real threads ---------------------------------------------------------------------------------------------- */

/* The owner wakes one worker for a phase, and in the end all are awake. */
static void test_phase_wakes_all(void **state)
{
	(void)state;
	enum { WORKERS = 15 };
	stilb_job_pool *pool = wide_pool(WORKERS);
	for (uint32_t i = 1; i <= WORKERS; i++)
		while (atomic_load_explicit(&pool->slot[i].parker.state, memory_order_relaxed) != ASLEEP ||
		       atomic_load_explicit(&pool->watched, memory_order_acquire) != 0)
			nap_us(500);
	count_wakes(pool);
	stilb_job_phase_begin(pool);
	assert_int_equal(wakes_here, 1);
	assert_true(await(&wakes, WORKERS));
	stilb_job_phase_end(pool);
	stilb_job_pool_destroy(pool);
	watched_pool = NULL;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_loop_wakes_as_many_as_it_has_slices_for),
		cmocka_unit_test(test_owner_wakes_one_and_helpers_two),
		cmocka_unit_test(test_thieves_wake_two),
		cmocka_unit_test(test_thieves_are_limited),
		cmocka_unit_test(test_spinners_are_limited),
		cmocka_unit_test(test_who_is_woken_for_a_phase_wakes_the_others),
		cmocka_unit_test(test_thieves_of_tiny_jobs_stay_away),
		cmocka_unit_test(test_only_threads_with_work_are_looked_at),
		cmocka_unit_test(test_only_threads_with_loops_are_helped),
		cmocka_unit_test(test_looks_begin_anywhere_and_miss_nobody),
		cmocka_unit_test(test_teams_share_a_cache),
		cmocka_unit_test(test_each_team_has_its_part),
		cmocka_unit_test(test_teams_help_one_another),
		cmocka_unit_test(test_short_loops_stay_in_their_team),
		cmocka_unit_test(test_wide_loops_run_each_index_once),
		cmocka_unit_test(test_phase_wakes_all),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
