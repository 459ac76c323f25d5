/*
 * job_lock: a lock for sections of a few instructions. Free, it costs one exchange to take and one plain store to give.
 *
 * Test and test-and-set: a waiter reads until the lock looks free and only then writes, so waiters do not take the line
 * from the holder. It does so for some 100 ns, then gives its time slice away a few times, then sleeps until woken. The
 * spin is that short on purpose: sections last a few nanoseconds, so a lock that stays taken means another thread that
 * wants it all the time, or a holder that does not run. Either way the CPU is better used by somebody else, at best by one
 * who works at the other end of a queue.
 *
 * Sleeping. `sleepers` is 0 or 1, and a thread sleeps only while it is 1. Who is going to sleep sets it, then tries the lock
 * once more, then sleeps. Who gives the lock and finds it set clears it and wakes one thread. That one sets it again before
 * it tries the lock: there may be more sleepers, so the next to give the lock wakes another. No wake-up is lost if
 * operations happen one after another; the model test runs through that. One gap stays: giving is a store to `held`, then a
 * load of `sleepers`, with no order between the two, for that order would cost more than all the rest. The load may come
 * first and miss a thread that has still found the lock taken; therefore no sleep is longer than JOB_LOCK_SLEEP_NS.
 */
#ifndef STILB_JOB_LOCK_H
#define STILB_JOB_LOCK_H

#include "jobs/job_line.h"
#include "jobs/job_sys.h"

#include <stdbool.h>

#define JOB_LOCK_SPIN_NS 100
#define JOB_LOCK_SLEEP_NS 4000000 /* about a time slice */
#ifndef JOB_LOCK_YIELDS
#define JOB_LOCK_YIELDS 8
#endif

/* All zero: free. */
typedef struct job_lock {
	_Atomic uint32_t held;
	_Atomic uint32_t sleepers; /* a futex */
} job_lock;

static inline bool job_lock_try(job_lock *lock)
{
	/* Relaxed: a hint. The exchange decides; acquire pairs with the release in job_lock_give: the section sees what
	 * earlier ones wrote. */
	return !atomic_load_explicit(&lock->held, memory_order_relaxed) &&
	       !atomic_exchange_explicit(&lock->held, 1, memory_order_acquire);
}

static inline void job_lock_sleep_and_take(job_lock *lock)
{
	for (;;) {
		/* Sequentially consistent: set before the lock is looked at again; pairs with the load in job_lock_give. */
		atomic_exchange_explicit(&lock->sleepers, 1, memory_order_seq_cst);
		if (job_lock_try(lock))
			return;
		job_sys_futex_wait_for(&lock->sleepers, 1, JOB_LOCK_SLEEP_NS);
	}
}

static inline __attribute__((cold)) void job_lock_wait_and_take(job_lock *lock)
{
	uint64_t start = job_sys_ticks(), spin = job_sys_ticks_in(JOB_LOCK_SPIN_NS);
	do {
		if (job_lock_try(lock))
			return;
		job_sys_pause();
	} while (job_sys_ticks() - start < spin);
	for (uint32_t turns = JOB_LOCK_YIELDS; turns > 0; turns--) {
		sched_yield();
		if (job_lock_try(lock))
			return;
	}
	job_lock_sleep_and_take(lock);
}

static inline void job_lock_take(job_lock *lock)
{
	if (!job_lock_try(lock))
		job_lock_wait_and_take(lock);
}

static inline __attribute__((cold)) void job_lock_wake(job_lock *lock)
{
	/* Relaxed: the word says all. Zero: another has cleared it meanwhile, and wakes for us. */
	if (atomic_exchange_explicit(&lock->sleepers, 0, memory_order_relaxed))
		job_sys_futex_wake_one(&lock->sleepers);
}

/* The lock must live until this returns, not only until another thread has it. */
static inline void job_lock_give(job_lock *lock)
{
	atomic_store_explicit(&lock->held, 0, memory_order_release); /* pairs with job_lock_try */
	/* Relaxed, and so in no order with the store: see above. */
	if (__builtin_expect(atomic_load_explicit(&lock->sleepers, memory_order_relaxed) != 0, 0))
		job_lock_wake(lock);
}

#endif
