/*
 * base_contract: which thread calls and which lock it holds, as asserts. C alone, no C++.
 *
 *   STILB_ASSERT_OWNER(render->owner);        the caller is the thread that took the owner last
 *   STILB_ASSERT_LOCKED(&resources->lock);    the caller holds this stilb_lock
 *
 * An object that is [main-thread] takes its owner when it is created; an object handed to another thread is taken
 * there. The structs are the same with and without NDEBUG. Every function is [any-thread].
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

/* From now on the object is the calling thread's. */
void stilb_owner_take(stilb_owner *owner);

/* The object belongs to the calling thread, or to nobody. */
bool stilb_owner_is_me(const stilb_owner *owner);

/* A mutex that knows who holds it, for STILB_ASSERT_LOCKED. stilb_lock_init -> take / give, from any thread ->
 * stilb_lock_finish. Not recursive: taking it twice is an assert. */
typedef struct stilb_lock {
	pthread_mutex_t mutex;
	stilb_owner holder;
} stilb_lock;

/* False: no memory for the mutex; then there is nothing to finish. */
bool stilb_lock_init(stilb_lock *lock);
void stilb_lock_finish(stilb_lock *lock);
void stilb_lock_take(stilb_lock *lock);
void stilb_lock_give(stilb_lock *lock);
bool stilb_lock_is_mine(const stilb_lock *lock);

#endif
