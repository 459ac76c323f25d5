/*
 * job_internal: the pool's layout and what its files share. Order of reading: job_queue, job_park, job_pool (threads,
 * submit), job_wait (groups, waiting), job_for (loops).
 *
 * Work comes in two kinds. Jobs lie in the queue. Loops (parallel-for) lie on their callers' stacks and hang in a list
 * while they have slices left to claim; a free thread joins one by counting itself into the loop's group under the list's lock,
 * and the caller leaves only when that group is empty, so nobody ever touches a loop that has gone.
 *
 * Who may help whom. A thread inside a slice of a loop with nesting level n helps only loops nested deeper than n: so a
 * stack holds at most one slice per level, however many loops there are. A loop's caller never needs help to
 * finish, so this cannot block. While the caller of a loop waits for its helpers it runs no jobs, which could be long.
 */
#ifndef STILB_JOB_INTERNAL_H
#define STILB_JOB_INTERNAL_H

#include "jobs/job.h"
#include "jobs/job_lock.h"
#include "jobs/job_park.h"
#include "jobs/job_queue.h"

#include <pthread.h>

typedef struct job_loop {
	stilb_job_range_fn *fn;
	void *context;
	uint32_t count;
	uint32_t grain;
	uint32_t slices;
	uint32_t level;          /* 1 for a loop that is in no other loop */
	bool listed;             /* guarded by loops_lock */
	struct job_loop *older;  /* guarded by loops_lock */
	stilb_job_group helpers; /* threads inside, without the caller */
	/* Claimed slices, and one more for each thread that found none left: 64 bits cannot overflow. Relaxed: claims are
	 * only counted here; data flows through the list's lock and the group. */
	alignas(JOB_LINE) _Atomic uint64_t claimed;
} job_loop;

/* What belongs to one thread; index 0 is the owner. */
typedef struct job_slot {
	alignas(JOB_LINE) job_parker parker;
	uint32_t level; /* of the innermost loop that this thread runs a slice of, else 0 */
	uint32_t turn;  /* workers look for jobs and loops first by turns, so neither kind starves the other */
	uint32_t index;
	stilb_job_pool *pool;
	pthread_t thread;
} job_slot;

struct stilb_job_pool {
	job_queue queue;
	job_idle_list idle;
	alignas(JOB_LINE) job_lock loops_lock;
	_Atomic(job_loop *) loops; /* newest first; written under loops_lock, read without it as a hint (relaxed) */
	alignas(JOB_LINE) _Atomic bool stop; /* release in destroy, pairs with acquire in the workers */
	uint32_t worker_count;
	stilb_job_hooks hooks;
	pthread_t owner;
	job_slot slot[]; /* worker_count + 1 */
};

/* job_pool.c */

/* Runs one job (if jobs is set), or helps one loop until it has no slices left or until has finished (may be NULL).
 * False if there was nothing to do. */
bool job_pool_help(stilb_job_pool *pool, uint32_t worker, bool jobs, stilb_job_group *until);

/* As job_pool_help, but looks for a few microseconds before it gives up; true also when until has finished. */
bool job_pool_seek(stilb_job_pool *pool, uint32_t worker, bool jobs, stilb_job_group *until);

/* Is there work that such a thread would take? Exact: work published before a thread entered the idle list is seen. */
bool job_pool_has_work(stilb_job_pool *pool, uint32_t level, bool jobs);

/* If work is left, wakes one thread for it: each thread that takes work calls it first, so a wake-up costs the submitter
 * at most one system call, and the threads wake one another as long as there is something to do. */
void job_pool_wake_next(stilb_job_pool *pool);

/* Sleeps until there is work for this thread or group has finished (NULL: until the pool stops). True if the thread
 * was chosen for some work: it then takes work or calls job_pool_wake_next. */
bool job_pool_park(stilb_job_pool *pool, uint32_t worker, stilb_job_group *group, bool jobs);

/* job_wait.c */

/* One more job to wait for. */
void job_group_add(stilb_job_group *group);

/* One job has finished: the last touch of the group, which may be gone a moment later. */
void job_group_finish(stilb_job_pool *pool, stilb_job_group *group);

/* True if every job has finished; then all that they wrote is visible. */
bool job_group_done(stilb_job_group *group);

/* Asks the last job to wake this thread; false if the group has finished already and nobody will. */
bool job_group_announce(stilb_job_group *group, uint32_t worker);

/* stilb_job_wait, with the choice to run jobs meanwhile or to help loops only. */
void job_group_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker, bool jobs);

/* job_for.c */

/* Joins a loop nested deeper than this thread's level, if there is one with slices left. */
bool job_loop_help(stilb_job_pool *pool, uint32_t worker, stilb_job_group *until);

/* The deepest level of a loop with slices left; 0 if there is none. Exact, as job_pool_has_work. */
uint32_t job_loop_deepest(stilb_job_pool *pool);

/* job_cpu.c */

/* CPUs granted by the cgroup quotas, rounded up; 0 if there is no limit. proc_cgroup lists this process's groups
 * (/proc/self/cgroup), mount is where the hierarchies are mounted (/sys/fs/cgroup). */
uint32_t job_cpu_quota(const char *proc_cgroup, const char *mount);

#endif
