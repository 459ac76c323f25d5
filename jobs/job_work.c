#include "jobs/job_internal.h"

#include <sched.h>

/* Once in so many looks for work, a thread tries loops and the shared queue before its own deque. Otherwise a thread
 * whose own deque never runs empty would never help with those. */
#ifndef SHARED_FIRST
#define SHARED_FIRST 16
#endif

/* If sched_yield takes longer than so many times JOB_WAKE_NS, another process has run on the CPU. */
#define YIELD_LONG 10

/* After such a long yield the thread pauses this many times before it yields again. */
#define SPINS_WITHOUT_YIELD 100000

const job_scope job_scope_all = {.all = true, .jobs = true, .high = true};

/* ---- threads that may have work -------------------------------------------------------------------------------- */

static void set_active(job_slot *slot, job_active_kind kind, bool active)
{
	_Atomic uint64_t *word = &slot->pool->active[kind][slot->index / 64];
	uint64_t bit = UINT64_C(1) << slot->index % 64;
	slot->active[kind] = active;
	/* Seq_cst, both: see the field. */
	if (active)
		atomic_fetch_or_explicit(word, bit, memory_order_seq_cst);
	else
		atomic_fetch_and_explicit(word, ~bit, memory_order_seq_cst);
}

void job_active_set(job_slot *slot, job_active_kind kind)
{
	set_active(slot, kind, true);
}

/* Called by an idle worker, which has neither jobs nor loops, and will have none before it finds work elsewhere. */
static void active_end(job_slot *slot)
{
	assert(slot->index > 0 && slot->level == 0 && slot->loops_open == 0 && job_deque_empty(&slot->deque));
	for (job_active_kind kind = 0; kind < JOB_ACTIVE_KINDS && !slot->pool->one_team; kind++)
		if (slot->active[kind])
			set_active(slot, kind, false);
}

bool job_visit_active(job_slot *slot, job_active_kind kind, uint32_t begin, uint32_t end, job_visit_fn *visit,
                      void *context)
{
	uint32_t middle = begin + job_random_below(slot, end - begin);
	for (uint32_t i = job_active_from(slot->pool, kind, middle); i < end; i = job_active_from(slot->pool, kind, i + 1))
		if (visit(slot, i, context))
			return true;
	for (uint32_t i = job_active_from(slot->pool, kind, begin); i < middle;
	     i = job_active_from(slot->pool, kind, i + 1))
		if (visit(slot, i, context))
			return true;
	return false;
}

/* ---- running --------------------------------------------------------------------------------------------------- */

void job_work_spin_stop(job_slot *slot)
{
	if (slot->spinning) {
		slot->spinning = false;
		job_idle_spin_stop(&slot->pool->idle);
	}
}

/* Calls the job's function, or runs its loop. */
static void call_job(job_slot *slot, const job_record *job, uint64_t tag)
{
	stilb_job_pool *pool = slot->pool;
	const stilb_job_hooks *hooks = &pool->hooks;
	if (hooks->job_begin)
		hooks->job_begin(hooks->user, slot->index, tag);
	if (job->kind == JOB_LOOP)
		stilb_job_parallel_for(pool, job->count, job->grain, job->fn.range, job->data, slot->index);
	else
		job->fn.one(job->data, slot->index);
	if (hooks->job_end)
		hooks->job_end(hooks->user, slot->index);
}

/* For a batch whose first job is about to run: puts the other jobs back, into the thread's own deque. So none of them
 * hides behind a job that is running. */
static void leave_rest(job_slot *slot, job_record *record)
{
	if (--record->count > 0) {
		record->data = (char *)record->data + record->stride;
		job_submit_record(slot, record);
	} else {
		record->tag = 0; /* the stride lay in its place */
		job_record_give(&slot->pool->records, &slot->records, record);
	}
}

/* Runs the first job of the record, or drops it if it is cancelled. Does not subtract it from its group's count: that
 * is left to the caller, who can subtract several jobs at once. */
static void run_one(job_slot *slot, job_record *record)
{
	stilb_job_pool *pool = slot->pool;
	job_record job = {
		.fn = record->fn, .data = record->data, .count = record->count, .grain = record->grain, .kind = record->kind};
	assert(record->target == JOB_ANYONE || record->target == slot->index);
	uint64_t tag = record->tag;
	bool drops = job_drops(pool, record->group);
	stilb_job_fn *dropped = drops && record->group ? record->group->dropped : NULL;
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	bool outer_high = slot->in_high;
	slot->in_high = outer_high || record->priority == STILB_JOB_HIGH;
	slot->level = atomic_load_explicit(&record->level, memory_order_relaxed);
	slot->root = atomic_load_explicit(&record->root, memory_order_relaxed);
	if (__builtin_expect(job.kind == JOB_BATCH, 0)) {
		leave_rest(slot, record);
		tag = 0;
	} else {
		job_record_give(&pool->records, &slot->records, record);
	}
	if (__builtin_expect(!drops, 1))
		call_job(slot, &job, tag);
	else if (dropped)
		dropped(job.data, slot->index);
	slot->level = outer_level;
	slot->root = outer_root;
	slot->in_high = outer_high;
	job_count(&slot->finished, 1);
}

/* True if the scope allows the thread to run this job, which lies in a deque. */
static bool scope_has(const job_scope *scope, const job_record *record)
{
	/* Relaxed: if another thread has taken the job and the record is reused, the exchange that takes it fails. */
	return scope->all || (atomic_load_explicit(&record->root, memory_order_relaxed) == scope->root &&
	                      atomic_load_explicit(&record->level, memory_order_relaxed) > scope->level);
}

/* scope_has as a test for job_deque.h. */
static bool in_scope(const job_record *record, const void *scope)
{
	return scope_has(scope, record);
}

job_record *job_work_take_own(job_slot *slot, const job_scope *scope)
{
	/* A thief can take this record only if it is the last one, so pop returns this record or NULL. */
	job_record *newest = job_deque_newest(&slot->deque);
	return newest && scope_has(scope, newest) ? job_deque_pop_newest(&slot->deque) : NULL;
}

/* Counts and reports that the thread has taken a job of thread `victim`. */
static void note_steal(job_slot *slot, uint32_t victim)
{
	const stilb_job_hooks *hooks = &slot->pool->hooks;
	job_tally(&slot->tally.steals, 1);
	if (hooks->steal)
		hooks->steal(hooks->user, slot->index, victim);
}

/* Takes the oldest job of the deque of thread `victim` if the scope allows it. Among many thieves, the one that another
 * is faster than tries once more: otherwise it would take the idle list's lock on its way to sleep and back. */
static job_record *steal_from(job_slot *slot, uint32_t victim, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	job_deque *deque = &pool->slot[victim].deque;
	int64_t top;
	job_record *record = job_deque_oldest(deque, &top);
	if (!record || !scope_has(scope, record))
		return NULL;
	if (!job_deque_steal(deque, top)) {
		record = pool->one_team ? NULL : job_deque_oldest(deque, &top);
		if (!record || !scope_has(scope, record) || !job_deque_steal(deque, top))
			return NULL;
	}
	slot->victim = victim; /* tried first next time: it may have more jobs */
	if (victim != slot->index)
		note_steal(slot, victim);
	return record;
}

typedef struct steal_search {
	const job_scope *scope;
	job_record *record;
} steal_search;

static bool steal_visit(job_slot *slot, uint32_t victim, void *context)
{
	steal_search *search = context;
	search->record = steal_from(slot, victim, search->scope);
	return search->record;
}

/* Tries the victim of the last steal, then all threads, those of the own team first. A waiting thread tries its own
 * deque, too: a job of its scope may be the oldest there, below newer jobs outside the scope. */
static job_record *steal(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	uint32_t victim = slot->victim;
	steal_search search = {.scope = scope};
	if (pool->one_team)
		job_visit_team(slot, victim, steal_visit, &search);
	else if (!steal_visit(slot, victim, &search) &&
	         !job_visit_active(slot, JOB_ACTIVE_JOBS, slot->team->begin, slot->team->end, steal_visit, &search))
		job_visit_active(slot, JOB_ACTIVE_JOBS, 0, pool->worker_count + 1, steal_visit, &search);
	return search.record;
}

/* Notes that the thief should pause if the stolen job, which ran for so many ticks, was shorter than JOB_STEAL_NS. That
 * is what a steal costs the victim, whose CPU must fetch the cache line of its deque again: two threads that contend
 * for tiny jobs are slower than one that runs them undisturbed. */
static void note_steal_cost(job_slot *slot, uint64_t ticks)
{
	slot->steal_unprofitable = ticks < slot->pool->steal_ticks;
	if (!slot->steal_unprofitable)
		slot->steal_doublings = 0;
}

/* Quickly, true if there may be work that the scope allows in other places than deques. Relaxed: may miss new work. */
static bool work_elsewhere(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	if (job_loop_seems_to_exist(slot, scope) || atomic_load_explicit(&slot->inbox, memory_order_relaxed))
		return true;
	for (uint32_t i = 0; i < JOB_SHARED_COUNT; i++)
		if ((i == JOB_SHARED_HIGH ? scope->high : scope->all) &&
		    atomic_load_explicit(&pool->shared_hint[i], memory_order_relaxed))
			return true;
	return false;
}

/* Runs a job and then, if scope is not NULL, more jobs of the scope, from the thread's own deque or the deque that the
 * job was stolen from. Consecutive jobs of one group are subtracted from its counter together: the group cannot finish
 * before the last of them, and the counter is the most contended cache line. */
static void run(job_slot *slot, job_record *record, bool stolen, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_group *group = record->group;
	uint32_t jobs = 0;
	for (int i = 0; record; i++) {
		if (record->group != group) {
			if (group)
				job_group_finish(slot, group, jobs);
			group = record->group;
			jobs = 0;
		}
		uint64_t start = stolen ? job_sys_ticks() : 0;
		uint32_t loot = stolen && record->kind == JOB_BATCH ? record->count : 1; /* a batch is stolen as a whole */
		bool graph = record->kind == JOB_NODES;
		job_record *next = NULL;
		if (graph)
			next = job_graph_run(slot, record, scope, until);
		else
			run_one(slot, record);
		if (stolen)
			note_steal_cost(slot, (job_sys_ticks() - start) * loot);
		jobs++;
		bool enough = until && (until == group ? job_group_done_but(until, jobs) : job_group_done(until));
		if (graph) /* JOBS_IN_A_ROW of its nodes have run, or all that there were */
			i = scope && work_elsewhere(slot, scope) ? JOBS_IN_A_ROW - 1 : 0;
		record = NULL;
		if (!scope || enough || i + 1 == JOBS_IN_A_ROW || job_work_urgent(slot)) {
			if (next)
				job_submit_record(slot, next);
			continue;
		}
		record = next ? next : job_work_take_own(slot, scope);
		stolen = !record && stolen && !slot->steal_unprofitable && (record = steal_from(slot, slot->victim, scope));
	}
	if (group)
		job_group_finish(slot, group, jobs);
}

/* ---- where to find it ------------------------------------------------------------------------------------------ */

/* Moves the jobs of the inbox to the end of slot->pinned, oldest first. */
static void fetch_pinned(job_slot *slot)
{
	/* Relaxed: may miss a job that has just been submitted. It is found at the next look; job_work_exists, which
	 * precedes every sleep, does not miss any. */
	if (!atomic_load_explicit(&slot->inbox, memory_order_relaxed))
		return;
	/* Acquire pairs with push_inbox: the contents of the records are visible. */
	job_record *newest = atomic_exchange_explicit(&slot->inbox, NULL, memory_order_acquire), *oldest = NULL;
	while (newest) {
		job_record *next = newest->next;
		newest->next = oldest;
		oldest = newest;
		newest = next;
	}
	job_record **end = &slot->pinned;
	while (*end)
		end = &(*end)->next;
	*end = oldest;
}

static job_record *take_pinned(job_slot *slot)
{
	if (!slot->pinned)
		fetch_pinned(slot);
	job_record *record = slot->pinned;
	if (record)
		slot->pinned = record->next;
	return record;
}

static job_record *take_shared(job_slot *slot, uint32_t which)
{
	stilb_job_pool *pool = slot->pool;
	void *record;
	/* Relaxed: may miss a job that has just been submitted, which the next look finds, as in fetch_pinned. */
	if (atomic_load_explicit(&pool->shared_hint[which], memory_order_relaxed) == 0 ||
	    stilb_job_queue_pop(pool->shared[which], &record, slot->index) != 0)
		return NULL;
	uint32_t hint = atomic_fetch_sub_explicit(&pool->shared_hint[which], 1, memory_order_relaxed);
	assert(hint > 0 && "raised before the push");
	(void)hint;
	stilb_job_queue_rest(pool->shared[which], slot->index); /* the job may be long */
	return record;
}

/* Takes the oldest job of low priority that the scope allows. */
static job_record *take_low(stilb_job_pool *pool, const job_scope *scope)
{
	/* Relaxed: may miss a job that has just been submitted, as in take_shared. */
	if (atomic_load_explicit(&pool->low_count, memory_order_relaxed) == 0)
		return NULL;
	job_lock_take(&pool->low_lock);
	job_record **at = &pool->low;
	while (*at && !scope_has(scope, *at))
		at = &(*at)->next;
	job_record *record = *at;
	if (record) {
		*at = record->next;
		if (!record->next)
			pool->low_end = at;
		atomic_fetch_sub_explicit(&pool->low_count, 1, memory_order_relaxed); /* see push_low */
	}
	job_lock_give(&pool->low_lock);
	return record;
}

/* True if there is a job of low priority that the scope allows. */
static bool low_has(stilb_job_pool *pool, const job_scope *scope)
{
	if (atomic_load_explicit(&pool->low_count, memory_order_relaxed) == 0) /* see push_low */
		return false;
	if (scope->all)
		return true;
	job_lock_take(&pool->low_lock);
	const job_record *record = pool->low;
	while (record && !scope_has(scope, record))
		record = record->next;
	job_lock_give(&pool->low_lock);
	return record;
}

/* Takes a job from a shared queue or steals one; *work says which. NULL if there is none that the scope allows. */
static job_record *take_visible(job_slot *slot, const job_scope *scope, job_work *work)
{
	*work = (job_work){.kind = JOB_WORK_SHARED};
	job_record *record = scope->all ? take_shared(slot, JOB_SHARED_NORMAL) : NULL;
	if (!record && (record = steal(slot, scope)))
		*work = (job_work){.kind = JOB_WORK_JOB,
		                   .root = atomic_load_explicit(&record->root, memory_order_relaxed),
		                   .level = atomic_load_explicit(&record->level, memory_order_relaxed)};
	if (!record && scope->all)
		record = take_low(slot->pool, scope);
	return record;
}

/* True if the scope allows some job in a deque. */
static bool deques_have_any(stilb_job_pool *pool, const job_scope *scope)
{
	int64_t index;
	for (uint32_t i = job_active_from(pool, JOB_ACTIVE_JOBS, 0); i <= pool->worker_count;
	     i = job_active_from(pool, JOB_ACTIVE_JOBS, i + 1))
		if (job_deque_find(&pool->slot[i].deque, in_scope, scope, &index))
			return true;
	return false;
}

/* True if the scope allows the oldest job of some deque. */
static bool deques_have(stilb_job_pool *pool, const job_scope *scope)
{
	for (uint32_t i = job_active_from(pool, JOB_ACTIVE_JOBS, 0); i <= pool->worker_count;
	     i = job_active_from(pool, JOB_ACTIVE_JOBS, i + 1)) {
		int64_t top;
		job_record *record = job_deque_oldest(&pool->slot[i].deque, &top);
		if (record && scope_has(scope, record))
			return true;
	}
	return false;
}

/* Takes a job; *work says from which place. NULL if there is none, or if slices of a loop were run instead
 * (*helped). */
static job_record *take_any(job_slot *slot, const job_scope *scope, stilb_job_group *until, job_work *work,
                            bool *helped)
{
	job_record *record = take_pinned(slot);
	*work = (job_work){.kind = JOB_WORK_HIGH};
	if (!record && scope->high)
		record = take_shared(slot, JOB_SHARED_HIGH);
	if (record || !scope->jobs) {
		*helped = !record && job_loop_help(slot, scope, until);
		return record;
	}
	slot->poll_round = (slot->poll_round + 1) % SHARED_FIRST;
	*work = (job_work){.kind = JOB_WORK_SHARED};
	if (slot->poll_round == 0) {
		*helped = job_loop_help(slot, scope, until);
		if (!*helped && scope->all)
			record = take_shared(slot, JOB_SHARED_NORMAL);
		if (*helped || record)
			return record;
	}
	*work = (job_work){.kind = JOB_WORK_OWN};
	record = job_work_take_own(slot, scope);
	if (!record && !(*helped = job_loop_help(slot, scope, until)))
		record = take_visible(slot, scope, work);
	return record;
}

bool job_work_help(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	assert(job_slot_is_mine(slot));
	job_work work;
	bool helped = false;
	job_record *record = take_any(slot, scope, until, &work, &helped);
	if (!record)
		return helped;
	job_work_spin_stop(slot);
	if (work.kind != JOB_WORK_OWN) {
		job_active_begin(slot, JOB_ACTIVE_JOBS); /* is set if the thread has jobs of its own */
		job_work_wake_next(slot, &work);         /* its push into its own deque has woken a thread already */
	}
	run(slot, record, work.kind == JOB_WORK_JOB, scope->jobs ? scope : NULL, until);
	return true;
}

void job_work_run_own(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	assert(job_slot_is_mine(slot));
	job_record *record = slot->pinned || job_work_urgent(slot) ? NULL : job_work_take_own(slot, scope);
	if (record)
		run(slot, record, false, scope, until);
}

bool job_work_dig(job_slot *slot, const job_scope *scope)
{
	assert(job_slot_is_mine(slot) && scope->jobs && !scope->all);
	if (!job_deque_dig(&slot->deque, in_scope, scope))
		return false;
	job_idle_wake_waiting(&slot->pool->idle); /* threads that looked meanwhile have not seen all jobs of this deque */
	return true;
}

/* Takes a job that the scope allows from the deque of thread `victim`, in which it may lie below older jobs: those are
 * moved to the thread's own deque. NULL if there is none. */
static job_record *steal_buried(job_slot *slot, uint32_t victim, const job_scope *scope)
{
	job_deque *deque = &slot->pool->slot[victim].deque;
	int64_t index, top;
	while (job_deque_find(deque, in_scope, scope, &index)) {
		job_record *record = job_deque_oldest(deque, &top);
		for (; record && top <= index; record = job_deque_oldest(deque, &top)) {
			bool wanted = scope_has(scope, record);
			if (!job_deque_steal(deque, top))
				continue; /* another thread has taken it */
			if (wanted)
				return record;
			job_submit_record(slot, record);
		}
	}
	return NULL;
}

bool job_work_unbury(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	assert(job_slot_is_mine(slot) && scope->jobs && !scope->all);
	stilb_job_pool *pool = slot->pool;
	job_record *record = take_low(pool, scope);
	for (uint32_t i = job_active_from(pool, JOB_ACTIVE_JOBS, 0); i <= pool->worker_count && !record;
	     i = job_active_from(pool, JOB_ACTIVE_JOBS, i + 1))
		if (i != slot->index && (record = steal_buried(slot, i, scope)))
			note_steal(slot, i);
	if (record)
		run(slot, record, false, scope, until);
	return record;
}

bool job_work_rescue(job_slot *slot)
{
	job_record *record = take_shared(slot, JOB_SHARED_HIGH);
	if (!record)
		record = take_shared(slot, JOB_SHARED_NORMAL);
	if (!record)
		record = take_low(slot->pool, &job_scope_all);
	if (!record)
		record = steal(slot, &job_scope_all);
	if (record)
		run(slot, record, false, NULL, NULL);
	return record;
}

bool job_work_exists(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	/* Seq_cst: step (2) of the head of job_park.h, the look for work after the thread has entered the idle list. */
	if (slot->pinned || atomic_load_explicit(&slot->inbox, memory_order_seq_cst))
		return true;
	if (scope->high && !stilb_job_queue_empty(pool->shared[JOB_SHARED_HIGH], slot->index))
		return true;
	if (scope->all && !stilb_job_queue_empty(pool->shared[JOB_SHARED_NORMAL], slot->index))
		return true;
	if (scope->jobs && (low_has(pool, scope) || (scope->all ? deques_have : deques_have_any)(pool, scope)))
		return true;
	return job_loop_exists(pool, scope);
}

/* Wakes threads for the jobs left in the deque that the calling thread has just stolen from (JOB_THIEVES), so that they
 * come as a tree (job_park.h). False if none is left. */
static bool wake_thieves(job_slot *slot, const job_work *stolen)
{
	stilb_job_pool *pool = slot->pool;
	int64_t left = job_deque_count(&pool->slot[slot->victim].deque);
	job_work work = *stolen;
	work.spinners = left < 4 ? 0 : left / 2 - 1 < JOB_THIEVES ? (uint32_t)(left / 2) - 1 : JOB_THIEVES;
	for (uint32_t i = 0; i < JOB_WAKE_FAN && left > 0; i++)
		if (!job_idle_maybe_wanted_beside(&pool->idle, work.spinners) || !job_idle_wake(&pool->idle, &work))
			break;
	return left > 0;
}

void job_work_wake_next(job_slot *slot, const job_work *work)
{
	if (!slot->pool->one_team && work->kind == JOB_WORK_JOB && wake_thieves(slot, work))
		return;
	/* Relaxed suffices: a sleeper that is missed here has entered the idle list so late that it looks for work itself
	 * before it sleeps. */
	if (job_idle_maybe_wanted(&slot->pool->idle) && job_work_exists(slot, &job_scope_all))
		job_idle_wake(&slot->pool->idle, work);
}

/* ---- idling ---------------------------------------------------------------------------------------------------- */

/* A quick job_work_exists for a spinning thread. Relaxed: may miss new work, which the next round finds. */
static bool work_seems_to_exist(job_slot *slot, const job_scope *scope)
{
	return work_elsewhere(slot, scope) || (scope->jobs && deques_have(slot->pool, scope)) ||
	       (scope->all && low_has(slot->pool, scope));
}

void job_work_relax(job_slot *slot)
{
	if (!slot->pool->oversubscribed || slot->spins_without_yield > 0) {
		slot->spins_without_yield -= slot->spins_without_yield > 0;
		job_sys_pause();
		return;
	}
	/* The thread that is waited for may need this CPU. But if a yield hands it to another process for a whole time
	 * slice, it is better to spin and sleep for a while, since the scheduler favours threads that wake up over threads
	 * that yield. */
	uint64_t start = job_sys_ticks();
	sched_yield();
	if (job_sys_ticks() - start > YIELD_LONG * slot->pool->wake_ticks)
		slot->spins_without_yield = SPINS_WITHOUT_YIELD;
}

/* job_work_spin that began at the time `start`. */
static bool spin_since(uint64_t start, job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_pool *pool = slot->pool;
	/* Relaxed: an old value only makes the spin end one round later or earlier. */
	for (;;) {
		if (job_sys_ticks() - start >= pool->wake_ticks) {
			if (!scope->all || !atomic_load_explicit(&pool->phase, memory_order_relaxed))
				return false;
			active_end(slot);
		}
		if (work_seems_to_exist(slot, scope) || (until && job_group_done(until)) ||
		    atomic_load_explicit(&pool->stop, memory_order_relaxed))
			return true;
		job_work_relax(slot);
	}
}

bool job_work_spin(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	uint64_t start = job_sys_ticks();
	bool found = spin_since(start, slot, scope, until);
	job_tally(&slot->tally.spin_ticks, job_sys_ticks() - start);
	return found;
}

/* Tells the shared queues that this thread will not use them while it sleeps, so that they can reuse all memory. */
static void queues_quiesce(job_slot *slot)
{
	for (int i = 0; i < JOB_SHARED_COUNT; i++)
		stilb_job_queue_rest(slot->pool->shared[i], slot->index);
}

bool job_work_watched(stilb_job_pool *pool)
{
	/* A read-modify-write that changes nothing, as in job_idle_wanted_strict. The watcher ends its watch by an exchange
	 * of the same word with 0 and then looks for loops once more. If its exchange comes after this one, it acquires
	 * what the caller released here and sees the caller's loop; if it came before, this reads 0. */
	return atomic_fetch_add_explicit(&pool->watched, 0, memory_order_acq_rel) != 0;
}

/* Sleeps until the thread is woken or finds a loop to help with. It looks for loops between naps (JOB_WATCH_NAP_NS),
 * unless another worker does so already, for JOB_WATCH_NS; after that it sleeps until it is woken. */
static void sleep_watching(job_slot *slot)
{
	stilb_job_pool *pool = slot->pool;
	uint64_t nap = JOB_WATCH_NAP_NS, slept = 0, left = JOB_WATCH_NS;
	bool token = false;
	/* Acquire-release, both: partners of job_work_watched. */
	if (left > 0 && atomic_exchange_explicit(&pool->watched, 1, memory_order_acq_rel) == 0) {
		while (left > 0 && !(token = job_parker_sleep_for(&slot->parker, nap)) &&
		       !job_loop_exists(pool, &job_scope_all)) {
			slept += nap;
			left -= nap < left ? nap : left;
			nap = slept / 2;
		}
		atomic_exchange_explicit(&pool->watched, 0, memory_order_acq_rel);
		if (token || job_loop_exists(pool, &job_scope_all))
			return;
	}
	job_parker_sleep(&slot->parker);
}

/* watch: the thread watches for loops while it sleeps (see sleep_watching). It is the last spinner, so no other thread
 * looks for work once it sleeps. */
static void sleep_until_woken(job_slot *slot, bool watch)
{
	const stilb_job_hooks *hooks = &slot->pool->hooks;
	queues_quiesce(slot);
	job_tally(&slot->tally.parks, 1);
	if (hooks->park)
		hooks->park(hooks->user, slot->index);
	if (watch)
		sleep_watching(slot);
	else
		job_parker_sleep(&slot->parker);
	if (hooks->wake)
		hooks->wake(hooks->user, slot->index);
}

job_idle_outcome job_work_park(job_slot *slot, const job_scope *scope, job_ready_fn *ready, void *context)
{
	stilb_job_pool *pool = slot->pool;
	assert(slot->index > 0 || !slot->spinning); /* only workers spin */
	job_idler idler = {.parker = &slot->parker, .scope = *scope, .worker = slot->index > 0};
	if (scope->all)
		active_end(slot);
	/* Steps (1) to (3) of job_park.h. */
	bool watch = scope->all && slot->spinning;
	bool alone = job_idle_enter(&pool->idle, &idler, slot->spinning);
	slot->spinning = false;
	bool rescue = false;
	if (!ready(slot, context)) {
		rescue = alone && !scope->all && job_work_exists(slot, &job_scope_all);
		if (rescue && !scope->jobs) {
			job_idle_wake(&pool->idle, &(job_work){.kind = JOB_WORK_SHARED});
			rescue = false;
		}
		if (!rescue && !job_work_exists(slot, scope))
			sleep_until_woken(slot, watch);
	}
	job_idle_outcome outcome = job_idle_leave(&pool->idle, &slot->parker);
	slot->look_far = true; /* for the loop that it was woken for, or that kept it awake */
	job_tally(&slot->tally.wakes, outcome != JOB_IDLE_NOT_CHOSEN);
	slot->spinning = scope->all && outcome == JOB_IDLE_CHOSEN;
	return rescue ? JOB_IDLE_RESCUE : outcome;
}

uint32_t stilb_job_run_pinned(stilb_job_pool *pool, uint32_t worker)
{
	job_slot *slot = job_slot_of(pool, worker);
	uint32_t jobs = 0, present = 0;
	fetch_pinned(slot);
	for (job_record *record = slot->pinned; record; record = record->next)
		present++;
	/* Only the jobs that were there at the start: a job may submit itself again, and then the loop would not end. */
	for (job_record *record; jobs < present && (record = take_pinned(slot)); jobs++)
		run(slot, record, false, NULL, NULL);
	return jobs;
}
