/*
 * job_internal: the pool's layout and what its files share. Order of reading: job_record, job_deque, job_park (the parts),
 * job_submit (where a job goes), job_work (what a thread does next), job_wait (groups, waiting), job_for (loops),
 * job_pool (threads, life cycle).
 *
 * Where work is.   Jobs of normal priority lie in the deque of the thread that submitted them; others, and those from
 *                  outside, in one of three shared FIFO queues; jobs pinned to a thread in its inbox; jobs that wait
 *                  for a group hang on that group. Loops (parallel-for) lie in their caller's slot, open for all to claim
 *                  slices of.
 * What belongs     Every job and loop has a level, one more than that of the job or slice it came from, and a root: the
 * together.        root of what it came from or, if it came from no job, its group (a loop: itself). All that happens on
 *                  behalf of one group of a frame has one root.
 * Who may do what. A worker without work does anything. A thread that waits for a group does jobs and loops of its own root
 *                  that are nested deeper than what it is in the middle of, so no wait runs unrelated work and a stack
 *                  holds at most one job or slice per level; beyond that only high priority and what is pinned to it.
 *                  A thread that waits for the last slices of a loop does deeper loops of its root and what is pinned to it.
 * No deadlock.     Work that a waiter may not touch is done by a worker that does not wait; if every worker waits, the
 *                  waiters may do anything (job_park.h calls that rescue). The caller of a loop never needs help.
 */
#ifndef STILB_JOB_INTERNAL_H
#define STILB_JOB_INTERNAL_H

#include "jobs/job_deque.h"
#include "jobs/job_park.h"
#include "jobs/job_queue_internal.h"
#include "jobs/job_record.h"

#include <pthread.h>

/* Loops that one thread has open at the same time, one in a slice of the other; the next ones inside run alone. */
#ifndef JOB_LOOP_DEPTH
#define JOB_LOOP_DEPTH 4
#endif

/* Threads from outside that can be in a submit at the same moment; more wait for their turn. */
#ifndef JOB_GUESTS
#define JOB_GUESTS 32
#endif

/* A wake-up and the sleep before it cost about this much (the kernel's share of both sides, measured: 22 + 7 us). So a worker
 * looks for work this long before it sleeps, and a loop shorter than this wakes nobody. */
#define JOB_WAKE_NS 30000u

/* What a steal costs the victim: one cache line more to fetch. And how long a thief stays away from one that is not worth it. */
#define JOB_STEAL_NS 100u
#define JOB_STEAL_REST_NS 2000u

#ifndef JOB_RATES
#define JOB_RATES 16
#endif

/* A loop is never freed, only used again, so threads may look at it at any time; what they read counts only if their exchange
 * of claim succeeds, for that compares the generation. The fields are relaxed: they are written before claim is released and
 * not again before all slices are done. */
typedef struct job_loop {
	/* generation << 32 | slices left to claim; release in open, pairs with acquire of who claims */
	alignas(JOB_LINE) _Atomic uint64_t claim;
	_Atomic(stilb_job_range_fn *) fn;
	_Atomic(void *) context;
	_Atomic uintptr_t root;
	_Atomic uint32_t level;
	_Atomic uint32_t count;
	_Atomic uint32_t grain;
	_Atomic uint32_t slices;
	_Atomic uint32_t worth; /* who joins wakes another thread only if this many slices are left */
	_Atomic uint32_t most;  /* slices to be claimed at once */
	/* What the submit hook gave. Plain: who has claimed slices reads it, and until those are done it is not written again. */
	uint64_t tag;
	/* Slices that helpers have finished since the pool was made, and JOB_LOOP_WAITER if the caller sleeps for them. Not reset
	 * by who opens a loop: that would hold up the store to claim until this line has come over. Release by helpers, pairs
	 * with the caller's acquire. */
	alignas(JOB_LINE) _Atomic uint64_t done;
	/* The caller's own: what done must come to. */
	alignas(JOB_LINE) uint64_t finished;
} job_loop;

#define JOB_LOOP_WAITER ((uint64_t)1 << 63)

/* How long a slice of some function took last time. */
typedef struct job_rate {
	stilb_job_range_fn *fn;
	uint64_t ticks; /* per slice */
} job_rate;

/* What belongs to one thread of the pool; index 0 is the owner. */
typedef struct job_slot {
	job_deque deque;
	alignas(JOB_LINE) _Atomic(job_record *) inbox; /* newest first; release by who pushes, acquire by its thread */
	job_loop loop[JOB_LOOP_DEPTH];
	alignas(JOB_LINE) job_parker parker;
	/* From here on the thread's own; first what every loop and job needs, in one line. */
	alignas(JOB_LINE) stilb_job_pool *pool;
	uintptr_t root; /* of the job or slice that it is in the middle of, 0 if none */
	uint32_t level; /* of that, 0 if none */
	uint32_t index;
	uint32_t loops_open;
	uint32_t turn, loops_run;    /* for what happens every so many times */
	uint64_t alone, alone_until; /* ticks spent in a row in short loops without help, and when the last one ended */
	uint32_t no_yield;           /* turns of spins that do not yield */
	uint32_t victim;             /* where it begins to look for something to steal */
	bool in_high;                /* in the middle of a job of high priority: its waits run no more of them */
	bool spinning;               /* counted as a spinner */
	bool meagre;                 /* the last job that it stole was not worth it */
	job_rate rate[JOB_RATES];
	job_record *pinned; /* taken from the inbox, oldest first */
	job_record_cache records;
	_Atomic uint64_t submitted, finished; /* jobs, by this thread; see pool_quiet */
	uint32_t cpu;                         /* to be bound to, or NO_CPU */
	pthread_t thread;
} job_slot;

/* A thread from outside, while it submits. */
typedef struct job_guest {
	alignas(JOB_LINE) job_record_cache records;
	_Atomic uint64_t submitted;
} job_guest;

/* A thread from outside, while it waits; on its own stack. */
typedef struct job_visitor {
	job_parker parker;
	struct job_visitor *next; /* guarded by visitors_lock */
} job_visitor;

/* One more, on a counter that only the calling thread writes. */
static inline void job_count(_Atomic uint64_t *counter)
{
	/* Release pairs with pool_quiet: who sees a job finished sees what it has submitted. */
	atomic_store_explicit(counter, atomic_load_explicit(counter, memory_order_relaxed) + 1, memory_order_release);
}

enum { JOB_SHARED_HIGH, JOB_SHARED_NORMAL, JOB_SHARED_LOW, JOB_SHARED_COUNT };

struct stilb_job_pool {
	/* Read only: what every call looks at. */
	alignas(JOB_LINE) uint32_t worker_count;
	uint32_t cpus;
	bool crowded;         /* more threads than CPUs */
	uint64_t wake_ticks;  /* JOB_WAKE_NS */
	uint64_t steal_ticks; /* JOB_STEAL_NS */
	stilb_job_queue *shared[JOB_SHARED_COUNT];
	stilb_job_hooks hooks;
	pthread_t owner;
	job_idle_list idle;
	job_record_store records;
	/* About how many jobs each shared queue holds; relaxed, saves a look into an empty queue. */
	alignas(JOB_LINE) _Atomic uint32_t shared_hint[JOB_SHARED_COUNT];
	alignas(JOB_LINE) _Atomic uint32_t phase; /* open phases; relaxed, a hint to spinners */
	_Atomic bool stop;                        /* release in destroy, pairs with acquire in the workers */
	_Atomic bool cancelled;                   /* relaxed: jobs that start at that moment may or may not run */
	alignas(JOB_LINE) job_lock after_lock;    /* guards the lists of all groups */
	alignas(JOB_LINE) job_lock visitors_lock;
	job_visitor *visitors;
	alignas(JOB_LINE) _Atomic uint32_t guests; /* bit per guest in use; acquire to claim, release to give back */
	job_guest guest[JOB_GUESTS];
	job_slot slot[]; /* worker_count + 1 */
};

/* Around what a waiting thread does when there is nothing to help with. */
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

/* job_pool.c: the public create over queues of the caller's making (tests and benchmarks put others under the pool). */
typedef stilb_job_queue *job_queue_maker(void);
int job_pool_create_over(const stilb_job_pool_desc *desc, job_queue_maker *make, stilb_job_pool **pool);

/* job_submit.c */

/* Puts a record that is ready where it belongs and wakes a thread for it if need be. slot is the caller's. Cannot fail. */
void job_submit_record(job_slot *slot, job_record *record);

/* A number for a thread from outside, for the length of a call. */
uint32_t job_guest_enter(stilb_job_pool *pool);
void job_guest_leave(stilb_job_pool *pool, uint32_t guest);

/* job_work.c */

/* Does something that the scope allows: some jobs, or slices of one loop. False if there was nothing. Ends early when until
 * (may be NULL) has finished. */
bool job_work_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Does one job, whatever it is, because nobody else would; false if there is none. First those that no waiting thread takes,
 * for one of them is what the others wait for. */
bool job_work_rescue(job_slot *slot);

/* Looks for a wake-up's length whether there may be work in this scope, or until (may be NULL) has finished: true then. A spinner
 * in a phase looks until the phase ends. */
bool job_work_linger(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Is there anything that the scope allows? Exact: sees what was published before the call. */
bool job_work_exists(job_slot *slot, const job_scope *scope);

/* One turn of a spin outside of locks. */
void job_work_relax(job_slot *slot);

/* This thread, if it was a spinner, is none any more. */
void job_work_spin_stop(job_slot *slot);

/* Is there more to do, and a thread to be woken for it? work says what kind this thread has just come across. */
void job_work_pass(job_slot *slot, const job_work *work);

/* Sleeps until there is work in this scope or somebody leaves the slot's thread a token. Does not sleep if ready(slot,
 * context) says so; it is asked after the thread has become visible as an idler. */
typedef bool job_ready_fn(job_slot *slot, void *context);
job_idle_fate job_work_park(job_slot *slot, const job_scope *scope, job_ready_fn *ready, void *context);

extern const job_scope job_scope_all;

/* job_wait.c */

void job_group_add(stilb_job_group *group, uint32_t jobs);

/* So many jobs have finished: the last touch of the group, which may be gone a moment later. */
void job_group_finish(job_slot *slot, stilb_job_group *group, uint32_t jobs);

/* True if every job has finished; then all that they wrote is visible. */
bool job_group_done(stilb_job_group *group);

/* True if all but so many have finished. A guess. */
bool job_group_done_but(stilb_job_group *group, uint32_t jobs);

/* Hangs record on group; false if the group has finished: then the record is ready. */
bool job_group_follow(stilb_job_pool *pool, stilb_job_group *group, job_record *record);

/* job_for.c */

/* Claims and runs slices of one loop that the scope allows; false if there is none. */
bool job_loop_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Is there such a loop? A relaxed look: loops get done without help. */
bool job_loop_exists(stilb_job_pool *pool, const job_scope *scope);

/* job_cpu.c */

/* CPUs granted by the cgroup quotas, rounded up; 0 if there is no limit. proc_cgroup lists this process's groups
 * (/proc/self/cgroup), mount is where the hierarchies are mounted (/sys/fs/cgroup). */
uint32_t job_cpu_quota(const char *proc_cgroup, const char *mount);

/* Up to max CPUs of the affinity mask beginning after the one this thread runs on, which is left out; how many. */
uint32_t job_cpu_others(uint32_t *cpus, uint32_t max);

#endif
