/*
 * job_lock: a lock for critical sections of a few instructions. Uncontended, it costs one exchange to take and one
 * plain store to release.
 *
 * Spinning.  Test and test-and-set: a waiter only reads until the lock looks free, so waiters do not take the cache
 *            line away from the holder. After some 100 ns it yields a few times, and then it sleeps until woken. The
 *            spin is that short because critical sections last a few nanoseconds: a lock that stays taken for longer
 *            has a holder that is not running, or another thread that takes it all the time. In both cases the CPU is
 *            better used by another thread, for example one at the other end of the queue.
 * Sleeping.  `sleepers` is 0 or 1, and a thread sleeps only while it is 1. A thread that is going to sleep sets it,
 *            passes a barrier, tries the lock once more, and sleeps. A thread that releases the lock and finds it set
 *            clears it and wakes one thread, which sets it again before it tries the lock: there may be more sleepers,
 *            and the next release then wakes another one.
 * Barrier.   A release stores `held` and then loads `sleepers`, and its CPU may do the load first: an order between the
 *            two would cost more than everything else. The sleeper has that order made when it needs it
 *            (job_sys_membarrier): at some moment after it has set `sleepers`, every other thread is either not yet at
 *            the load of its release, and will find `sleepers` set, or has passed it, and then its store to `held` is
 *            done and the sleeper's last try finds it. If that try finds the lock taken, it is by a thread of the first
 *            kind. So no wake-up is lost.
 * Limit.     Without membarrier, a load that came too early can miss the sleeper. Then no sleep is longer than
 *            JOB_LOCK_SLEEP_NS.
 */
#ifndef STILB_JOB_LOCK_H
#define STILB_JOB_LOCK_H

#include "jobs/job_contract.h"
#include "jobs/job_line.h"
#include "jobs/job_sys.h"

#include <stdbool.h>

#define JOB_LOCK_SPIN_NS 100
#define JOB_LOCK_SLEEP_NS 4000000 /* without membarrier; about one time slice of the scheduler */
#ifndef JOB_LOCK_YIELDS
#define JOB_LOCK_YIELDS 8
#endif

/* A lock; with all members 0 it is free. */
typedef struct job_lock {
	_Atomic uint32_t held;
	_Atomic uint32_t sleepers; /* a futex */
	_Atomic uintptr_t holder;  /* job_this_thread of the holder, or 0; written in builds with asserts alone */
} job_lock;

/* For asserts: the calling thread holds the lock. Always true with NDEBUG, where the holder is not recorded. */
static inline bool job_lock_is_mine(const job_lock *lock)
{
#ifndef NDEBUG
	/* Relaxed: only the calling thread stores its own number, and it reads its own stores in order. */
	return atomic_load_explicit(&lock->holder, memory_order_relaxed) == job_this_thread();
#else
	(void)lock;
	return true;
#endif
}

static inline void job_lock_set_mine(job_lock *lock, bool mine)
{
#ifndef NDEBUG
	atomic_store_explicit(&lock->holder, mine ? job_this_thread() : 0, memory_order_relaxed); /* see job_lock_is_mine */
#else
	(void)lock, (void)mine;
#endif
}

static inline bool job_lock_try(job_lock *lock)
{
	/* The relaxed load only saves an exchange in vain, which would take the cache line from the holder; the exchange
	 * decides. Acquire pairs with the release in job_lock_give: this critical section sees what earlier ones wrote. */
	return !atomic_load_explicit(&lock->held, memory_order_relaxed) &&
	       !atomic_exchange_explicit(&lock->held, 1, memory_order_acquire);
}

static inline void job_lock_sleep_and_take(job_lock *lock)
{
	for (;;) {
		/* Seq_cst: set before the lock is tried again; pairs with the load in job_lock_release. */
		atomic_exchange_explicit(&lock->sleepers, 1, memory_order_seq_cst);
		bool ordered = job_sys_membarrier();
		if (job_lock_try(lock))
			return;
		if (ordered)
			job_sys_futex_wait(&lock->sleepers, 1);
		else
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
	for (uint32_t yields = JOB_LOCK_YIELDS; yields > 0; yields--) {
		sched_yield();
		if (job_lock_try(lock))
			return;
	}
	job_lock_sleep_and_take(lock);
}

/* Takes the lock if it is free; false if it is not. Not recursive: the caller must not hold it already. */
static inline bool job_lock_take_now(job_lock *lock)
{
#ifndef NDEBUG
	assert(!job_lock_is_mine(lock) && "the lock is not taken twice");
#endif
	if (!job_lock_try(lock))
		return false;
	job_lock_set_mine(lock, true);
	return true;
}

/* Waits until the lock is free and takes it. Not recursive. */
static inline void job_lock_take(job_lock *lock)
{
	if (job_lock_take_now(lock))
		return;
	job_lock_wait_and_take(lock);
	job_lock_set_mine(lock, true);
}

static inline __attribute__((cold)) void job_lock_wake(job_lock *lock)
{
	/* Relaxed: nothing but `sleepers` itself is exchanged between the threads. If it is 0 already, another thread has
	 * cleared it and wakes the sleeper. */
	if (atomic_exchange_explicit(&lock->sleepers, 0, memory_order_relaxed))
		job_sys_futex_wake_one(&lock->sleepers);
}

/* Releases the lock. True if threads may sleep: the caller must call job_lock_wake. The memory of the lock must stay
 * valid until then: another thread may take the lock while this one still looks for sleepers in it. */
static inline bool job_lock_release(job_lock *lock)
{
	assert(job_lock_is_mine(lock) && "the caller holds the lock");
	job_lock_set_mine(lock, false);
	atomic_store_explicit(&lock->held, 0, memory_order_release); /* pairs with job_lock_try */
	/* Relaxed: the sleeper's job_sys_membarrier orders the load after the store, see "Barrier" in the head of this
	 * file. */
	job_sys_compiler_barrier();
	return atomic_load_explicit(&lock->sleepers, memory_order_relaxed) != 0;
}

/* Releases the lock and wakes a thread that waits for it. */
static inline void job_lock_give(job_lock *lock)
{
	if (__builtin_expect(job_lock_release(lock), 0))
		job_lock_wake(lock);
}

#endif
