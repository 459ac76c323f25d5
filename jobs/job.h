/*
 * jobs: a worker pool fed by a low-lock queue. A stand-alone library: C17 and Linux, no other part of Stilb.
 *
 * What it is.   N worker threads take jobs from one multi-producer, multi-consumer FIFO (Sutter's generalised queue: one
 *               lock for producers, one for consumers, so the two ends never wait for each other), help with the
 *               parallel loops that are open, and sleep when there is nothing to do. A thread that waits helps meanwhile,
 *               so a pool with zero workers works too: everything then runs in stilb_job_wait, stilb_job_parallel_for
 *               and stilb_job_pool_destroy.
 * Life cycle.   stilb_job_pool_create -> submit / parallel_for / wait, any number of times -> stilb_job_pool_destroy.
 * Per frame.    stilb_job_parallel_for, or stilb_job_submit into a group followed by stilb_job_wait.
 * Threads.      The thread that creates a pool is its owner and has worker index 0; workers have 1..worker_count.
 *               Every call says who may make it: [any-thread] (the owner, and jobs and slices of this pool),
 *               [owner-thread] (the owner alone). Several pools may live side by side.
 * Errors.       0 or a negative errno. Nothing here prints.
 * Waiting.      Because a waiting thread runs other jobs on top of its stack:
 *               - wait only for jobs that you or your callees submitted; two jobs that wait for each other never return;
 *               - hold no lock across a wait that another job may want;
 *               - jobs that wait while many more of that kind are queued nest one in another and need the stack for it.
 *                 A loop inside a job nests no jobs: prefer stilb_job_parallel_for there.
 *
 * The guarantee of the queue, said honestly: low-lock, not lock-free. A thread stalled inside one of its two short
 * critical sections stops its own side (producers or consumers) until it runs again.
 * Source: Herb Sutter, "Writing a Generalized Concurrent Queue", Dr. Dobb's Journal, November 2008.
 */
#ifndef STILB_JOB_H
#define STILB_JOB_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STILB_JOB_MAX_WORKERS 256

/* A job: data is what was given at submit, worker is the index (0..worker_count) of the thread that runs it. */
typedef void stilb_job_fn(void *data, uint32_t worker);

/* A slice [begin, end) of a parallel-for, run on the thread with index worker. */
typedef void stilb_job_range_fn(uint32_t begin, uint32_t end, uint32_t worker, void *context);

typedef struct stilb_job_pool stilb_job_pool;

/* Counts jobs that have not finished, up to 2^32 - 1. Zero-initialise it; it must outlive its jobs and the waits for it.
 * Only this library touches the field (with atomic operations). A group may be used again, or its memory freed, once
 * stilb_job_wait has returned; a running job may submit into its own group. */
typedef struct stilb_job_group {
	uint64_t state;
} stilb_job_group;

/* Called on the thread concerned; any may be NULL. This is how a profiler sees the pool without the pool knowing it. */
typedef struct stilb_job_hooks {
	void *user;
	void (*thread_start)(void *user, uint32_t worker); /* a worker begins its life */
	void (*thread_stop)(void *user, uint32_t worker);  /* a worker ends its life */
	void (*park)(void *user, uint32_t worker);         /* found nothing to do and goes to sleep; the owner, too */
	void (*wake)(void *user, uint32_t worker);         /* is awake again; pairs with park */
} stilb_job_hooks;

typedef struct stilb_job_pool_desc {
	uint32_t worker_count; /* threads beside the owner, 0..STILB_JOB_MAX_WORKERS */
	stilb_job_hooks hooks;
} stilb_job_pool_desc;

/* worker_count = stilb_job_cpu_count() - 1, at least 1, at most STILB_JOB_MAX_WORKERS; no hooks. [any-thread] */
stilb_job_pool_desc stilb_job_pool_desc_default(void);

/* CPUs this process may use: the affinity mask, bounded by the cgroup CPU quota (rounded up), at least 1. [any-thread] */
uint32_t stilb_job_cpu_count(void);

/* Starts the workers; the calling thread becomes the owner. -EINVAL: worker_count out of range; -ENOMEM, -EAGAIN: no
 * memory, no threads to be had. After an error nothing is left running and *pool is NULL. [any-thread] */
int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **pool);

/* Runs what is still queued and what those jobs submit, stops and joins the workers. NULL is fine. No loop or wait of
 * the owner's may be running. [owner-thread] */
void stilb_job_pool_destroy(stilb_job_pool *pool);

/* Threads beside the owner. Per-worker state of a caller needs worker_count + 1 slots. [any-thread] */
uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool);

/* Queues fn(data, worker), counts it in group (may be NULL) and wakes a parked worker if there is one.
 * Jobs start in the order in which they were queued. -ENOMEM: nothing was queued or counted. [any-thread] */
int stilb_job_submit(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group);

/* Returns when every job of group has finished; runs queued jobs and helps open loops meanwhile, parks when there are
 * none. All that those jobs wrote is visible to the caller. worker is the caller's own index: 0 for the owner, else what
 * its job was given. [any-thread] */
void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker);

/* Runs fn over [0, count) in slices of grain (0 counts as 1; the last may be shorter), on the caller and on every worker
 * that is free or becomes so; returns when all slices have finished and all that they wrote is visible. Slices are
 * claimed from one counter, so a slow slice strands nobody; which thread runs which slice is not determined. May be
 * nested. Needs no memory and no help, so it cannot fail; while the caller waits for the last slices of others it
 * helps deeper loops only, never jobs. worker is the caller's own index. [any-thread] */
void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker);

#ifdef __cplusplus
}
#endif
#endif
