/*
 * job_park: how threads go to sleep without missing the event they sleep for. An eventcount: announce, look again,
 * sleep.
 *
 * The idle list holds the threads that sleep or are about to, the idlers, each with its scope: the work it would wake
 * up for. A worker without work wakes up for anything, a thread that waits for a group or a loop only for jobs of it.
 * Each thread sleeps on a futex of its own, its parker, which holds a token or not. To wake a thread is to leave the
 * token there, so a wake-up that comes before the sleep is not lost. With one futex for each thread instead of one for
 * all, the waker chooses which thread to wake: of those that may do the work, the one that came last, whose caches are
 * warmest.
 *
 * Spinners are workers that look for work before they sleep, or that have just been woken for some. While there is one,
 * a new job wakes nobody: the spinner finds it, and wakes the next thread before it starts on it. So a burst of submits
 * costs one system call, and the workers wake one another for as long as there is more to do. Outside a phase at most
 * one worker looks for work by itself; other spinners are on their way to a loop.
 *
 * Where many are needed, waking is a tree: a thread that has been woken for a long loop wakes JOB_WAKE_FAN others, and
 * one that has been woken for a phase goes on until nobody sleeps or there is a loop to help with, since it has nothing
 * else to do. So 63 workers are awake after six wake-ups one after the other at most, and not after 63. The spinners
 * bound it: a phase has room for so many, and a loop wakes one more thread only if that leaves enough slices for each
 * of the spinners, who may all be on their way to it.
 *
 * `state` counts idlers and spinners in one word. No wake-up is lost: A thread that goes to sleep: (1) counts itself in
 * as an idler, and out as a spinner, (2) looks for work again, (3) sleeps. A thread that has work: (a) publishes the
 * work, (b) reads the word. (1), (2), (a) and (b) are seq_cst, so there is one order of them. If (1) comes before (b),
 * then (b) sees an idler, and either wakes one or sees a spinner as well. If (b) comes before (1), then (a) comes
 * before (2), which finds the work. A spinner seen in (b) either has not done its own (1) yet, or has not counted
 * itself out yet after finding other work, and then looks for more: in both cases it looks after (a). If (a) is a
 * seq_cst read-modify-write of the work's own word (a deque, an inbox), (b) can be a load. If (a) is weaker (the shared
 * queues), (b) is a read-modify-write that does not change the word and is ordered against (1), which is one, too.
 *
 * A thread that waits for a group is in a harder case: the spinner may take unrelated work, run it for long, and never
 * come to the job that the waiting thread could run. So for a job of a root that an idler waits for, this idler is
 * woken whether or not there is a spinner; and in step (2) a waiting thread looks for jobs of its root not only where
 * it can take them at once, but everywhere. `roots` says with one load whether such an idler may exist.
 */
#ifndef STILB_JOB_PARK_H
#define STILB_JOB_PARK_H

#include "jobs/job.h"
#include "jobs/job_lock.h"

#include <stdalign.h>

typedef struct job_parker {
	_Atomic uint32_t state; /* no token, a token or asleep: see job_park.c */
	bool chosen;            /* its thread's own: it has taken the token of a waker that has chosen it */
	/* The fields below are guarded by the idle list's lock; a chosen thread reads rescue after it has the token. */
	bool rescue;    /* woken to do any work there is */
	bool bound;     /* its thread is bound to cpu */
	uint32_t cpu;   /* valid if bound */
	int32_t thread; /* the kernel's id of the thread, valid if bound */
} job_parker;

/* Sleeps until the token is there and takes it. Everything done before the token was left is visible. Only for the
 * parker's own thread. */
void job_parker_sleep(job_parker *parker);

/* job_parker_sleep for about the given time at most. False if it took no token: the time is over, or the kernel
 * returned early. */
bool job_parker_sleep_for(job_parker *parker, uint64_t nanoseconds);

/* Takes the token if it is there; never sleeps. Only for the parker's own thread. */
void job_parker_clear(job_parker *parker);

/* Leaves the token and wakes the thread if it sleeps. A parker holds one token at most: a second one left before the
 * thread takes the first changes nothing. [any-thread] */
void job_parker_wake(job_parker *parker);

/* The work that a thread may do (see job_internal.h). */
typedef struct job_scope {
	bool all;       /* any work: root and level do not matter; jobs and high are true, too */
	bool jobs;      /* jobs and loops of this root and level; false: loops alone */
	bool high;      /* jobs of high priority, whatever their root */
	uintptr_t root; /* work that descends from this root ... */
	uint32_t level; /* ... and is nested deeper than this level */
} job_scope;

/* Places where work lies: the thread's own deque, another thread's deque, the queue of high priority, an open loop, the
 * other shared queues. */
typedef enum job_work_kind { JOB_WORK_OWN, JOB_WORK_JOB, JOB_WORK_HIGH, JOB_WORK_LOOP, JOB_WORK_SHARED } job_work_kind;

/* Some work that has appeared, as the waker describes it to find a sleeping thread whose scope includes it. */
typedef struct job_work {
	job_work_kind kind;
	uintptr_t root; /* root and level are set for JOB_WORK_JOB and JOB_WORK_LOOP */
	uint32_t level;
	uint32_t spinners; /* there is enough of it for so many spinners and one thread more */
} job_work;

/* An entry of the idle list: a thread that sleeps or is about to. */
typedef struct job_idler {
	job_parker *parker;
	job_scope scope;
	bool worker; /* false for the owner */
} job_idler;

/* The most threads that one woken for a loop wakes, and that are woken at a time. A wake-up reaches its thread after
 * some 24 us, of which the waker is busy for 7: with more than two, the last would start hardly earlier, and the waker
 * itself later. */
#define JOB_WAKE_FAN 2

#define JOB_IDLE_SPINNER (1u << 16) /* one spinner in the state word; the bits below count idlers */

typedef struct job_idle_list {
	alignas(JOB_LINE) _Atomic uint32_t state; /* idlers, and spinners << 16; the idlers change under the lock */
	/* The bits (job_idle_root_bit) of the roots whose jobs listed threads wait for. Relaxed, and changed under the
	 * lock: a bit is set before its thread is counted in `state`, by which it is published. */
	_Atomic uint64_t roots;
	alignas(JOB_LINE) job_lock lock; /* guards everything below */
	bool spare;                      /* spare_cpu is valid */
	uint32_t spare_cpu;              /* a CPU that no worker is bound to */
	uint32_t workers;                /* workers of the pool; constant */
	uint32_t
		waiting; /* listed workers that wait for a group or a loop; when all workers do, one of them may do any work */
	job_idler
		idler[STILB_JOB_MAX_WORKERS + 1]; /* a stack: the last to come has the warmest caches and is woken first */
} job_idle_list;

void job_idle_init(job_idle_list *list, uint32_t workers);

/* Notes that the calling thread, which parks on parker, is bound to cpu. */
void job_idle_bound(job_idle_list *list, job_parker *parker, uint32_t cpu);

/* Counts the calling worker as a spinner, unless there are `limit` spinners already; true if it did. */
bool job_idle_spin_start(job_idle_list *list, uint32_t limit);

/* The calling worker, a spinner, has found work. It looks for more work afterwards and wakes a thread for that. */
void job_idle_spin_stop(job_idle_list *list);

/* Step (1) of the head of this file: puts the calling thread on the list. spinning: it has been a spinner, and is none
 * any more. True if every worker now waits for a group or a loop: then the caller must do whatever work there is
 * instead of sleeping. The thread must not be on the list. */
bool job_idle_enter(job_idle_list *list, const job_idler *idler, bool spinning);

/* How a thread came off the idle list. */
typedef enum job_idle_outcome {
	JOB_IDLE_NOT_CHOSEN, /* it removed itself: no thread has chosen it */
	JOB_IDLE_CHOSEN,     /* for work that it must do or wake another thread for; a spinner now if its scope is all */
	JOB_IDLE_RESCUE      /* chosen to do any work there is, because every worker waits */
} job_idle_outcome;

/* Wakes up to `count` workers whose scope is all, as spinners, while there are fewer than `limit` spinners; returns how
 * many. May miss a thread that has just entered the list. count: JOB_WAKE_FAN at most. [any-thread] */
uint32_t job_idle_wake_spinners(job_idle_list *list, uint32_t limit, uint32_t count);

/* After the sleep, or instead of it: removes the calling thread from the list if it is still there, and takes its
 * token. */
job_idle_outcome job_idle_leave(job_idle_list *list, job_parker *parker);

/* True if this state word says that new work needs a wake-up: there is an idler and no spinner. */
static inline bool job_idle_state_wanted(uint32_t state)
{
	return (state & (JOB_IDLE_SPINNER - 1)) > 0 && state < JOB_IDLE_SPINNER;
}

/* One of 64 bits for a root; different roots may have the same. */
static inline uint64_t job_idle_root_bit(uintptr_t root)
{
	return UINT64_C(1) << ((root >> 4 ^ root >> 10 ^ root >> 16) % 64);
}

/* True if a thread should be woken for new jobs of this root, judging by a state word that the caller has read: there
 * is an idler and no spinner, or, as it seems, an idler that waits for such jobs. */
static inline bool job_idle_wanted_by(const job_idle_list *list, uint32_t state, uintptr_t root)
{
	if (job_idle_state_wanted(state))
		return true;
	/* Relaxed: the caller's load of state has acquired the bits of all the idlers that state counts. */
	return (state & (JOB_IDLE_SPINNER - 1)) > 0 &&
	       (atomic_load_explicit(&list->roots, memory_order_relaxed) & job_idle_root_bit(root));
}

/* Step (b) for a job of this root, published by a seq_cst read-modify-write: true if a thread should be woken.
 * [any-thread] */
static inline bool job_idle_wanted(const job_idle_list *list, uintptr_t root)
{
	/* Partner of (1). */
	return job_idle_wanted_by(list, atomic_load_explicit(&list->state, memory_order_seq_cst), root);
}

/* Step (b) for work published in any other way: job_idle_wanted by a read-modify-write that adds 0 (see the head of
 * this file). [any-thread] */
static inline bool job_idle_wanted_strict(job_idle_list *list, uintptr_t root)
{
	/* Partner of (1). */
	return job_idle_wanted_by(list, atomic_fetch_add_explicit(&list->state, 0, memory_order_seq_cst), root);
}

/* job_idle_wanted, but relaxed: the answer may be out of date, so a wake-up may be missed. For callers to whom that
 * costs time but not progress. [any-thread] */
static inline bool job_idle_maybe_wanted(const job_idle_list *list)
{
	return job_idle_state_wanted(atomic_load_explicit(&list->state, memory_order_relaxed));
}

/* True if there is an idler and at most this many spinners. Relaxed, as in job_idle_maybe_wanted. [any-thread] */
static inline bool job_idle_maybe_wanted_beside(const job_idle_list *list, uint32_t spinners)
{
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed);
	return (state & (JOB_IDLE_SPINNER - 1)) > 0 && state / JOB_IDLE_SPINNER <= spinners;
}

/* The number of workers that are not on the list; one too few if the owner is on it. Relaxed: may be out of date.
 * [any-thread] */
static inline uint32_t job_idle_awake(const job_idle_list *list)
{
	uint32_t idlers = atomic_load_explicit(&list->state, memory_order_relaxed) & (JOB_IDLE_SPINNER - 1);
	return idlers < list->workers ? list->workers - idlers : 0;
}

/* Chooses an idler whose scope has this work, a bound one if there is one, the newest of those, and wakes it; false if
 * there is none. Idlers that may do any work are not chosen while there are more spinners than work->spinners. Costs
 * the caller some 7 us. [any-thread] */
bool job_idle_wake(job_idle_list *list, const job_work *work);

/* For jobs that could not be seen for a moment: wakes every thread that waits for jobs, and one that may do any work
 * unless there is a spinner. [any-thread] */
void job_idle_wake_waiting(job_idle_list *list);

/* Wakes the thread of this parker if it is on the list, for work that no other thread may do. Includes step (b).
 * [any-thread] */
void job_idle_wake_thread(job_idle_list *list, job_parker *parker);

#endif
