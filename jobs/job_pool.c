#include "jobs/job_internal.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Between two looks of an owner that waits for the last jobs before it takes the pool down. */
#define NAP_NS 100000u

#define NO_CPU UINT32_MAX

/* ---- the workers ----------------------------------------------------------------------------------------------- */

static void worker_set_name(uint32_t worker)
{
	char name[32]; /* the kernel keeps 15 characters */
	snprintf(name, sizeof name, worker < 100 ? "stilb-worker-%u" : "stilb-wrk-%u", worker);
	pthread_setname_np(pthread_self(), name);
}

/* Spinners beside the thread that feeds them: one, or in a phase one for every other CPU. */
static uint32_t spin_limit(stilb_job_pool *pool)
{
	/* Relaxed: a hint, a phase that has just begun or ended makes itself felt a moment later. */
	return atomic_load_explicit(&pool->phase, memory_order_relaxed) && pool->cpus > 2 ? pool->cpus - 1 : 1;
}

static bool stopping(job_slot *slot, void *context)
{
	(void)context;
	return atomic_load_explicit(&slot->pool->stop, memory_order_acquire); /* pairs with stop_workers */
}

/* Has found nothing to do. */
static void worker_idle(job_slot *slot)
{
	stilb_job_pool *pool = slot->pool;
	if (!slot->spinning)
		slot->spinning = job_idle_spin_start(&pool->idle, spin_limit(pool));
	if (slot->spinning && job_work_linger(slot, &job_scope_all, NULL))
		return;
	job_work_park(slot, &job_scope_all, stopping, NULL);
	if (slot->spinning && spin_limit(pool) > 1)
		job_idle_wake_spinner(&pool->idle, spin_limit(pool)); /* phase_begin woke this one, which wakes the next */
}

/* Lets a thread with many small jobs get on with them. Counted as a spinner meanwhile: it is about to look for work. */
static void leave_alone(job_slot *slot)
{
	uint64_t start = job_sys_ticks(), rest = job_sys_ticks_in(JOB_STEAL_REST_NS);
	slot->meagre = false;
	if (job_deque_empty(&slot->pool->slot[slot->victim].deque))
		return; /* it was the only one */
	if (!slot->spinning)
		slot->spinning = job_idle_spin_start(&slot->pool->idle, spin_limit(slot->pool));
	while (job_sys_ticks() - start < rest)
		job_sys_pause();
}

static void *worker_main(void *data)
{
	job_slot *slot = data;
	stilb_job_pool *pool = slot->pool;
	worker_set_name(slot->index);
	if (slot->cpu != NO_CPU && job_sys_bind(0, slot->cpu)) /* if it cannot be, it goes without */
		job_idle_bound(&pool->idle, &slot->parker, slot->cpu);
	if (pool->hooks.thread_start)
		pool->hooks.thread_start(pool->hooks.user, slot->index);
	while (!stopping(slot, NULL))
		if (!job_work_help(slot, &job_scope_all, NULL))
			worker_idle(slot);
		else if (slot->meagre)
			leave_alone(slot);
	if (slot->spinning)
		job_idle_spin_stop(&pool->idle);
	if (pool->hooks.thread_stop)
		pool->hooks.thread_stop(pool->hooks.user, slot->index);
	return NULL;
}

/* Joins workers 1..started. */
static void stop_workers(stilb_job_pool *pool, uint32_t started)
{
	atomic_store_explicit(&pool->stop, true, memory_order_release); /* pairs with the acquire in stopping */
	for (uint32_t i = 1; i <= started; i++)
		job_parker_wake(&pool->slot[i].parker);
	for (uint32_t i = 1; i <= started; i++)
		pthread_join(pool->slot[i].thread, NULL);
}

/* ---- life cycle ------------------------------------------------------------------------------------------------ */

static void pool_free(stilb_job_pool *pool)
{
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		job_deque_finish(&pool->slot[i].deque);
	for (int i = 0; i < JOB_SHARED_COUNT; i++)
		stilb_job_queue_destroy(pool->shared[i]);
	job_record_store_finish(&pool->records);
	free(pool);
}

/* 0 or -ENOMEM; what has been made is freed by pool_free. */
static int make_queues(stilb_job_pool *pool, const stilb_job_pool_desc *desc, job_queue_maker *make)
{
	stilb_job_queue_desc queue = {
		.kind = desc->queue, .capacity = SIZE_MAX, .thread_count = desc->worker_count + 1 + JOB_GUESTS};
	for (int i = 0; i < JOB_SHARED_COUNT; i++) {
		int error = 0;
		if (make)
			pool->shared[i] = make();
		else
			error = stilb_job_queue_create(&queue, &pool->shared[i]);
		if (error || !pool->shared[i])
			return error ? error : -ENOMEM;
	}
	for (uint32_t i = 0; i <= desc->worker_count; i++) {
		int error = job_deque_init(&pool->slot[i].deque);
		if (error)
			return error;
	}
	return 0;
}

static void slot_init(job_slot *slot, stilb_job_pool *pool, uint32_t index)
{
	slot->pool = pool;
	slot->index = index;
	slot->cpu = NO_CPU;
	atomic_init(&slot->inbox, NULL);
	atomic_init(&slot->parker.state, 0);
	for (int i = 0; i < JOB_LOOP_DEPTH; i++)
		atomic_init(&slot->loop[i].claim, 0);
}

static stilb_job_pool *pool_allocate(const stilb_job_pool_desc *desc)
{
	size_t size = sizeof(stilb_job_pool) + (desc->worker_count + 1) * sizeof(job_slot);
	stilb_job_pool *pool = aligned_alloc(JOB_LINE, size); /* both parts are multiples of the alignment */
	if (!pool)
		return NULL;
	memset(pool, 0, size);
	job_idle_init(&pool->idle, desc->worker_count);
	job_record_store_init(&pool->records);
	pool->worker_count = desc->worker_count;
	pool->cpus = stilb_job_cpu_count();
	pool->wake_ticks = job_sys_ticks_in(JOB_WAKE_NS);
	pool->steal_ticks = job_sys_ticks_in(JOB_STEAL_NS);
	pool->crowded = desc->worker_count >= pool->cpus;
	pool->hooks = desc->hooks;
	pool->owner = pthread_self();
	for (uint32_t i = 0; i <= desc->worker_count; i++)
		slot_init(&pool->slot[i], pool, i);
	return pool;
}

/* A worker woken by a thread that goes on running starts at once only on another CPU, and left alone the kernel mostly puts it on
 * that thread's own. So each worker gets a CPU of its own and one is left for the owner, if there are enough; should the owner
 * be moved to a worker's CPU, that worker changes over to the one left (job_park.c). */
static void choose_cpus(stilb_job_pool *pool, const stilb_job_pool_desc *desc)
{
	uint32_t cpus[STILB_JOB_MAX_WORKERS];
	if (desc->affinity != STILB_JOB_AFFINITY_AUTO || desc->worker_count == 0 ||
	    job_cpu_others(cpus, desc->worker_count) < desc->worker_count)
		return;
	pool->idle.spare = true;
	pool->idle.spare_cpu = job_sys_cpu();
	for (uint32_t i = 1; i <= desc->worker_count; i++)
		pool->slot[i].cpu = cpus[i - 1];
}

static int start_workers(stilb_job_pool *pool)
{
	for (uint32_t i = 1; i <= pool->worker_count; i++) {
		int error = pthread_create(&pool->slot[i].thread, NULL, worker_main, &pool->slot[i]);
		if (error) {
			stop_workers(pool, i - 1);
			return -error;
		}
	}
	return 0;
}

stilb_job_pool_desc stilb_job_pool_desc_default(void)
{
	uint32_t cpus = stilb_job_cpu_count();
	uint32_t workers = cpus > 1 ? cpus - 1 : 1;
	return (stilb_job_pool_desc){.worker_count = workers < STILB_JOB_MAX_WORKERS ? workers : STILB_JOB_MAX_WORKERS};
}

int job_pool_create_over(const stilb_job_pool_desc *desc, job_queue_maker *make, stilb_job_pool **out)
{
	*out = NULL;
	if (desc->worker_count > STILB_JOB_MAX_WORKERS || (uint32_t)desc->queue > STILB_JOB_QUEUE_LOCK_FREE ||
	    (uint32_t)desc->affinity > STILB_JOB_AFFINITY_NONE)
		return -EINVAL;
	stilb_job_pool *pool = pool_allocate(desc);
	if (!pool)
		return -ENOMEM;
	int error = make_queues(pool, desc, make);
	choose_cpus(pool, desc);
	if (!error)
		error = start_workers(pool);
	if (error) {
		pool_free(pool);
		return error;
	}
	*out = pool;
	return 0;
}

int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **pool)
{
	return job_pool_create_over(desc, NULL, pool);
}

/* True if at some moment during the call every job that had been submitted had finished: then nobody is in the middle of one,
 * who could submit another. All that has finished is counted before all that has been submitted, so what comes in between
 * only adds to the latter. */
static bool pool_quiet(stilb_job_pool *pool)
{
	uint64_t finished = 0, submitted = 0;
	/* Acquire pairs with job_count. */
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		finished += atomic_load_explicit(&pool->slot[i].finished, memory_order_acquire);
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		submitted += atomic_load_explicit(&pool->slot[i].submitted, memory_order_acquire);
	for (int i = 0; i < JOB_GUESTS; i++)
		submitted += atomic_load_explicit(&pool->guest[i].submitted, memory_order_acquire);
	return finished == submitted;
}

void stilb_job_pool_destroy(stilb_job_pool *pool)
{
	if (!pool)
		return;
	assert(pthread_equal(pool->owner, pthread_self()));
	while (!pool_quiet(pool))
		if (!job_work_help(&pool->slot[0], &job_scope_all, NULL))
			job_sys_nap(NAP_NS);
	stop_workers(pool, pool->worker_count);
	pool_free(pool);
}

void stilb_job_pool_cancel(stilb_job_pool *pool)
{
	atomic_store_explicit(&pool->cancelled, true, memory_order_relaxed);
}

uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool)
{
	return pool->worker_count;
}

void stilb_job_phase_begin(stilb_job_pool *pool)
{
	/* Relaxed: a hint to spinners. */
	if (atomic_fetch_add_explicit(&pool->phase, 1, memory_order_relaxed) == 0)
		job_idle_wake_spinner(&pool->idle, spin_limit(pool)); /* it wakes the next */
}

void stilb_job_phase_end(stilb_job_pool *pool)
{
	uint32_t phases = atomic_fetch_sub_explicit(&pool->phase, 1, memory_order_relaxed);
	assert(phases > 0);
	(void)phases;
}
