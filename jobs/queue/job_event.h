/*
 * job_event: how a thread sleeps until a call that was refused may succeed, such as a pop from an empty queue. The
 * other side, which makes it succeed, pays one load and one branch a call while nobody waits.
 *
 *   push:   put the item into the queue;  job_event_signal(&queue->items, 1);
 *   pop:    error = pop();  if (error == -EAGAIN) error = job_event_wait(&queue->items, pop, queue, timeout_ns);
 *
 * Waiting.   A waiter (1) counts itself in `waiters`, (2) passes a barrier, (3) sets `signals` to 0 and tries again,
 *            (4) sleeps if `signals` still is 0. Then it goes on at (3). It counts itself out at the end.
 * Barrier.   A push stores its item and then loads `waiters`, and its CPU may do the load first: an order between the
 *            two would cost every push some nanoseconds. The waiter has that order made when it needs it, as in
 *            job_lock.h: at some moment after (1), every other thread either has yet to load `waiters`, and will find
 *            the waiter, or its item is in the queue and (3) finds it. Without membarrier no sleep is longer than
 *            JOB_EVENT_SLEEP_NS.
 * Signals.   A push that finds waiters adds 1 to `signals`, and wakes a thread if that was 0: one system call for a
 *            burst of pushes, until the woken thread runs. That one takes all signals, uses one item, and passes the
 *            other signals on, with one wake-up for all of them. So while a thread sleeps, the signals, together with
 *            those taken at (3) by threads that are awake, are at least as many as the items that nobody has seen; if
 *            (3) finds nothing, there are none, and the signals it took are void.
 * Closing.   Signals JOB_EVENT_ALL times, more than there are waiters; and a waiter that ends because the queue is
 *            closed passes on one signal in any case.
 */
#ifndef STILB_JOB_EVENT_H
#define STILB_JOB_EVENT_H

#include "jobs/job_sys.h"

#define JOB_EVENT_ALL (1u << 20)      /* signals for every waiter there may be */
#define JOB_EVENT_SPIN_NS 5000        /* how long a waiter tries before it sleeps: about what being woken costs it */
#define JOB_EVENT_SLEEP_NS 4000000    /* without membarrier; about one time slice of the scheduler */
#define JOB_EVENT_NO_LIMIT UINT64_MAX /* a timeout */

/* With all members 0 nobody waits. */
typedef struct job_event {
	_Atomic uint32_t waiters;
	_Atomic uint32_t signals; /* a futex; at most JOB_EVENT_ALL */
} job_event;

/* The part of job_event_signal that is needed if there are waiters. [any-thread] */
__attribute__((cold)) void job_event_wake(job_event *event, uint32_t count);

/* True if a thread may wait: the caller must call job_event_wake. Follows the stores by which attempts may succeed.
 * [any-thread] */
static inline bool job_event_awaited(const job_event *event)
{
	/* Relaxed: the waiter's job_sys_membarrier orders the load after the stores, see "Barrier" in the head of this
	 * file. */
	job_sys_compiler_barrier();
	return atomic_load_explicit(&event->waiters, memory_order_relaxed) != 0;
}

/* Says that `count` more attempts may succeed, at least 1. Follows the stores that make them succeed. [any-thread] */
static inline void job_event_signal(job_event *event, uint32_t count)
{
	if (__builtin_expect(job_event_awaited(event), 0))
		job_event_wake(event, count);
}

/* Calls attempt(context), which has been refused with -EAGAIN, again until it returns something else, and sleeps in
 * between. Returns that, or -ETIMEDOUT when timeout_ns nanoseconds have passed; JOB_EVENT_NO_LIMIT: never. With a
 * timeout of 0 it neither tries nor sleeps. [any-thread] */
int job_event_wait(job_event *event, int (*attempt)(void *context), void *context, uint64_t timeout_ns);

#endif
