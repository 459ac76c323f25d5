#include "jobs/job_internal.h"

/* How often a loop is timed when nothing depends on it. */
#define MEASURE_EVERY 16

/* ---- claiming -------------------------------------------------------------------------------------------------- */

/* What a thread needs to know to run slices of a loop: a copy, for the loop may be another one a moment later. */
typedef struct loop_span {
	stilb_job_range_fn *fn;
	void *context;
	uintptr_t root;
	uint32_t level, count, grain, worth;
	uint32_t first, slices; /* claimed */
	uint32_t left;          /* for others */
} loop_span;

/* Guided self-scheduling (Polychronopoulos and Kuck, IEEE Transactions on Computers C-36, 1987): a part of what is left,
 * so there are few claims as long as there is much to do, and single slices at the end, when threads must finish together.
 * But no more than most. */
static uint32_t guided(uint32_t left, uint32_t threads, uint32_t most)
{
	uint32_t part = left / (2 * threads);
	return part > most ? most : part > 0 ? part : 1;
}

static bool loop_claim(job_loop *loop, const job_scope *scope, uint32_t threads, loop_span *out)
{
	/* Acquire pairs with the release in loop_open: the fields, and what the caller's data points to. */
	uint64_t claim = atomic_load_explicit(&loop->claim, memory_order_acquire);
	while ((uint32_t)claim > 0) {
		/* Relaxed: see job_loop. */
		out->root = atomic_load_explicit(&loop->root, memory_order_relaxed);
		out->level = atomic_load_explicit(&loop->level, memory_order_relaxed);
		if (!scope->all && (out->root != scope->root || out->level <= scope->level))
			return false;
		out->fn = atomic_load_explicit(&loop->fn, memory_order_relaxed);
		out->context = atomic_load_explicit(&loop->context, memory_order_relaxed);
		out->count = atomic_load_explicit(&loop->count, memory_order_relaxed);
		out->grain = atomic_load_explicit(&loop->grain, memory_order_relaxed);
		out->worth = atomic_load_explicit(&loop->worth, memory_order_relaxed);
		out->slices = guided((uint32_t)claim, threads, atomic_load_explicit(&loop->most, memory_order_relaxed));
		out->first = atomic_load_explicit(&loop->slices, memory_order_relaxed) - (uint32_t)claim;
		out->left = (uint32_t)claim - out->slices;
		/* Success needs no order of its own: the load above had it. Acquire on failure: the loop may be a new one. */
		if (atomic_compare_exchange_weak_explicit(&loop->claim, &claim, claim - out->slices, memory_order_acquire,
		                                          memory_order_acquire))
			return true;
	}
	return false;
}

static void span_run(const loop_span *span, uint32_t worker)
{
	uint32_t begin = span->first * span->grain;
	for (uint32_t i = 0; i < span->slices; i++, begin += span->grain) {
		uint32_t left = span->count - begin;
		span->fn(begin, begin + (left < span->grain ? left : span->grain), worker, span->context);
	}
}

/* ---- helping --------------------------------------------------------------------------------------------------- */

/* Runs slices of one of owner's loops after the first have been claimed. */
static void loop_help(job_loop *loop, job_slot *owner, job_slot *slot, const job_scope *scope, loop_span *span,
                      stilb_job_group *until)
{
	stilb_job_pool *pool = slot->pool;
	const stilb_job_hooks *hooks = &pool->hooks;
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	uint64_t done = 0, start = slot->spinning ? job_sys_ticks() : 0;
	slot->level = span->level;
	slot->root = span->root;
	if (hooks->job_begin)
		hooks->job_begin(hooks->user, slot->index, loop->tag);
	do {
		span_run(span, slot->index);
		done += span->slices;
		if (slot->spinning && job_sys_ticks() - start > pool->wake_ticks)
			job_work_spin_stop(slot);
	} while (!(until && job_group_done(until)) && loop_claim(loop, scope, pool->worker_count + 1, span));
	if (hooks->job_end)
		hooks->job_end(hooks->user, slot->index);
	slot->level = outer_level;
	slot->root = outer_root;
	/* Release: what the slices wrote is seen by the caller, who acquires in loop_wait. */
	if (atomic_fetch_add_explicit(&loop->done, done, memory_order_release) & JOB_LOOP_WAITER)
		job_parker_wake(&owner->parker);
}

/* Wakes one more thread, if there is one to wake, enough left for it to do and a CPU for it to run on. */
static bool wake_helper(stilb_job_pool *pool, const loop_span *span)
{
	/* A relaxed guess: nobody depends on help, so a wake-up missed here strands no work. */
	return span->left >= span->worth && job_idle_maybe_wanted(&pool->idle) &&
	       (!pool->crowded || job_idle_awake(&pool->idle) + 1 < pool->cpus) &&
	       job_idle_wake(&pool->idle, &(job_work){.kind = JOB_WORK_LOOP, .root = span->root, .level = span->level});
}

static bool slot_help(job_slot *slot, job_slot *owner, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_pool *pool = slot->pool;
	for (int i = 0; i < JOB_LOOP_DEPTH; i++) {
		loop_span span;
		job_loop *loop = &owner->loop[i];
		if (!loop_claim(loop, scope, pool->worker_count + 1, &span))
			continue;
		/* A spinner that will be back sooner than anybody could be woken stays one, and so leaves the word alone that
		 * every loop's caller looks at. */
		if (span.left + span.slices >= span.worth)
			job_work_spin_stop(slot);
		wake_helper(pool, &span);
		loop_help(loop, owner, slot, scope, &span, until);
		return true;
	}
	return false;
}

bool job_loop_help(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_pool *pool = slot->pool;
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		if (slot_help(slot, &pool->slot[i], scope, until))
			return true;
	return false;
}

bool job_loop_exists(stilb_job_pool *pool, const job_scope *scope)
{
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		for (int j = 0; j < JOB_LOOP_DEPTH; j++) {
			job_loop *loop = &pool->slot[i].loop[j];
			/* Relaxed: a loop is done with or without help. */
			if ((uint32_t)atomic_load_explicit(&loop->claim, memory_order_relaxed) > 0 &&
			    (scope->all || (atomic_load_explicit(&loop->root, memory_order_relaxed) == scope->root &&
			                    atomic_load_explicit(&loop->level, memory_order_relaxed) > scope->level)))
				return true;
		}
	return false;
}

/* ---- the caller ------------------------------------------------------------------------------------------------ */

/* The memory of how long slices of fn take; one thread's own, so a plain table. */
static job_rate *rate_of(job_slot *slot, stilb_job_range_fn *fn)
{
	uintptr_t key = (uintptr_t)fn;
	job_rate *rate = &slot->rate[(key >> 4 ^ key >> 10) % JOB_RATES];
	if (rate->fn != fn)
		*rate = (job_rate){.fn = fn};
	return rate;
}

static void loop_open(job_loop *loop, const loop_span *span, uint32_t slices, uint32_t most)
{
	/* Relaxed: see job_loop; nobody looks at the fields while there are no slices left. */
	atomic_store_explicit(&loop->fn, span->fn, memory_order_relaxed);
	atomic_store_explicit(&loop->context, span->context, memory_order_relaxed);
	atomic_store_explicit(&loop->root, span->root, memory_order_relaxed);
	atomic_store_explicit(&loop->level, span->level, memory_order_relaxed);
	atomic_store_explicit(&loop->count, span->count, memory_order_relaxed);
	atomic_store_explicit(&loop->grain, span->grain, memory_order_relaxed);
	atomic_store_explicit(&loop->slices, slices, memory_order_relaxed);
	atomic_store_explicit(&loop->worth, span->worth, memory_order_relaxed);
	atomic_store_explicit(&loop->most, most, memory_order_relaxed);
	uint64_t generation = (atomic_load_explicit(&loop->claim, memory_order_relaxed) >> 32) + 1;
	/* Release pairs with the acquire in loop_claim. */
	atomic_store_explicit(&loop->claim, generation << 32 | span->left, memory_order_release);
}

/* Counts go round; so do the sums of them. */
static bool done_is(uint64_t done, uint64_t wanted)
{
	return ((done ^ wanted) & ~JOB_LOOP_WAITER) == 0;
}

static bool loop_finished(const job_loop *loop, uint64_t wanted)
{
	return done_is(atomic_load_explicit(&loop->done, memory_order_acquire), wanted); /* pairs with loop_help */
}

/* Asks the helpers to wake this thread. False if they have finished. */
static bool loop_announce(job_loop *loop, uint64_t wanted)
{
	/* Acquire, as in loop_finished. In one step with the helpers' counts: either they see the flag, or it sees them. */
	return !done_is(atomic_fetch_or_explicit(&loop->done, JOB_LOOP_WAITER, memory_order_acquire), wanted);
}

typedef struct loop_wait_for {
	job_loop *loop;
	uint64_t wanted;
} loop_wait_for;

static bool loop_ready(job_slot *slot, void *context)
{
	(void)slot;
	loop_wait_for *wait = context;
	return !loop_announce(wait->loop, wait->wanted);
}

/* Spins for a wake-up's length, helping with deeper loops; false if the slices have not been finished then. */
static bool loop_linger(job_loop *loop, job_slot *slot, const job_scope *scope, uint64_t wanted)
{
	uint64_t start = job_sys_ticks();
	do {
		if (loop_finished(loop, wanted))
			return true;
		if (job_work_help(slot, scope, NULL))
			start = job_sys_ticks();
		job_work_relax(slot);
	} while (job_sys_ticks() - start < slot->pool->wake_ticks);
	return false;
}

/* Waits for the slices that others have claimed: until done has come to wanted. */
static void loop_wait(job_loop *loop, job_slot *slot, const loop_span *span, uint64_t wanted)
{
	if (loop_finished(loop, wanted))
		return;
	job_hook_wait_begin(slot->pool, slot->index);
	const job_scope scope = {.root = span->root, .level = span->level};
	loop_wait_for wait = {.loop = loop, .wanted = wanted};
	bool announced = false;
	while (!loop_linger(loop, slot, &scope, wanted)) {
		announced = true;
		if (job_work_park(slot, &scope, loop_ready, &wait) == JOB_IDLE_CHOSEN && !job_work_help(slot, &scope, NULL))
			job_work_pass(slot, &(job_work){.kind = JOB_WORK_SHARED});
	}
	if (announced) /* nobody else writes it now; relaxed: the next loop_open publishes it */
		atomic_store_explicit(&loop->done, wanted & ~JOB_LOOP_WAITER, memory_order_relaxed);
	job_hook_wait_end(slot->pool, slot->index);
}

/* From how many slices on a wake-up pays; unknown slices may be long. */
static uint32_t slices_worth(const stilb_job_pool *pool, uint64_t ticks)
{
	return ticks == 0                              ? 1
	       : ticks * UINT32_MAX < pool->wake_ticks ? UINT32_MAX
	                                               : (uint32_t)(pool->wake_ticks / ticks) + 1;
}

/* The loop in the caller's slot, open for all. Not inline: the way of short loops stays short. */
__attribute__((noinline)) static void loop_run(job_slot *slot, loop_span *span, uint32_t slices, bool asleep)
{
	stilb_job_pool *pool = slot->pool;
	job_loop *loop = &slot->loop[slot->loops_open++];
	job_rate *rate = rate_of(slot, span->fn);
	bool measured = asleep || rate->ticks == 0 || slot->loops_run++ % MEASURE_EVERY == 0;
	uint64_t start = measured ? job_sys_ticks() : 0;
	uint32_t threads = pool->worker_count + 1;
	/* With more threads than CPUs one that has claimed much may not be running, and all would have to wait for it. */
	uint32_t most = pool->crowded && rate->ticks > 0 ? slices_worth(pool, rate->ticks) : UINT32_MAX;
	uint32_t all = slices - span->first;
	span->slices = guided(all, threads, most);
	span->left = all - span->slices;
	if (pool->hooks.submit)
		loop->tag = pool->hooks.submit(pool->hooks.user, slot->index);
	loop_open(loop, span, slices, most);
	/* Asked again after the loop has been opened, for the last spinner may have gone to sleep just before; and then after each
	 * span, for in the relaxed look of a worker that goes to sleep the loop may not have been open yet. */
	bool woken = wake_helper(pool, span);
	uint64_t mine = 0;
	do {
		span_run(span, slot->index);
		mine += span->slices;
		if (!woken && span->left > 0 && job_idle_maybe_wanted(&pool->idle)) {
			/* What the first slices took says more than what others took some time ago. */
			if (measured) {
				span->worth = slices_worth(pool, (job_sys_ticks() - start) / mine);
				atomic_store_explicit(&loop->worth, span->worth, memory_order_relaxed);
			}
			woken = wake_helper(pool, span);
		}
	} while (loop_claim(loop, &job_scope_all, threads, span));
	if (measured)
		rate->ticks = (job_sys_ticks() - start) / mine + 1;
	if (mine < all) {
		loop->finished += all - mine;
		loop_wait(loop, slot, span, loop->finished);
	}
	slot->loops_open--;
}

/* Nobody is awake to help, and by what slices of fn took last time it would be over before somebody is. If this time they take
 * longer, the rest is left: how many slices were run. */
static uint32_t loop_run_short(job_slot *slot, const loop_span *span, uint32_t slices, uint64_t start)
{
	uint64_t ticks = 0;
	loop_span part = *span;
	for (part.first = 0; part.first < slices && ticks < slot->pool->wake_ticks; part.first += part.slices) {
		part.slices = (slices - part.first + 1) / 2;
		span_run(&part, slot->index);
		ticks = job_sys_ticks() - start;
	}
	rate_of(slot, span->fn)->ticks = ticks / part.first + 1;
	slot->alone_until = start + ticks;
	slot->alone += ticks;
	return part.first;
}

/* Is it better to let the others sleep? Yes if this loop is shorter than a wake-up. But if one such loop follows another, a
 * worker that is awake would spin from one to the next and help with all of them: so when the short loops in a row have
 * come to what a wake-up costs, it is paid; at worst that is twice what it would have cost to know the future. */
static bool loop_stays_alone(job_slot *slot, const loop_span *span, uint32_t slices, uint64_t start)
{
	uint64_t wake_ticks = slot->pool->wake_ticks;
	if (start - slot->alone_until > wake_ticks)
		slot->alone = 0;
	return slices < span->worth && slot->alone < wake_ticks;
}

void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker)
{
	assert(worker <= pool->worker_count);
	if (count == 0)
		return;
	job_slot *slot = &pool->slot[worker];
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	loop_span span = {.fn = fn, .context = context, .count = count, .grain = grain ? grain : 1};
	uint32_t slices = (count - 1) / span.grain + 1;
	/* A loop that comes from no job is a root of its own, named by the place where it lies. */
	slot->root = span.root = outer_root ? outer_root : (uintptr_t)&slot->loop[0];
	slot->level = span.level = outer_level + 1;
	if (slices > 1 && pool->worker_count > 0 && slot->loops_open < JOB_LOOP_DEPTH) {
		bool asleep = job_idle_maybe_wanted(&pool->idle);
		span.worth = slices_worth(pool, rate_of(slot, fn)->ticks);
		uint64_t start = asleep ? job_sys_ticks() : 0;
		if (asleep && loop_stays_alone(slot, &span, slices, start))
			span.first = loop_run_short(slot, &span, slices, start);
		else if (asleep)
			span.worth = 1;
		if (span.first < slices)
			loop_run(slot, &span, slices, asleep);
	} else {
		span.slices = slices;
		span_run(&span, worker);
	}
	slot->level = outer_level;
	slot->root = outer_root;
}
