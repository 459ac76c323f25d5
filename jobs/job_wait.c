#include "jobs/job_internal.h"

#include <assert.h>

/*
 * A group is one 64-bit word: the count of unfinished jobs (low half) and who waits (high half: worker index + 1, 0 for
 * nobody, WAITERS_MANY for several). One word, because the thread that finishes the last job must learn who waits in
 * the same step in which it lets go of the group: a moment later the waiter may have returned and the group be gone.
 */
#define WAITER_SHIFT 32
#define WAITERS_MANY UINT32_MAX

/* Atomics stay out of the public header, so the word is plain there. */
static _Atomic uint64_t *group_word(stilb_job_group *group)
{
	static_assert(sizeof(_Atomic uint64_t) == sizeof group->state, "an atomic word is a plain word");
	static_assert(_Alignof(_Atomic uint64_t) == _Alignof(stilb_job_group), "and aligned like one");
	return (_Atomic uint64_t *)&group->state;
}

static uint32_t word_waiter(uint64_t word)
{
	return (uint32_t)(word >> WAITER_SHIFT);
}

static bool word_done(uint64_t word)
{
	return (uint32_t)word == 0;
}

void job_group_add(stilb_job_group *group)
{
	/* Relaxed: the caller publishes the job itself, through the queue or the loop list. */
	atomic_fetch_add_explicit(group_word(group), 1, memory_order_relaxed);
}

bool job_group_done(stilb_job_group *group)
{
	/* Acquire pairs with the release in job_group_finish of every job: the decrements form one release sequence. */
	return word_done(atomic_load_explicit(group_word(group), memory_order_acquire));
}

bool job_group_announce(stilb_job_group *group, uint32_t worker)
{
	_Atomic uint64_t *word = group_word(group);
	uint64_t old = atomic_load_explicit(word, memory_order_relaxed); /* a first guess for the exchange */
	for (;;) {
		if (word_done(old))
			return false; /* the caller's next job_group_done acquires */
		uint32_t waiter = word_waiter(old);
		uint32_t next = waiter == 0 || waiter == worker + 1 ? worker + 1 : WAITERS_MANY;
		uint64_t wanted = (uint64_t)next << WAITER_SHIFT | (uint32_t)old;
		/* Relaxed: count and waiter share the word, so either the exchange finds the group finished or the last
		 * decrement finds the waiter. What the jobs wrote is acquired in job_group_done. */
		if (atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_relaxed, memory_order_relaxed))
			return true;
	}
}

void job_group_finish(stilb_job_pool *pool, stilb_job_group *group)
{
	/* Release: what the job wrote is seen by who sees it finished (job_group_done). Not touched again after this. */
	uint64_t old = atomic_fetch_sub_explicit(group_word(group), 1, memory_order_release);
	uint32_t waiter = word_waiter(old);
	if ((uint32_t)old != 1 || waiter == 0)
		return;
	if (waiter != WAITERS_MANY) {
		job_parker_wake(&pool->slot[waiter - 1].parker);
		return;
	}
	for (uint32_t i = 0; i <= pool->worker_count; ++i) /* rare; a thread woken in vain looks around and sleeps again */
		job_parker_wake(&pool->slot[i].parker);
}

void job_group_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker, bool jobs)
{
	bool chosen = false, announced = false;
	while (!job_group_done(group)) {
		if (job_pool_seek(pool, worker, jobs, group)) {
			chosen = false;
		} else {
			chosen = job_pool_park(pool, worker, group, jobs);
			announced = true;
		}
	}
	if (chosen)
		job_pool_wake_next(pool); /* the work this thread was woken for is somebody else's now */
	if (announced) {
		/* Relaxed: forgets the waiter, lest the next use of the group wakes it. If the group is in use again, so be it. */
		uint64_t old = atomic_load_explicit(group_word(group), memory_order_relaxed);
		if (word_done(old))
			atomic_compare_exchange_strong_explicit(group_word(group), &old, 0, memory_order_relaxed,
			                                        memory_order_relaxed);
	}
}

void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker)
{
	assert(worker <= pool->worker_count);
	job_group_wait(pool, group, worker, true);
}
