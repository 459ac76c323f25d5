/* job_pool_fixture: shared by the tests of the pool: pools of every shape, workers that are held and released, outside
 * threads. */
#ifndef JOB_POOL_FIXTURE_H
#define JOB_POOL_FIXTURE_H

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#include "jobs/job.h"
#include "support/test.h"

/* Incremented by jobs and polled by the test. Release and acquire, so that the test also sees the jobs' writes. */
typedef _Atomic uint32_t counter;

static inline uint32_t count_up(counter *value)
{
	return atomic_fetch_add_explicit(value, 1, memory_order_acq_rel);
}

static inline uint32_t count_of(counter *value)
{
	return atomic_load_explicit(value, memory_order_acquire);
}

static inline uint64_t now_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static inline void nap_us(uint32_t microseconds)
{
	nanosleep(&(struct timespec){.tv_nsec = (long)microseconds * 1000}, NULL);
}

/* Waits until the counter has the value. False if it did not change for ten seconds, which guards against a hang. */
static inline bool await(counter *value, uint32_t wanted)
{
	uint64_t start = now_ns();
	uint32_t last = count_of(value), now = last;
	for (uint32_t turns = 0; now != wanted; turns++, now = count_of(value)) {
		if (now != last)
			start = now_ns();
		else if (now_ns() - start > 10000000000u)
			return false;
		last = now;
		if (turns < 100)
			sched_yield();
		else
			nap_us(50);
	}
	return true;
}

/* The shapes of pools to test: for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) ... */
typedef struct shape {
	uint32_t workers;
	stilb_job_queue_kind queue;
} shape;

enum { MOST_WORKERS = 8, MOST_THREADS = MOST_WORKERS + 1 };

static inline shape shape_first(void)
{
	return (shape){.workers = 0, .queue = STILB_JOB_QUEUE_LOW_LOCK};
}

/* 0, 1, 2 and 8 workers with queues of one kind, then the same with the other kind. */
static inline shape shape_next(shape s)
{
	if (s.workers == MOST_WORKERS)
		return (shape){.workers = 0, .queue = s.queue + 1};
	return (shape){.workers = s.workers < 2 ? s.workers + 1 : MOST_WORKERS, .queue = s.queue};
}

static inline bool shape_is_end(shape s)
{
	return s.queue > STILB_JOB_QUEUE_LOCK_FREE;
}

static inline stilb_job_pool *pool_with_hooks(shape s, stilb_job_hooks hooks)
{
	stilb_job_pool *pool = NULL;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = s.workers;
	desc.queue = s.queue;
	desc.hooks = hooks;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	assert_int_equal(stilb_job_pool_worker_count(pool), s.workers);
	return pool;
}

static inline stilb_job_pool *pool_with(shape s)
{
	return pool_with_hooks(s, (stilb_job_hooks){0});
}

/* ---- sleeping threads ------------------------------------------------------------------------------------------ */

typedef struct sleep_log {
	counter parks;
	counter asleep; /* number of threads between the hooks park and wake */
} sleep_log;

static inline void sleep_log_park(void *user, uint32_t worker)
{
	sleep_log *log = user;
	(void)worker;
	count_up(&log->parks);
	count_up(&log->asleep);
}

static inline void sleep_log_wake(void *user, uint32_t worker)
{
	sleep_log *log = user;
	(void)worker;
	atomic_fetch_sub_explicit(&log->asleep, 1, memory_order_acq_rel);
}

static inline stilb_job_hooks sleep_log_hooks(sleep_log *log)
{
	return (stilb_job_hooks){.user = log, .park = sleep_log_park, .wake = sleep_log_wake};
}

/* ---- workers held in jobs -------------------------------------------------------------------------------------- */

typedef struct blocker {
	counter inside; /* number of threads held */
	counter go;
} blocker;

static inline void blocker_job(void *data, uint32_t worker)
{
	blocker *b = data;
	(void)worker;
	count_up(&b->inside);
	while (count_of(&b->go) == 0)
		nap_us(50);
}

static inline void submit_pinned(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group,
                                 uint32_t target, uint32_t worker)
{
	stilb_job_options options = {.pinned = true, .target = target};
	assert_int_equal(stilb_job_submit_with(pool, fn, data, group, &options, worker), 0);
}

static inline void submit_priority(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group,
                                   stilb_job_priority priority, uint32_t worker)
{
	stilb_job_options options = {.priority = priority};
	assert_int_equal(stilb_job_submit_with(pool, fn, data, group, &options, worker), 0);
}

/* Submits jobs to workers first..last and returns when all of them are inside. The jobs last until blocker_release. */
static inline void hold_workers(stilb_job_pool *pool, blocker *b, stilb_job_group *group, uint32_t first, uint32_t last)
{
	uint32_t before = count_of(&b->inside);
	for (uint32_t i = first; i <= last; i++)
		submit_pinned(pool, blocker_job, b, group, i, 0);
	assert_true(await(&b->inside, before + last + 1 - first));
}

static inline void blocker_release(blocker *b)
{
	count_up(&b->go);
}

/* ---- outside threads ------------------------------------------------------------------------------------------- */

static inline pthread_t outside_start(void *(*fn)(void *), void *data)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, fn, data), 0);
	return thread;
}

static inline void outside_run(void *(*fn)(void *), void *data)
{
	pthread_join(outside_start(fn, data), NULL);
}

#endif
