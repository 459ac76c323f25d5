/*
 * Hooks: how a profiler observes the pool. Each is called on the thread that it is about, so a slot for each worker
 * index needs no atomics. Here they count; and submit tags each job with the time, so that job_begin knows how long it
 * has been waiting.
 *
 * Prints: 100 jobs submitted, 100 began, 100 ended, all after they were submitted: yes, parks and wakes pair: yes
 */
#include <stilb/job.h>

#include <stdio.h>
#include <time.h>

enum { JOBS = 100, WORKERS = 2 };

typedef struct counts {
	_Alignas(128) uint32_t submits;
	uint32_t begins, early, ends, parks, wakes;
} counts;

static uint64_t now_ns(void)
{
	struct timespec time;
	clock_gettime(CLOCK_MONOTONIC, &time);
	return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

static uint64_t submit(void *user, uint32_t worker)
{
	((counts *)user)[worker].submits++; /* no outside thread submits here */
	return now_ns();
}

static void job_begin(void *user, uint32_t worker, uint64_t tag)
{
	((counts *)user)[worker].begins++;
	((counts *)user)[worker].early += now_ns() < tag;
}

static void job_end(void *user, uint32_t worker)
{
	((counts *)user)[worker].ends++;
}

static void park(void *user, uint32_t worker)
{
	((counts *)user)[worker].parks++;
}

static void wake(void *user, uint32_t worker)
{
	((counts *)user)[worker].wakes++;
}

static void nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

int main(void)
{
	static counts by_thread[WORKERS + 1];
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = WORKERS;
	desc.hooks = (stilb_job_hooks){
		.user = by_thread, .submit = submit, .job_begin = job_begin, .job_end = job_end, .park = park, .wake = wake};
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS; i++)
		if (stilb_job_submit(pool, nothing, NULL, &group, 0) != 0)
			return 1;
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool); /* joins the workers: now their slots may be read */

	counts all = {0};
	for (int i = 0; i <= WORKERS; i++) {
		all.submits += by_thread[i].submits;
		all.begins += by_thread[i].begins;
		all.early += by_thread[i].early;
		all.ends += by_thread[i].ends;
		all.parks += by_thread[i].parks;
		all.wakes += by_thread[i].wakes;
	}
	printf("%u jobs submitted, %u began, %u ended, all after they were submitted: %s, parks and wakes pair: %s\n",
	       all.submits, all.begins, all.ends, all.early == 0 ? "yes" : "no", all.parks == all.wakes ? "yes" : "no");
	return 0;
}
