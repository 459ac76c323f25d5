/*
 * job_lock: a spin lock for sections of a few instructions. Test and test-and-set: a waiter reads until the lock looks
 * free and only then writes, so waiters do not take the line from the holder. It pauses, then yields: with more threads
 * than CPUs the holder may not be running, and pure spinning would burn the very time slice it needs.
 */
#ifndef STILB_JOB_LOCK_H
#define STILB_JOB_LOCK_H

#include "jobs/job_sys.h"

#include <stdbool.h>

/* Two cache lines: CPUs prefetch lines in pairs, so data 64 bytes apart still travels together. */
#define JOB_LINE 128

typedef struct job_lock {
	_Atomic bool held;
} job_lock;

static inline void job_lock_take(job_lock *lock)
{
	uint32_t turns = 0;
	/* Acquire pairs with the release in job_lock_give: the section sees what earlier ones wrote. */
	while (atomic_exchange_explicit(&lock->held, true, memory_order_acquire))
		while (atomic_load_explicit(&lock->held, memory_order_relaxed)) /* a hint, the exchange decides */
			job_sys_relax(&turns);
}

static inline void job_lock_give(job_lock *lock)
{
	atomic_store_explicit(&lock->held, false, memory_order_release); /* pairs with job_lock_take */
}

#endif
