#include "jobs/job_internal.h"

#include <assert.h>

static bool loop_has_slices(const job_loop *loop)
{
	return atomic_load_explicit(&loop->claimed, memory_order_relaxed) < loop->slices;
}

static void loop_open(stilb_job_pool *pool, job_loop *loop)
{
	job_lock_take(&pool->loops_lock);
	loop->older = atomic_load_explicit(&pool->loops, memory_order_relaxed); /* ordered by the lock */
	loop->listed = true;
	atomic_store_explicit(&pool->loops, loop, memory_order_relaxed);
	job_lock_give(&pool->loops_lock);
}

/* Takes the loop off the list; whoever finds no slice left does it, so that nobody looks at the loop in vain. */
static void loop_close(stilb_job_pool *pool, job_loop *loop)
{
	job_lock_take(&pool->loops_lock);
	if (loop->listed) {
		loop->listed = false;
		job_loop *at = atomic_load_explicit(&pool->loops, memory_order_relaxed); /* ordered by the lock */
		if (at == loop) {
			atomic_store_explicit(&pool->loops, loop->older, memory_order_relaxed);
		} else {
			while (at->older != loop)
				at = at->older;
			at->older = loop->older;
		}
	}
	job_lock_give(&pool->loops_lock);
}

/* Claims and runs slices until none is left (true) or until has finished (false). */
static bool loop_run(job_loop *loop, job_slot *slot, stilb_job_group *until)
{
	uint32_t outer = slot->level;
	bool exhausted = true;
	slot->level = loop->level;
	for (;;) {
		if (until && job_group_done(until)) {
			exhausted = false;
			break;
		}
		uint64_t slice = atomic_fetch_add_explicit(&loop->claimed, 1, memory_order_relaxed);
		if (slice >= loop->slices)
			break;
		uint32_t begin = (uint32_t)slice * loop->grain;
		uint32_t left = loop->count - begin;
		loop->fn(begin, begin + (left < loop->grain ? left : loop->grain), slot->index, loop->context);
	}
	slot->level = outer;
	return exhausted;
}

/* Counts the thread into a loop that it may help; null if there is none. */
static job_loop *loop_join(stilb_job_pool *pool, uint32_t level)
{
	if (!atomic_load_explicit(&pool->loops, memory_order_relaxed)) /* a hint; see job_loop_deepest */
		return NULL;
	job_lock_take(&pool->loops_lock);
	job_loop *loop = atomic_load_explicit(&pool->loops, memory_order_relaxed); /* ordered by the lock */
	while (loop && !(loop->level > level && loop_has_slices(loop)))
		loop = loop->older;
	if (loop)
		job_group_add(&loop->helpers); /* under the lock: the caller closes the loop before it waits for helpers */
	job_lock_give(&pool->loops_lock);
	return loop;
}

bool job_loop_help(stilb_job_pool *pool, uint32_t worker, stilb_job_group *until)
{
	job_slot *slot = &pool->slot[worker];
	job_loop *loop = loop_join(pool, slot->level);
	if (!loop)
		return false;
	job_pool_wake_next(pool);
	if (loop_run(loop, slot, until))
		loop_close(pool, loop);
	job_group_finish(pool, &loop->helpers);
	return true;
}

uint32_t job_loop_deepest(stilb_job_pool *pool)
{
	/* Relaxed: a loop opened before this thread entered the idle list happened before this load (job_park.h), one opened
	 * later finds this thread on the list. */
	if (!atomic_load_explicit(&pool->loops, memory_order_relaxed))
		return 0;
	uint32_t level = 0;
	job_lock_take(&pool->loops_lock);
	job_loop *loop = atomic_load_explicit(&pool->loops, memory_order_relaxed); /* ordered by the lock */
	for (; loop; loop = loop->older)
		if (loop->level > level && loop_has_slices(loop))
			level = loop->level;
	job_lock_give(&pool->loops_lock);
	return level;
}

void stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn, void *context,
                            uint32_t worker)
{
	assert(worker <= pool->worker_count);
	if (count == 0)
		return;
	job_slot *slot = &pool->slot[worker];
	job_loop loop = {
		.fn = fn, .context = context, .count = count, .grain = grain ? grain : 1, .level = slot->level + 1};
	loop.slices = (count - 1) / loop.grain + 1;
	bool shared = loop.slices > 1 && pool->worker_count > 0;
	if (shared) {
		loop_open(pool, &loop);
		job_idle_wake(&pool->idle, loop.level); /* one; it wakes the next */
	}
	loop_run(&loop, slot, NULL);
	if (shared) {
		loop_close(pool, &loop);
		job_group_wait(pool, &loop.helpers, worker, false);
	}
}
