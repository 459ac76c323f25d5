/* The pool: 0 to far too many workers, jobs in jobs, loops in loops, sleep and wake, failures. */
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "jobs/job.h"
#include "support/test.h"

static const uint32_t worker_counts[] = {0, 1, 2, 8, 64};
enum { WORKER_COUNTS = sizeof worker_counts / sizeof *worker_counts };

/* Counters that jobs write. Relaxed: the group's wait or the join orders them before the test reads. */
typedef _Atomic uint32_t counter;

static void count_up(counter *value)
{
	atomic_fetch_add_explicit(value, 1, memory_order_relaxed);
}

/* ---- failures on demand; linked with -Wl,--wrap=pthread_create,--wrap=malloc,--wrap=aligned_alloc ---------------- */

static uint32_t threads_to_grant = UINT32_MAX;
static bool out_of_memory;

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data)
{
	if (threads_to_grant == 0)
		return EAGAIN;
	if (threads_to_grant != UINT32_MAX)
		threads_to_grant--;
	return __real_pthread_create(thread, attributes, fn, data);
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return out_of_memory ? NULL : __real_malloc(size);
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return out_of_memory ? NULL : __real_aligned_alloc(alignment, size);
}

static stilb_job_pool *pool_with(uint32_t workers, stilb_job_hooks hooks)
{
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	desc.hooks = hooks;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	assert_int_equal(stilb_job_pool_worker_count(pool), workers);
	return pool;
}

/* ---- hooks ---------------------------------------------------------------------------------------------------- */

typedef struct hook_log {
	counter starts, stops, parks, wakes;
	counter misplaced;                          /* calls on another thread than the one named, or not in pairs */
	uint32_t asleep[STILB_JOB_MAX_WORKERS + 1]; /* each written by its own thread only */
} hook_log;

static void check_name(hook_log *log, uint32_t worker)
{
	char name[16] = "", expected[32];
	pthread_getname_np(pthread_self(), name, sizeof name);
	snprintf(expected, sizeof expected, "stilb-worker-%u", worker);
	if (strcmp(name, expected) != 0)
		count_up(&log->misplaced);
}

static void on_start(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->starts);
	check_name(log, worker);
}

static void on_stop(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->stops);
	check_name(log, worker);
}

static void on_park(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->parks);
	if (log->asleep[worker]++ != 0)
		count_up(&log->misplaced);
	if (worker > 0)
		check_name(log, worker);
}

static void on_wake(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->wakes);
	if (--log->asleep[worker] != 0)
		count_up(&log->misplaced);
}

static stilb_job_hooks log_hooks(hook_log *log)
{
	return (stilb_job_hooks){
		.user = log, .thread_start = on_start, .thread_stop = on_stop, .park = on_park, .wake = on_wake};
}

static void test_hooks_come_in_pairs(void **state)
{
	(void)state;
	hook_log log = {0};
	stilb_job_pool *pool = pool_with(8, log_hooks(&log));
	for (int i = 0; i < 1000 && log.parks < 8; i++)
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	assert_true(log.parks >= 8);
	stilb_job_pool_destroy(pool);
	assert_int_equal(log.starts, 8);
	assert_int_equal(log.stops, 8);
	assert_int_equal(log.parks, log.wakes);
	assert_int_equal(log.misplaced, 0);
}

/* ---- jobs ----------------------------------------------------------------------------------------------------- */

typedef struct work {
	stilb_job_pool *pool;
	uint32_t worker_count;
	counter ran;
	counter wrong; /* wrong worker indices, and waits that returned too early */
} work;

static void count_job(void *data, uint32_t worker)
{
	work *w = data;
	if (worker > w->worker_count)
		count_up(&w->wrong);
	count_up(&w->ran);
}

static void test_submit_and_wait(void **state)
{
	(void)state;
	for (int k = 0; k < WORKER_COUNTS; k++) {
		work w = {.pool = pool_with(worker_counts[k], (stilb_job_hooks){0}), .worker_count = worker_counts[k]};
		stilb_job_group group = {0};
		stilb_job_wait(w.pool, &group, 0); /* returns at once */
		for (int i = 0; i < 2000; i++)
			assert_int_equal(stilb_job_submit(w.pool, count_job, &w, &group, 0), 0);
		stilb_job_wait(w.pool, &group, 0);
		assert_int_equal(w.ran, 2000);
		assert_int_equal(w.wrong, 0);
		stilb_job_pool_destroy(w.pool);
	}
}

static void test_group_is_reusable(void **state)
{
	(void)state;
	work w = {.pool = pool_with(2, (stilb_job_hooks){0}), .worker_count = 2};
	stilb_job_group group = {0};
	for (uint32_t i = 1; i <= 10000; i++) {
		assert_int_equal(stilb_job_submit(w.pool, count_job, &w, &group, 0), 0);
		stilb_job_wait(w.pool, &group, 0);
		assert_int_equal(w.ran, i);
		assert_int_equal(group.state, 0);
	}
	stilb_job_pool_destroy(w.pool);
}

/* Submits two children into its own group, down to depth 0. */
typedef struct tree {
	work *work;
	stilb_job_group *group;
	uint32_t depth;
} tree;

static void grow_tree(void *data, uint32_t worker)
{
	tree *t = data;
	count_job(t->work, worker);
	for (int i = 0; i < 2 && t->depth > 0; i++) {
		tree *child = __real_malloc(sizeof *child);
		*child = (tree){t->work, t->group, t->depth - 1};
		if (stilb_job_submit(t->work->pool, grow_tree, child, t->group, worker) != 0)
			count_up(&t->work->wrong);
	}
	free(t);
}

static void test_jobs_submit_jobs(void **state)
{
	(void)state;
	for (int k = 0; k < WORKER_COUNTS; k++) {
		work w = {.pool = pool_with(worker_counts[k], (stilb_job_hooks){0}), .worker_count = worker_counts[k]};
		stilb_job_group group = {0};
		tree *root = __real_malloc(sizeof *root);
		*root = (tree){&w, &group, 10};
		assert_int_equal(stilb_job_submit(w.pool, grow_tree, root, &group, 0), 0);
		stilb_job_wait(w.pool, &group, 0);
		assert_int_equal(w.ran, (1 << 11) - 1);
		assert_int_equal(w.wrong, 0);
		stilb_job_pool_destroy(w.pool);
	}
}

/* Submits ten jobs into a group on its own stack and waits for them. It may be the only thread that runs. */
static void wait_inside(void *data, uint32_t worker)
{
	work *w = data;
	work inner = {.pool = w->pool, .worker_count = w->worker_count};
	stilb_job_group group = {0};
	for (int i = 0; i < 10; i++)
		stilb_job_submit(w->pool, count_job, &inner, &group, worker);
	stilb_job_wait(w->pool, &group, worker);
	if (inner.ran != 10 || inner.wrong)
		count_up(&w->wrong);
	count_up(&w->ran);
}

static void test_jobs_wait_for_jobs(void **state)
{
	(void)state;
	for (int k = 0; k < WORKER_COUNTS; k++) {
		work w = {.pool = pool_with(worker_counts[k], (stilb_job_hooks){0}), .worker_count = worker_counts[k]};
		stilb_job_group group = {0};
		for (int i = 0; i < 200; i++)
			assert_int_equal(stilb_job_submit(w.pool, wait_inside, &w, &group, 0), 0);
		stilb_job_wait(w.pool, &group, 0);
		assert_int_equal(w.ran, 200);
		assert_int_equal(w.wrong, 0);
		stilb_job_pool_destroy(w.pool);
	}
}

typedef struct shared_group {
	work work;
	stilb_job_group slow; /* several jobs wait for this group */
	counter go;
} shared_group;

static void slow_job(void *data, uint32_t worker)
{
	shared_group *s = data;
	(void)worker;
	while (!atomic_load_explicit(&s->go, memory_order_relaxed))
		sched_yield();
	nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	count_up(&s->work.ran);
}

static void wait_for_slow(void *data, uint32_t worker)
{
	shared_group *s = data;
	count_up(&s->go);
	stilb_job_wait(s->work.pool, &s->slow, worker);
	if (atomic_load_explicit(&s->work.ran, memory_order_relaxed) != 1)
		count_up(&s->work.wrong);
}

static void test_several_wait_for_one_group(void **state)
{
	(void)state;
	for (int i = 0; i < 20; i++) {
		shared_group s = {.work = {.pool = pool_with(4, (stilb_job_hooks){0})}};
		stilb_job_group waiters = {0};
		assert_int_equal(stilb_job_submit(s.work.pool, slow_job, &s, &s.slow, 0), 0);
		for (int k = 0; k < 3; k++)
			assert_int_equal(stilb_job_submit(s.work.pool, wait_for_slow, &s, &waiters, 0), 0);
		count_up(&s.go);
		stilb_job_wait(s.work.pool, &waiters, 0);
		stilb_job_wait(s.work.pool, &s.slow, 0);
		assert_int_equal(s.work.ran, 1);
		assert_int_equal(s.work.wrong, 0);
		stilb_job_pool_destroy(s.work.pool);
	}
}

/* ---- loops ---------------------------------------------------------------------------------------------------- */

enum { COUNT_MAX = 5000 };

typedef struct cover {
	stilb_job_pool *pool;
	uint32_t grain, count, worker_count;
	counter runs[COUNT_MAX];
	counter wrong;
} cover;

static void cover_range(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	cover *c = context;
	uint32_t grain = c->grain ? c->grain : 1;
	if (begin >= end || end > c->count || end - begin > grain || begin % grain != 0 || worker > c->worker_count)
		count_up(&c->wrong);
	for (uint32_t i = begin; i < end; i++)
		count_up(&c->runs[i]);
}

static void cover_check(cover *c, uint32_t count, uint32_t grain)
{
	memset(c->runs, 0, sizeof c->runs);
	c->count = count;
	c->grain = grain;
	stilb_job_parallel_for(c->pool, count, grain, cover_range, c, 0);
	uint32_t bad = 0;
	for (uint32_t i = 0; i < COUNT_MAX; i++)
		bad += c->runs[i] != (i < count);
	assert_int_equal(bad, 0);
	assert_int_equal(c->wrong, 0);
}

static void test_loop_covers_every_index_once(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 2, 3, 7, 63, 64, 65, 1000, 4999, 5000};
	static const uint32_t grains[] = {0, 1, 2, 3, 64, 999, 5000, UINT32_MAX};
	static cover c;
	for (int k = 0; k < WORKER_COUNTS; k++) {
		c.worker_count = worker_counts[k];
		c.pool = pool_with(c.worker_count, (stilb_job_hooks){0});
		for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
			for (size_t g = 0; g < sizeof grains / sizeof *grains; g++)
				cover_check(&c, counts[i], grains[g]);
		stilb_job_pool_destroy(c.pool);
	}
}

typedef struct extent {
	_Atomic uint64_t sum;
	counter slices;
} extent;

static void add_range(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	extent *e = context;
	(void)worker;
	atomic_fetch_add_explicit(&e->sum, end - begin, memory_order_relaxed);
	count_up(&e->slices);
}

static void test_loop_over_the_largest_count(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with(2, (stilb_job_hooks){0});
	extent e = {0};
	stilb_job_parallel_for(pool, UINT32_MAX, 1u << 30, add_range, &e, 0);
	assert_int_equal(e.sum, UINT32_MAX);
	assert_int_equal(e.slices, 4);
	stilb_job_pool_destroy(pool);
}

typedef struct nest {
	work work;
	uint32_t *inside;   /* per worker, written by that worker: number of slices on its stack */
	uint32_t counts[3]; /* for each level */
	uint32_t level;
} nest;

static void nest_range(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	nest *outer = context;
	if (++outer->inside[worker] > 3) /* at most one slice of each level on a stack */
		count_up(&outer->work.wrong);
	for (uint32_t i = begin; i < end; i++) {
		if (outer->level == 2) {
			count_job(&outer->work, worker);
			continue;
		}
		nest inner = {.work = {.pool = outer->work.pool, .worker_count = outer->work.worker_count},
		              .inside = outer->inside,
		              .level = outer->level + 1};
		memcpy(inner.counts, outer->counts, sizeof inner.counts);
		stilb_job_parallel_for(inner.work.pool, inner.counts[inner.level], 1, nest_range, &inner, worker);
		uint32_t leaves = inner.level == 2 ? inner.counts[2] : inner.counts[1] * inner.counts[2];
		if (inner.work.ran != leaves || inner.work.wrong)
			count_up(&outer->work.wrong);
		atomic_fetch_add_explicit(&outer->work.ran, inner.work.ran, memory_order_relaxed);
	}
	outer->inside[worker]--;
}

static uint32_t nest_inside[STILB_JOB_MAX_WORKERS + 1];

static void nest_job(void *data, uint32_t worker)
{
	work *w = data;
	nest n = {.work = {.pool = w->pool, .worker_count = w->worker_count}, .inside = nest_inside, .counts = {40, 3, 20}};
	stilb_job_parallel_for(w->pool, 40, 1, nest_range, &n, worker);
	if (n.work.ran != 2400 || n.work.wrong)
		count_up(&w->wrong);
	count_up(&w->ran);
}

static void test_loops_in_loops_in_jobs(void **state)
{
	(void)state;
	for (int k = 0; k < WORKER_COUNTS; k++) {
		work w = {.pool = pool_with(worker_counts[k], (stilb_job_hooks){0}), .worker_count = worker_counts[k]};
		stilb_job_group group = {0};
		for (int i = 0; i < 20; i++)
			assert_int_equal(stilb_job_submit(w.pool, nest_job, &w, &group, 0), 0);
		nest_job(&w, 0);
		stilb_job_wait(w.pool, &group, 0);
		assert_int_equal(w.ran, 21);
		assert_int_equal(w.wrong, 0);
		stilb_job_pool_destroy(w.pool);
	}
}

typedef struct meeting {
	counter inside;
	counter met;
} meeting;

/* Returns when two threads are inside at the same time, or after a minute, which guards against a hang. */
static void meet(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	meeting *m = context;
	(void)begin;
	(void)end;
	(void)worker;
	struct timespec start, now;
	clock_gettime(CLOCK_MONOTONIC, &start);
	count_up(&m->inside);
	do {
		if (m->inside == 2) {
			count_up(&m->met);
			return;
		}
		sched_yield();
		clock_gettime(CLOCK_MONOTONIC, &now);
	} while (now.tv_sec - start.tv_sec < 60);
}

static void test_loop_gets_help(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with(1, (stilb_job_hooks){0});
	for (int i = 0; i < 20; i++) {
		meeting m = {0};
		stilb_job_parallel_for(pool, 2, 1, meet, &m, 0);
		assert_int_equal(m.met, 2);
	}
	stilb_job_pool_destroy(pool);
}

/* A loop that is short, or one whose slices return only when two threads are inside (or after a minute). */
typedef struct changing {
	meeting meeting;
	bool is_long;
} changing;

static void run_changing(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	changing *c = context;
	(void)begin;
	(void)end;
	(void)worker;
	if (!c->is_long)
		return;
	count_up(&c->meeting.inside);
	for (int i = 0; i < 60000 && c->meeting.inside < 2; i++)
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	if (c->meeting.inside >= 2)
		count_up(&c->meeting.met);
}

/* Short loops make the pool expect another short one, so the workers stay asleep for some time. Even if the next loop
 * is long, it must not run on its caller alone. */
static void test_long_loop_after_short_ones_gets_help(void **state)
{
	(void)state;
	static const long asleep_ms[] = {0, 5, 20,
	                                 200}; /* less and more than the time for which a worker watches for loops */
	for (uint32_t workers = 1; workers <= 3; workers += 2)
		for (size_t i = 0; i < sizeof asleep_ms / sizeof asleep_ms[0]; i++) {
			hook_log log = {0};
			stilb_job_pool *pool = pool_with(workers, log_hooks(&log));
			changing c = {.is_long = false};
			for (int k = 0; k < 1000; k++)
				stilb_job_parallel_for(pool, 2, 1, run_changing, &c, 0);
			for (int k = 0; k < 10000 && log.parks - log.wakes < workers; k++)
				nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
			assert_int_equal(log.parks - log.wakes, workers);
			nanosleep(&(struct timespec){.tv_nsec = asleep_ms[i] * 1000000}, NULL);
			c.is_long = true;
			stilb_job_parallel_for(pool, 2, 1, run_changing, &c, 0);
			assert_int_equal(c.meeting.met, 2);
			stilb_job_pool_destroy(pool);
		}
}

/* ---- sleep and wake ------------------------------------------------------------------------------------------- */

/* The owner does not help, so a lost wake-up is a worker that sleeps for ever. */
static void test_parked_workers_wake(void **state)
{
	(void)state;
	for (uint32_t workers = 1; workers <= 4; workers += 3) {
		hook_log log = {0};
		work w = {.pool = pool_with(workers, log_hooks(&log)), .worker_count = workers};
		for (uint32_t i = 1; i <= 25; i++) {
			nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
			for (int k = 0; k < 60000 && log.parks - log.wakes < workers; k++)
				nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
			assert_int_equal(log.parks - log.wakes, workers); /* idle workers sleep, they do not spin */
			assert_int_equal(stilb_job_submit(w.pool, count_job, &w, NULL, 0), 0);
			for (int k = 0; k < 60000 && w.ran < i; k++)
				nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
			assert_int_equal(w.ran, i);
		}
		stilb_job_pool_destroy(w.pool);
		assert_int_equal(log.parks, log.wakes);
		assert_int_equal(log.misplaced, 0);
	}
}

/* The owner sleeps in a wait and is woken twice: by a job that it may run, and by the end of the group. */
typedef struct sleeper {
	work work;
	hook_log log;
	counter started;
	counter helped; /* number of jobs that the owner ran */
	stilb_job_group group;
} sleeper;

static void note_helper(void *data, uint32_t worker)
{
	sleeper *s = data;
	if (worker == 0)
		count_up(&s->helped);
	count_up(&s->work.ran);
}

static void wait_for_owner_to_sleep(void *data, uint32_t worker)
{
	sleeper *s = data;
	(void)worker;
	count_up(&s->started);
	nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
	stilb_job_submit(s->work.pool, note_helper, s, NULL, worker);
	for (int i = 0; i < 60000 && s->work.ran == 0; i++) /* keeps the only worker busy, so that the owner must help */
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
}

static void test_waiting_owner_wakes(void **state)
{
	(void)state;
	for (int i = 0; i < 5; i++) {
		sleeper s = {0};
		s.work.pool = pool_with(1, log_hooks(&s.log));
		assert_int_equal(stilb_job_submit(s.work.pool, wait_for_owner_to_sleep, &s, &s.group, 0), 0);
		while (s.started == 0) /* until the worker has taken it */
			sched_yield();
		stilb_job_wait(s.work.pool, &s.group, 0);
		assert_int_equal(s.helped, 1);
		stilb_job_pool_destroy(s.work.pool);
		assert_int_equal(s.log.parks, s.log.wakes);
		assert_int_equal(s.log.misplaced, 0);
	}
}

/* ---- creation and destruction --------------------------------------------------------------------------------- */

static void test_destroy_runs_what_is_queued(void **state)
{
	(void)state;
	stilb_job_pool_destroy(NULL);
	for (uint32_t i = 0; i < 200; i++) {
		work w = {.worker_count = i % 4};
		w.pool = pool_with(w.worker_count, (stilb_job_hooks){0});
		stilb_job_group unused = {0};
		tree *root = __real_malloc(sizeof *root);
		*root = (tree){&w, &unused, 3};
		for (int k = 0; k < 20; k++)
			assert_int_equal(stilb_job_submit(w.pool, count_job, &w, NULL, 0), 0);
		assert_int_equal(stilb_job_submit(w.pool, grow_tree, root, NULL, 0), 0);
		stilb_job_pool_destroy(w.pool);
		assert_int_equal(w.ran, 20 + 15);
		assert_int_equal(w.wrong, 0);
	}
}

static void test_pools_side_by_side(void **state)
{
	(void)state;
	work a = {.pool = pool_with(2, (stilb_job_hooks){0}), .worker_count = 2};
	work b = {.pool = pool_with(1, (stilb_job_hooks){0}), .worker_count = 1};
	stilb_job_group group_a = {0}, group_b = {0};
	for (int i = 0; i < 100; i++) {
		assert_int_equal(stilb_job_submit(a.pool, count_job, &a, &group_a, 0), 0);
		assert_int_equal(stilb_job_submit(b.pool, count_job, &b, &group_b, 0), 0);
	}
	stilb_job_wait(b.pool, &group_b, 0);
	stilb_job_wait(a.pool, &group_a, 0);
	assert_int_equal(a.ran, 100);
	assert_int_equal(b.ran, 100);
	stilb_job_pool_destroy(a.pool);
	stilb_job_pool_destroy(b.pool);
}

static void test_create_refuses(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = {.worker_count = STILB_JOB_MAX_WORKERS + 1};
	stilb_job_pool *pool = (stilb_job_pool *)&desc;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), -EINVAL);
	assert_null(pool);
	desc.worker_count = UINT32_MAX;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), -EINVAL);
}

static void test_create_cleans_up_after_a_failure(void **state)
{
	(void)state;
	hook_log log = {0};
	stilb_job_pool_desc desc = {.worker_count = 8, .hooks = log_hooks(&log)};
	for (uint32_t granted = 0; granted < 8; granted++) {
		memset(&log, 0, sizeof log);
		stilb_job_pool *pool = (stilb_job_pool *)&desc;
		threads_to_grant = granted;
		int error = stilb_job_pool_create(&desc, &pool);
		threads_to_grant = UINT32_MAX;
		assert_int_equal(error, -EAGAIN);
		assert_null(pool);
		assert_int_equal(log.starts, granted); /* the threads that had started were joined */
		assert_int_equal(log.stops, granted);
	}
	stilb_job_pool *pool = (stilb_job_pool *)&desc;
	out_of_memory = true;
	int error = stilb_job_pool_create(&desc, &pool);
	out_of_memory = false;
	assert_int_equal(error, -ENOMEM);
	assert_null(pool);
}

static void test_submit_without_memory(void **state)
{
	(void)state;
	work w = {.pool = pool_with(0, (stilb_job_hooks){0})}; /* no other thread calls malloc */
	stilb_job_group group = {0};
	uint64_t submitted = 0;
	int error;
	out_of_memory = true;
	while ((error = stilb_job_submit(w.pool, count_job, &w, &group, 0)) == 0)
		submitted++; /* these jobs use records that were allocated before */
	extent e = {0};
	stilb_job_parallel_for(w.pool, 100, 10, add_range, &e, 0); /* needs no memory */
	out_of_memory = false;
	assert_int_equal(error, -ENOMEM);
	assert_int_equal(e.sum, 100);
	stilb_job_wait(w.pool, &group, 0); /* would hang if the failed job was counted */
	assert_int_equal(w.ran, submitted);
	stilb_job_pool_destroy(w.pool);
}

static void test_default_desc(void **state)
{
	(void)state;
	uint32_t cpus = stilb_job_cpu_count();
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	assert_true(cpus >= 1);
	assert_int_equal(desc.worker_count, cpus > 1 ? cpus - 1 : 1);
	assert_null(desc.hooks.park);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_default_desc),
		cmocka_unit_test(test_create_refuses),
		cmocka_unit_test(test_create_cleans_up_after_a_failure),
		cmocka_unit_test(test_submit_without_memory),
		cmocka_unit_test(test_submit_and_wait),
		cmocka_unit_test(test_group_is_reusable),
		cmocka_unit_test(test_jobs_submit_jobs),
		cmocka_unit_test(test_jobs_wait_for_jobs),
		cmocka_unit_test(test_several_wait_for_one_group),
		cmocka_unit_test(test_loop_covers_every_index_once),
		cmocka_unit_test(test_loop_over_the_largest_count),
		cmocka_unit_test(test_loops_in_loops_in_jobs),
		cmocka_unit_test(test_loop_gets_help),
		cmocka_unit_test(test_long_loop_after_short_ones_gets_help),
		cmocka_unit_test(test_hooks_come_in_pairs),
		cmocka_unit_test(test_parked_workers_wake),
		cmocka_unit_test(test_waiting_owner_wakes),
		cmocka_unit_test(test_destroy_runs_what_is_queued),
		cmocka_unit_test(test_pools_side_by_side),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
