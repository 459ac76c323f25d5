/*
 * job: a pool of worker threads that runs jobs and parallel loops. The library stands alone: C17 and Linux, no other
 * part of Stilb.
 *
 * Overview.     A pool is N worker threads plus the thread that created it, its owner. A job is a function and a
 *               pointer. Each thread keeps the jobs it submits in a deque of its own: it runs the newest first, and
 *               other threads steal the oldest. Jobs from threads outside the pool and jobs of high priority go
 *               through shared FIFO queues (job_queue.h). The slices of a parallel loop are claimed by any thread that
 *               is free. A thread that waits runs other jobs of what it waits for, so a pool of zero workers also
 *               works: everything then runs inside the owner's calls.
 * Life cycle.   stilb_job_pool_create -> submit, parallel_for and wait, any number of times -> stilb_job_pool_destroy.
 * Each frame.   stilb_job_parallel_for; or stilb_job_submit into a group, then stilb_job_wait for the group. Programs
 *               with frames call stilb_job_phase_begin and stilb_job_phase_end around the part of a frame that uses the
 *               pool.
 * Example.
 *                   static void square(uint32_t begin, uint32_t end, uint32_t worker, void *context)
 *                   {
 *                       float *values = context;
 *                       for (uint32_t i = begin; i < end; i++)
 *                           values[i] *= values[i];
 *                   }
 *
 *                   stilb_job_pool_desc desc = stilb_job_pool_desc_default();
 *                   stilb_job_pool *pool;
 *                   if (stilb_job_pool_create(&desc, &pool) == 0) {
 *                       stilb_job_parallel_for(pool, 100000, 1024, square, values, 0);
 *                       stilb_job_pool_destroy(pool);
 *                   }
 * Threads.      The owner has worker index 0, the workers have 1 to worker_count. Every call takes the index of the
 *               thread that makes it; a thread outside the pool passes STILB_JOB_OUTSIDE. The words at the end of each
 *               function's comment say who may call it: [any-thread]: every thread; [pool-thread]: the owner, and jobs
 *               and slices on the thread that runs them; [owner-thread]: the owner alone. A program may have several
 *               pools at once.
 * Errors.       Functions return 0 or a negative errno value and print nothing. A broken rule of this header, for
 *               example the index of another thread, is an assert in builds without NDEBUG and undefined behaviour with
 *               it.
 * Waiting.      Until its group has finished, stilb_job_wait runs these jobs: jobs that descend from the same outermost
 *               job or group as the caller and are nested deeper than the caller; jobs of high priority, unless the
 *               caller is inside one; and jobs pinned to the calling thread. It finds them wherever they lie, also
 *               between unrelated jobs, and sleeps only when all of them have started: before that it looks through
 *               all jobs in the pool. It starts an unrelated job only while every worker of the pool is waiting as
 *               well, because then no other thread would. Jobs that threads outside the pool have submitted are
 *               unrelated.
 *               - Wait only for jobs that the caller or its callees have submitted. Two jobs that wait for each other
 *                 never return.
 *               - Do not hold a lock across a wait if another job may take that lock.
 * Progress.     Deques, loop claims, inboxes and job records are lock-free. The shared queues are low-lock or
 *               lock-free, as chosen in stilb_job_pool_desc. Sleeping, waking, jobs of low priority and jobs `after` a
 *               group use short locks that spin and then sleep. Memory comes from the pool's allocator (job_memory.h),
 *               whose progress the library inherits.
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
#pragma GCC visibility push(default)

/* The most worker threads of one pool. */
#define STILB_JOB_MAX_WORKERS 256

/* Passed instead of a worker index by a thread that is neither the owner nor a worker of the pool. A thread of the pool
 * may pass it to submit a job through the shared queues, unrelated to the job that it is in, but not to wait. */
#define STILB_JOB_OUTSIDE UINT32_MAX

/* A job. data is the pointer given at submit; worker (0..worker_count) is the index of the thread that runs the job,
 * which the job passes on to the calls it makes. */
typedef void stilb_job_fn(void *data, uint32_t worker);

/* The part of a parallel loop that covers indices begin <= i < end. worker is the index of the thread that runs it,
 * context the pointer given with the loop. */
typedef void stilb_job_range_fn(uint32_t begin, uint32_t end, uint32_t worker, void *context);

/* Created by stilb_job_pool_create. */
typedef struct stilb_job_pool stilb_job_pool;

/* Counts the unfinished jobs that were submitted into it, at most 2^32 - 2. Zero-initialise it. It must outlive its
 * jobs and every wait for it, and all its jobs belong to one pool. Once stilb_job_wait has returned the group may be
 * reused or freed. A running job may submit more jobs into its own group. */
typedef struct stilb_job_group {
	uint64_t state; /* the library's own */
	void *after;    /* the library's own: jobs that start when this group has finished */
	/* Called instead of each job of this group that is dropped (stilb_job_group_cancel, stilb_job_pool_cancel), with
	 * the job's data or the loop's context, for example to free it; NULL: nothing is called. Set by the program before
	 * the first submit. */
	stilb_job_fn *dropped;
} stilb_job_group;

/* The order in which threads look for jobs. */
typedef enum stilb_job_priority {
	STILB_JOB_NORMAL, /* the default */
	STILB_JOB_HIGH,   /* before all others; for short jobs that do not wait, since every wait runs them */
	STILB_JOB_LOW     /* when there is nothing else to do; for long jobs */
} stilb_job_priority;

/* Functions that the pool calls as things happen, on the thread to which they happen; any may be NULL. This is how a
 * profiler sees the pool (examples/hooks.c). */
typedef struct stilb_job_hooks {
	void *user; /* the first argument of every hook */
	/* A worker thread begins, and ends. */
	void (*thread_start)(void *user, uint32_t worker);
	void (*thread_stop)(void *user, uint32_t worker);
	/* A thread has found nothing to do and goes to sleep, and has woken up again. Also for the owner. Calls pair up. */
	void (*park)(void *user, uint32_t worker);
	void (*wake)(void *user, uint32_t worker);
	/* A job is submitted, or a loop is opened for others to help with. The result is a tag of the caller's choice.
	 * worker is STILB_JOB_OUTSIDE on a thread outside the pool. */
	uint64_t (*submit)(void *user, uint32_t worker);
	/* The job with this tag starts, possibly inside the wait of another job; or the thread starts to help with the loop
	 * of this tag. Any number of threads help with a loop, each any number of times. Without a submit hook the tag is
	 * 0. */
	void (*job_begin)(void *user, uint32_t worker, uint64_t tag);
	/* The job has returned, or the loop has no slices left. Pairs with job_begin. */
	void (*job_end)(void *user, uint32_t worker);
	/* The thread waits for a group, or for the last slices of its own loop, and finds nothing to help with. It may park
	 * before wait_end, and jobs that arrive may begin and end in between. worker may be STILB_JOB_OUTSIDE. */
	void (*wait_begin)(void *user, uint32_t worker);
	/* Pairs with wait_begin. One wait may have several such pairs, with help given between them. */
	void (*wait_end)(void *user, uint32_t worker);
	/* The thread has taken a job from the deque of thread victim. */
	void (*steal)(void *user, uint32_t worker, uint32_t victim);
	/* Called between job_begin and job_end of a job that is a node of a graph and has a name (job_graph.h): its
	 * function begins, and has returned. name is valid as long as the graph; *memo belongs to the hook, one for each
	 * node, and is NULL at first. */
	void (*node_begin)(void *user, uint32_t worker, const char *name, void **memo);
	void (*node_end)(void *user, uint32_t worker);
} stilb_job_hooks;

/* Binding of workers to CPUs. */
typedef enum stilb_job_affinity {
	/* Binds each worker to a CPU of its own, none to the owner's: if there is a choice, to cores that no other thread
	 * of the pool uses, near the owner's. Workers for which the affinity mask has no CPU left are not bound, and are
	 * woken last. The owner is never bound. Two such pools use the same CPUs: if they work at the same time, give each
	 * of them CPUs of its own, or create the second one with STILB_JOB_AFFINITY_NONE. */
	STILB_JOB_AFFINITY_AUTO,
	STILB_JOB_AFFINITY_NONE, /* binds no worker to a single CPU */
	STILB_JOB_AFFINITY_EACH  /* binds worker i to cpus[i - 1] of the desc, and leaves it there */
} stilb_job_affinity;

/* The settings of a pool; start from stilb_job_pool_desc_default. What is zero is left to the library. */
typedef struct stilb_job_pool_desc {
	uint32_t worker_count;       /* threads beside the owner, 0..STILB_JOB_MAX_WORKERS */
	stilb_job_queue_kind queue;  /* the kind of the shared queues */
	stilb_job_affinity affinity; /* default: AUTO */
	stilb_job_hooks hooks;       /* default: none */
	/* What ps, top and debuggers call the workers: the name, a hyphen and the index, as in "loader-1". Linux keeps 15
	 * bytes; the name is cut, and the index is not. NULL or "": "stilb-worker". */
	const char *name;
	/* Of each worker, in bytes; PTHREAD_STACK_MIN at least, rounded up to whole pages. glibc may give more, the stack
	 * of a thread that has ended. 0: the system's, mostly 8 MiB. A wait runs other jobs on top of the one that waits,
	 * so nested waits need more. */
	size_t stack_size;
	/* Added to the nice value of the thread that creates the pool, -39..39: with 10 the workers run where other threads
	 * leave time. Negative values need a permission (RLIMIT_NICE); stilb_job_pool_worker_info says what they got. */
	int32_t nice;
	/* The CPUs that workers may use, in any order, cpu_count numbers below STILB_JOB_MAX_CPUS. AUTO chooses among them;
	 * workers that it does not bind to one of them, and with NONE all workers, may run on any of them. EACH: one for
	 * each worker; the same may stand there twice. None: those of the affinity mask of the thread that creates the
	 * pool. */
	const uint32_t *cpus;
	uint32_t cpu_count;
	/* Where the pool's memory comes from; job_memory.h says when its functions are called, and by which threads. NULL:
	 * the C library. */
	const stilb_job_allocator *allocator;
} stilb_job_pool_desc;

#define STILB_JOB_MAX_CPUS 65536

/* worker_count is stilb_job_cpu_count() - 1, but at least 1 and at most STILB_JOB_MAX_WORKERS; queues are low-lock,
 * affinity is AUTO, there are no hooks, and memory comes from the C library. [any-thread] */
stilb_job_pool_desc stilb_job_pool_desc_default(void);

/* The number of CPUs this process may use: those of the affinity mask, but no more than the cgroup CPU quota, rounded
 * up; at least 1. [any-thread] */
uint32_t stilb_job_cpu_count(void);

/* What is wrong with the settings, as a sentence to print, for example "worker_count is more than
 * STILB_JOB_MAX_WORKERS"; NULL if they are in range. [any-thread] */
const char *stilb_job_pool_desc_error(const stilb_job_pool_desc *desc);

/* Starts the workers and stores the pool in *pool; the calling thread becomes its owner. desc and what it points to are
 * copied. -EINVAL: a setting is out of range, and stilb_job_pool_desc_error says which; -ENOMEM: no memory; -EAGAIN:
 * the system refused a thread or its stack. A nice value or CPU that the system refuses is no error, see
 * stilb_job_pool_worker_info. After an error no thread is left running and *pool is NULL. [any-thread] */
int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **pool);

/* Runs every submitted job and the jobs they submit, then stops and joins the workers and frees the pool. pool may be
 * NULL. No other call may be in progress, and the owner must not be inside a job. Never returns if a job waits for a
 * group that cannot finish. [owner-thread] */
void stilb_job_pool_destroy(stilb_job_pool *pool);

/* From now on, jobs that have not started are dropped: they count as finished without running, so waits return and
 * destroy ends soon. Jobs in a group are handed back through its function `dropped`, others are not. For shutting down
 * quickly: cancel, then destroy. Loops that have begun run to their end. A pool stays cancelled. [any-thread] */
void stilb_job_pool_cancel(stilb_job_pool *pool);

/* The number of threads beside the owner, 0..STILB_JOB_MAX_WORKERS. An array with an element for each thread needs one
 * element more. [any-thread] */
uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool);

/* What the system has granted to a worker. */
typedef struct stilb_job_worker_info {
	int32_t nice;       /* -20 (runs first) to 19, as the worker started */
	int nice_error;     /* 0, or why it is not the nice value asked for: -EACCES or -EPERM, no permission */
	int affinity_error; /* 0, or why it is not bound as asked for: -EINVAL, it may use none of these CPUs; -ENOMEM */
} stilb_job_worker_info;

/* What worker number `worker`, 1..worker_count, has been granted. Waits until it has started, some microseconds after
 * the pool was created. [any-thread] */
void stilb_job_pool_worker_info(stilb_job_pool *pool, uint32_t worker, stilb_job_worker_info *info);

/* What a thread of a pool has done since the pool was created. */
typedef struct stilb_job_thread_stats {
	uint64_t submitted;    /* jobs; an array is one, and the run of a graph one or a few */
	uint64_t jobs;         /* jobs that it has run to their end, or dropped because they were cancelled */
	uint64_t steals;       /* times that it has taken from the deque of another thread */
	uint64_t loops_helped; /* times that it has helped with a loop of another thread */
	uint64_t slices;       /* slices of loops that it has run, its own loops and others */
	uint64_t parks;        /* times that it has slept because it found nothing to do */
	uint64_t wakes;        /* times that it was chosen and woken for new work */
	uint64_t spin_ns;      /* time that it has looked for work before it slept, or instead */
	uint64_t deque;        /* entries of its deque at the moment; up to 256 jobs of stilb_job_submit_n are one entry */
} stilb_job_thread_stats;

/* The same of a whole pool. */
typedef struct stilb_job_pool_stats {
	stilb_job_thread_stats all; /* the sums over its threads; submitted: by threads outside the pool, too */
	uint64_t high, shared, low; /* entries at the moment: of high priority, from threads outside, of low priority */
} stilb_job_pool_stats;

/* Read the statistics at any time, also while jobs run, without disturbing them: nothing is locked, and what is counted
 * costs the threads nothing measurable. The counts grow independently of one another. Those of jobs, steals and slices
 * include all that has happened before a wait for it returned. worker: 0..worker_count. [any-thread] */
void stilb_job_pool_get_stats(stilb_job_pool *pool, stilb_job_pool_stats *stats);
void stilb_job_pool_get_thread_stats(stilb_job_pool *pool, uint32_t worker, stilb_job_thread_stats *stats);

/* Queues fn(data, worker) and counts it in group, which may be NULL; wakes a worker unless one is already looking for
 * work. worker is the caller's own index or STILB_JOB_OUTSIDE. data must stay valid until the job has run. -ENOMEM:
 * nothing was queued or counted. [any-thread] */
int stilb_job_submit(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group, uint32_t worker);

/* Submits count jobs: fn(data, worker), fn(data + stride bytes, worker), and so on, for example one for each element of
 * an array; stride 0: all get the same data. Cheaper than count calls of stilb_job_submit, and the jobs become visible
 * to other threads together. They start in any order. A count of 0 submits nothing. -ENOMEM: nothing was queued or
 * counted. [any-thread] */
int stilb_job_submit_n(stilb_job_pool *pool, stilb_job_fn *fn, void *data, size_t stride, uint32_t count,
                       stilb_job_group *group, uint32_t worker);

/* What stilb_job_submit_with may ask for. The default of every field is zero. */
typedef struct stilb_job_options {
	stilb_job_priority priority;
	bool pinned;     /* only thread number target runs the job; the owner does so in waits, loops and run_pinned */
	uint32_t target; /* 0..worker_count; ignored unless pinned */
	stilb_job_group *after; /* the job starts after this group has finished, which may have happened; NULL: at once */
} stilb_job_options;

/* stilb_job_submit with options. Among themselves, jobs of high priority start in the order of submission, and so do
 * jobs of low priority; pinned jobs have no priority. -EINVAL: priority or target is out of range, or after is group,
 * so the job would wait for itself; -ENOMEM: nothing was queued or counted. [any-thread] */
int stilb_job_submit_with(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group,
                          const stilb_job_options *options, uint32_t worker);

/* Submits the loop of stilb_job_parallel_for as one job of group and returns at once; the cost is that of one submit
 * for any count. context must stay valid until the loop has run. A count of 0 submits nothing. -ENOMEM: nothing was
 * queued or counted. [any-thread] */
int stilb_job_submit_array(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                           stilb_job_group *group, uint32_t worker);

/* Runs the jobs that are pinned to the calling thread at the moment of the call and returns their number. Waits, loops
 * and idle workers run pinned jobs by themselves; this call is for an owner that neither waits nor runs loops.
 * [pool-thread] */
uint32_t stilb_job_run_pinned(stilb_job_pool *pool, uint32_t worker);

/* Returns when every job of group has finished; everything these jobs wrote is then visible to the caller. Meanwhile
 * the calling thread runs other jobs (which ones: see Waiting at the head of this file) and sleeps when there are none;
 * a thread outside the pool only sleeps. [any-thread] */
void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker);

/* Until the group has finished, its jobs that have not started are dropped: they count as finished without running, and
 * group->dropped, if set, is called for each of them, on the thread that would have run it. So are jobs that are
 * submitted into the group meanwhile. Jobs that are running run to their end; they may ask
 * stilb_job_group_is_cancelled. Jobs `after` the group and jobs that its jobs have submitted into other groups are not
 * dropped. Does nothing if the group has no unfinished jobs. The group must be in use by the caller, which waits for it
 * later or is one of its jobs. [any-thread] */
void stilb_job_group_cancel(stilb_job_pool *pool, stilb_job_group *group);

/* True from stilb_job_group_cancel until the group has finished. [any-thread] */
bool stilb_job_group_is_cancelled(const stilb_job_group *group);

/* Calls fn for slices of grain indices that together cover 0 <= i < count, on the calling thread and on every worker
 * that is free or becomes free; returns when all slices have finished, and everything they wrote is then visible. grain
 * 0 means 1; the last slice may be shorter. Which thread runs which slice is not determined, and a slow slice delays no
 * other. May be nested. It needs neither memory nor helpers and so cannot fail. Sleeping workers are woken only for
 * loops that take longer than a wake-up. While the caller waits for slices that others have claimed, it helps with
 * loops nested deeper in this one and runs jobs pinned to its thread, but no other jobs. A thread outside the pool
 * sleeps while threads of the pool run all slices; in a pool without workers the owner does so in a wait.
 * It needs memory for one job, and tries again until it gets that. [any-thread] */
void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker);

/* Between phase_begin and phase_end workers without work spin, as many as there are CPUs beside the owner's, so that
 * new work starts within a fraction of a microsecond. Otherwise one worker spins for some 30 us, and then it sleeps,
 * too. Phases nest; every begin needs its end. [any-thread] */
void stilb_job_phase_begin(stilb_job_pool *pool);
void stilb_job_phase_end(stilb_job_pool *pool);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
