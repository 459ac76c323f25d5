#include "jobs/job_internal.h"

#include <errno.h>

/* gcc does not inline a function of this size that two others call. Then a submitter lies in memory, which costs 6 of
 * 26 ns a job (100,000 empty jobs on one thread of an AMD EPYC). */
#define INLINE static inline __attribute__((always_inline))

/* ---- threads from outside -------------------------------------------------------------------------------------- */

uint32_t job_guest_enter(stilb_job_pool *pool)
{
	uint32_t rounds = 0;
	uint32_t used = atomic_load_explicit(&pool->guests, memory_order_relaxed); /* the first guess of the exchange */
	for (;;) {
		uint32_t guest = used == UINT32_MAX ? JOB_GUESTS : (uint32_t)__builtin_ctz(~used);
		if (guest >= JOB_GUESTS) {
			job_sys_relax(&rounds);
			used = atomic_load_explicit(&pool->guests, memory_order_relaxed);
			continue;
		}
		/* Acquire pairs with the release in job_guest_leave: the state of the previous guest of this number. */
		if (atomic_compare_exchange_weak_explicit(&pool->guests, &used, used | 1u << guest, memory_order_acquire,
		                                          memory_order_relaxed))
			return guest;
	}
}

void job_guest_leave(stilb_job_pool *pool, uint32_t guest)
{
	assert(guest < JOB_GUESTS);
	/* Release pairs with job_guest_enter. */
	uint32_t used = atomic_fetch_and_explicit(&pool->guests, ~(1u << guest), memory_order_release);
	assert(used & 1u << guest && "a guest leaves once");
	(void)used;
}

/* ---- where a job goes ------------------------------------------------------------------------------------------ */

/* Puts the record into the inbox of one thread and wakes that thread. Needs no memory, so it cannot fail. */
static void push_inbox(job_slot *target, job_record *record)
{
	record->next = atomic_load_explicit(&target->inbox, memory_order_relaxed); /* the first guess of the exchange */
	/* Seq_cst: publishes the record to the thread that empties the inbox, and comes before the look at the idle list:
	 * step (a) in the head of job_park.h. */
	while (!atomic_compare_exchange_weak_explicit(&target->inbox, &record->next, record, memory_order_seq_cst,
	                                              memory_order_relaxed))
		;
	job_idle_wake_thread(&target->pool->idle, &target->parker);
}

/* The record as the waker of a thread describes it. To be called before the record is pushed: after that another thread
 * may run the job and reuse the record. */
static job_work work_of(const job_record *record)
{
	return (job_work){.kind = JOB_WORK_JOB,
	                  .root = atomic_load_explicit(&record->root, memory_order_relaxed),
	                  .level = atomic_load_explicit(&record->level, memory_order_relaxed)};
}

/* Appends to the list of jobs of low priority. Needs no memory, so it cannot fail. */
static void push_low(stilb_job_pool *pool, job_record *record)
{
	job_work work = work_of(record);
	record->next = NULL;
	job_lock_take(&pool->low_lock);
	*pool->low_end = record;
	pool->low_end = &record->next;
	/* Relaxed: changed under the lock. Threads that read it without the lock either find the job a moment later, or are
	 * going to sleep: job_idle_wanted_strict below is ordered against their step (1). */
	atomic_fetch_add_explicit(&pool->low_count, 1, memory_order_relaxed);
	job_lock_give(&pool->low_lock);
	if (job_idle_wanted_strict(&pool->idle, work.root))
		job_idle_wake(&pool->idle, &work);
}

/* Pushes into the shared queue of the record's priority, which is not low; thread is the caller's thread number in the
 * queue's calls (job_queue.h). 0 or -ENOMEM. */
static int push_shared(stilb_job_pool *pool, job_record *record, uint32_t thread)
{
	uint32_t which = record->priority == STILB_JOB_HIGH ? JOB_SHARED_HIGH : JOB_SHARED_NORMAL;
	job_work work = work_of(record);
	work.kind = which == JOB_SHARED_HIGH ? JOB_WORK_HIGH : JOB_WORK_SHARED;
	/* Relaxed: consumers skip a queue whose count is 0, and if they see the new count late, they find the job a moment
	 * later. Raised before the push, so that it never falls below zero. */
	atomic_fetch_add_explicit(&pool->shared_hint[which], 1, memory_order_relaxed);
	int error = stilb_job_queue_push(pool->shared[which], record, thread);
	if (error) {
		atomic_fetch_sub_explicit(&pool->shared_hint[which], 1, memory_order_relaxed);
		return error;
	}
	stilb_job_queue_rest(pool->shared[which], thread);
	if (job_idle_wanted_strict(&pool->idle, work.root))
		job_idle_wake(&pool->idle, &work);
	return 0;
}

/* Pushes into the calling thread's deque. 0 or -ENOMEM. */
static int push_own(job_slot *slot, job_record *record)
{
	assert(slot->active[JOB_ACTIVE_JOBS]);
	/* Relaxed, both, and before the push: see work_of. */
	uintptr_t root = atomic_load_explicit(&record->root, memory_order_relaxed);
	uint32_t level = atomic_load_explicit(&record->level, memory_order_relaxed);
	int error = job_deque_push(&slot->deque, record);
	if (!error && job_idle_wanted(&slot->pool->idle, root))
		job_idle_wake(&slot->pool->idle, &(job_work){.kind = JOB_WORK_JOB, .root = root, .level = level});
	return error;
}

/* The slot whose inbox takes a job when there is no memory for a queue: a worker's, if there is one. */
static job_slot *fallback_slot(stilb_job_pool *pool)
{
	return &pool->slot[pool->worker_count > 0];
}

/* job_submit_record, when the caller knows what the record says, often a constant. */
INLINE void submit_record(job_slot *slot, job_record *record, uint16_t target, uint8_t priority)
{
	assert(job_slot_is_mine(slot) && record->target == target && record->priority == priority);
	if (target != JOB_ANYONE)
		push_inbox(&slot->pool->slot[target], record);
	else if (priority == STILB_JOB_LOW)
		push_low(slot->pool, record);
	else if ((priority != STILB_JOB_NORMAL || push_own(slot, record) != 0) &&
	         push_shared(slot->pool, record, slot->index) != 0)
		push_inbox(fallback_slot(slot->pool), record);
}

void job_submit_record(job_slot *slot, job_record *record)
{
	submit_record(slot, record, record->target, record->priority);
}

static void submit_as_guest(stilb_job_pool *pool, job_record *record, uint32_t guest)
{
	if (record->target != JOB_ANYONE)
		push_inbox(&pool->slot[record->target], record);
	else if (record->priority == STILB_JOB_LOW)
		push_low(pool, record);
	else if (push_shared(pool, record, pool->worker_count + 1 + guest) != 0)
		push_inbox(fallback_slot(pool), record);
}

/* ---- public ---------------------------------------------------------------------------------------------------- */

/* The submitting thread: one of the pool, or one from outside that uses pool->guest[guest]. */
typedef struct submitter {
	stilb_job_pool *pool;
	job_slot *slot; /* NULL: from outside */
	uint32_t guest;
} submitter;

INLINE submitter submit_begin(stilb_job_pool *pool, uint32_t worker)
{
	assert(pool);
	submitter by = {.pool = pool, .slot = worker == STILB_JOB_OUTSIDE ? NULL : job_slot_of(pool, worker)};
	by.guest = by.slot ? 0 : job_guest_enter(pool);
	return by;
}

INLINE void submit_end(const submitter *by)
{
	if (!by->slot)
		job_guest_leave(by->pool, by->guest);
}

INLINE job_record *record_take(const submitter *by)
{
	return job_record_take(&by->pool->records, by->slot ? &by->slot->records : &by->pool->guest[by->guest].records);
}

static void record_give(const submitter *by, job_record *record)
{
	job_record_give(&by->pool->records, by->slot ? &by->slot->records : &by->pool->guest[by->guest].records, record);
}

/* Fills a record: the fields of *job that the submitter chooses, and root, level and tag. */
INLINE void record_fill(const submitter *by, job_record *record, const job_record *job)
{
	const job_slot *slot = by->slot;
	const stilb_job_hooks *hooks = &by->pool->hooks;
	record->fn = job->fn;
	record->data = job->data;
	record->group = job->group;
	record->count = job->count;
	record->grain = job->grain;
	record->target = job->target;
	record->priority = job->priority;
	record->kind = job->kind;
	uintptr_t root = slot && slot->root ? slot->root : (uintptr_t)job->group;
	atomic_store_explicit(&record->root, root, memory_order_relaxed);
	atomic_store_explicit(&record->level, slot ? slot->level + 1 : 1, memory_order_relaxed);
	if (hooks->submit)
		record->tag = hooks->submit(hooks->user, slot ? slot->index : STILB_JOB_OUTSIDE);
}

/* Counts jobs as submitted and in their group, before they are pushed: by the time that a push returns, its job may
 * have finished. */
INLINE void submit_count(const submitter *by, stilb_job_group *group, uint32_t jobs)
{
	job_count(by->slot ? &by->slot->submitted : &by->pool->guest[by->guest].submitted, jobs);
	if (group)
		job_group_add(group, jobs);
}

/* Submits a job as a new record with the fields of *job that the submitter chooses. 0 or -ENOMEM. */
INLINE int submit_copy(stilb_job_pool *pool, const job_record *job, stilb_job_group *after, uint32_t worker)
{
	assert((job->kind == JOB_LOOP ? (bool)job->fn.range : (bool)job->fn.one) && "a job has a function");
	submitter by = submit_begin(pool, worker);
	job_record *record = record_take(&by);
	if (record) {
		record_fill(&by, record, job);
		submit_count(&by, job->group, 1);
		if (job->kind == JOB_NODES)
			record->group = NULL; /* the count is the whole run's, and not this record's */
		if (after && job_group_follow(pool, after, record))
			(void)0; /* the thread that finishes `after` submits it */
		else if (by.slot)
			submit_record(by.slot, record, job->target, job->priority);
		else
			submit_as_guest(pool, record, by.guest);
	}
	submit_end(&by);
	return record ? 0 : -ENOMEM;
}

/* Takes `count` records as a list linked by next. NULL, and nothing is taken, if there is no memory. */
static job_record *records_take(const submitter *by, uint32_t count)
{
	job_record *first = NULL, *record = NULL;
	for (uint32_t i = 0; i < count && (record = record_take(by)); i++) {
		record->next = first;
		first = record;
	}
	for (job_record *next; !record && first; first = next) {
		next = first->next;
		record_give(by, first);
	}
	return first;
}

/* The most jobs of one record for a batch of so many: few enough that every thread of the pool finds some records. One
 * if each job needs a tag. */
static uint32_t batch_jobs(const stilb_job_pool *pool, uint32_t jobs)
{
	uint32_t share = jobs / (JOB_BATCH_SHARES * (pool->worker_count + 1));
	if (pool->hooks.submit || share <= 1)
		return 1;
	return share < JOB_BATCH_JOBS ? share : JOB_BATCH_JOBS;
}

/* Fills the records of a list with `jobs` jobs, `each` to a record; job i gets the data at job.data + i * stride. */
static void records_fill(const submitter *by, job_record *first, job_record job, size_t stride, uint32_t jobs,
                         uint32_t each)
{
	for (job_record *record = first; record; record = record->next) {
		job.count = jobs < each ? jobs : each;
		record_fill(by, record, &job);
		if (job.kind == JOB_BATCH)
			record->stride = stride;
		job.data = (char *)job.data + job.count * stride;
		jobs -= job.count;
	}
	assert(jobs == 0);
}

/* Pushes each record of the list by itself. Cannot fail. */
static void submit_each(const submitter *by, job_record *first)
{
	for (job_record *record = first, *next; record; record = next) {
		next = record->next;
		if (by->slot)
			job_submit_record(by->slot, record);
		else
			submit_as_guest(by->pool, record, by->guest);
	}
}

int stilb_job_submit_n(stilb_job_pool *pool, stilb_job_fn *fn, void *data, size_t stride, uint32_t count,
                       stilb_job_group *group, uint32_t worker)
{
	assert(fn);
	if (count == 0)
		return 0;
	submitter by = submit_begin(pool, worker);
	uint32_t each = batch_jobs(pool, count), records = (count - 1) / each + 1;
	job_record job = {
		.fn.one = fn, .data = data, .group = group, .target = JOB_ANYONE, .kind = each > 1 ? JOB_BATCH : JOB_SINGLE};
	job_record *first = records_take(&by, records);
	if (first) {
		records_fill(&by, first, job, stride, count, each);
		job_work work = work_of(first);
		submit_count(&by, group, count);
		if (!by.slot || job_deque_push_list(&by.slot->deque, first, records) != 0)
			submit_each(&by, first);
		else if (job_idle_wanted(&pool->idle, work.root))
			job_idle_wake(&pool->idle, &work);
	}
	submit_end(&by);
	return first ? 0 : -ENOMEM;
}

int stilb_job_submit(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group, uint32_t worker)
{
	job_record job = {.fn.one = fn, .data = data, .group = group, .target = JOB_ANYONE};
	return submit_copy(pool, &job, NULL, worker);
}

int stilb_job_submit_with(stilb_job_pool *pool, stilb_job_fn *fn, void *data, stilb_job_group *group,
                          const stilb_job_options *options, uint32_t worker)
{
	assert(pool && options);
	if ((options->pinned && options->target > pool->worker_count) || (uint32_t)options->priority > STILB_JOB_LOW ||
	    (options->after && options->after == group))
		return -EINVAL;
	job_record job = {.fn.one = fn,
	                  .data = data,
	                  .group = group,
	                  .target = options->pinned ? (uint16_t)options->target : JOB_ANYONE,
	                  .priority = (uint8_t)options->priority};
	return submit_copy(pool, &job, options->after, worker);
}

int stilb_job_submit_array(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                           stilb_job_group *group, uint32_t worker)
{
	if (count == 0)
		return 0;
	job_record job = {.fn.range = fn,
	                  .data = context,
	                  .group = group,
	                  .count = count,
	                  .grain = grain,
	                  .target = JOB_ANYONE,
	                  .kind = JOB_LOOP};
	return submit_copy(pool, &job, NULL, worker);
}

int job_submit_graph(stilb_job_pool *pool, struct stilb_job_graph *graph, uint32_t first, uint32_t count,
                     stilb_job_group *group, uint32_t worker)
{
	assert(count > 0 && group);
	job_record job = {.fn.graph = graph,
	                  .chain = UINT32_MAX,
	                  .group = group,
	                  .count = count,
	                  .grain = first,
	                  .target = JOB_ANYONE,
	                  .kind = JOB_NODES};
	return submit_copy(pool, &job, NULL, worker);
}
