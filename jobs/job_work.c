#include "jobs/job_internal.h"

#include <sched.h>

/* Jobs in a row from one place before the thread looks elsewhere. */
#ifndef JOBS_IN_A_ROW
#define JOBS_IN_A_ROW 16
#endif

/* Loops and the shared queue come before the own deque every so many times, so that none of them starves. */
#ifndef SHARED_FIRST
#define SHARED_FIRST 16
#endif

/* A yield that takes this many times a wake-up has given the CPU to a stranger; and for how many turns it is not repeated. */
#define YIELD_LONG 10
#define TURNS_WITHOUT_YIELD 100000

const job_scope job_scope_all = {.all = true, .jobs = true, .high = true};

/* ---- running --------------------------------------------------------------------------------------------------- */

void job_work_spin_stop(job_slot *slot)
{
	if (slot->spinning) {
		slot->spinning = false;
		job_idle_spin_stop(&slot->pool->idle);
	}
}

/* Runs one job, except for telling its group. */
static void run_one(job_slot *slot, job_record *record)
{
	stilb_job_pool *pool = slot->pool;
	const stilb_job_hooks *hooks = &pool->hooks;
	job_record job = {.fn = record->fn, .data = record->data, .count = record->count, .grain = record->grain};
	uint64_t tag = record->tag;
	uint32_t outer_level = slot->level;
	uintptr_t outer_root = slot->root;
	bool outer_high = slot->in_high;
	slot->in_high = outer_high || record->priority == STILB_JOB_HIGH;
	slot->level = atomic_load_explicit(&record->level, memory_order_relaxed);
	slot->root = atomic_load_explicit(&record->root, memory_order_relaxed);
	job_record_give(&pool->records, &slot->records, record);
	if (!atomic_load_explicit(&pool->cancelled, memory_order_relaxed)) {
		if (hooks->job_begin)
			hooks->job_begin(hooks->user, slot->index, tag);
		if (job.count > 0)
			stilb_job_parallel_for(pool, job.count, job.grain, job.fn.range, job.data, slot->index);
		else
			job.fn.one(job.data, slot->index);
		if (hooks->job_end)
			hooks->job_end(hooks->user, slot->index);
	}
	slot->level = outer_level;
	slot->root = outer_root;
	slot->in_high = outer_high;
	job_count(&slot->finished);
}

static bool scope_has(const job_scope *scope, const job_record *record)
{
	/* Relaxed: see job_record. */
	return scope->all || (atomic_load_explicit(&record->root, memory_order_relaxed) == scope->root &&
	                      atomic_load_explicit(&record->level, memory_order_relaxed) > scope->level);
}

/* The newest of the thread's own jobs, if the scope has it. */
static job_record *take_own(job_slot *slot, const job_scope *scope)
{
	/* If a thief takes the record that was looked at, the deque is empty: pop gives that one or none. */
	job_record *newest = job_deque_newest(&slot->deque);
	return newest && scope_has(scope, newest) ? job_deque_pop(&slot->deque) : NULL;
}

/* The oldest job of one thread's deque, if the scope has it. */
static job_record *steal_from(job_slot *slot, uint32_t victim, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	job_deque *deque = &pool->slot[victim].deque;
	int64_t top;
	job_record *record = job_deque_oldest(deque, &top);
	if (!record || !scope_has(scope, record) || !job_deque_steal(deque, top))
		return NULL;
	slot->victim = victim; /* where there was one there may be more */
	if (pool->hooks.steal && victim != slot->index)
		pool->hooks.steal(pool->hooks.user, slot->index, victim);
	return record;
}

/* The same for all threads. A waiting thread looks at its own deque, too: what it may run can lie under what it may not. */
static job_record *steal(job_slot *slot, const job_scope *scope)
{
	uint32_t threads = slot->pool->worker_count + 1, victim = slot->victim;
	job_record *record = NULL;
	for (uint32_t i = 0; i < threads && !record; i++, victim = victim + 1 < threads ? victim + 1 : 0)
		record = steal_from(slot, victim, scope);
	return record;
}

/* A steal costs the victim as much as it costs the thief, for it takes the line of the victim's deque away. A thief whose last
 * catch took less than that leaves the victim alone for a moment: two threads that fight over empty jobs are slower than
 * one that runs them in peace. */
static void note_catch(job_slot *slot, uint64_t ticks)
{
	slot->meagre = ticks < slot->pool->steal_ticks;
}

/* Is there something that comes before the next job of the same place? Relaxed: a guess. */
static bool urgent(job_slot *slot)
{
	return atomic_load_explicit(&slot->pool->shared_hint[JOB_SHARED_HIGH], memory_order_relaxed) > 0 ||
	       atomic_load_explicit(&slot->inbox, memory_order_relaxed);
}

/* Runs a job and then, if there is a scope, more that it has, from the own deque or where the last one was stolen. Those of one
 * group that come in a row are counted out of it together: it cannot have finished before the last of them anyway, and
 * its word is the one that all threads fight for. */
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
		run_one(slot, record);
		if (stolen)
			note_catch(slot, job_sys_ticks() - start);
		jobs++;
		bool enough = until && (until == group ? job_group_done_but(until, jobs) : job_group_done(until));
		record = NULL;
		if (!scope || enough || i + 1 == JOBS_IN_A_ROW || urgent(slot))
			continue;
		record = take_own(slot, scope);
		stolen = !record && stolen && !slot->meagre && (record = steal_from(slot, slot->victim, scope));
	}
	if (group)
		job_group_finish(slot, group, jobs);
}

/* ---- where to find it ------------------------------------------------------------------------------------------ */

/* Moves the inbox to the end of the thread's own list, oldest first. */
static void fetch_pinned(job_slot *slot)
{
	/* Relaxed: a guess; if it misses one, the look before the sleep does not. */
	if (!atomic_load_explicit(&slot->inbox, memory_order_relaxed))
		return;
	/* Acquire pairs with push_inbox: the records. */
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
	/* Relaxed: a guess, as above. */
	if (atomic_load_explicit(&pool->shared_hint[which], memory_order_relaxed) == 0 ||
	    stilb_job_queue_pop(pool->shared[which], &record, slot->index) != 0)
		return NULL;
	atomic_fetch_sub_explicit(&pool->shared_hint[which], 1, memory_order_relaxed);
	stilb_job_queue_rest(pool->shared[which], slot->index); /* the job may be long */
	return record;
}

/* A job that lay where others can see it; *work says what kind it was. */
static job_record *take_visible(job_slot *slot, const job_scope *scope, job_work *work)
{
	*work = (job_work){.kind = JOB_WORK_SHARED};
	job_record *record = scope->all ? take_shared(slot, JOB_SHARED_NORMAL) : NULL;
	if (!record && (record = steal(slot, scope)))
		*work = (job_work){.kind = JOB_WORK_JOB,
		                   .root = atomic_load_explicit(&record->root, memory_order_relaxed),
		                   .level = atomic_load_explicit(&record->level, memory_order_relaxed)};
	if (!record && scope->all)
		record = take_shared(slot, JOB_SHARED_LOW);
	return record;
}

/* Is there something to be stolen? */
static bool deques_have(stilb_job_pool *pool, const job_scope *scope)
{
	for (uint32_t i = 0; i <= pool->worker_count; i++) {
		int64_t top;
		job_record *record = job_deque_oldest(&pool->slot[i].deque, &top);
		if (record && scope_has(scope, record))
			return true;
	}
	return false;
}

/* Takes a job and says what kind of work it was; NULL if there is none or a loop was helped (then *helped). */
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
	slot->turn = (slot->turn + 1) % SHARED_FIRST;
	*work = (job_work){.kind = JOB_WORK_SHARED};
	if (slot->turn == 0) {
		*helped = job_loop_help(slot, scope, until);
		if (!*helped && scope->all)
			record = take_shared(slot, JOB_SHARED_NORMAL);
		if (*helped || record)
			return record;
	}
	*work = (job_work){.kind = JOB_WORK_OWN};
	record = take_own(slot, scope);
	if (!record && !(*helped = job_loop_help(slot, scope, until)))
		record = take_visible(slot, scope, work);
	return record;
}

bool job_work_help(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	job_work work;
	bool helped = false;
	job_record *record = take_any(slot, scope, until, &work, &helped);
	if (!record)
		return helped;
	job_work_spin_stop(slot);
	if (work.kind != JOB_WORK_OWN) /* who pushed an own one has seen to it that somebody looks for the next */
		job_work_pass(slot, &work);
	run(slot, record, work.kind == JOB_WORK_JOB, scope->jobs ? scope : NULL, until);
	return true;
}

bool job_work_rescue(job_slot *slot)
{
	job_record *record = take_shared(slot, JOB_SHARED_HIGH);
	if (!record)
		record = take_shared(slot, JOB_SHARED_NORMAL);
	if (!record)
		record = take_shared(slot, JOB_SHARED_LOW);
	if (!record)
		record = steal(slot, &job_scope_all);
	if (record)
		run(slot, record, false, NULL, NULL);
	return record;
}

bool job_work_exists(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	/* Seq_cst: the look (2) of job_park.h. */
	if (slot->pinned || atomic_load_explicit(&slot->inbox, memory_order_seq_cst))
		return true;
	if (scope->high && !stilb_job_queue_empty(pool->shared[JOB_SHARED_HIGH], slot->index))
		return true;
	if (scope->all && (!stilb_job_queue_empty(pool->shared[JOB_SHARED_NORMAL], slot->index) ||
	                   !stilb_job_queue_empty(pool->shared[JOB_SHARED_LOW], slot->index)))
		return true;
	return (scope->jobs && deques_have(pool, scope)) || job_loop_exists(pool, scope);
}

void job_work_pass(job_slot *slot, const job_work *work)
{
	/* A relaxed guess will do: a thread that goes to sleep later looks for work itself. */
	if (job_idle_maybe_wanted(&slot->pool->idle) && job_work_exists(slot, &job_scope_all))
		job_idle_wake(&slot->pool->idle, work);
}

/* ---- idling ---------------------------------------------------------------------------------------------------- */

/* The same question as job_work_exists, answered by a glance: relaxed, only at what is likely. */
static bool glimpse(job_slot *slot, const job_scope *scope)
{
	stilb_job_pool *pool = slot->pool;
	if (job_loop_exists(pool, scope) || atomic_load_explicit(&slot->inbox, memory_order_relaxed))
		return true;
	for (uint32_t i = 0; i < JOB_SHARED_COUNT; i++)
		if ((i == JOB_SHARED_HIGH ? scope->high : scope->all) &&
		    atomic_load_explicit(&pool->shared_hint[i], memory_order_relaxed))
			return true;
	return scope->jobs && deques_have(pool, scope);
}

void job_work_relax(job_slot *slot)
{
	if (!slot->pool->crowded || slot->no_yield > 0) {
		slot->no_yield -= slot->no_yield > 0;
		job_sys_pause();
		return;
	}
	/* What is waited for may be waiting for this CPU. But if it goes to a stranger for a whole time slice, waiters had better
	 * spin and sleep like others for a while: the kernel favours who wakes up over who yields. */
	uint64_t start = job_sys_ticks();
	sched_yield();
	if (job_sys_ticks() - start > YIELD_LONG * slot->pool->wake_ticks)
		slot->no_yield = TURNS_WITHOUT_YIELD;
}

bool job_work_linger(job_slot *slot, const job_scope *scope, stilb_job_group *until)
{
	stilb_job_pool *pool = slot->pool;
	uint64_t start = job_sys_ticks();
	/* Relaxed: hints; the caller looks properly afterwards. */
	while (job_sys_ticks() - start < pool->wake_ticks ||
	       (scope->all && atomic_load_explicit(&pool->phase, memory_order_relaxed))) {
		if (glimpse(slot, scope) || (until && job_group_done(until)) ||
		    atomic_load_explicit(&pool->stop, memory_order_relaxed))
			return true;
		job_work_relax(slot);
	}
	return false;
}

static void rest(job_slot *slot)
{
	for (int i = 0; i < JOB_SHARED_COUNT; i++)
		stilb_job_queue_rest(slot->pool->shared[i], slot->index);
}

static void sleep_until_woken(job_slot *slot)
{
	const stilb_job_hooks *hooks = &slot->pool->hooks;
	rest(slot);
	if (hooks->park)
		hooks->park(hooks->user, slot->index);
	job_parker_sleep(&slot->parker);
	if (hooks->wake)
		hooks->wake(hooks->user, slot->index);
}

job_idle_fate job_work_park(job_slot *slot, const job_scope *scope, job_ready_fn *ready, void *context)
{
	stilb_job_pool *pool = slot->pool;
	job_idler idler = {.parker = &slot->parker, .scope = *scope, .worker = slot->index > 0};
	/* The steps (1) to (3) of job_park.h. */
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
			sleep_until_woken(slot);
	}
	job_idle_fate fate = job_idle_leave(&pool->idle, &slot->parker);
	slot->spinning = scope->all && fate == JOB_IDLE_CHOSEN;
	return rescue ? JOB_IDLE_RESCUE : fate;
}

uint32_t stilb_job_run_pinned(stilb_job_pool *pool, uint32_t worker)
{
	job_slot *slot = &pool->slot[worker];
	uint32_t jobs = 0, there = 0;
	fetch_pinned(slot);
	for (job_record *record = slot->pinned; record; record = record->next)
		there++;
	/* Not those that come meanwhile: such a job may submit itself again. */
	for (job_record *record; jobs < there && (record = take_pinned(slot)); jobs++)
		run(slot, record, false, NULL, NULL);
	return jobs;
}
