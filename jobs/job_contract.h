/*
 * job_contract: asserts that take more than an expression. With NDEBUG none of them costs anything; structs are the
 * same with and without it.
 *
 *   JOB_CHECK(job_deque_is_sound(deque));     walks a whole structure; stands at the end of a change to it
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

/* A region that one thread at a time may be in, without being a lock. Zero-initialised it is free. */
typedef struct job_exclusive {
	_Atomic uint32_t threads;
} job_exclusive;

static inline void job_exclusive_begin(job_exclusive *region)
{
#ifndef NDEBUG
	/* Relaxed: counts alone. An order here would hide a missing one from the thread sanitizer. */
	uint32_t others = atomic_fetch_add_explicit(&region->threads, 1, memory_order_relaxed);
	assert(others == 0 && "one thread at a time");
#else
	(void)region;
#endif
}

static inline void job_exclusive_end(job_exclusive *region)
{
#ifndef NDEBUG
	atomic_fetch_sub_explicit(&region->threads, 1, memory_order_relaxed); /* as above */
#else
	(void)region;
#endif
}

#endif
