/*
 * The pool on lock-free queues, for programs in which a thread that is stopped at any instruction (by a debugger, by a
 * scheduler with more threads than CPUs) must not stop the others. It costs some throughput; everything else is the
 * same.
 *
 * Prints: 1000 jobs on lock-free queues
 */
#include <stilb/job.h>

#include <stdatomic.h>
#include <stdio.h>

enum { JOBS = 1000 };

static void count(void *data, uint32_t worker)
{
	(void)worker;
	atomic_fetch_add_explicit((atomic_uint *)data, 1, memory_order_relaxed); /* read after the wait, which orders it */
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.queue = STILB_JOB_QUEUE_LOCK_FREE;
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	stilb_job_group group = {0};
	stilb_job_options low = {.priority = STILB_JOB_LOW}; /* jobs with a priority go through the shared queues */
	atomic_uint ran = 0;
	for (int i = 0; i < JOBS; i++)
		if (stilb_job_submit_with(pool, count, &ran, &group, &low, 0) != 0)
			return 1;
	stilb_job_wait(pool, &group, 0);
	printf("%u jobs on lock-free queues\n", atomic_load_explicit(&ran, memory_order_relaxed));
	stilb_job_pool_destroy(pool);
	return 0;
}
