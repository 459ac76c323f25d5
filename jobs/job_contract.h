/*
 * job_contract: asserts that take more than an expression. With NDEBUG none of them costs anything; structs have the
 * same layout with and without NDEBUG.
 *
 *   JOB_CHECK(job_deque_is_sound(deque));     checks a whole structure; stands at the end of a change to it
 *   job_exclusive_begin(&queue->producer);    until job_exclusive_end, no other thread may be here
 */
#ifndef STILB_JOB_CONTRACT_H
#define STILB_JOB_CONTRACT_H

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef NDEBUG
#define JOB_CHECK(condition) ((void)(false && (condition))) /* compiled, so that the function counts as used */
#else
#define JOB_CHECK(condition) assert(condition)
#endif

/* A number that identifies the calling thread, never 0. */
static inline uintptr_t job_this_thread(void)
{
	return (uintptr_t)pthread_self();
}

/* Detects two threads in code that only one may be in at a time; it does not make the second one wait, as a lock would.
 * All zero: no thread is inside. */
typedef struct job_exclusive {
	_Atomic uint32_t threads;
} job_exclusive;

static inline void job_exclusive_begin(job_exclusive *region)
{
#ifndef NDEBUG
	/* Relaxed: only the count matters. A stronger order would synchronise the two threads, and the thread sanitizer
	 * would no longer report a race between them. */
	uint32_t others = atomic_fetch_add_explicit(&region->threads, 1, memory_order_relaxed);
	assert(others == 0 && "one thread at a time");
#else
	(void)region;
#endif
}

static inline void job_exclusive_end(job_exclusive *region)
{
#ifndef NDEBUG
	atomic_fetch_sub_explicit(&region->threads, 1, memory_order_relaxed); /* as in job_exclusive_begin */
#else
	(void)region;
#endif
}

#endif
