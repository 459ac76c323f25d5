/*
 * prof_contract: asserts that take more than an expression. With NDEBUG all that is left of them is that a mutex
 * records its holder; structs have the same layout with and without NDEBUG.
 *
 *   PROF_CHECK(prof_window_is_sound(window));      checks a whole structure; stands at the end of a change to it
 *   prof_mutex_lock(&made.lock);              a mutex that knows its holder: assert(prof_mutex_is_mine(&made.lock))
 *   prof_exclusive_begin(&frames.marking);    until prof_exclusive_end, no other call may be here
 */
#ifndef STILB_PROF_CONTRACT_H
#define STILB_PROF_CONTRACT_H

#include <assert.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef NDEBUG
#define PROF_CHECK(condition) ((void)(false && (condition))) /* compiled, so that the function counts as used */
#else
#define PROF_CHECK(condition) assert(condition)
#endif

typedef struct prof_mutex {
	pthread_mutex_t lock;
	uintptr_t holder; /* pthread_self of the holder; 0: none. Relaxed: threads only compare it with their own */
} prof_mutex;

#define PROF_MUTEX_INIT                                                                                                \
	{                                                                                                                  \
		PTHREAD_MUTEX_INITIALIZER, 0                                                                                   \
	}

static inline bool prof_mutex_is_mine(const prof_mutex *mutex)
{
	return __atomic_load_n(&mutex->holder, __ATOMIC_RELAXED) == (uintptr_t)pthread_self();
}

static inline void prof_mutex_lock(prof_mutex *mutex)
{
	assert(!prof_mutex_is_mine(mutex) && "the lock is not taken twice");
	pthread_mutex_lock(&mutex->lock);
	__atomic_store_n(&mutex->holder, (uintptr_t)pthread_self(), __ATOMIC_RELAXED);
}

/* Takes the mutex if it is free. False: another thread holds it. */
static inline bool prof_mutex_try(prof_mutex *mutex)
{
	assert(!prof_mutex_is_mine(mutex) && "the lock is not taken twice");
	if (pthread_mutex_trylock(&mutex->lock) != 0)
		return false;
	__atomic_store_n(&mutex->holder, (uintptr_t)pthread_self(), __ATOMIC_RELAXED);
	return true;
}

static inline void prof_mutex_unlock(prof_mutex *mutex)
{
	assert(prof_mutex_is_mine(mutex) && "the caller holds the lock");
	__atomic_store_n(&mutex->holder, 0, __ATOMIC_RELAXED);
	pthread_mutex_unlock(&mutex->lock);
}

/* Detects two calls in code that only one may be in at a time; it does not make the second one wait, as a lock would.
 * All zero: no call is inside. */
typedef struct prof_exclusive {
	uint32_t calls;
} prof_exclusive;

static inline void prof_exclusive_begin(prof_exclusive *region)
{
#ifndef NDEBUG
	/* Relaxed: only the count matters. A stronger order would synchronise the two threads, and the thread sanitizer
	 * would no longer report a race between them. */
	uint32_t others = __atomic_fetch_add(&region->calls, 1, __ATOMIC_RELAXED);
	assert(others == 0 && "one call at a time");
#else
	(void)region;
#endif
}

static inline void prof_exclusive_end(prof_exclusive *region)
{
#ifndef NDEBUG
	__atomic_fetch_sub(&region->calls, 1, __ATOMIC_RELAXED); /* as in prof_exclusive_begin */
#else
	(void)region;
#endif
}

#endif
