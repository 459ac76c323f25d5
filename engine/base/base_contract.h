/*
 * base_contract: asserts about the calling thread and the lock that it holds. C only, because of C11's atomics.
 *
 *   STILB_ASSERT_OWNER(render->owner);        the caller is the thread that took the owner last
 *   STILB_ASSERT_LOCKED(&resources->lock);    the caller holds this stilb_lock
 *
 * Life cycle.  An object that is [main-thread] holds a stilb_owner and takes it when it is created; an object handed to
 *              another thread is taken there. A stilb_lock is initialised, taken and given any number of times, and
 *              finished.
 * Threads.     [any-thread] but for stilb_lock_init and stilb_lock_finish: while they run, no other thread uses the
 *              lock.
 * Layout.      The structs are the same with and without NDEBUG; without asserts an owner costs one relaxed store where
 *              it is taken.
 */
#ifndef STILB_BASE_CONTRACT_H
#define STILB_BASE_CONTRACT_H

#include "base/base.h"

#include <pthread.h>

#define STILB_ASSERT_OWNER(owner) STILB_ASSERT(stilb_owner_is_me(&(owner)) && "called on the owner's thread")
#define STILB_ASSERT_LOCKED(lock) STILB_ASSERT(stilb_lock_is_mine(lock) && "the caller holds the lock")

/* The thread that an object belongs to, for STILB_ASSERT_OWNER. Zero-initialised it belongs to nobody, and every thread
 * passes the assert. */
typedef struct stilb_owner {
	_Atomic uintptr_t thread;
} stilb_owner;

/* From now on the object belongs to the calling thread. */
void stilb_owner_take(stilb_owner *owner);

/* True if the object belongs to the calling thread or to nobody. */
bool stilb_owner_is_me(const stilb_owner *owner);

/* A mutex that records its holder, for STILB_ASSERT_LOCKED. Not recursive. */
typedef struct stilb_lock {
	pthread_mutex_t mutex;
	stilb_owner holder;
} stilb_lock;

/* Not held at first. False if there is no memory for the mutex; then there is nothing to finish. */
bool stilb_lock_init(stilb_lock *lock);

/* Nobody holds the lock. It may be initialised again afterwards. */
void stilb_lock_finish(stilb_lock *lock);

/* Waits until no other thread holds the lock, then holds it. The caller does not hold it yet. */
void stilb_lock_take(stilb_lock *lock);

/* Releases the lock, which the caller holds. */
void stilb_lock_give(stilb_lock *lock);

/* True if the calling thread holds the lock. It does not tell whether some other thread does. */
bool stilb_lock_is_mine(const stilb_lock *lock);

#endif
