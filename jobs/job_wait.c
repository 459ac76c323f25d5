#include "jobs/job_internal.h"

/*
 * A group is one 64-bit word: the count of unfinished jobs (low half), who waits (16 bits: worker index + 1, 0 for nobody,
 * WAITERS_OUTSIDE for threads from outside, WAITERS_MANY for several) and whether jobs follow. One word, because the thread that finishes the last job must learn who
 * waits in the same step in which it lets go of the group: a moment later the waiter may have returned and the group
 * be gone.
 *
 * Followers (jobs that start after the group) hang in a list; while there are any, the count is one higher. Who brings it
 * down to that one takes FOLLOWED away in the same step and so holds the last count, alone: it sends the followers on
 * their way while the group cannot go, and only then gives up that count.
 */
#define WAITER_SHIFT 32
#define WAITERS_OUTSIDE 0xfffeu
#define WAITERS_MANY 0xffffu
#define FOLLOWED ((uint64_t)1 << 63)

/* Atomics stay out of the public header, so the word is plain there. */
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
	/* Relaxed: the caller publishes the job itself. */
	atomic_fetch_add_explicit(group_word(group), jobs, memory_order_relaxed);
}

bool job_group_done(stilb_job_group *group)
{
	/* Acquire pairs with the release in group_subtract of every job: the decrements form one release sequence. */
	return word_count(atomic_load_explicit(group_word(group), memory_order_acquire)) == 0;
}

bool job_group_done_but(stilb_job_group *group, uint32_t jobs)
{
	return word_count(atomic_load_explicit(group_word(group), memory_order_relaxed)) <= jobs;
}

/* Asks the last job to wake this waiter; false if the group has finished already and nobody will. */
static bool group_announce(stilb_job_group *group, uint32_t waiter)
{
	_Atomic uint64_t *word = group_word(group);
	uint64_t old = atomic_load_explicit(word, memory_order_relaxed); /* a first guess for the exchange */
	for (;;) {
		if (word_count(old) == 0)
			return false; /* the caller's next job_group_done acquires */
		uint32_t other = word_waiter(old);
		uint64_t next = other == 0 || other == waiter ? waiter : WAITERS_MANY;
		uint64_t wanted = (old & (FOLLOWED | UINT32_MAX)) | next << WAITER_SHIFT;
		/* Relaxed: count and waiter share the word, so either the exchange finds the group finished or the last
		 * decrement finds the waiter. What the jobs wrote is acquired in job_group_done. */
		if (atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_relaxed, memory_order_relaxed))
			return true;
	}
}

/* Takes the announcement back, lest the next use of the group wakes this thread. */
static void group_forget(stilb_job_group *group)
{
	/* Relaxed: if the group is in use again, so be it. */
	uint64_t old = atomic_load_explicit(group_word(group), memory_order_relaxed);
	if (word_count(old) == 0)
		atomic_compare_exchange_strong_explicit(group_word(group), &old, 0, memory_order_relaxed, memory_order_relaxed);
}

static void wake_waiter(stilb_job_pool *pool, uint32_t waiter)
{
	if (waiter == 0)
		return;
	if (waiter < WAITERS_OUTSIDE) {
		job_parker_wake(&pool->slot[waiter - 1].parker);
		return;
	}
	/* Rare. A thread woken in vain looks around and sleeps again. */
	for (uint32_t i = 0; i <= pool->worker_count && waiter == WAITERS_MANY; i++)
		job_parker_wake(&pool->slot[i].parker);
	job_lock_take(&pool->visitors_lock); /* keeps them from returning while they are woken */
	for (job_visitor *visitor = pool->visitors; visitor; visitor = visitor->next)
		job_parker_wake(&visitor->parker);
	job_lock_give(&pool->visitors_lock);
}

/* True if the last count is the caller's now and the followers are its to send. */
static bool group_subtract(stilb_job_pool *pool, stilb_job_group *group, uint32_t jobs)
{
	_Atomic uint64_t *word = group_word(group);
	uint64_t old = atomic_load_explicit(word, memory_order_relaxed); /* a first guess for the exchange */
	uint64_t wanted;
	bool followed;
	do {
		wanted = old - jobs;
		followed = word_count(wanted) == 1 && (old & FOLLOWED);
		if (followed)
			wanted &= ~FOLLOWED;
		/* Release: what the job wrote is seen by who sees it finished (job_group_done); acquire: the sender of the
		 * followers hands on what all the jobs wrote. Not touched again after this if nothing is left. */
	} while (!atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_acq_rel, memory_order_relaxed));
	if (word_count(wanted) == 0)
		wake_waiter(pool, word_waiter(wanted));
	return followed;
}

/* Takes the list of followers, first come first. */
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
		jobs = 1; /* the count that stood for the followers */
	}
}

bool job_group_follow(stilb_job_pool *pool, stilb_job_group *group, job_record *record)
{
	_Atomic uint64_t *word = group_word(group);
	job_lock_take(&pool->after_lock);
	/* Acquire, here and where the exchange fails: if the group has finished, the follower sees what its jobs wrote. */
	uint64_t old = atomic_load_explicit(word, memory_order_acquire);
	for (;;) {
		if (word_count(old) == 0) {
			job_lock_give(&pool->after_lock);
			return false;
		}
		uint64_t wanted = old & FOLLOWED ? old : (old + 1) | FOLLOWED;
		/* Also when nothing changes: whoever takes FOLLOWED away later takes the lock later, and so sees the record.
		 * The record itself goes through the lock. */
		if (atomic_compare_exchange_weak_explicit(word, &old, wanted, memory_order_acquire, memory_order_acquire))
			break;
	}
	record->next = group->after;
	group->after = record;
	job_lock_give(&pool->after_lock);
	return true;
}

/* ---- waiting --------------------------------------------------------------------------------------------------- */

static void visitor_leave(stilb_job_pool *pool, job_visitor *visitor)
{
	job_lock_take(&pool->visitors_lock);
	job_visitor **at = &pool->visitors;
	while (*at != visitor)
		at = &(*at)->next;
	*at = visitor->next;
	job_lock_give(&pool->visitors_lock);
}

/* A thread from outside does not help: it has no place in the pool to do so. */
static void outside_wait(stilb_job_pool *pool, stilb_job_group *group)
{
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

static bool announce_or_done(job_slot *slot, void *group)
{
	return !group_announce(group, slot->index + 1);
}

/* There is nothing to help with: until there is, or the group has finished. */
static void wait_idle(job_slot *slot, const job_scope *scope, stilb_job_group *group, bool *announced)
{
	if (job_work_linger(slot, scope, group))
		return;
	job_idle_fate fate = job_work_park(slot, scope, announce_or_done, group);
	*announced = true;
	if (fate == JOB_IDLE_UNMOVED || (fate == JOB_IDLE_RESCUE && job_work_rescue(slot)))
		return;
	/* Chosen for some work: it is this thread's business that somebody does it. */
	if (!job_work_help(slot, scope, group))
		job_work_pass(slot, &(job_work){.kind = JOB_WORK_SHARED});
}

static void wait_inside(job_slot *slot, stilb_job_group *group)
{
	job_scope scope = {
		.jobs = true, .high = !slot->in_high, .root = slot->root ? slot->root : (uintptr_t)group, .level = slot->level};
	bool alone = slot->pool->worker_count == 0, announced = false;
	while (!job_group_done(group)) {
		if (job_work_help(slot, &scope, group) || (alone && job_work_rescue(slot)))
			continue;
		job_hook_wait_begin(slot->pool, slot->index);
		wait_idle(slot, &scope, group, &announced);
		job_hook_wait_end(slot->pool, slot->index);
	}
	if (announced)
		group_forget(group);
}

void stilb_job_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker)
{
	assert(worker == STILB_JOB_OUTSIDE || worker <= pool->worker_count);
	if (worker == STILB_JOB_OUTSIDE)
		outside_wait(pool, group);
	else
		wait_inside(&pool->slot[worker], group);
}
