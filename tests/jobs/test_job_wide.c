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

enum { ASLEEP = 2, TOKEN = 1 }; /* job_parker.state, see job_park.c */

/* ---- made-up workers ------------------------------------------------------------------------------------------- */

static _Atomic bool made_up; /* no thread is started for a worker */
/* Wake-ups of parkers by the calling thread, and by all. */
static _Thread_local uint32_t wakes_here;
static counter wakes, most_wakes;
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
	uint32_t most = count_of(&most_wakes);
	while (wakes_here > most && !atomic_compare_exchange_weak_explicit(&most_wakes, &most, wakes_here,
	                                                                   memory_order_acq_rel, memory_order_acquire))
		;
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

/* A pool on a machine with a CPU for each of its threads. */
static stilb_job_pool *wide_pool(uint32_t workers)
{
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE};
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static void set_cpus(stilb_job_pool *pool)
{
	pool->cpus = pool->worker_count + 1;
	pool->oversubscribed = false;
	watched_pool = pool;
	atomic_store_explicit(&wakes, 0, memory_order_release);
	atomic_store_explicit(&most_wakes, 0, memory_order_release);
	wakes_here = 0;
}

static stilb_job_pool *made_up_pool(uint32_t workers)
{
	made_up = true;
	stilb_job_pool *pool = wide_pool(workers);
	for (uint32_t i = 0; i <= workers; i++)
		job_slot_set_mine(&pool->slot[i]);
	set_cpus(pool);
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
		if (atomic_load_explicit(&slot->parker.state, memory_order_relaxed) != TOKEN)
			continue;
		assert_int_equal(job_idle_leave(&pool->idle, &slot->parker), JOB_IDLE_CHOSEN);
		slot->spinning = true;
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

static void test_spinners_are_limited(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_up_pool(15);
	sleep_all(pool);
	job_idle_wake_spinners(&pool->idle, 15, 2);
	assert_int_equal(count_of(&wakes), 2);
	job_idle_wake_spinners(&pool->idle, 3, 2); /* there is room for one more */
	assert_int_equal(count_of(&wakes), 3);
	while (next_woken(pool))
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

static void nothing(void *data, uint32_t worker)
{
	(void)data, (void)worker;
}

static void submit_nothing(void *data, uint32_t worker)
{
	assert_int_equal(stilb_job_submit(data, nothing, NULL, NULL, worker), 0);
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

/* Each look visits the team of the thread, then all threads. In time it begins at each of them. */
static void test_looks_begin_anywhere_and_miss_nobody(void **state)
{
	enum { THREADS = 32, ROUNDS = 1000 };
	(void)state;
	stilb_job_pool *pool = made_up_pool(THREADS - 1);
	uint32_t first_of_team[THREADS] = {0}, first_of_all[THREADS] = {0}, same = 0;
	for (uint32_t i = 0; i < THREADS; i++)
		job_active_begin(&pool->slot[i], JOB_ACTIVE_JOBS);
	for (uint32_t round = 0; round < ROUNDS; round++) {
		round_trip trip = {0}, other = {0};
		job_visit_threads(&pool->slot[10], JOB_ACTIVE_JOBS, 0, note_visit, &trip);
		job_visit_threads(&pool->slot[11], JOB_ACTIVE_JOBS, 0, note_visit, &other);
		assert_int_equal(trip.visits, 8 + THREADS);
		for (uint32_t i = 0; i < THREADS; i++)
			assert_int_equal(trip.seen[i], 1 + (i >= 8 && i < 16));
		for (uint32_t i = 0; i < 8; i++)
			assert_in_range(trip.order[i], 8, 15);
		first_of_team[trip.order[0]]++;
		first_of_all[trip.order[8]]++;
		same += trip.order[0] == other.order[0] && trip.order[8] == other.order[8];
	}
	for (uint32_t i = 0; i < THREADS; i++) {
		assert_true(first_of_all[i] > ROUNDS / THREADS / 2);
		assert_true((first_of_team[i] > ROUNDS / 8 / 2) == (i >= 8 && i < 16));
	}
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
		assert_int_equal(pool->slot[i].team_begin, first[0]);
		assert_int_equal(pool->slot[i].team_end, first[1]);
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
	check_teams(one, 8, (const uint32_t[]){0, 8});
	check_teams(one, 20, (const uint32_t[]){0, 8, 16, 20});
	check_teams(fours, 8, (const uint32_t[]){0, 8});
	check_teams(fours, 20, (const uint32_t[]){0, 4, 8, 12, 16, 20});
	check_teams(sixes, 20, (const uint32_t[]){0, 6, 12, 18, 20});
	check_teams(alone, 20, (const uint32_t[]){0, 4, 8, 12, 16, 20});
}

/* ---- real threads ---------------------------------------------------------------------------------------------- */

/* The owner wakes one worker for a phase, each of them two at most, and in the end all are awake. */
static void test_phase_wakes_all(void **state)
{
	(void)state;
	enum { WORKERS = 15 };
	stilb_job_pool *pool = wide_pool(WORKERS);
	for (uint32_t i = 1; i <= WORKERS; i++)
		while (atomic_load_explicit(&pool->slot[i].parker.state, memory_order_relaxed) != ASLEEP ||
		       atomic_load_explicit(&pool->watched, memory_order_acquire) != 0)
			nap_us(500);
	set_cpus(pool);
	stilb_job_phase_begin(pool);
	assert_int_equal(wakes_here, 1);
	assert_true(await(&wakes, WORKERS));
	stilb_job_phase_end(pool);
	assert_true(count_of(&most_wakes) <= JOB_WAKE_FAN);
	stilb_job_pool_destroy(pool);
	watched_pool = NULL;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_loop_wakes_as_many_as_it_has_slices_for),
		cmocka_unit_test(test_owner_wakes_one_and_helpers_two),
		cmocka_unit_test(test_spinners_are_limited),
		cmocka_unit_test(test_only_threads_with_work_are_looked_at),
		cmocka_unit_test(test_only_threads_with_loops_are_helped),
		cmocka_unit_test(test_looks_begin_anywhere_and_miss_nobody),
		cmocka_unit_test(test_teams_share_a_cache),
		cmocka_unit_test(test_phase_wakes_all),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
