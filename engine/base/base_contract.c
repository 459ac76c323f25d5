/* base_contract: who owns an object and who holds a lock, for the asserts of base.h. */
#include "base/base_contract.h"

#include <stdatomic.h>

/* pthread_self is a pointer on Linux and never 0. */
static uintptr_t me(void)
{
	return (uintptr_t)pthread_self();
}

void stilb_owner_take(stilb_owner *owner)
{
	STILB_ASSERT(owner);
	/* Relaxed: the value is only compared with the reader's own identity, which no other thread stores. So a thread
	 * that owns the object reads its own store, and any other reads something different, old or new. */
	atomic_store_explicit(&owner->thread, me(), memory_order_relaxed);
}

bool stilb_owner_is_me(const stilb_owner *owner)
{
	STILB_ASSERT(owner);
	uintptr_t thread = atomic_load_explicit(&owner->thread, memory_order_relaxed); /* stilb_owner_take says why */
	return thread == 0 || thread == me();
}

bool stilb_lock_init(stilb_lock *lock)
{
	STILB_ASSERT(lock);
	*lock = (stilb_lock){0};
	return pthread_mutex_init(&lock->mutex, NULL) == 0;
}

void stilb_lock_finish(stilb_lock *lock)
{
	STILB_ASSERT(atomic_load_explicit(&lock->holder.thread, memory_order_relaxed) == 0 && "nobody holds the lock");
	pthread_mutex_destroy(&lock->mutex);
}

void stilb_lock_take(stilb_lock *lock)
{
	STILB_ASSERT(!stilb_lock_is_mine(lock) && "the lock is not taken twice");
	pthread_mutex_lock(&lock->mutex);
	STILB_ASSERT(atomic_load_explicit(&lock->holder.thread, memory_order_relaxed) == 0 && "the last holder gave it");
	stilb_owner_take(&lock->holder);
}

void stilb_lock_give(stilb_lock *lock)
{
	STILB_ASSERT_LOCKED(lock);
	atomic_store_explicit(&lock->holder.thread, 0, memory_order_relaxed); /* stilb_owner_take says why */
	pthread_mutex_unlock(&lock->mutex);
}

bool stilb_lock_is_mine(const stilb_lock *lock)
{
	return atomic_load_explicit(&lock->holder.thread, memory_order_relaxed) == me(); /* stilb_owner_take says why */
}
