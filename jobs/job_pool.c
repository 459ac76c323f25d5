#include "jobs/job_internal.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

static bool run_job(stilb_job_pool *pool, uint32_t worker)
{
	job_item item;
	if (!job_queue_pop(&pool->queue, &item))
		return false;
	job_pool_wake_next(pool);
	item.fn(item.data, worker);
	if (item.group)
		job_group_finish(pool, item.group);
	return true;
}

bool job_pool_help(stilb_job_pool *pool, uint32_t worker, bool jobs, stilb_job_group *until)
{
	bool jobs_first = pool->slot[worker].turn++ % 2 != 0;
	if (jobs && jobs_first && run_job(pool, worker))
		return true;
	if (job_loop_help(pool, worker, until))
		return true;
	return jobs && !jobs_first && run_job(pool, worker);
}

/* Waits a little for something to do; ends early when it may pay to look closer. */
static void linger(stilb_job_pool *pool, stilb_job_group *group, bool jobs)
{
	for (int i = 0; i < JOB_IDLE_LOOKS; ++i) {
		/* Relaxed: guesses, the caller looks properly afterwards. */
		if (atomic_load_explicit(&pool->loops, memory_order_relaxed) ||
		    atomic_load_explicit(&pool->stop, memory_order_relaxed) || (jobs && !job_queue_looks_empty(&pool->queue)) ||
		    (group && job_group_done(group)))
			return;
		job_sys_pause();
	}
}

bool job_pool_seek(stilb_job_pool *pool, uint32_t worker, bool jobs, stilb_job_group *until)
{
	if (job_pool_help(pool, worker, jobs, until))
		return true;
	linger(pool, until, jobs);
	return (until && job_group_done(until)) || job_pool_help(pool, worker, jobs, until);
}

bool job_pool_has_work(stilb_job_pool *pool, uint32_t level, bool jobs)
{
	return (jobs && !job_queue_empty(&pool->queue)) || job_loop_deepest(pool) > level;
}

void job_pool_wake_next(stilb_job_pool *pool)
{
	/* A relaxed guess is enough: a thread that enters the list later looks for work itself. */
	if (!job_idle_any(&pool->idle))
		return;
	if (!job_queue_empty(&pool->queue))
		job_idle_wake(&pool->idle, JOB_WORK_JOB);
	uint32_t level = job_loop_deepest(pool);
	if (level > 0)
		job_idle_wake(&pool->idle, level);
}

bool job_pool_park(stilb_job_pool *pool, uint32_t worker, stilb_job_group *group, bool jobs)
{
	const stilb_job_hooks *hooks = &pool->hooks;
	job_slot *slot = &pool->slot[worker];
	/* The steps (1) to (3) of job_park.h. */
	job_idle_enter(&pool->idle, (job_idler){.parker = &slot->parker, .level = slot->level, .jobs = jobs});
	bool ready = group ? !job_group_announce(group, worker)
	                   : atomic_load_explicit(&pool->stop, memory_order_acquire); /* pairs with stop_workers */
	if (!ready && !job_pool_has_work(pool, slot->level, jobs)) {
		if (hooks->park)
			hooks->park(hooks->user, worker);
		job_parker_sleep(&slot->parker);
		if (hooks->wake)
			hooks->wake(hooks->user, worker);
	}
	return job_idle_leave(&pool->idle, &slot->parker);
}

static void worker_set_name(uint32_t worker)
{
	char name[32]; /* the kernel keeps 15 characters */
	snprintf(name, sizeof name, worker < 100 ? "stilb-worker-%u" : "stilb-wrk-%u", worker);
	pthread_setname_np(pthread_self(), name);
}

static void *worker_main(void *data)
{
	job_slot *slot = data;
	stilb_job_pool *pool = slot->pool;
	worker_set_name(slot->index);
	if (pool->hooks.thread_start)
		pool->hooks.thread_start(pool->hooks.user, slot->index);
	for (;;) {
		if (job_pool_seek(pool, slot->index, true, NULL))
			continue;
		if (atomic_load_explicit(&pool->stop, memory_order_acquire)) /* pairs with stop_workers */
			break;
		job_pool_park(pool, slot->index, NULL, true);
	}
	if (pool->hooks.thread_stop)
		pool->hooks.thread_stop(pool->hooks.user, slot->index);
	return NULL;
}

/* Joins workers 1..started. */
static void stop_workers(stilb_job_pool *pool, uint32_t started)
{
	atomic_store_explicit(&pool->stop, true, memory_order_release); /* pairs with the acquire in the workers */
	while (job_idle_wake(&pool->idle, JOB_WORK_JOB))
		;
	for (uint32_t i = 1; i <= started; ++i)
		pthread_join(pool->slot[i].thread, NULL);
}

static stilb_job_pool *pool_allocate(const stilb_job_pool_desc *desc)
{
	size_t size = sizeof(stilb_job_pool) + (desc->worker_count + 1) * sizeof(job_slot);
	stilb_job_pool *pool = aligned_alloc(JOB_LINE, size); /* both parts are multiples of the alignment */
	if (!pool)
		return NULL;
	if (job_queue_init(&pool->queue) != 0) {
		free(pool);
		return NULL;
	}
	job_idle_init(&pool->idle);
	atomic_init(&pool->loops_lock.held, false);
	atomic_init(&pool->loops, NULL);
	atomic_init(&pool->stop, false);
	pool->worker_count = desc->worker_count;
	pool->hooks = desc->hooks;
	pool->owner = pthread_self();
	for (uint32_t i = 0; i <= desc->worker_count; ++i) {
		pool->slot[i] = (job_slot){.index = i, .pool = pool};
		atomic_init(&pool->slot[i].parker.state, 0);
	}
	return pool;
}

static void pool_free(stilb_job_pool *pool)
{
	job_queue_finish(&pool->queue);
	free(pool);
}

stilb_job_pool_desc stilb_job_pool_desc_default(void)
{
	uint32_t cpus = stilb_job_cpu_count();
	uint32_t workers = cpus > 1 ? cpus - 1 : 1;
	return (stilb_job_pool_desc){.worker_count = workers < STILB_JOB_MAX_WORKERS ? workers : STILB_JOB_MAX_WORKERS};
}

int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **out)
{
	*out = NULL;
	if (desc->worker_count > STILB_JOB_MAX_WORKERS)
		return -EINVAL;
	stilb_job_pool *pool = pool_allocate(desc);
	if (!pool)
		return -ENOMEM;
	for (uint32_t i = 1; i <= desc->worker_count; ++i) {
		int error = pthread_create(&pool->slot[i].thread, NULL, worker_main, &pool->slot[i]);
		if (error) {
			stop_workers(pool, i - 1);
			pool_free(pool);
			return -error;
		}
	}
	*out = pool;
	return 0;
}

void stilb_job_pool_destroy(stilb_job_pool *pool)
{
	if (!pool)
		return;
	assert(pthread_equal(pool->owner, pthread_self()));
	while (run_job(pool, 0))
		;
	/* Nothing is left behind: a worker leaves only after it has found the queue empty, and what a job submits while the
	 * others leave is found by the worker that ran it. */
	stop_workers(pool, pool->worker_count);
	pool_free(pool);
}

uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool)
{
	return pool->worker_count;
}

int stilb_job_submit(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group)
{
	if (group)
		job_group_add(group); /* first: a worker may have finished the job before push returns */
	int error = job_queue_push(&pool->queue, &(job_item){.fn = fn, .data = data, .group = group});
	if (error) {
		if (group)
			job_group_finish(pool, group);
		return error;
	}
	job_idle_wake(&pool->idle, JOB_WORK_JOB);
	return 0;
}
