/*
 * job_internal: the pool's data and the functions that its files share. Read the files in this order: job_record,
 * job_deque, job_park (the parts), job_submit (where a job goes), job_work (what a thread does next), job_wait (groups
 * and waiting), job_for (loops), job_graph (graphs), job_worker (what a thread is given), job_pool (life cycle).
 *
 * Places of work.  Jobs of normal priority lie in the deque of the thread that submitted them; jobs from outside
 *                  threads and jobs of high priority in one of two shared FIFO queues; jobs of low priority in a list;
 *                  jobs pinned to a thread in its inbox; jobs that wait for a group in that group's list. A parallel
 *                  loop lies in its caller's slot, where any thread may claim slices of it; in a pool of many threads
 *                  a loop of many slices lies in parts, one for each team of threads that share a cache (job_team).
 * Root and level.  Every job and loop has a level, one more than that of the job or slice that created it, and a root:
 *                  the root of its creator or, if no job created it, its group (a loop: itself). All work done on
 *                  behalf of one group of a frame has the same root.
 * Permissions.     A worker without work does any work. A thread that waits for a group does jobs and loops of its own
 *                  root at a deeper level than its own. So a wait runs no unrelated work, and a stack holds at most one
 *                  job or slice of each level. Beyond that it runs jobs of high priority and jobs pinned to it. A
 *                  thread that waits for the last slices of a loop does deeper loops of its root and jobs pinned to it.
 * Buried jobs.     Deques give and take at their ends, but a job that a waiting thread may run can lie in the middle,
 *                  below or above unrelated ones. Before it sleeps, the thread digs such jobs out of its own deque
 *                  (job_deque_dig), takes them out of the list of low priority, and out of other deques by moving the
 *                  older jobs there to its own. So a wait sleeps only while all jobs of its root that it may run have
 *                  started.
 * No deadlock.     Work that a waiting thread may not do is done by a worker that does not wait. If every worker waits,
 *                  the waiting threads may do any work (job_park.h calls that rescue). The caller of a loop needs no
 *                  help.
 */
#ifndef STILB_JOB_INTERNAL_H
#define STILB_JOB_INTERNAL_H

#include "jobs/job_contract.h"
#include "jobs/job_deque.h"
#include "jobs/job_park.h"
#include "jobs/job_record.h"
#include "jobs/queue/job_queue_internal.h"

#include <pthread.h>

/* The most jobs in a row from one deque before the thread looks elsewhere. */
#ifndef JOBS_IN_A_ROW
#define JOBS_IN_A_ROW 16
#endif

/* The most jobs of a batch (stilb_job_submit_n) in one record; fewer if there were less than JOB_BATCH_SHARES records
 * for each thread of the pool otherwise. */
#ifndef JOB_BATCH_JOBS
#define JOB_BATCH_JOBS 256
#endif
#ifndef JOB_BATCH_SHARES
#define JOB_BATCH_SHARES 4
#endif

/* The most nested loops that one thread has open at a time; further ones inside them run on the caller alone. */
#ifndef JOB_LOOP_DEPTH
#define JOB_LOOP_DEPTH 4
#endif

/* The most threads from outside the pool that can be inside a submit at the same moment; further ones wait. */
#ifndef JOB_GUESTS
#define JOB_GUESTS 32
#endif

/* The CPU time that a sleep and the wake-up from it cost, measured: 22 us for the thread that sleeps and 7 us for the
 * one that wakes it. A worker looks for work this long before it sleeps, and a loop shorter than this wakes nobody. */
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
 * steal of a job that was shorter than that. It doubles with each such steal, JOB_STEAL_DOUBLINGS times at most, if the
 * victim has worked at its deque meanwhile, so that many thieves of tiny jobs cost their owner little; more for each
 * eight teams of the pool. A victim that has not worked loses nothing by a steal. */
#define JOB_STEAL_NS 100u
#define JOB_STEAL_PAUSE_NS 2000u
#define JOB_STEAL_DOUBLINGS 4

/* In a pool of several teams, a thread that has stolen a job wakes up to JOB_WAKE_FAN others for the jobs left in that
 * deque, but only while there are at most JOB_THIEVES spinners, and two jobs for each spinner and for the thread to be
 * woken: all of them may be on their way to that deque. More would only wait for one another, at the lock of the idle
 * list and at the end of the deque. */
#define JOB_THIEVES 4

/* A pool of so many threads or fewer is one team, and its threads look for work at one another without further ado.
 * Larger pools are cut into teams of at most JOB_TEAM_MOST threads whose CPUs share their last level of cache, and
 * remember which threads may have work (stilb_job_pool.active). A team has at least JOB_TEAM_LEAST threads, even if
 * fewer CPUs share a cache; the last one may have fewer. */
#ifndef JOB_TEAM_MOST
#define JOB_TEAM_MOST 8
#endif
#define JOB_TEAM_LEAST ((JOB_TEAM_MOST + 1) / 2)

/* So many teams report the end of their parts of a loop in one place, see job_team. */
#ifndef JOB_GATHER
#define JOB_GATHER 4
#endif

/* A thread looks for loops in its own team, and in others only once in so many looks, about 4 us, times the number of
 * other teams: so the threads of all others together look at a team's loops once or twice a microsecond, whatever
 * their number. A loop of few slices is best left to its team, because all threads that look at it fetch its cache line
 * after each claim. */
#define JOB_NEAR_LOOKS 64

/* The number of loop functions of which a thread remembers how long a slice takes (job_slot.rate). */
#ifndef JOB_RATES
#define JOB_RATES 16
#endif

/* A parallel loop. Loops are never freed, only reused, so threads may look at them at any time. `claim` contains a
 * generation, which counts the uses: the fields that a thread has read are valid if its compare-exchange of claim then
 * succeeds. They are relaxed: they are written before claim is released, and not again until all slices are done. */
typedef struct job_loop {
	/* generation << 32 | slices left to claim; release in loop_open, pairs with acquire in loop_claim. */
	alignas(JOB_LINE) _Atomic uint64_t claim;
	_Atomic(stilb_job_range_fn *) fn;
	_Atomic(void *) context;
	_Atomic uintptr_t root;
	_Atomic uint32_t level;
	_Atomic uint32_t count;
	_Atomic uint32_t grain;
	_Atomic uint32_t slices;      /* of a part of a wide loop (job_team): up to the last one of this part */
	_Atomic uint32_t wake_slices; /* a wake-up pays if at least this many slices are left */
	_Atomic uint32_t claim_limit; /* the most slices of one claim */
	_Atomic uint32_t owner;       /* the thread that has opened it */
	_Atomic uint32_t goal;        /* of a part of a wide loop: done, as 32 bits, when all its slices are done */
	/* The submit hook's result. Not atomic: only threads that have claimed slices read it, and it is not written again
	 * until these slices are done. */
	uint64_t tag;
	/* Slices that helpers (of a part of a wide loop: all threads) have finished since the pool was created, and
	 * JOB_LOOP_WAITER if the caller sleeps until they are done. Opening a loop does not reset it: the store to claim
	 * would have to wait for this cache line. Release by helpers, pairs with the caller's acquire. */
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

/* Threads that share a cache. A loop of many slices is cut into a part for each team, which is a loop of its own: so
 * threads of different teams do not claim from the same cache line. One such wide loop is open at a time. Its caller
 * waits for one team in JOB_GATHER: the thread that finishes the last slice of another part adds one to the `done` of
 * the team before whose number is a multiple of JOB_GATHER. */
typedef struct job_team {
	job_loop part;
	alignas(JOB_LINE) uint32_t begin, end; /* its threads: begin <= index < end */
} job_team;

/* What thread i may have if its bit is set in stilb_job_pool.active: an open loop, jobs in its deque. */
typedef enum job_active_kind { JOB_ACTIVE_LOOPS, JOB_ACTIVE_JOBS, JOB_ACTIVE_KINDS } job_active_kind;
#define JOB_ACTIVE_WORDS ((STILB_JOB_MAX_WORKERS + 1 + 63) / 64)

/* What a thread has done, see stilb_job_thread_stats. Only this thread writes them. */
typedef struct job_tallies {
	_Atomic uint64_t steals, loops_helped, slices, parks, wakes, spin_ticks;
} job_tallies;

/* A thread of the pool. */
typedef struct job_slot {
	job_deque deque;
	/* Jobs pinned to this thread, newest first. Release by the submitter, pairs with the acquire by this thread. */
	alignas(JOB_LINE) _Atomic(job_record *) inbox;
	job_loop loop[JOB_LOOP_DEPTH];
	alignas(JOB_LINE) job_parker parker;
	/* From here on only this thread writes. The fields that every loop and job needs come first, on one cache line. */
	alignas(JOB_LINE) stilb_job_pool *pool;
	uintptr_t root; /* of the job or slice in progress, 0 outside of one */
	uint32_t level; /* of that job or slice, 0 outside of one */
	uint32_t index;
	uint32_t loops_open;
	uint32_t poll_round;           /* counts looks for work, see SHARED_FIRST in job_work.c */
	uint32_t loops_run;            /* counts loops, see MEASURE_EVERY in job_for.c */
	bool active[JOB_ACTIVE_KINDS]; /* its bits in stilb_job_pool.active; always true if the pool is one team */
	uint64_t alone_ticks;          /* time in the latest loops that began without help, see loop_starts_alone */
	uint64_t alone_until;          /* the time at which the last of these loops ended */
	uint32_t spins_without_yield;  /* spins left in which job_work_relax does not yield */
	uint32_t victim;               /* the thread to try first when stealing */
	bool in_high;                  /* inside a job of high priority: waits run no others */
	bool spinning;                 /* counted as a spinner (job_park.h) */
	bool steal_unprofitable;       /* the last stolen job took less time than its steal cost the victim */
	uint8_t steal_doublings;       /* of the pause after such a steal */
	job_rate rate[JOB_RATES];
	int64_t victim_bottom; /* the end of the victim's deque at the last such pause */
	job_record *pinned;    /* taken from the inbox, oldest first */
	job_record_cache records;
	_Atomic uint64_t submitted, finished; /* counts of jobs, by this thread; see pool_is_quiet */
	job_tallies tally;
	uint32_t cpu;        /* the CPU to bind the thread to, or JOB_NO_CPU */
	job_team *team;      /* NULL if the pool is one team */
	uint32_t near_looks; /* looks for loops in its own team since one in others, see JOB_NEAR_LOOKS */
	bool look_far;       /* the next one goes to all teams */
	uint32_t random;     /* the state of job_random_below */
	pthread_t thread;
	stilb_job_worker_info info;
	_Atomic bool started;   /* info is complete; release in job_worker_begin, pairs with stilb_job_pool_worker_info */
	_Atomic uintptr_t self; /* job_this_thread of this thread; written only in builds with asserts */
} job_slot;

#define JOB_NO_CPU UINT32_MAX /* in job_slot.cpu */

/* What the workers are given when they start, from stilb_job_pool_desc. */
typedef struct job_worker_desc {
	char name[16];
	size_t stack_size;
	int32_t nice;
	uint32_t cpu_count;
	uint32_t *cpus; /* in the pool's memory */
} job_worker_desc;

/* The records and the count of a thread from outside the pool, lent to it for one submit (job_guest_enter). */
typedef struct job_guest {
	alignas(JOB_LINE) job_record_cache records;
	_Atomic uint64_t submitted;
} job_guest;

/* A thread from outside the pool that waits for a group; lies on that thread's stack. */
typedef struct job_visitor {
	job_parker parker;
	struct job_visitor *next; /* guarded by visitors_lock */
} job_visitor;

/* Adds to a counter that only the calling thread writes. */
static inline void job_count(_Atomic uint64_t *counter, uint32_t jobs)
{
	/* Release pairs with pool_is_quiet: a thread that sees a job counted as finished also sees the counts of all jobs
	 * that it has submitted. */
	atomic_store_explicit(counter, atomic_load_explicit(counter, memory_order_relaxed) + jobs, memory_order_release);
}

/* 0: the model tests do not count, since each access would be a step. */
#ifndef JOB_TALLIES
#define JOB_TALLIES 1
#endif

/* Adds to a tally of the calling thread. Relaxed, both: it is for statistics, which order nothing. */
static inline void job_tally(_Atomic uint64_t *tally, uint64_t more)
{
	if (JOB_TALLIES)
		atomic_store_explicit(tally, atomic_load_explicit(tally, memory_order_relaxed) + more, memory_order_relaxed);
}

enum { JOB_SHARED_HIGH, JOB_SHARED_NORMAL, JOB_SHARED_COUNT };

struct stilb_job_pool {
	/* The first fields are read by every call and constant. */
	alignas(JOB_LINE) uint32_t worker_count;
	uint32_t cpus;
	bool oversubscribed; /* there are more threads than CPUs */
	bool one_team;       /* there are at most JOB_TEAM_MOST threads */
	uint32_t team_count;
	job_team *team;       /* behind the slots in memory */
	uint64_t wake_ticks;  /* JOB_WAKE_NS in ticks of job_sys_ticks */
	uint64_t steal_ticks; /* JOB_STEAL_NS in such ticks */
	stilb_job_queue *shared[JOB_SHARED_COUNT];
	stilb_job_hooks hooks;
	job_idle_list idle;
	job_record_store records;
	/* The number of jobs in each shared queue, or a few more. Relaxed: only saves looking into empty queues. */
	alignas(JOB_LINE) _Atomic uint32_t shared_hint[JOB_SHARED_COUNT];
	/* Phases that have begun and not ended. Relaxed: a thread that reads an old value spins too long or too short. */
	alignas(JOB_LINE) _Atomic uint32_t phase;
	/* 1 while a worker watches for loops. Changed and read by acquire-release exchanges alone, see job_work_watched. */
	_Atomic uint32_t watched;
	_Atomic bool stop; /* release in destroy, pairs with acquire in the workers */
	/* How many cancelled groups have not finished, plus one if the whole pool is cancelled. Relaxed, both: jobs that
	 * start at the moment of a cancel may or may not run. */
	_Atomic uint32_t cancels;
	_Atomic bool cancelled;                /* the whole pool */
	alignas(JOB_LINE) job_lock after_lock; /* guards the followers of all groups */
	/* The jobs of low priority, linked by next, oldest first. A list and not a queue, since waits take jobs out of its
	 * middle. */
	alignas(JOB_LINE) job_lock low_lock; /* guards low, low_end and changes of low_count */
	_Atomic uint32_t low_count;
	job_record *low;
	job_record **low_end; /* the link at the end of the list */
	alignas(JOB_LINE) job_lock visitors_lock;
	job_visitor *visitors;
	stilb_job_allocator memory;
	size_t size; /* of this struct with all that follows, in bytes */
	/* Bit i: guest[i] is in use. Acquire to set it, pairs with the release that clears it. */
	alignas(JOB_LINE) _Atomic uint32_t guests;
	job_guest guest[JOB_GUESTS];
	/* Bit i: thread i may have an open loop, or jobs in its deque; a look for work skips the others. A thread sets the
	 * first before it opens a loop, and the second before it begins a job or a slice, which may push jobs. A worker
	 * clears both when it has been without work for JOB_WAKE_NS: so the words seldom change, and every thread has them
	 * in its cache. No other thread changes these bits, so they are set whenever there is something to find. Seq_cst:
	 * in the argument of job_park.h, setting a bit belongs to (a) and reading it to (2). Not used by a single team. */
	alignas(JOB_LINE) _Atomic uint64_t active[JOB_ACTIVE_KINDS][JOB_ACTIVE_WORDS];
	/* Some thread uses the teams' parts. Acquire to set it, pairs with the release that clears it. */
	_Atomic bool wide_open;
	job_worker_desc worker;
	job_slot slot[]; /* worker_count + 1; slot[0] is the owner's */
};

/* Records for asserts that the calling thread is the one of this slot. */
static inline void job_slot_set_mine(job_slot *slot)
{
#ifndef NDEBUG
	atomic_store_explicit(&slot->self, job_this_thread(), memory_order_relaxed); /* see job_slot_is_mine */
#else
	(void)slot;
#endif
}

/* For asserts: the slot is the calling thread's. Always true with NDEBUG, where slots do not record their threads. */
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

/* For asserts: the calling thread is not one of the pool's. Always true with NDEBUG, as job_slot_is_mine. */
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

/* The first thread from `first` on that may have work of this kind. From worker_count + 1 on there is none. */
static inline uint32_t job_active_from(stilb_job_pool *pool, job_active_kind kind, uint32_t first)
{
	uint32_t threads = pool->worker_count + 1, word = first / 64;
	if (pool->one_team || first >= threads)
		return first;
	/* Seq_cst, both: see the field. */
	uint64_t bits = atomic_load_explicit(&pool->active[kind][word], memory_order_seq_cst) & UINT64_MAX << first % 64;
	while (bits == 0 && ++word * 64 < threads)
		bits = atomic_load_explicit(&pool->active[kind][word], memory_order_seq_cst);
	return bits ? word * 64 + (uint32_t)__builtin_ctzll(bits) : threads;
}

void job_active_set(job_slot *slot, job_active_kind kind); /* job_work.c */

/* Called by a thread that may have work of this kind soon. */
static inline void job_active_begin(job_slot *slot, job_active_kind kind)
{
	if (__builtin_expect(!slot->active[kind], 0))
		job_active_set(slot, kind);
}

/* A number below `end`, which is at most 2^16, that looks random; another sequence of numbers for each thread.
 * Marsaglia, "Xorshift RNGs", Journal of Statistical Software 8 (14), 2003. */
static inline uint32_t job_random_below(job_slot *slot, uint32_t end)
{
	uint32_t x = slot->random;
	x ^= x << 13;
	x ^= x >> 17;
	x ^= x << 5;
	slot->random = x;
	return (x >> 16) * end >> 16;
}

/* Looks for work at one thread; true if that ends the search. */
typedef bool job_visit_fn(job_slot *slot, uint32_t thread, void *context);

/* Visits the threads begin <= i < end that may have work of this kind, from a random one on in a circle, until a visit
 * ends the search; true if one did. So threads that look at the same time begin at different places. In job_work.c. */
bool job_visit_active(job_slot *slot, job_active_kind kind, uint32_t begin, uint32_t end, job_visit_fn *visit,
                      void *context);

/* Visits all threads of a pool that is one team, from `first` on in a circle. */
static inline __attribute__((always_inline)) bool job_visit_team(job_slot *slot, uint32_t first, job_visit_fn *visit,
                                                                 void *context)
{
	uint32_t threads = slot->pool->worker_count + 1, thread = first;
	for (uint32_t i = 0; i < threads; i++, thread = thread + 1 < threads ? thread + 1 : 0)
		if (visit(slot, thread, context))
			return true;
	return false;
}

/* The slot of the calling thread, which has passed `worker` as its index; asserts that this is so. */
static inline job_slot *job_slot_of(stilb_job_pool *pool, uint32_t worker)
{
	assert(pool);
	assert(worker <= pool->worker_count && "the index of a thread of the pool");
	assert(job_slot_is_mine(&pool->slot[worker]) && "the calling thread's own index");
	return &pool->slot[worker];
}

/* Call the hooks wait_begin and wait_end if the pool has them. */
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

/* For a worker that has been woken for a phase: wakes others, as many as may spin, until none sleeps or there is a loop
 * to help with. */
void job_pool_wake_for_phase(job_slot *slot);

/* Waits after a steal that was not worth its cost, see JOB_STEAL_PAUSE_NS. Meanwhile the worker counts as a spinner
 * (job_park.h), since it will look for work soon. */
void job_pool_pause_stealing(job_slot *slot);

/* job_worker.c */

/* Copies what the desc says about workers; cpus has room for desc->cpu_count numbers. */
void job_worker_prepare(stilb_job_pool *pool, const stilb_job_pool_desc *desc, uint32_t *cpus);

/* Creates the thread of worker `index`, which runs main(slot). 0 or -EAGAIN. */
int job_worker_create(stilb_job_pool *pool, uint32_t index, void *(*main)(void *));

/* The calling thread, a worker that begins, gives itself its name, its nice value and its CPU. */
void job_worker_begin(job_slot *slot);

/* job_submit.c */

/* Puts a complete record where it belongs and wakes a thread for it if necessary. slot is the caller's. Cannot fail. */
void job_submit_record(job_slot *slot, job_record *record);

/* Submits `count` nodes of a graph, whose numbers lie from index `first` on, as one record. The job that this counts in
 * the group is the graph's run: it is left to job_graph.c to subtract. 0 or -ENOMEM. */
int job_submit_graph(stilb_job_pool *pool, struct stilb_job_graph *graph, uint32_t first, uint32_t count,
                     stilb_job_group *group, uint32_t worker);

/* Reserves a guest for the calling outside thread until job_guest_leave, and returns its number. */
uint32_t job_guest_enter(stilb_job_pool *pool);
void job_guest_leave(stilb_job_pool *pool, uint32_t guest);

/* job_work.c: slot is the calling thread's. */

/* Runs a few jobs (16 at most), or slices of one loop until none is left, of the work that the scope allows; false if
 * there was none. Returns early once the group `until`, which may be NULL, has finished. */
bool job_work_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* job_work_help for a wait, which most often is for the newest job of the thread's own deque. Does nothing if another
 * job lies there, or goes first. */
void job_work_run_own(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Brings jobs that the scope of a wait allows to the newest end of the thread's own deque, where job_work_help takes
 * them. False: none lies below other jobs there. */
bool job_work_dig(job_slot *slot, const job_scope *scope);

/* For a wait that would sleep otherwise: runs jobs that the scope allows from places where job_work_help does not look,
 * the middle of other threads' deques and the list of low priority; false if there are none. May move jobs from other
 * deques to the thread's own. */
bool job_work_unbury(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* Takes the newest job of the thread's own deque if the scope allows it. */
job_record *job_work_take_own(job_slot *slot, const job_scope *scope);

/* True if there is a job of high priority or a pinned one, which go before the next job of the same deque. Relaxed: if
 * the answer is out of date, that job starts one job later. */
static inline bool job_work_urgent(job_slot *slot)
{
	return atomic_load_explicit(&slot->pool->shared_hint[JOB_SHARED_HIGH], memory_order_relaxed) > 0 ||
	       atomic_load_explicit(&slot->inbox, memory_order_relaxed);
}

/* Runs one job, whichever it is; false if there is none. Called when every worker waits, so that no thread would run
 * unrelated jobs otherwise. Takes from the shared queues first, since waits take only jobs of high priority from
 * there. */
bool job_work_rescue(job_slot *slot);

/* Spins for JOB_WAKE_NS; an idle worker in a phase goes on until the phase ends. True as soon as there seems to be work
 * that the scope allows, or the group `until`, which may be NULL, has finished. */
bool job_work_spin(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* True if there is work that the scope allows. Exact: sees everything that was published before the call. For the scope
 * of a wait it looks at every job in every deque. */
bool job_work_exists(job_slot *slot, const job_scope *scope);

/* One round of a loop in which the thread looks for work or waits: pauses or yields the CPU. */
void job_work_relax(job_slot *slot);

/* Stops counting the thread as a spinner (job_park.h), if it is counted as one. */
void job_work_spin_stop(job_slot *slot);

/* True if a worker watches for loops (see JOB_WATCH_NAP_NS). It then finds every loop that was opened before the call
 * and is still open at its next look, the last of which comes after the end of the watch. */
bool job_work_watched(stilb_job_pool *pool);

/* Wakes a sleeping thread if there is more work and no other thread is looking for work. `work` describes what the
 * caller has just found: more of that is likely, so a thread that may do it is woken. */
void job_work_wake_next(job_slot *slot, const job_work *work);

/* Enters the idle list and sleeps until another thread wakes this one. Does not sleep if ready(slot, context), called
 * once after entering the list, returns true, or if there is work that the scope allows. */
typedef bool job_ready_fn(job_slot *slot, void *context);
job_idle_outcome job_work_park(job_slot *slot, const job_scope *scope, job_ready_fn *ready, void *context);

extern const job_scope job_scope_all;

/* job_wait.c */

/* job_drops, when it is known that the pool or some group is cancelled. */
bool job_group_drops(stilb_job_pool *pool, const stilb_job_group *group);

/* True if jobs of this group, which may be NULL, are dropped. */
static inline bool job_drops(stilb_job_pool *pool, const stilb_job_group *group)
{
	return __builtin_expect(atomic_load_explicit(&pool->cancels, memory_order_relaxed) > 0, 0) && /* see the field */
	       job_group_drops(pool, group);
}

/* Counts this many new jobs as unfinished. */
void job_group_add(stilb_job_group *group, uint32_t jobs);

/* Counts this many jobs as finished. If none is left, the thread that waits for the group may already have freed it
 * when this returns. */
void job_group_finish(job_slot *slot, stilb_job_group *group, uint32_t jobs);

/* True if every job of the group has finished; then everything they wrote is visible. */
bool job_group_done(stilb_job_group *group);

/* True if at most this many jobs of the group are unfinished. Relaxed: may be out of date, and orders nothing. */
bool job_group_done_but(stilb_job_group *group, uint32_t jobs);

/* Makes record a follower of group, to start when it has finished. False if it has finished already: then the caller
 * must submit the record. */
bool job_group_follow(stilb_job_pool *pool, stilb_job_group *group, job_record *record);

/* job_for.c */

/* Claims and runs slices of one loop that the scope allows, until none is left or `until` (may be NULL) has finished.
 * False if there is no such loop. */
bool job_loop_help(job_slot *slot, const job_scope *scope, stilb_job_group *until);

/* True if a loop that the scope allows has slices left to claim. Relaxed, so it may miss one: loops finish without
 * help, so that costs time but blocks nobody. */
bool job_loop_exists(stilb_job_pool *pool, const job_scope *scope);

/* job_loop_exists for a thread that looks at its own team otherwise; false if the pool is one team. If it returns true,
 * the next job_loop_help looks at all. */
bool job_loop_exists_far(job_slot *slot, const job_scope *scope);

/* job_loop_exists for a thread that spins: looks at other teams only now and then (JOB_NEAR_LOOKS). If it returns true,
 * the next job_loop_help looks there, too. */
bool job_loop_seems_to_exist(job_slot *slot, const job_scope *scope);

/* job_graph.c */

/* Runs the first of the record's nodes, then nodes that this has made ready and others of the same graph from the
 * thread's own deque, JOBS_IN_A_ROW at most; one if scope is NULL. Stops early as job_work_help does. Returns NULL, or
 * a record that the caller runs or submits; the graph may be gone. */
job_record *job_graph_run(job_slot *slot, job_record *record, const job_scope *scope, stilb_job_group *until);

/* job_cpu.c */

/* The CPUs granted by the cgroup quotas, rounded up; 0 if there is no limit. proc_cgroup is the file that lists this
 * process's groups (/proc/self/cgroup), mount the folder where the hierarchies are mounted (/sys/fs/cgroup). */
uint32_t job_cpu_quota(const char *proc_cgroup, const char *mount);

/* Stores the max CPUs of allowed[0..count), or all if there are fewer, that suit the workers of an owner on the CPU
 * `here` best, in cpus: first those on cores that no other thread of the pool uses, near ones (the same last level of
 * cache, then the same memory node) before far ones; then second hardware threads of cores. cpu_dirs is the folder that
 * describes the CPUs (/sys/devices/system/cpu). Returns their number. max: at least 1. */
uint32_t job_cpu_choose(const uint32_t *allowed, uint32_t count, uint32_t here, const char *cpu_dirs, uint32_t *cpus,
                        uint32_t max);

/* Brings the CPUs cpus[1..count) into an order in which those that share their last level of cache follow one another,
 * those of cpus[0] first, and otherwise keeps their order. cache[i] is then a number for the cache of cpus[i].
 * cpu_dirs: as in job_cpu_choose. */
void job_cpu_sort(uint32_t *cpus, uint32_t count, const char *cpu_dirs, uint32_t *cache);

/* A list of CPUs, with repetitions or without; of no CPU: those of the affinity mask. */
typedef struct job_cpu_list {
	const uint32_t *cpu;
	uint32_t count;
} job_cpu_list;

/* job_cpu_choose for the CPUs of the list without `here`; 0 if the kernel or the memory does not allow it. */
uint32_t job_cpu_others(job_cpu_list list, uint32_t here, uint32_t *cpus, uint32_t max);

/* The number of different CPUs in the list, 1 if there is no memory. */
uint32_t job_cpu_different(job_cpu_list list);

/* True if the list has this CPU or none at all. */
bool job_cpu_allows(job_cpu_list list, uint32_t cpu);

/* Lets the calling thread run on the CPUs of the list alone. 0, -EINVAL: it may use none of them, or -ENOMEM. */
int job_cpu_bind(job_cpu_list list);

#endif
