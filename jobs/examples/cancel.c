/*
 * Shutting down without running the remaining jobs. Destroy alone runs every job first. After a cancel, jobs that have
 * not started never run, but their groups finish, so no wait hangs.
 *
 * Prints: some ran, the rest were cancelled, the wait returned
 */
#include <stilb/job.h>

#include <stdatomic.h>
#include <stdio.h>
#include <time.h>

enum { JOBS = 10000 };

static atomic_uint ran; /* relaxed everywhere: a count that orders nothing */

static void slow(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
	atomic_fetch_add_explicit(&ran, 1, memory_order_relaxed);
	nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS; i++)
		if (stilb_job_submit(pool, slow, NULL, &group, 0) != 0)
			return 1;
	while (atomic_load_explicit(&ran, memory_order_relaxed) == 0)
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	stilb_job_pool_cancel(pool); /* 10,000 jobs of 1 ms would take seconds */
	stilb_job_wait(pool, &group, 0);
	unsigned count = atomic_load_explicit(&ran, memory_order_relaxed);
	stilb_job_pool_destroy(pool);
	printf("%s, %s, the wait returned\n", count > 0 ? "some ran" : "none ran",
	       count < JOBS ? "the rest were cancelled" : "none was cancelled");
	return 0;
}
