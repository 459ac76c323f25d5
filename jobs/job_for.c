#include "jobs/job_internal.h"

/* One loop in so many is timed even if all workers are awake, so that the known slice times (job_rate) stay true. */
#define MEASURE_EVERY 16

#define JOB_MEMORY_NAP_NS 1000000u /* between two attempts to get memory, which other threads may free meanwhile */

/* ---- claiming -------------------------------------------------------------------------------------------------- */

/* Claimed slices of a loop, with a copy of its fields: the loop may be reused a moment later. */
typedef struct loop_span {
	stilb_job_range_fn *fn;
	void *context;
	uintptr_t root;
	uint32_t level, count, grain, wake_slices;
	uint32_t first, slices; /* the claimed slices: index of the first one, and their number */
	uint32_t left;          /* slices of the loop that are still unclaimed */
} loop_span;

/* The number of slices to claim by guided self-scheduling (Polychronopoulos and Kuck, IEEE Transactions on Computers
 * C-36, 1987): a fraction of those left, which makes few claims while there are many, and single slices at the end,
 * when the threads must finish together. At most limit. */
static uint32_t guided(uint32_t left, uint32_t threads, uint32_t limit)
{
	assert(left > 0 && threads > 0 && limit > 0);
	uint32_t part = left / (2 * threads);
	return part > limit ? limit : part > 0 ? part : 1;
}

/* Claims slices of loop, which any thread may have opened, if the scope allows it: `wanted` of them at most, or as many
 * as guided() says if wanted is 0. False if there are none. */
static bool loop_claim(job_loop *loop, const job_scope *scope, uint32_t threads, uint32_t wanted, loop_span *out)
{
	/* Acquire pairs with the release in loop_open: the fields, and all that the caller wrote before. */
	uint64_t claim = atomic_load_explicit(&loop->claim, memory_order_acquire);
	while ((uint32_t)claim > 0) {
		/* Relaxed: the fields are known to be valid if the exchange of claim below succeeds (see job_loop). If root or
		 * level are those of another use of the loop, at worst this use gets no help from the calling thread. */
		out->root = atomic_load_explicit(&loop->root, memory_order_relaxed);
		out->level = atomic_load_explicit(&loop->level, memory_order_relaxed);
		if (!scope->all && (out->root != scope->root || out->level <= scope->level))
			return false;
		out->fn = atomic_load_explicit(&loop->fn, memory_order_relaxed);
		out->context = atomic_load_explicit(&loop->context, memory_order_relaxed);
		out->count = atomic_load_explicit(&loop->count, memory_order_relaxed);
		out->grain = atomic_load_explicit(&loop->grain, memory_order_relaxed);
		out->wake_slices = atomic_load_explicit(&loop->wake_slices, memory_order_relaxed);
		uint32_t left = (uint32_t)claim, limit = atomic_load_explicit(&loop->claim_limit, memory_order_relaxed);
		out->slices = wanted == 0 ? guided(left, threads, limit) : wanted < left ? wanted : left;
		out->first = atomic_load_explicit(&loop->slices, memory_order_relaxed) - left;
		out->left = left - out->slices;
		/* Success needs no order, since the load of claim has acquired the fields. Acquire on failure: the loop may
		 * have been reused, and its fields are read again. */
		if (atomic_compare_exchange_weak_explicit(&loop->claim, &claim, claim - out->slices, memory_order_acquire,
		                                          memory_order_acquire))
			return true;
	}
	return false;
}

static void span_run(const loop_span *span, uint32_t worker)
{
	assert(span->slices > 0 && span->first <= (span->count - 1) / span->grain + 1 - span->slices);
	uint32_t begin = span->first * span->grain;
	for (uint32_t i = 0; i < span->slices; i++, begin += span->grain) {
		uint32_t left = span->count - begin;
		span->fn(begin, begin + (left < span->grain ? left : span->grain), worker, span->context);
	}
}

/* ---- helping --------------------------------------------------------------------------------------------------- */

/* For whom a thread helps: which loops, and until which group has finished (may be NULL). */
typedef struct help_with {
	const job_scope *scope;
	stilb_job_group *until;
} help_with;

/* The number of threads among which the slices of a loop are shared. team: as in loop_help. */
static uint32_t loop_threads(const stilb_job_pool *pool, const job_team *team)
{
	return team ? team->end - team->begin : pool->worker_count + 1;
}

/* Adds finished slices to the loop's count, and wakes the loop's caller, the thread of `owner`, if it sleeps. After the
 * addition the loop may be finished, and used again. Returns the count before. */
static uint64_t loop_count(job_loop *loop, job_slot *owner, uint64_t slices)
{
	/* Release: the loop's caller, who acquires in loop_finished, sees what the slices wrote. Acquire: the thread that
	 * counts the last slices of a part of a wide loop passes on what all of them wrote. */
	uint64_t before = atomic_fetch_add_explicit(&loop->done, slices, memory_order_acq_rel);
	if (before & JOB_LOOP_WAITER)
		job_parker_wake(&owner->parker);
	return before;
}

/* The part in which the end of the team's part of a wide loop is counted (job_team). */
static job_loop *gathered_in(const stilb_job_pool *pool, const job_team *team)
{
	uint32_t number = (uint32_t)(team - pool->team);
	return &pool->team[number - number % JOB_GATHER].part;
}

/* Counts slices of the team's part that the calling thread has finished; the last ones of a part that is gathered
 * elsewhere count as one slice there. */
static void part_count(stilb_job_pool *pool, job_team *team, job_slot *owner, uint64_t slices)
{
	job_loop *whole = gathered_in(pool, team);
	/* Relaxed: constant until all slices are done, and some are the calling thread's. */
	uint32_t goal = atomic_load_explicit(&team->part.goal, memory_order_relaxed);
	uint64_t before = loop_count(&team->part, owner, slices);
	if (whole != &team->part && (uint32_t)(before + slices) == goal)
		loop_count(whole, owner, 1);
}

/* Runs the claimed slices of a loop, and then claims and runs more of them while there are any. slot is the calling
 * thread's; team: as in loop_help. */
static void run_claimed(job_loop *loop, job_slot *slot, job_team *team, const help_with *with, loop_span *span)
{
	stilb_job_pool *pool = slot->pool;
	uint32_t threads = loop_threads(pool, team);
	/* Relaxed: constant until all slices are done, and some are the calling thread's. */
	job_slot *owner = &pool->slot[atomic_load_explicit(&loop->owner, memory_order_relaxed)];
	const stilb_job_hooks *hooks = &pool->hooks;
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	uint64_t done = 0, start = slot->spinning ? job_sys_ticks() : 0;
	job_active_begin(slot, JOB_ACTIVE_JOBS);
	slot->level = span->level;
	slot->root = span->root;
	if (hooks->job_begin)
		hooks->job_begin(hooks->user, slot->index, loop->tag);
	do {
		span_run(span, slot->index);
		done += span->slices;
		if (slot->spinning && job_sys_ticks() - start > pool->wake_ticks)
			job_work_spin_stop(slot);
	} while (!(with->until && job_group_done(with->until)) && loop_claim(loop, with->scope, threads, 0, span));
	if (hooks->job_end)
		hooks->job_end(hooks->user, slot->index);
	job_tally(&slot->tally.loops_helped, 1);
	job_tally(&slot->tally.slices, done);
	slot->level = outer_level;
	slot->root = outer_root;
	if (team)
		part_count(pool, team, owner, done);
	else
		loop_count(loop, owner, done);
}

/* Wakes one more thread if one sleeps, there are `spinners` spinners at most, enough slices are left for a thread, and
 * it has a CPU to run on; true if it did. */
static bool wake_helper(stilb_job_pool *pool, const loop_span *span, uint32_t spinners)
{
	job_work work = {.kind = JOB_WORK_LOOP, .root = span->root, .level = span->level, .spinners = spinners};
	/* Relaxed: may miss a sleeping thread. Loops finish without help, so that blocks nothing. */
	return span->left >= span->wake_slices && job_idle_maybe_wanted_beside(&pool->idle, spinners) &&
	       (!pool->oversubscribed || job_idle_awake(&pool->idle) + 1 < pool->cpus) && job_idle_wake(&pool->idle, &work);
}

/* For a thread that has come to help: wakes JOB_WAKE_FAN more, so that help grows as a tree (job_park.h). */
static void wake_helpers(stilb_job_pool *pool, const loop_span *span)
{
	if (span->left < span->wake_slices)
		return;
	uint32_t threads = span->left / span->wake_slices; /* a wake-up pays for so many */
	for (uint32_t i = 0; i < JOB_WAKE_FAN && wake_helper(pool, span, threads - 1); i++)
		;
}

/* Claims and runs slices of a loop; false if there are none or the scope does not allow it. team: whose part of a wide
 * loop it is, NULL for other loops. */
static bool loop_help(job_loop *loop, job_slot *slot, job_team *team, const help_with *with)
{
	loop_span span;
	stilb_job_pool *pool = slot->pool;
	if (!loop_claim(loop, with->scope, loop_threads(pool, team), 0, &span))
		return false;
	/* If the slices left take less time than a wake-up, the spinner stays counted as one while it helps. That saves
	 * writing the idle list's `state`, which the caller of every loop reads. */
	if (span.left + span.slices >= span.wake_slices)
		job_work_spin_stop(slot);
	/* If the own part has slices left, so have the others; but it is the first to be empty where others come from. */
	uint64_t left = (uint64_t)span.left * (team && team == slot->team ? pool->team_count : 1);
	span.left = left < UINT32_MAX ? (uint32_t)left : UINT32_MAX;
	wake_helpers(pool, &span);
	run_claimed(loop, slot, team, with, &span);
	return true;
}

/* Helps with one of the loops of a thread; false if there is none that the scope allows. */
static bool help_thread(job_slot *slot, uint32_t thread, void *with)
{
	job_slot *owner = &slot->pool->slot[thread];
	for (int i = 0; i < JOB_LOOP_DEPTH; i++)
		/* Relaxed: most loops are closed, which this sees without a call; loop_claim reads the word again. */
		if ((uint32_t)atomic_load_explicit(&owner->loop[i].claim, memory_order_relaxed) > 0 &&
		    loop_help(&owner->loop[i], slot, NULL, with))
			return true;
	return false;
}

/* Helps with the part of a wide loop that is for the team after `after` others in the circle that begins with the
 * thread's own. */
static bool help_team(job_slot *slot, uint32_t after, const help_with *with)
{
	stilb_job_pool *pool = slot->pool;
	job_team *team = &pool->team[((uint32_t)(slot->team - pool->team) + after) % pool->team_count];
	return loop_help(&team->part, slot, team, with);
}

/* Helps with the own team's part of a wide loop and then with those of other teams, from a random one on, until one has
 * no slices left: the others then have few or none, and a look at each takes a cache line from its team. Or helps with
 * a loop of a thread of the team. */
static bool help_near(job_slot *slot, help_with *with)
{
	uint32_t others = slot->pool->team_count - 1;
	if (!help_team(slot, 0, with))
		return job_visit_active(slot, JOB_ACTIVE_LOOPS, slot->team->begin, slot->team->end, help_thread, with);
	for (uint32_t i = 0, first = job_random_below(slot, others); i < others; i++)
		if (!help_team(slot, 1 + (first + i) % others, with))
			break;
	return true;
}

static bool help_far(job_slot *slot, help_with *with)
{
	for (uint32_t i = 1; i < slot->pool->team_count; i++)
		if (help_team(slot, i, with))
			return true;
	return job_visit_active(slot, JOB_ACTIVE_LOOPS, 0, slot->pool->worker_count + 1, help_thread, with);
}

/* True once in so many calls that one of them falls to each of the other teams (JOB_NEAR_LOOKS). */
static bool is_far_look(job_slot *slot)
{
	if (++slot->near_looks < JOB_NEAR_LOOKS * (slot->pool->team_count - 1))
		return false;
	slot->near_looks = 0;
	return true;
}

bool job_loop_help(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	help_with with = {.scope = scope, .until = until};
	if (slot->pool->one_team)
		return job_visit_team(slot, 0, help_thread, &with);
	if (help_near(slot, &with))
		return true;
	if (!slot->look_far && !is_far_look(slot))
		return false;
	slot->look_far = false;
	return help_far(slot, &with);
}

/* True if the loop has slices left to claim and the scope allows it. Relaxed, all: may miss a loop that has just been
 * opened, see job_internal.h. */
static bool loop_has(job_loop *loop, const job_scope *scope)
{
	return (uint32_t)atomic_load_explicit(&loop->claim, memory_order_relaxed) > 0 &&
	       (scope->all || (atomic_load_explicit(&loop->root, memory_order_relaxed) == scope->root &&
	                       atomic_load_explicit(&loop->level, memory_order_relaxed) > scope->level));
}

/* True if one of the threads begin <= i < end has such a loop. */
static bool threads_have(stilb_job_pool *pool, uint32_t begin, uint32_t end, const job_scope *scope)
{
	for (uint32_t i = job_active_from(pool, JOB_ACTIVE_LOOPS, begin); i < end;
	     i = job_active_from(pool, JOB_ACTIVE_LOOPS, i + 1))
		for (int j = 0; j < JOB_LOOP_DEPTH; j++)
			if (loop_has(&pool->slot[i].loop[j], scope))
				return true;
	return false;
}

bool job_loop_exists(stilb_job_pool *pool, const job_scope *scope)
{
	for (uint32_t i = 0; i < pool->team_count; i++)
		if (loop_has(&pool->team[i].part, scope))
			return true;
	return threads_have(pool, 0, pool->worker_count + 1, scope);
}

bool job_loop_exists_far(job_slot *slot, const job_scope *scope)
{
	slot->look_far = !slot->pool->one_team && job_loop_exists(slot->pool, scope);
	return slot->look_far;
}

bool job_loop_seems_to_exist(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	if (pool->one_team)
		return job_loop_exists(pool, scope);
	if (loop_has(&slot->team->part, scope) || threads_have(pool, slot->team->begin, slot->team->end, scope))
		return true;
	return is_far_look(slot) && job_loop_exists_far(slot, scope);
}

/* ---- the caller ------------------------------------------------------------------------------------------------ */

/* The entry for fn in the thread's hash table of slice times. Two functions with the same hash replace each other's. */
static job_rate *rate_of(job_slot *slot, stilb_job_range_fn *fn)
{
	uintptr_t key = (uintptr_t)fn;
	job_rate *rate = &slot->rate[(key >> 4 ^ key >> 10) % JOB_RATES];
	if (rate->fn != fn)
		*rate = (job_rate){.fn = fn};
	return rate;
}

/* Lets other threads claim the last span->left of the loop's slices; the caller has claimed the others. */
static void loop_open(job_loop *loop, const loop_span *span, uint32_t slices, uint32_t limit)
{
	assert(span->left > 0 && span->left <= slices && limit > 0);
	/* Relaxed: see job_loop; no thread uses the fields while no slices are left. */
	atomic_store_explicit(&loop->fn, span->fn, memory_order_relaxed);
	atomic_store_explicit(&loop->context, span->context, memory_order_relaxed);
	atomic_store_explicit(&loop->root, span->root, memory_order_relaxed);
	atomic_store_explicit(&loop->level, span->level, memory_order_relaxed);
	atomic_store_explicit(&loop->count, span->count, memory_order_relaxed);
	atomic_store_explicit(&loop->grain, span->grain, memory_order_relaxed);
	atomic_store_explicit(&loop->slices, slices, memory_order_relaxed);
	atomic_store_explicit(&loop->wake_slices, span->wake_slices, memory_order_relaxed);
	atomic_store_explicit(&loop->claim_limit, limit, memory_order_relaxed);
	assert((uint32_t)atomic_load_explicit(&loop->claim, memory_order_relaxed) == 0 && "the previous loop has finished");
	uint64_t generation = (atomic_load_explicit(&loop->claim, memory_order_relaxed) >> 32) + 1;
	/* Release pairs with the acquire in loop_claim. */
	atomic_store_explicit(&loop->claim, generation << 32 | span->left, memory_order_release);
}

/* True if two values of job_loop.done are the same count, whatever their flags JOB_LOOP_WAITER. */
static bool done_is(uint64_t done, uint64_t wanted)
{
	return ((done ^ wanted) & ~JOB_LOOP_WAITER) == 0;
}

static bool loop_finished(const job_loop *loop, uint64_t wanted)
{
	return done_is(atomic_load_explicit(&loop->done, memory_order_acquire), wanted); /* pairs with loop_help */
}

/* Sets the flag JOB_LOOP_WAITER in done, for which the helpers wake this thread when they finish. False if all have
 * finished: done has reached wanted. */
static bool loop_announce(job_loop *loop, uint64_t wanted)
{
	/* Acquire, as in loop_finished. Flag and count share a word, so either the last helper finds the flag when it adds
	 * to the count, or this finds the count complete. */
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

/* Waits JOB_WAKE_NS for the slices that others have claimed, and meanwhile helps with loops nested in this one. False
 * if they have not finished by then. */
static bool loop_spin(job_loop *loop, job_slot *slot, const job_scope *scope, uint64_t wanted)
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

/* Waits for the slices that other threads have claimed, that is, until loop->done has reached wanted. */
static void loop_wait(job_loop *loop, job_slot *slot, const loop_span *span, uint64_t wanted)
{
	if (loop_finished(loop, wanted))
		return;
	job_hook_wait_begin(slot->pool, slot->index);
	job_scope scope = {.root = span->root, .level = span->level};
	loop_wait_for wait = {.loop = loop, .wanted = wanted};
	bool announced = false;
	while (!loop_spin(loop, slot, &scope, wanted)) {
		announced = true;
		if (job_work_park(slot, &scope, loop_ready, &wait) == JOB_IDLE_CHOSEN && !job_work_help(slot, &scope, NULL))
			job_work_wake_next(slot, &(job_work){.kind = JOB_WORK_SHARED});
	}
	if (announced) /* clears the flag; all helpers have finished. Relaxed: the next loop_open publishes it */
		atomic_store_explicit(&loop->done, wanted & ~JOB_LOOP_WAITER, memory_order_relaxed);
	job_hook_wait_end(slot->pool, slot->index);
}

/* The least number of slices that together take longer than a wake-up, if each takes `ticks`; 1 if ticks is 0, which
 * means that it is not known. */
static uint32_t slices_to_wake_for(const stilb_job_pool *pool, uint64_t ticks)
{
	return ticks == 0                              ? 1
	       : ticks * UINT32_MAX < pool->wake_ticks ? UINT32_MAX
	                                               : (uint32_t)(pool->wake_ticks / ticks) + 1;
}

/* True if the caller should not wake a sleeping worker: judging by the last time, the loop ends before one could be
 * awake. But if such loops follow one another, a worker that is awake would spin from one to the next and help with all
 * of them. So once they have taken as long as a wake-up, a worker is woken. The total is at most twice the optimum (the
 * ski rental problem). */
static bool loop_starts_alone(job_slot *slot, const loop_span *span, uint32_t slices, uint64_t start)
{
	uint64_t wake_ticks = slot->pool->wake_ticks;
	if (start - slot->alone_until > wake_ticks)
		slot->alone_ticks = 0;
	return slices < span->wake_slices && slot->alone_ticks < wake_ticks;
}

/* wake_helper with a better guess of the least number of slices that is worth a wake-up; helpers read it, too. */
static bool wake_helper_anew(stilb_job_pool *pool, job_loop *loop, loop_span *span, uint32_t wake_slices)
{
	span->wake_slices = wake_slices;
	atomic_store_explicit(&loop->wake_slices, wake_slices, memory_order_relaxed); /* see job_loop */
	return wake_helper(pool, span, 0);
}

/* Runs the loop; span->wake_slices is a guess from earlier loops. asleep: no thread is awake to help. The caller of a
 * loop that seems short then starts alone, if a worker watches (see JOB_WATCH_NS): it claims one slice, then twice as
 * many each time, and no longer counts as alone when the loop has taken as long as a wake-up. */
__attribute__((noinline)) static void loop_run(job_slot *slot, loop_span *span, uint32_t slices, bool asleep)
{
	stilb_job_pool *pool = slot->pool;
	job_active_begin(slot, JOB_ACTIVE_LOOPS);
	job_loop *loop = &slot->loop[slot->loops_open++];
	const job_rate *rate = rate_of(slot, span->fn);
	bool measured = asleep || rate->ticks == 0 || slot->loops_run++ % MEASURE_EVERY == 0;
	uint64_t start = measured ? job_sys_ticks() : 0;
	uint32_t threads = pool->worker_count + 1;
	bool alone = asleep && loop_starts_alone(slot, span, slices, start), started_alone = alone;
	/* With more threads than CPUs a thread may be preempted after a claim, and all would wait for it: claim less at
	 * once. */
	uint32_t limit = pool->oversubscribed && rate->ticks > 0 ? span->wake_slices : UINT32_MAX;
	if (asleep && !alone)
		span->wake_slices = 1;
	span->slices = alone ? 1 : guided(slices, threads, limit);
	span->left = slices - span->slices;
	if (pool->hooks.submit)
		loop->tag = pool->hooks.submit(pool->hooks.user, slot->index);
	loop_open(loop, span, slices, limit);
	bool woken = false;
	if (alone && !job_work_watched(pool)) {
		alone = started_alone = false;
		woken = wake_helper_anew(pool, loop, span, 1);
	} else if (!alone) {
		/* Looks for sleepers after the loop has been opened, since the last spinner may have gone to sleep just before;
		 * and again after each span, since a worker that looked for work before its sleep may not have seen the
		 * loop. */
		woken = wake_helper(pool, span, 0);
	}
	uint64_t ticks = 0;
	uint32_t mine = 0;
	do {
		span_run(span, slot->index);
		mine += span->slices;
		if (alone) {
			ticks = job_sys_ticks() - start;
			alone = ticks < pool->wake_ticks;
		}
		if (!alone && !woken && span->left > 0 && job_idle_maybe_wanted(&pool->idle))
			/* The duration of the slices that have just run says more than that of earlier loops. */
			woken = wake_helper_anew(pool, loop, span,
			                         measured ? slices_to_wake_for(pool, (job_sys_ticks() - start) / mine)
			                                  : span->wake_slices);
		/* Two calls of the same function, so that the compiler makes a copy of it for the usual case, wanted = 0. */
	} while (__builtin_expect(alone, 0) ? loop_claim(loop, &job_scope_all, threads, mine, span)
	                                    : loop_claim(loop, &job_scope_all, threads, 0, span));
	job_tally(&slot->tally.slices, mine);
	if (measured) {
		if (!alone)
			ticks = job_sys_ticks() - start;
		rate_of(slot, span->fn)->ticks = ticks / mine + 1; /* not *rate: loops in the slices may have replaced it */
	}
	if (started_alone) {
		slot->alone_until = start + ticks;
		slot->alone_ticks += ticks;
	}
	if (mine < slices) {
		loop->finished += slices - mine;
		loop_wait(loop, slot, span, loop->finished);
	}
	assert(slot->loops_open > 0 && loop == &slot->loop[slot->loops_open - 1] && "loops are nested");
	slot->loops_open--;
}

/* The first slice of the part of a wide loop that begins with thread number `thread`: each team gets as large a part of
 * the slices as of the threads. */
static uint32_t part_begin(const stilb_job_pool *pool, uint32_t slices, uint32_t thread)
{
	return (uint32_t)((uint64_t)slices * thread / (pool->worker_count + 1));
}

static uint32_t part_slices(const stilb_job_pool *pool, uint32_t slices, const job_team *team)
{
	return part_begin(pool, slices, team->end) - part_begin(pool, slices, team->begin);
}

/* What the caller of a wide loop has done itself: slices and the time that they have taken, and whether it has woken a
 * thread for the loop. */
typedef struct wide_work {
	uint32_t mine;
	bool woken;
	uint64_t ticks;
} wide_work;

static void wide_open(job_slot *slot, loop_span *span, uint32_t slices)
{
	stilb_job_pool *pool = slot->pool;
	uint64_t tag = pool->hooks.submit ? pool->hooks.submit(pool->hooks.user, slot->index) : 0;
	uint32_t limit = pool->oversubscribed && span->wake_slices > 1 ? span->wake_slices : UINT32_MAX; /* see loop_run */
	for (uint32_t i = 0; i < pool->team_count; i++) {
		job_team *team = &pool->team[i];
		span->left = part_slices(pool, slices, team);
		if (span->left == 0)
			continue;
		job_loop *whole = gathered_in(pool, team);
		team->part.tag = tag;
		team->part.finished += span->left;
		whole->finished += whole != &team->part;
		/* Relaxed, both: see job_loop. */
		atomic_store_explicit(&team->part.owner, slot->index, memory_order_relaxed);
		atomic_store_explicit(&team->part.goal, (uint32_t)team->part.finished, memory_order_relaxed);
		loop_open(&team->part, span, part_begin(pool, slices, team->end), limit);
	}
	span->left = slices;
}

/* wake_helper with a better guess of what a slice takes; helpers of all teams read it, too. */
static bool wide_wake_anew(stilb_job_pool *pool, loop_span *span, uint64_t ticks)
{
	span->wake_slices = slices_to_wake_for(pool, ticks);
	for (uint32_t i = 0; i < pool->team_count; i++)
		atomic_store_explicit(&pool->team[i].part.wake_slices, span->wake_slices,
		                      memory_order_relaxed); /* see job_loop */
	return wake_helper(pool, span, 0);
}

/* Claims and runs slices of a team's part until none is left. */
static void part_claim(job_slot *slot, job_team *team, loop_span *span, wide_work *work)
{
	stilb_job_pool *pool = slot->pool;
	uint32_t before = work->mine;
	while (loop_claim(&team->part, &job_scope_all, loop_threads(pool, team), 0, span)) {
		uint64_t start = job_sys_ticks();
		span_run(span, slot->index);
		work->ticks += job_sys_ticks() - start;
		work->mine += span->slices;
		if (!work->woken && span->left > 0 && job_idle_maybe_wanted(&pool->idle))
			work->woken = wide_wake_anew(pool, span, work->ticks / work->mine);
	}
	if (work->mine > before)
		part_count(pool, team, slot, work->mine - before);
}

/* part_claim for all teams, the own one first. */
static void wide_claim(job_slot *slot, loop_span *span, wide_work *work)
{
	stilb_job_pool *pool = slot->pool;
	uint32_t own = (uint32_t)(slot->team - pool->team);
	for (uint32_t i = 0; i < pool->team_count; i++) {
		job_team *team = &pool->team[(own + i) % pool->team_count];
		const job_loop *whole = gathered_in(pool, team);
		/* Looks at the count first, which the caller needs anyway: often all of the part is done. */
		if (i == 0 || !loop_finished(whole, whole->finished))
			part_claim(slot, team, span, work);
	}
}

/* Runs a loop of many slices as a wide one (job_team); otherwise as loop_run. False if another wide loop is open, or if
 * it seems short and no thread is awake to help (asleep). */
__attribute__((noinline)) static bool wide_run(job_slot *slot, loop_span *span, uint32_t slices, bool asleep)
{
	stilb_job_pool *pool = slot->pool;
	if (asleep && loop_starts_alone(slot, span, slices, job_sys_ticks()))
		return false;
	if (atomic_exchange_explicit(&pool->wide_open, true, memory_order_acquire)) /* see the field */
		return false;
	if (asleep)
		span->wake_slices = 1;
	wide_open(slot, span, slices);
	wide_work work = {.woken = wake_helper(pool, span, 0)};
	wide_claim(slot, span, &work);
	job_tally(&slot->tally.slices, work.mine);
	if (work.mine > 0)
		rate_of(slot, span->fn)->ticks = work.ticks / work.mine + 1;
	for (uint32_t i = 0; i < pool->team_count; i += JOB_GATHER)
		loop_wait(&pool->team[i].part, slot, span, pool->team[i].part.finished);
	atomic_store_explicit(&pool->wide_open, false, memory_order_release); /* see the field */
	return true;
}

/* A loop that a thread outside the pool waits for. */
typedef struct outside_loop {
	stilb_job_pool *pool;
	stilb_job_range_fn *fn;
	void *context;
	uint32_t count, grain;
} outside_loop;

static void outside_loop_run(void *data, uint32_t worker)
{
	outside_loop *loop = data;
	stilb_job_parallel_for(loop->pool, loop->count, loop->grain, loop->fn, loop->context, worker);
}

/* stilb_job_parallel_for for a thread outside the pool, which has no index to pass to slices: a thread of the pool
 * calls it as a job. The loop is not dropped when the pool is cancelled, as no other is. */
static void for_outside(outside_loop *loop)
{
	assert(job_pool_is_outside(loop->pool) && "a thread of the pool passes its index");
	stilb_job_group group = {.dropped = outside_loop_run};
	while (stilb_job_submit(loop->pool, outside_loop_run, loop, &group, STILB_JOB_OUTSIDE) != 0)
		job_sys_nap(JOB_MEMORY_NAP_NS);
	stilb_job_wait(loop->pool, &group, STILB_JOB_OUTSIDE);
}

void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker)
{
	assert(pool && fn);
	if (count == 0)
		return;
	if (worker == STILB_JOB_OUTSIDE) {
		for_outside(&(outside_loop){.pool = pool, .fn = fn, .context = context, .count = count, .grain = grain});
		return;
	}
	job_slot *slot = job_slot_of(pool, worker);
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	loop_span span = {.fn = fn, .context = context, .count = count, .grain = grain ? grain : 1};
	uint32_t slices = (count - 1) / span.grain + 1;
	/* A loop outside of all jobs is a root of its own, identified by its address. */
	slot->root = span.root = outer_root ? outer_root : (uintptr_t)&slot->loop[0];
	slot->level = span.level = outer_level + 1;
	if (slices > 1 && pool->worker_count > 0 && slot->loops_open < JOB_LOOP_DEPTH) {
		span.wake_slices = slices_to_wake_for(pool, rate_of(slot, fn)->ticks);
		bool asleep = job_idle_maybe_wanted(&pool->idle);
		bool wide = !pool->one_team && slices / 2 >= pool->team_count && wide_run(slot, &span, slices, asleep);
		if (!wide)
			loop_run(slot, &span, slices, asleep);
	} else {
		span.slices = slices;
		span_run(&span, worker);
		job_tally(&slot->tally.slices, slices);
	}
	slot->level = outer_level;
	slot->root = outer_root;
}
