#include "jobs/job_internal.h"

/*
 * A group is one 64-bit word: the count of unfinished jobs (bits 0 to 31), the waiter (bits 32 to 47: worker index + 1,
 * 0 for none, WAITERS_OUTSIDE for outside threads, WAITERS_MANY for several threads), CANCELLED, whether its jobs are
 * dropped until it has finished, and FOLLOWED, whether jobs follow.
 * It is one word because the thread that finishes the last job must learn who waits in the same step in which it drops
 * its last reference to the group: a moment later the waiter may have returned and freed the group.
 *
 * Followers (jobs `after` the group) form a list; while there are any, the count is one higher. The thread that brings
 * the count down to that one clears FOLLOWED in the same step, and so becomes the only owner of the last count: it
 * submits the followers while the group cannot finish, and then subtracts that count.
 */
#define WAITER_SHIFT 32
#define WAITERS_OUTSIDE 0xfffeu
#define WAITERS_MANY 0xffffu
#define CANCELLED ((uint64_t)1 << 62)
#define FOLLOWED ((uint64_t)1 << 63)

/* The public header has no atomics, so the word is plain there. */
static _Atomic uint64_t *group_word(stilb_job_group *group)
{
	static_assert(sizeof(_Atomic uint64_t) == sizeof group->state, "an atomic word is a plain word");
	static_assert(_Alignof(_Atomic uint64_t) == _Alignof(stilb_job_group), "and aligned like one");
	return (_Atomic uint64_t *)&group->state;
}

static uint32_t word_waiter(uint64_t word)
{
	return (uint32_t)(word >> WAITER_SHIFT) & WAITERS_MANY;
}

static uint32_t word_count(uint64_t word)
{
	return (uint32_t)word;
}

void job_group_add(stilb_job_group *group, uint32_t jobs)
{
	assert((uintptr_t)group % _Alignof(stilb_job_group) == 0);
	/* Relaxed: orders nothing; the caller publishes the job later, by pushing it. */
	uint64_t old = atomic_fetch_add_explicit(group_word(group), jobs, memory_order_relaxed);
	assert(word_count(old) <= UINT32_MAX - 1 - jobs &&
	       "2^32 - 2 unfinished jobs at most; was the group zero-initialised?");
	(void)old;
}

bool job_group_done(stilb_job_group *group)
{
	/* Acquire pairs with the release in group_subtract of every job: the subtractions form one release sequence. */
	return word_count(atomic_load_explicit(group_word(group), memory_order_acquire)) == 0;
}

bool job_group_done_but(stilb_job_group *group, uint32_t jobs)
{
	return word_count(atomic_load_explicit(group_word(group), memory_order_relaxed)) <= jobs;
}

/* Writes the waiter (worker index + 1, or WAITERS_OUTSIDE) into the group's word, so that the thread that finishes the
 * last job wakes it. False if the group has finished already: then no thread will wake it. */
static bool group_announce(stilb_job_group *group, uint32_t waiter)
{
	_Atomic uint64_t *word = group_word(group);
	uint64_t old = atomic_load_explicit(word, memory_order_relaxed); /* the first guess of the exchange */
	for (;;) {
		if (word_count(old) == 0)
			return false; /* the caller's next job_group_done acquires what the jobs wrote */
		uint32_t other = word_waiter(old);
		uint64_t next = other == 0 || other == waiter ? waiter : WAITERS_MANY;
		uint64_t wanted = (old & (FOLLOWED | CANCELLED | UINT32_MAX)) | next << WAITER_SHIFT;
		/* Relaxed: count and waiter share the word, so either the exchange finds the group finished, or the last
		 * subtraction finds the waiter. What the jobs wrote is acquired in job_group_done. */
		if (atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_relaxed, memory_order_relaxed))
			return true;
	}
}

/* Withdraws group_announce, so that the next use of the group does not wake this thread. */
static void group_forget(stilb_job_group *group)
{
	/* Relaxed: orders nothing. If the group is in use again already, the waiter stays in the word, and a needless
	 * wake-up is harmless. */
	uint64_t old = atomic_load_explicit(group_word(group), memory_order_relaxed);
	if (word_count(old) == 0)
		atomic_compare_exchange_strong_explicit(group_word(group), &old, 0, memory_order_relaxed, memory_order_relaxed);
}

static void wake_waiter(stilb_job_pool *pool, uint32_t waiter)
{
	if (waiter == 0)
		return;
	if (waiter < WAITERS_OUTSIDE) {
		assert(waiter <= pool->worker_count + 1 && "all jobs and waits of a group are in one pool");
		job_parker_wake(&pool->slot[waiter - 1].parker);
		return;
	}
	/* Outside threads or several threads wait, which is rare: wakes all that could be meant. A thread woken in vain
	 * finds its group unfinished and sleeps again. */
	for (uint32_t i = 0; i <= pool->worker_count && waiter == WAITERS_MANY; i++)
		job_parker_wake(&pool->slot[i].parker);
	/* A visitor is the entry of an outside thread that waits, on that thread's stack; it takes the lock to leave the
	 * list, so it stays alive while it is woken. */
	job_lock_take(&pool->visitors_lock);
	for (job_visitor *visitor = pool->visitors; visitor; visitor = visitor->next)
		job_parker_wake(&visitor->parker);
	job_lock_give(&pool->visitors_lock);
}

/* Subtracts finished jobs from the count. True if only the followers' count is left: the caller then owns it and must
 * submit the followers (see the head of this file). */
static bool group_subtract(stilb_job_pool *pool, stilb_job_group *group, uint32_t jobs)
{
	_Atomic uint64_t *word = group_word(group);
	uint64_t old = atomic_load_explicit(word, memory_order_relaxed); /* the first guess of the exchange */
	uint64_t wanted;
	bool followed;
	do {
		assert(word_count(old) >= jobs && "a job finishes once");
		wanted = old - jobs;
		followed = word_count(wanted) == 1 && (old & FOLLOWED);
		if (followed)
			wanted &= ~FOLLOWED;
		if (word_count(wanted) == 0)
			wanted &= ~CANCELLED;
		/* Release: a thread that sees the job finished (job_group_done) sees what it wrote. Acquire: the thread that
		 * submits the followers passes on what all the jobs wrote. If the count is now 0, the group may be gone. */
	} while (!atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_acq_rel, memory_order_relaxed));
	if (old & CANCELLED & ~wanted)
		atomic_fetch_sub_explicit(&pool->cancels, 1, memory_order_relaxed); /* see stilb_job_group_cancel */
	if (word_count(wanted) == 0)
		wake_waiter(pool, word_waiter(wanted));
	return followed;
}

/* Takes the list of followers, in the order of submission. */
static job_record *group_take_followers(stilb_job_pool *pool, stilb_job_group *group)
{
	job_lock_take(&pool->after_lock);
	job_record *newest = group->after, *oldest = NULL;
	group->after = NULL;
	job_lock_give(&pool->after_lock);
	while (newest) {
		job_record *next = newest->next;
		newest->next = oldest;
		oldest = newest;
		newest = next;
	}
	return oldest;
}

void job_group_finish(job_slot *slot, stilb_job_group *group, uint32_t jobs)
{
	while (group_subtract(slot->pool, group, jobs)) {
		job_record *record = group_take_followers(slot->pool, group);
		while (record) {
			job_record *next = record->next;
			job_submit_record(slot, record);
			record = next;
		}
		jobs = 1; /* the additional count of the followers */
	}
}

bool job_group_follow(stilb_job_pool *pool, stilb_job_group *group, job_record *record)
{
	_Atomic uint64_t *word = group_word(group);
	job_lock_take(&pool->after_lock);
	/* Acquire, here and when the exchange fails: if the group has finished, the follower (the job of this record) sees
	 * what the group's jobs wrote. */
	uint64_t old = atomic_load_explicit(word, memory_order_acquire);
	for (;;) {
		if (word_count(old) == 0) {
			job_lock_give(&pool->after_lock);
			return false;
		}
		uint64_t wanted = old & FOLLOWED ? old : (old + 1) | FOLLOWED;
		/* Exchanged even if the word does not change: the thread that clears FOLLOWED later takes the lock later, and
		 * then sees the record. The record itself is published by the lock. */
		if (atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_acquire, memory_order_acquire))
			break;
	}
	record->next = group->after;
	group->after = record;
	job_lock_give(&pool->after_lock);
	return true;
}

/* ---- cancelling ------------------------------------------------------------------------------------------------ */

static uint64_t group_state(const stilb_job_group *group)
{
	/* Relaxed: jobs that start at the moment of a cancel may or may not run. */
	return atomic_load_explicit((const _Atomic uint64_t *)&group->state, memory_order_relaxed);
}

void stilb_job_group_cancel(stilb_job_pool *pool, stilb_job_group *group)
{
	assert(pool && group);
	/* Raised first, and lowered by the thread that clears CANCELLED, so that it never falls below zero. Relaxed, all: a
	 * thread that starts a job because of something that the caller did after this call sees both. */
	atomic_fetch_add_explicit(&pool->cancels, 1, memory_order_relaxed);
	uint64_t old = group_state(group); /* the first guess of the exchange */
	while (word_count(old) > 0 && !(old & CANCELLED))
		if (atomic_compare_exchange_weak_explicit(group_word(group), &old, old | CANCELLED, memory_order_relaxed,
		                                          memory_order_relaxed))
			return;
	atomic_fetch_sub_explicit(&pool->cancels, 1, memory_order_relaxed);
}

bool stilb_job_group_is_cancelled(const stilb_job_group *group)
{
	assert(group);
	return group_state(group) & CANCELLED;
}

bool job_group_drops(stilb_job_pool *pool, const stilb_job_group *group)
{
	return atomic_load_explicit(&pool->cancelled, memory_order_relaxed) || /* see the field */
	       (group && stilb_job_group_is_cancelled(group));
}

/* ---- waiting --------------------------------------------------------------------------------------------------- */

/* Takes the entry of an outside thread, which waits no longer, out of the list. */
static void visitor_leave(stilb_job_pool *pool, job_visitor *visitor)
{
	job_lock_take(&pool->visitors_lock);
	job_visitor **at = &pool->visitors;
	while (*at != visitor) {
		assert(*at && "the visitor is in the list");
		at = &(*at)->next;
	}
	*at = visitor->next;
	job_lock_give(&pool->visitors_lock);
}

/* stilb_job_wait for a thread from outside the pool. It only sleeps: without a slot it cannot run jobs. */
static void wait_outside(stilb_job_pool *pool, stilb_job_group *group)
{
	assert(job_pool_is_outside(pool) && "a thread of the pool waits with its index");
	if (job_group_done(group))
		return;
	job_hook_wait_begin(pool, STILB_JOB_OUTSIDE);
	job_visitor visitor = {0};
	job_lock_take(&pool->visitors_lock);
	visitor.next = pool->visitors;
	pool->visitors = &visitor;
	job_lock_give(&pool->visitors_lock);
	while (!job_group_done(group))
		if (group_announce(group, WAITERS_OUTSIDE))
			job_parker_sleep(&visitor.parker);
	visitor_leave(pool, &visitor);
	group_forget(group);
	job_hook_wait_end(pool, STILB_JOB_OUTSIDE);
}

/* For job_work_park: makes the thread the waiter of the group; true if the group has finished, so it need not sleep. */
static bool announce_or_done(job_slot *slot, void *group)
{
	return !group_announce(group, slot->index + 1);
}

/* Spins, then runs jobs that job_work_help does not find, or sleeps if there are none, until there seems to be work
 * that the scope allows or the group has finished. True if it has run a job. *announced is set if this thread may have
 * entered itself into the group as its waiter (group_announce), which the caller must then withdraw with
 * group_forget. */
static bool wait_idle(job_slot *slot, const job_scope *scope, stilb_job_group *group, bool *announced)
{
	if (job_work_spin(slot, scope, group))
		return false;
	if (job_work_unbury(slot, scope, group))
		return true;
	job_idle_outcome outcome = job_work_park(slot, scope, announce_or_done, group);
	*announced = true;
	if (outcome == JOB_IDLE_NOT_CHOSEN)
		return false;
	if (outcome == JOB_IDLE_RESCUE && job_work_rescue(slot))
		return true;
	/* Chosen for some work: this thread does it, or wakes another thread for it. */
	if (job_work_help(slot, scope, group))
		return true;
	job_work_wake_next(slot, &(job_work){.kind = JOB_WORK_SHARED});
	return false;
}

static void wait_inside(job_slot *slot, stilb_job_group *group)
{
	if (job_group_done(group))
		return;
	job_scope scope = {
		.jobs = true, .high = !slot->in_high, .root = slot->root ? slot->root : (uintptr_t)group, .level = slot->level};
	bool alone = slot->pool->worker_count == 0, announced = false;
	bool dug = false; /* no job for this wait lies in the thread's own deque, until the thread runs a job again */
	job_work_run_own(slot, &scope, group);
	while (!job_group_done(group)) {
		if (job_work_help(slot, &scope, group)) {
			dug = false;
		} else if (!dug && job_work_dig(slot, &scope)) {
			continue;
		} else if (alone) {
			dug = true; /* unrelated jobs submit none of this root, so there is no need to dig after each of them */
			job_work_rescue(slot);
		} else {
			job_hook_wait_begin(slot->pool, slot->index);
			dug = !wait_idle(slot, &scope, group, &announced);
			job_hook_wait_end(slot->pool, slot->index);
		}
	}
	if (announced)
		group_forget(group);
}

void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker)
{
	assert(pool && group);
	if (worker == STILB_JOB_OUTSIDE)
		wait_outside(pool, group);
	else
		wait_inside(job_slot_of(pool, worker), group);
}
