/*
 * jobs: a worker pool. A stand-alone library: C17 and Linux, no other part of Stilb.
 *
 * What it is.   N worker threads beside the thread that made the pool, its owner. Jobs lie in a deque of the thread that
 *               submitted them, where it runs the newest first and others steal the oldest; jobs from outside the pool and
 *               jobs with a priority lie in FIFO queues that all share (job_queue.h). Parallel loops are claimed slice by
 *               slice by whoever is free. A thread that waits helps with what it waits for, so a pool with zero workers
 *               works too: everything then runs in the owner's calls.
 * Life cycle.   stilb_job_pool_create -> submit / parallel_for / wait, any number of times -> stilb_job_pool_destroy.
 * Per frame.    stilb_job_parallel_for, or submits into a group followed by stilb_job_wait. A program with frames puts
 *               stilb_job_phase_begin and _end around the part of a frame that uses the pool.
 * Threads.      The owner has worker index 0, the workers have 1..worker_count. A call takes the index of the thread that
 *               makes it; a thread that is not of the pool passes STILB_JOB_OUTSIDE. [any-thread]: all of them;
 *               [pool-thread]: the owner, jobs and slices; [owner-thread]: the owner alone. Several pools may live side
 *               by side.
 * Errors.       0 or a negative errno. Nothing here prints.
 * Waiting.      stilb_job_wait runs, until its group has finished: what descends from the same outermost job or group, is
 *               nested deeper than the caller and lies at an end of a deque; jobs of high priority, unless the caller is
 *               in one; and jobs pinned to this thread. It starts unrelated work only while every worker of the pool
 *               waits too, for then nobody else would.
 *               - Wait only for jobs that you or your callees submitted; two jobs that wait for each other never return.
 *               - Hold no lock across a wait that another job may want.
 *
 * The guarantees, structure by structure: the deques, the loops' claims, the inboxes and the records are lock-free. The
 * shared queues are low-lock or lock-free, as the pool was made. Sleeping and waking, and the list of jobs that follow
 * a group, go through short spin-then-sleep locks. Allocation is as lock-free as malloc.
 */
#ifndef STILB_JOB_H
#define STILB_JOB_H

#include "job_queue.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STILB_JOB_MAX_WORKERS 256

/* In place of a worker index: the calling thread is not of the pool. */
#define STILB_JOB_OUTSIDE UINT32_MAX

/* A job: data is what was given at submit, worker is the index (0..worker_count) of the thread that runs it. */
typedef void stilb_job_fn(void *data, uint32_t worker);

/* A slice [begin, end) of a parallel-for or an array, run on the thread with index worker. */
typedef void stilb_job_range_fn(uint32_t begin, uint32_t end, uint32_t worker, void *context);

typedef struct stilb_job_pool stilb_job_pool;

/* Counts jobs that have not finished, up to 2^32 - 2. Zero-initialise it; it must outlive its jobs and the waits for it.
 * Only this library touches the fields. A group may be used again, or its memory freed, once stilb_job_wait has
 * returned; a running job may submit into its own group. */
typedef struct stilb_job_group {
	uint64_t state;
	void *after; /* jobs that start when this group has finished */
} stilb_job_group;

typedef enum stilb_job_priority {
	STILB_JOB_NORMAL, /* zero, the default */
	STILB_JOB_HIGH,   /* before all others. For short jobs that do not wait: every wait runs them */
	STILB_JOB_LOW     /* when nothing else is to be done. For long jobs: no wait runs them (but see Waiting) */
} stilb_job_priority;

/* Called on the thread concerned; any may be NULL. This is how a profiler sees the pool without the pool knowing it. */
typedef struct stilb_job_hooks {
	void *user;
	void (*thread_start)(void *user, uint32_t worker); /* a worker begins its life */
	void (*thread_stop)(void *user, uint32_t worker);  /* a worker ends its life */
	void (*park)(void *user, uint32_t worker);         /* found nothing to do and goes to sleep; the owner, too */
	void (*wake)(void *user, uint32_t worker);         /* is awake again; pairs with park */
	/* A job is submitted here, or a loop opened for others to help with. What is returned is its tag. worker is
	 * STILB_JOB_OUTSIDE on a thread from outside. */
	uint64_t (*submit)(void *user, uint32_t worker);
	/* The job with that tag (0 without submit) starts here, perhaps inside the wait of another; or this thread begins to help
	 * with the loop. Any number of threads help with a loop, each any number of times. */
	void (*job_begin)(void *user, uint32_t worker, uint64_t tag);
	void (*job_end)(void *user, uint32_t worker); /* it has returned, or the loop has no more; pairs with job_begin */
	/* This thread waits for a group or for the last slices of its loop, and finds nothing to help with. It may park meanwhile,
	 * and begin a job that comes. worker may be STILB_JOB_OUTSIDE. */
	void (*wait_begin)(void *user, uint32_t worker);
	void (*wait_end)(void *user, uint32_t worker); /* pairs with wait_begin; the wait may go on after some help */
	void (*steal)(void *user, uint32_t worker, uint32_t victim); /* took a job from the deque of thread victim */
} stilb_job_hooks;

typedef enum stilb_job_affinity {
	/* Each worker is bound to a CPU of its own, away from the CPU of the owner, if worker_count is less than the number of
	 * CPUs of the affinity mask; else nobody is bound. The owner never is. Two such pools share CPUs: give the second
	 * one STILB_JOB_AFFINITY_NONE if they work at the same time. */
	STILB_JOB_AFFINITY_AUTO,
	STILB_JOB_AFFINITY_NONE
} stilb_job_affinity;

typedef struct stilb_job_pool_desc {
	uint32_t worker_count;      /* threads beside the owner, 0..STILB_JOB_MAX_WORKERS */
	stilb_job_queue_kind queue; /* of the shared queues */
	stilb_job_affinity affinity;
	stilb_job_hooks hooks;
} stilb_job_pool_desc;

/* worker_count = stilb_job_cpu_count() - 1, at least 1, at most STILB_JOB_MAX_WORKERS; low-lock queues; affinity AUTO; no
 * hooks. [any-thread] */
stilb_job_pool_desc stilb_job_pool_desc_default(void);

/* CPUs this process may use: the affinity mask, bounded by the cgroup CPU quota (rounded up), at least 1. [any-thread] */
uint32_t stilb_job_cpu_count(void);

/* Starts the workers; the calling thread becomes the owner. -EINVAL: worker_count, queue or affinity out of range;
 * -ENOMEM, -EAGAIN: no memory, no threads to be had. After an error nothing is left running and *pool is NULL. [any-thread] */
int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **pool);

/* Runs everything that has been submitted and what those jobs submit, stops and joins the workers. NULL is fine. No other call
 * may be running; jobs that wait for a group that can never finish make this wait for ever. [owner-thread] */
void stilb_job_pool_destroy(stilb_job_pool *pool);

/* From now on jobs that have not started do not run any more: they count as finished, so waits return and destroy ends
 * soon. For going down quickly: cancel, then destroy. Loops that have begun run to their end. [any-thread] */
void stilb_job_pool_cancel(stilb_job_pool *pool);

/* Threads beside the owner. Per-worker state of a caller needs worker_count + 1 slots. [any-thread] */
uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool);

/* Queues fn(data, worker), counts it in group (may be NULL) and wakes a worker if all that look for work are busy.
 * -ENOMEM: nothing was queued or counted. worker is the caller's own index or STILB_JOB_OUTSIDE. [any-thread] */
int stilb_job_submit(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group, uint32_t worker);

/* Zero is the default of every field. */
typedef struct stilb_job_options {
	stilb_job_priority priority;
	bool pinned;     /* only the thread with index target runs it; the owner does in its waits, loops and run_pinned */
	uint32_t target; /* 0..worker_count */
	stilb_job_group *after; /* not before this group has finished; NULL: at once. May be one that is finished already */
} stilb_job_options;

/* stilb_job_submit with options. Jobs of high or low priority start in the order in which they were submitted, among
 * themselves; pinned jobs have no priority. -EINVAL: priority or target out of range, or after is group: the job would wait
 * for itself. [any-thread] */
int stilb_job_submit_with(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group,
                          const stilb_job_options *options, uint32_t worker);

/* fn over [0, count) in slices of grain, as stilb_job_parallel_for, as one job of group: returns at once, and it costs no more
 * than one submit, whatever count is. [any-thread] */
int stilb_job_submit_array(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                           stilb_job_group *group, uint32_t worker);

/* Runs the jobs pinned to this thread that are there now; how many. For an owner that waits for nothing. [pool-thread] */
uint32_t stilb_job_run_pinned(stilb_job_pool *pool, uint32_t worker);

/* Returns when every job of group has finished; helps meanwhile (see Waiting), sleeps when there is nothing to help with. All
 * that those jobs wrote is visible to the caller. A thread from outside does not help. [any-thread] */
void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker);

/* Runs fn over [0, count) in slices of grain (0 counts as 1; the last may be shorter), on the caller and on every worker
 * that is free or becomes so; returns when all slices have finished and all that they wrote is visible. A slow slice
 * strands nobody; which thread runs which slice is not determined. May be nested. Needs no memory and no help, so it cannot
 * fail; while the caller waits for the last slices of others it helps deeper loops of the same origin and runs what is
 * pinned to its thread, but no other jobs.
 * Sleeping workers are woken only for loops longer than that takes. [pool-thread] */
void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker);

/* Inside a phase workers without work spin, as many as there are CPUs for beside the owner's, so work starts within a fraction
 * of a microsecond; outside one worker spins for some 30 us and then sleeps. Phases nest. [any-thread] */
void stilb_job_phase_begin(stilb_job_pool *pool);
void stilb_job_phase_end(stilb_job_pool *pool);

#ifdef __cplusplus
}
#endif
#endif
