/*
 * prof_contract: asserts that take more than an expression. With NDEBUG all that is left of them is the number that a
 * mutex keeps; structs are the same with and without it.
 *
 *   PROF_CHECK(prof_window_is_sound(window));      walks a whole structure; stands at the end of a change to it
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
	uintptr_t holder; /* pthread_self of the thread that holds it; 0: nobody. Relaxed: compared with one's own alone */
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

/* False: another thread holds it. */
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

/* A region that one call at a time may be in, without being a lock. Zero-initialised it is free. */
typedef struct prof_exclusive {
	uint32_t calls;
} prof_exclusive;

static inline void prof_exclusive_begin(prof_exclusive *region)
{
#ifndef NDEBUG
	/* Relaxed: counts alone. An order here would hide a missing one from the thread sanitizer. */
	uint32_t others = __atomic_fetch_add(&region->calls, 1, __ATOMIC_RELAXED);
	assert(others == 0 && "one call at a time");
#else
	(void)region;
#endif
}

static inline void prof_exclusive_end(prof_exclusive *region)
{
#ifndef NDEBUG
	__atomic_fetch_sub(&region->calls, 1, __ATOMIC_RELAXED); /* as above */
#else
	(void)region;
#endif
}

#endif
