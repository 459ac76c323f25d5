/*
 * job_internal: the pool's data and the functions that its files share. Read the files in this order: job_record,
 * job_deque, job_park (the parts), job_submit (where a job goes), job_work (what a thread does next), job_wait (groups
 * and waiting), job_for (loops), job_pool (threads and life cycle).
 *
 * Places of work.  Jobs of normal priority lie in the deque of the thread that submitted them; others, and jobs from
 *                  outside threads, in one of three shared FIFO queues; jobs pinned to a thread in its inbox; jobs that
 *                  wait for a group in that group's list. A parallel loop lies in its caller's slot, where any thread
 *                  may claim slices of it.
 * Root and level.  Every job and loop has a level, one more than that of the job or slice that created it, and a root:
 *                  the root of its creator or, if no job created it, its group (a loop: itself). All work done on
 *                  behalf of one group of a frame has the same root.
 * Permissions.     A worker without work does any work. A thread that waits for a group does jobs and loops of its own
 *                  root at a deeper level than its own. So a wait runs no unrelated work, and a stack holds at most one
 *                  job or slice of each level. Beyond that it runs jobs of high priority and jobs pinned to it. A
 *                  thread that waits for the last slices of a loop does deeper loops of its root and jobs pinned to it.
 * No deadlock.     Work that a waiting thread may not do is done by a worker that does not wait. If every worker waits,
 *                  the waiting threads may do any work (job_park.h calls that rescue). The caller of a loop needs no
 *                  help.
 */
#ifndef STILB_JOB_INTERNAL_H
#define STILB_JOB_INTERNAL_H

#include "jobs/job_contract.h"
#include "jobs/job_deque.h"
#include "jobs/job_park.h"
#include "jobs/job_queue_internal.h"
#include "jobs/job_record.h"

#include <pthread.h>

/* The most nested loops that one thread has open at a time; further ones inside them run on the caller alone. */
#ifndef JOB_LOOP_DEPTH
#define JOB_LOOP_DEPTH 4
#endif

/* The most outside threads inside a submit at the same moment; further ones wait for their turn. */
#ifndef JOB_GUESTS
#define JOB_GUESTS 32
#endif

/* The cost of a wake-up and the sleep before it: the kernel's share on both sides, measured as 22 + 7 us. A worker
 * looks for work this long before it sleeps, and a loop shorter than this wakes nobody. */
#define JOB_WAKE_NS 30000u

/* The last worker to go to sleep watches for loops: it sleeps in naps and looks for open loops in between. So a loop
 * that its caller runs alone, because loops of this function were short, gets help if it turns out long. The first nap
 * takes JOB_WATCH_NAP_NS, each later one half as long as all before together: help comes at the latest after half the
 * time for which the workers have slept before the loop, or after the first nap. The watch ends after JOB_WATCH_NS, so
 * that idle pools cost nothing. The next loop then wakes a worker, whatever its length. */
#define JOB_WATCH_NAP_NS 2000000u
#ifndef JOB_WATCH_NS
#define JOB_WATCH_NS 32000000u
#endif

/* The cost of a steal to its victim, one more cache line to fetch; and the time for which a thief stays away after a
 * steal that was not worth that. */
#define JOB_STEAL_NS 100u
#define JOB_STEAL_PAUSE_NS 2000u

/* Functions whose slice times a thread remembers. */
#ifndef JOB_RATES
#define JOB_RATES 16
#endif

/* A parallel loop. Loops are never freed, only reused, so threads may look at them at any time. The fields that a
 * thread has read are valid if its exchange of claim succeeds, because that compares the generation. They are relaxed:
 * they are written before claim is released, and not again until all slices are done. */
typedef struct job_loop {
	/* generation << 32 | slices left to claim; release in loop_open, pairs with acquire in loop_claim. */
	alignas(JOB_LINE) _Atomic uint64_t claim;
	_Atomic(stilb_job_range_fn *) fn;
	_Atomic(void *) context;
	_Atomic uintptr_t root;
	_Atomic uint32_t level;
	_Atomic uint32_t count;
	_Atomic uint32_t grain;
	_Atomic uint32_t slices;
	_Atomic uint32_t wake_slices; /* a wake-up pays if at least this many slices are left */
	_Atomic uint32_t claim_limit; /* the most slices of one claim */
	/* The submit hook's result. Plain: threads that have claimed slices read it, and it is not written before those are
	 * done. */
	uint64_t tag;
	/* Slices that helpers have finished since the pool was created, and JOB_LOOP_WAITER if the caller sleeps until they
	 * are done. Opening a loop does not reset it: the store to claim would have to wait for this cache line. Release by
	 * helpers, pairs with the caller's acquire. */
	alignas(JOB_LINE) _Atomic uint64_t done;
	/* The value of done at which the loop has finished; the caller's own. */
	alignas(JOB_LINE) uint64_t finished;
} job_loop;

#define JOB_LOOP_WAITER ((uint64_t)1 << 63)

/* The duration of one slice of fn, in ticks, as measured the last time. */
typedef struct job_rate {
	stilb_job_range_fn *fn;
	uint64_t ticks; /* 0: not known */
} job_rate;

/* A thread of the pool. */
typedef struct job_slot {
	job_deque deque;
	alignas(JOB_LINE) _Atomic(job_record *) inbox; /* newest first; release by the submitter, acquire by this thread */
	job_loop loop[JOB_LOOP_DEPTH];
	alignas(JOB_LINE) job_parker parker;
	/* From here on only this thread writes. The fields that every loop and job needs come first, on one cache line. */
	alignas(JOB_LINE) stilb_job_pool *pool;
	uintptr_t root; /* of the job or slice in progress, 0 outside of one */
	uint32_t level; /* of the same, 0 outside of one */
	uint32_t index;
	uint32_t loops_open;
	uint32_t poll_round;          /* counts looks for work, see SHARED_FIRST */
	uint32_t loops_run;           /* counts loops, see MEASURE_EVERY */
	uint64_t alone_ticks;         /* total of the latest loops in a row that began alone (job_for.c) */
	uint64_t alone_until;         /* the end of the last of them */
	uint32_t spins_without_yield; /* spins left in which job_work_relax does not yield */
	uint32_t victim;              /* the thread to try first when stealing */
	bool in_high;                 /* inside a job of high priority: waits run no others */
	bool spinning;                /* counted as a spinner (job_park.h) */
	bool steal_unprofitable;      /* the last stolen job took less time than its steal cost the victim */
	job_rate rate[JOB_RATES];
	job_record *pinned; /* taken from the inbox, oldest first */
	job_record_cache records;
	_Atomic uint64_t submitted, finished; /* jobs, by this thread; see pool_is_quiet */
	uint32_t cpu;                         /* the CPU to bind the thread to, or NO_CPU */
	pthread_t thread;
	_Atomic uintptr_t self; /* job_this_thread of this thread; written in builds with asserts alone */
} job_slot;

/* An outside thread during a submit. */
typedef struct job_guest {
	alignas(JOB_LINE) job_record_cache records;
	_Atomic uint64_t submitted;
} job_guest;

/* An outside thread during a wait; on its own stack. */
typedef struct job_visitor {
	job_parker parker;
	struct job_visitor *next; /* guarded by visitors_lock */
} job_visitor;

/* Adds one to a counter that only the calling thread writes. */
static inline void job_count(_Atomic uint64_t *counter)
{
	/* Release pairs with pool_is_quiet: a thread that sees a job finished sees all that the job has submitted. */
	atomic_store_explicit(counter, atomic_load_explicit(counter, memory_order_relaxed) + 1, memory_order_release);
}

enum { JOB_SHARED_HIGH, JOB_SHARED_NORMAL, JOB_SHARED_LOW, JOB_SHARED_COUNT };

struct stilb_job_pool {
	/* Read by every call, and constant. */
	alignas(JOB_LINE) uint32_t worker_count;
	uint32_t cpus;
	bool oversubscribed;  /* there are more threads than CPUs */
	uint64_t wake_ticks;  /* JOB_WAKE_NS */
	uint64_t steal_ticks; /* JOB_STEAL_NS */
	stilb_job_queue *shared[JOB_SHARED_COUNT];
	stilb_job_hooks hooks;
	job_idle_list idle;
	job_record_store records;
	/* Jobs in each shared queue, or a few more; relaxed, saves looking into empty queues. */
	alignas(JOB_LINE) _Atomic uint32_t shared_hint[JOB_SHARED_COUNT];
	alignas(JOB_LINE) _Atomic uint32_t phase; /* open phases; relaxed, a hint to spinners */
	/* 1 while a worker watches for loops. Changed and read by acquire-release exchanges alone, see job_work_watched. */
	_Atomic uint32_t watched;
	_Atomic bool stop;                     /* release in destroy, pairs with acquire in the workers */
	_Atomic bool cancelled;                /* relaxed: jobs that start at that moment may or may not run */
	alignas(JOB_LINE) job_lock after_lock; /* guards the followers of all groups */
	alignas(JOB_LINE) job_lock visitors_lock;
	job_visitor *visitors;
	alignas(JOB_LINE) _Atomic uint32_t guests; /* a bit for each guest in use; acquire to claim, release to give back */
	job_guest guest[JOB_GUESTS];
	job_slot slot[]; /* worker_count + 1; slot[0] is the owner's */
};

/* The calling thread is this slot's from now on, for asserts. */
static inline void job_slot_set_mine(job_slot *slot)
{
#ifndef NDEBUG
	atomic_store_explicit(&slot->self, job_this_thread(), memory_order_relaxed); /* see job_slot_is_mine */
#else
	(void)slot;
#endif
}

/* For asserts: the slot is the calling thread's, or nobody keeps whose it is. */
static inline bool job_slot_is_mine(job_slot *slot)
{
#ifndef NDEBUG
	/* Relaxed: only the calling thread stores its own number, and it reads its own stores in order. */
	return atomic_load_explicit(&slot->self, memory_order_relaxed) == job_this_thread();
#else
	(void)slot;
	return true;
#endif
}

/* For asserts: the calling thread is none of the pool's, or nobody keeps which those are. */
static inline bool job_pool_is_outside(stilb_job_pool *pool)
{
#ifndef NDEBUG
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		if (job_slot_is_mine(&pool->slot[i]))
			return false;
#else
	(void)pool;
#endif
	return true;
}

/* The slot of the calling thread, which says that its index is worker. */
static inline job_slot *job_slot_of(stilb_job_pool *pool, uint32_t worker)
{
	assert(pool);
	assert(worker <= pool->worker_count && "the index of a thread of the pool");
	assert(job_slot_is_mine(&pool->slot[worker]) && "the calling thread's own index");
	return &pool->slot[worker];
}

/* wait_begin and wait_end of the hooks. */
static inline void job_hook_wait_begin(const stilb_job_pool *pool, uint32_t worker)
{
	if (pool->hooks.wait_begin)
		pool->hooks.wait_begin(pool->hooks.user, worker);
}

static inline void job_hook_wait_end(const stilb_job_pool *pool, uint32_t worker)
{
	if (pool->hooks.wait_end)
		pool->hooks.wait_end(pool->hooks.user, worker);
}

/* job_pool.c: stilb_job_pool_create with shared queues that `make` creates, for tests and benchmarks. */
typedef stilb_job_queue *job_queue_maker(void);
int job_pool_create_over(const stilb_job_pool_desc *desc, job_queue_maker *make, stilb_job_pool **pool);

/* job_submit.c */

/* Puts a complete record where it belongs and wakes a thread for it if necessary. slot is the caller's. Cannot fail. */
void job_submit_record(job_slot *slot, job_record *record);

/* Reserves a guest for the calling outside thread until job_guest_leave, and returns its number. */
uint32_t job_guest_enter(stilb_job_pool *pool);
void job_guest_leave(stilb_job_pool *pool, uint32_t guest);

/* job_work.c: slot is the calling thread's. */

/* Does some work of the scope: some jobs, or slices of one loop. False if there is none. Returns early once `until`,
 * which may be NULL, has finished. */
bool job_work_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Does one job, whichever it is, because every worker waits; false if there is none. The shared queues come first,
 * since no waiting thread takes from them. */
bool job_work_rescue(job_slot *slot);

/* Spins for JOB_WAKE_NS, and a worker in a phase until the phase ends. True as soon as there seems to be work of the
 * scope or `until`, which may be NULL, has finished. */
bool job_work_spin(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* True if there is work of the scope. Exact: sees everything that was published before the call. */
bool job_work_exists(job_slot *slot, const job_scope *scope);

/* One round of a spin outside of locks: pauses or yields. */
void job_work_relax(job_slot *slot);

/* The thread, if it is a spinner, is none any more. */
void job_work_spin_stop(job_slot *slot);

/* True if a worker watches for loops, and finds every loop opened before the call, unless that ends before. */
bool job_work_watched(stilb_job_pool *pool);

/* Wakes a thread if there is more work and none looks for it. `work` is what the caller has just found. */
void job_work_wake_next(job_slot *slot, const job_work *work);

/* Sleeps until there is work of the scope or a token for the slot's thread. Does not sleep if ready(slot, context) is
 * true, which is called after the thread has entered the idle list. */
typedef bool job_ready_fn(job_slot *slot, void *context);
job_idle_outcome job_work_park(job_slot *slot, const job_scope *scope, job_ready_fn *ready, void *context);

extern const job_scope job_scope_all;

/* job_wait.c */

void job_group_add(stilb_job_group *group, uint32_t jobs);

/* Subtracts jobs that have finished. The group may be gone when this returns. */
void job_group_finish(job_slot *slot, stilb_job_group *group, uint32_t jobs);

/* True if every job has finished; then everything they wrote is visible. */
bool job_group_done(stilb_job_group *group);

/* A hint, relaxed: true if at most this many jobs have not finished. */
bool job_group_done_but(stilb_job_group *group, uint32_t jobs);

/* Makes record a follower of group, to start when it has finished. False if it has finished already: then the caller
 * must submit the record. */
bool job_group_follow(stilb_job_pool *pool, stilb_job_group *group, job_record *record);

/* job_for.c */

/* Claims and runs slices of one loop of the scope; false if there is none. */
bool job_loop_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* A hint, relaxed: true if there is such a loop. Loops finish without help, so a miss delays but never blocks. */
bool job_loop_exists(stilb_job_pool *pool, const job_scope *scope);

/* job_cpu.c */

/* The CPUs granted by the cgroup quotas, rounded up; 0 if there is no limit. proc_cgroup is the file that lists this
 * process's groups (/proc/self/cgroup), mount the folder where the hierarchies are mounted (/sys/fs/cgroup). */
uint32_t job_cpu_quota(const char *proc_cgroup, const char *mount);

/* Stores up to max CPUs of the affinity mask in cpus, beginning after the CPU that the calling thread runs on, which is
 * left out. Returns their number, 0 if the kernel does not say. max: at least 1. */
uint32_t job_cpu_others(uint32_t *cpus, uint32_t max);

#endif
