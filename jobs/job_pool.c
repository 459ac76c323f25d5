#include "jobs/job_internal.h"

#include <errno.h>
#include <string.h>

/* How long an owner in stilb_job_pool_destroy sleeps before it looks again whether the workers have run all jobs. */
#define NAP_NS 100000u

/* ---- the workers ----------------------------------------------------------------------------------------------- */

/* The most spinners at a time: one, or in a phase one for each CPU but the owner's. */
static uint32_t spin_limit(stilb_job_pool *pool)
{
	/* Relaxed: with an old value, the begin or end of a phase takes effect a moment later, which is harmless. */
	return atomic_load_explicit(&pool->phase, memory_order_relaxed) && pool->cpus > 2 ? pool->cpus - 1 : 1;
}

static bool stopping(job_slot *slot, void *context)
{
	(void)context;
	return atomic_load_explicit(&slot->pool->stop, memory_order_acquire); /* pairs with stop_workers */
}

void job_pool_wake_for_phase(job_slot *slot)
{
	stilb_job_pool *pool = slot->pool;
	while (spin_limit(pool) > 1 && job_idle_wake_spinners(&pool->idle, spin_limit(pool), JOB_WAKE_FAN) > 0 &&
	       !job_loop_seems_to_exist(slot, &job_scope_all))
		;
}

/* Called when the worker has found nothing to do: looks for work for a while, then sleeps. */
static void worker_idle(job_slot *slot)
{
	stilb_job_pool *pool = slot->pool;
	if (!slot->spinning)
		slot->spinning = job_idle_spin_start(&pool->idle, spin_limit(pool));
	if (slot->spinning && job_work_spin(slot, &job_scope_all, NULL))
		return;
	if (job_loop_exists_far(slot, &job_scope_all))
		return; /* spares it the way onto the idle list and back */
	job_work_park(slot, &job_scope_all, stopping, NULL);
	if (slot->spinning)
		job_pool_wake_for_phase(slot);
}

void job_pool_pause_stealing(job_slot *slot)
{
	job_deque *deque = &slot->pool->slot[slot->victim].deque;
	uint64_t start = job_sys_ticks(), pause = job_sys_ticks_in(JOB_STEAL_PAUSE_NS);
	slot->steal_unprofitable = false;
	if (job_deque_empty(deque))
		return; /* nothing is left to steal there, so the worker may look elsewhere at once */
	/* Relaxed: an old value makes a pause too short. */
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	if (bottom != slot->victim_bottom) {
		pause = (pause << slot->steal_doublings) * (1 + slot->pool->team_count / 8);
		slot->steal_doublings += slot->steal_doublings < JOB_STEAL_DOUBLINGS;
	} else {
		slot->steal_doublings = 0;
	}
	slot->victim_bottom = bottom;
	if (!slot->spinning)
		slot->spinning = job_idle_spin_start(&slot->pool->idle, spin_limit(slot->pool));
	while (job_sys_ticks() - start < pause)
		job_sys_pause();
}

static void *worker_main(void *data)
{
	job_slot *slot = data;
	stilb_job_pool *pool = slot->pool;
	job_slot_set_mine(slot);
	job_worker_begin(slot);
	if (pool->hooks.thread_start)
		pool->hooks.thread_start(pool->hooks.user, slot->index);
	while (!stopping(slot, NULL))
		if (!job_work_help(slot, &job_scope_all, NULL))
			worker_idle(slot);
		else if (slot->steal_unprofitable)
			job_pool_pause_stealing(slot);
	if (slot->spinning)
		job_idle_spin_stop(&pool->idle);
	if (pool->hooks.thread_stop)
		pool->hooks.thread_stop(pool->hooks.user, slot->index);
	return NULL;
}

/* Stops and joins workers 1 to started. */
static void stop_workers(stilb_job_pool *pool, uint32_t started)
{
	atomic_store_explicit(&pool->stop, true, memory_order_release); /* pairs with the acquire in stopping */
	for (uint32_t i = 1; i <= started; i++)
		job_parker_wake(&pool->slot[i].parker);
	for (uint32_t i = 1; i <= started; i++)
		pthread_join(pool->slot[i].thread, NULL);
}

/* ---- life cycle ------------------------------------------------------------------------------------------------ */

static void pool_free(stilb_job_pool *pool)
{
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		job_deque_finish(&pool->slot[i].deque);
	for (int i = 0; i < JOB_SHARED_COUNT; i++)
		stilb_job_queue_destroy(pool->shared[i]);
	job_record_store_finish(&pool->records);
	stilb_job_allocator memory = pool->memory;
	job_release(&memory, pool, pool->size);
}

/* Creates the shared queues and the deques. 0 or -ENOMEM; pool_free frees those that were created. */
static int make_queues(stilb_job_pool *pool, const stilb_job_pool_desc *desc, job_queue_maker *make)
{
	stilb_job_queue_desc queue = {.kind = desc->queue,
	                              .capacity = SIZE_MAX,
	                              .thread_count = desc->worker_count + 1 + JOB_GUESTS,
	                              .allocator = &pool->memory};
	for (int i = 0; i < JOB_SHARED_COUNT; i++) {
		int error = 0;
		if (make)
			pool->shared[i] = make();
		else
			error = stilb_job_queue_create(&queue, &pool->shared[i]);
		if (error || !pool->shared[i])
			return error ? error : -ENOMEM;
	}
	for (uint32_t i = 0; i <= desc->worker_count; i++) {
		int error = job_deque_init(&pool->slot[i].deque, &pool->memory);
		if (error)
			return error;
	}
	return 0;
}

static void slot_init(job_slot *slot, stilb_job_pool *pool, uint32_t index)
{
	slot->pool = pool;
	slot->index = index;
	slot->cpu = JOB_NO_CPU;
	slot->random = (index + 1) * 0x9e3779b9u; /* not 0, and different for all */
	slot->active[JOB_ACTIVE_LOOPS] = slot->active[JOB_ACTIVE_JOBS] = pool->one_team;
	atomic_init(&slot->inbox, NULL);
	atomic_init(&slot->parker.state, 0);
	for (int i = 0; i < JOB_LOOP_DEPTH; i++) {
		atomic_init(&slot->loop[i].claim, 0);
		atomic_init(&slot->loop[i].owner, index);
	}
}

static stilb_job_pool *pool_allocate(const stilb_job_pool_desc *desc)
{
	/* All structs are multiples of the alignment. The numbers of desc->cpus lie behind them. */
	bool one_team = desc->worker_count < JOB_TEAM_MOST;
	size_t slots = sizeof(stilb_job_pool) + (desc->worker_count + 1) * sizeof(job_slot);
	size_t teams = one_team ? 0 : desc->worker_count / JOB_TEAM_LEAST + 1; /* at most */
	size_t structs = slots + teams * sizeof(job_team);
	size_t size = structs + desc->cpu_count * sizeof *desc->cpus;
	stilb_job_allocator memory = job_allocator_of(desc->allocator);
	stilb_job_pool *pool = job_allocate(&memory, size, JOB_LINE);
	if (!pool)
		return NULL;
	memset(pool, 0, size);
	pool->memory = memory;
	pool->size = size;
	job_idle_init(&pool->idle, desc->worker_count);
	job_record_store_init(&pool->records, &pool->memory);
	pool->low_end = &pool->low;
	pool->worker_count = desc->worker_count;
	pool->cpus = stilb_job_cpu_count();
	pool->wake_ticks = job_sys_ticks_in(JOB_WAKE_NS);
	pool->steal_ticks = job_sys_ticks_in(JOB_STEAL_NS);
	pool->one_team = one_team;
	pool->team = (job_team *)((char *)pool + slots);
	pool->oversubscribed = desc->worker_count >= pool->cpus;
	pool->hooks = desc->hooks;
	for (uint32_t i = 0; i <= desc->worker_count; i++)
		slot_init(&pool->slot[i], pool, i);
	job_slot_set_mine(&pool->slot[0]);
	job_active_begin(&pool->slot[0], JOB_ACTIVE_JOBS); /* always: the owner submits jobs between jobs */
	job_worker_prepare(pool, desc, (uint32_t *)((char *)pool + structs));
	return pool;
}

/* Cuts the pool into teams; cache[i] names the last level of cache of the CPU of thread i, for i < bound. */
static void make_teams(stilb_job_pool *pool, const uint32_t *cache, uint32_t bound)
{
	uint32_t threads = pool->worker_count + 1;
	for (uint32_t begin = 0, end; begin < threads; begin = end) {
		for (end = begin + 1; end < threads && end - begin < JOB_TEAM_MOST; end++)
			if (end < bound && cache[end] != cache[end - 1] && end - begin >= JOB_TEAM_LEAST)
				break;
		job_team *team = &pool->team[pool->team_count++];
		team->begin = begin;
		team->end = end;
		for (uint32_t i = begin; i < end; i++)
			pool->slot[i].team = team;
	}
}

/* A worker that is woken by a thread which keeps running starts at once only on another CPU, but the kernel mostly
 * chooses the waker's. So each worker is bound to a CPU of its own, and one CPU is left for the owner. If the owner
 * moves to a worker's CPU, its next wake-up of that worker binds it to the CPU left over. Workers for which no CPU is
 * left are not bound; bound ones are woken first (job_park.c, both). */
static void choose_cpus(stilb_job_pool *pool, const stilb_job_pool_desc *desc)
{
	uint32_t cpus[STILB_JOB_MAX_WORKERS + 1] = {job_sys_cpu()}, cache[STILB_JOB_MAX_WORKERS + 1], others = 0;
	job_cpu_list list = {desc->cpus, desc->cpu_count};
	if (desc->affinity == STILB_JOB_AFFINITY_AUTO && desc->worker_count > 0 && cpus[0] != UINT32_MAX)
		others = job_cpu_others(list, cpus[0], cpus + 1, desc->worker_count);
	if (!pool->one_team) {
		job_cpu_sort(cpus, others + 1, "/sys/devices/system/cpu", cache);
		make_teams(pool, cache, others + 1);
	}
	pool->idle.spare = others > 0 && job_cpu_allows(list, cpus[0]);
	pool->idle.spare_cpu = cpus[0];
	for (uint32_t i = 1; i <= others; i++)
		pool->slot[i].cpu = cpus[i];
}

static int start_workers(stilb_job_pool *pool)
{
	for (uint32_t i = 1; i <= pool->worker_count; i++) {
		int error = job_worker_create(pool, i, worker_main);
		if (error) {
			stop_workers(pool, i - 1);
			return error;
		}
	}
	return 0;
}

int job_pool_create_over(const stilb_job_pool_desc *desc, job_queue_maker *make, stilb_job_pool **out)
{
	assert(desc && out);
	*out = NULL;
	if (stilb_job_pool_desc_error(desc))
		return -EINVAL;
	stilb_job_pool *pool = pool_allocate(desc);
	if (!pool)
		return -ENOMEM;
	int error = make_queues(pool, desc, make);
	choose_cpus(pool, desc);
	if (!error)
		error = start_workers(pool);
	if (error) {
		pool_free(pool);
		return error;
	}
	*out = pool;
	return 0;
}

int stilb_job_pool_create(const stilb_job_pool_desc *desc, stilb_job_pool **pool)
{
	return job_pool_create_over(desc, NULL, pool);
}

/* True if at some moment during the call every submitted job had finished, so that no running job could submit another.
 * The finished jobs are counted first, so jobs that are submitted or finish between the two counts can only make the
 * result false. */
static bool pool_is_quiet(stilb_job_pool *pool)
{
	uint64_t finished = 0, submitted = 0;
	/* Acquire, all: pair with the release in job_count. */
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		finished += atomic_load_explicit(&pool->slot[i].finished, memory_order_acquire);
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		submitted += atomic_load_explicit(&pool->slot[i].submitted, memory_order_acquire);
	for (int i = 0; i < JOB_GUESTS; i++)
		submitted += atomic_load_explicit(&pool->guest[i].submitted, memory_order_acquire);
	assert(finished <= submitted);
	return finished == submitted;
}

/* For asserts: no job is left in any deque, inbox or shared queue, and no thread is inside a loop or job. To be called
 * after the workers have been joined. */
static bool pool_is_deserted(stilb_job_pool *pool)
{
	for (uint32_t i = 0; i <= pool->worker_count; i++) {
		job_slot *slot = &pool->slot[i];
		/* Relaxed: no other call is in progress. */
		if (!job_deque_empty(&slot->deque) || atomic_load_explicit(&slot->inbox, memory_order_relaxed) ||
		    slot->pinned || slot->loops_open > 0 || slot->level > 0)
			return false;
	}
	for (int i = 0; i < JOB_SHARED_COUNT; i++)
		if (!stilb_job_queue_empty(pool->shared[i], 0))
			return false;
	return !pool->low;
}

void stilb_job_pool_destroy(stilb_job_pool *pool)
{
	if (!pool)
		return;
	assert(job_slot_is_mine(&pool->slot[0]) && "destroyed by its owner");
	assert(pool->slot[0].level == 0 && "not from inside a job");
	assert(!pool->visitors && atomic_load_explicit(&pool->guests, memory_order_relaxed) == 0 &&
	       "no other call is running");
	while (!pool_is_quiet(pool))
		if (!job_work_help(&pool->slot[0], &job_scope_all, NULL))
			job_sys_nap(NAP_NS);
	stop_workers(pool, pool->worker_count);
	JOB_CHECK(pool_is_deserted(pool));
	pool_free(pool);
}

void stilb_job_pool_cancel(stilb_job_pool *pool)
{
	assert(pool);
	if (!atomic_exchange_explicit(&pool->cancelled, true, memory_order_relaxed)) /* relaxed: see job_internal.h */
		atomic_fetch_add_explicit(&pool->cancels, 1, memory_order_relaxed);
}

const stilb_job_allocator *job_pool_memory(const stilb_job_pool *pool)
{
	return &pool->memory;
}

uint32_t stilb_job_pool_worker_count(const stilb_job_pool *pool)
{
	assert(pool);
	return pool->worker_count;
}

void stilb_job_phase_begin(stilb_job_pool *pool)
{
	assert(pool);
	/* Relaxed: workers that see the phase a moment later only start to spin a moment later. */
	if (atomic_fetch_add_explicit(&pool->phase, 1, memory_order_relaxed) == 0)
		job_idle_wake_spinners(&pool->idle, spin_limit(pool), 1); /* which wakes the next ones, and so on */
}

void stilb_job_phase_end(stilb_job_pool *pool)
{
	assert(pool);
	/* Relaxed, as in stilb_job_phase_begin. */
	uint32_t phases = atomic_fetch_sub_explicit(&pool->phase, 1, memory_order_relaxed);
	assert(phases > 0 && "a phase ends after it has begun");
	(void)phases;
}
