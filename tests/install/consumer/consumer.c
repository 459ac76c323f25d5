/* Adds up on the worker pool, inside a zone of the profiler, and prints the sum only if the trace shows the zone and
 * the pool's workers. */
#include <stilb/job_prof.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_trace.h>

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static _Atomic unsigned sum;
static char trace[65536];
static size_t trace_size;

static void add_numbers(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	for (uint32_t i = begin; i < end; i++)
		atomic_fetch_add_explicit(&sum, i, memory_order_relaxed);
}

static int keep(void *user, const void *data, size_t size)
{
	(void)user;
	if (size >= sizeof trace - trace_size)
		return -1;
	memcpy(trace + trace_size, data, size);
	trace_size += size;
	return 0;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool = NULL;
	desc.worker_count = 2;
	desc.hooks = stilb_job_prof_hooks("worker");
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	{
		PROFILE("add numbers");
		stilb_job_parallel_for(pool, 1000, 10, add_numbers, NULL, 0);
	}
	stilb_job_pool_destroy(pool);
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_sink sink = {keep, NULL};
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0 || stilb_prof_trace_write_chrome(&snapshot, NULL, sink) != 0 ||
	    !strstr(trace, "add numbers") || !strstr(trace, "\"worker 2\""))
		return 1;
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	printf("sum %u\n", atomic_load(&sum));
	return 0;
}
