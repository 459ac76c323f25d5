#include "jobs/job_internal.h"

/* The number of records in a deque, or about so many while other threads take some. Relaxed, both: the ends are not of
 * one moment, so the newer top may lie beyond the older bottom. */
static uint64_t deque_length(const job_deque *deque)
{
	int64_t top = atomic_load_explicit(&deque->top, memory_order_relaxed);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	return bottom > top ? (uint64_t)(bottom - top) : 0;
}

/* Adds what a thread has counted. Relaxed, all but one: see job_tally. Acquire: pairs with job_count; the other tallies
 * are then at least as new as the count of jobs. */
static void add_thread(const job_slot *slot, stilb_job_thread_stats *stats, uint64_t *spin_ticks)
{
	const job_tallies *tally = &slot->tally;
	stats->jobs += atomic_load_explicit(&slot->finished, memory_order_acquire);
	stats->submitted += atomic_load_explicit(&slot->submitted, memory_order_relaxed);
	stats->steals += atomic_load_explicit(&tally->steals, memory_order_relaxed);
	stats->loops_helped += atomic_load_explicit(&tally->loops_helped, memory_order_relaxed);
	stats->slices += atomic_load_explicit(&tally->slices, memory_order_relaxed);
	stats->parks += atomic_load_explicit(&tally->parks, memory_order_relaxed);
	stats->wakes += atomic_load_explicit(&tally->wakes, memory_order_relaxed);
	*spin_ticks += atomic_load_explicit(&tally->spin_ticks, memory_order_relaxed);
	stats->deque += deque_length(&slot->deque);
}

/* By the ticks that JOB_WAKE_NS takes. */
static uint64_t nanoseconds(const stilb_job_pool *pool, uint64_t ticks)
{
	return ticks / pool->wake_ticks * JOB_WAKE_NS + ticks % pool->wake_ticks * JOB_WAKE_NS / pool->wake_ticks;
}

void stilb_job_pool_get_thread_stats(stilb_job_pool *pool, uint32_t worker, stilb_job_thread_stats *stats)
{
	assert(pool && stats);
	assert(worker <= pool->worker_count && "the index of a thread of the pool");
	uint64_t spin_ticks = 0;
	*stats = (stilb_job_thread_stats){0};
	add_thread(&pool->slot[worker], stats, &spin_ticks);
	stats->spin_ns = nanoseconds(pool, spin_ticks);
}

void stilb_job_pool_get_stats(stilb_job_pool *pool, stilb_job_pool_stats *stats)
{
	assert(pool && stats);
	uint64_t spin_ticks = 0;
	*stats = (stilb_job_pool_stats){0};
	for (uint32_t i = 0; i <= pool->worker_count; i++)
		add_thread(&pool->slot[i], &stats->all, &spin_ticks);
	stats->all.spin_ns = nanoseconds(pool, spin_ticks);
	/* Relaxed, all: they are for statistics. */
	for (uint32_t i = 0; i < JOB_GUESTS; i++)
		stats->all.submitted += atomic_load_explicit(&pool->guest[i].submitted, memory_order_relaxed);
	stats->high = atomic_load_explicit(&pool->shared_hint[JOB_SHARED_HIGH], memory_order_relaxed);
	stats->shared = atomic_load_explicit(&pool->shared_hint[JOB_SHARED_NORMAL], memory_order_relaxed);
	stats->low = atomic_load_explicit(&pool->low_count, memory_order_relaxed);
}
