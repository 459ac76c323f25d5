/* The idle list of job_park.h when work is published under a lock, as jobs of low priority and those of the shared
 * queues are, by a thread that then calls job_idle_wanted_strict: genmc.h. */
#include "genmc.h"

#include "jobs/job_park.c"

#undef NDEBUG
#include <assert.h>

static job_idle_list idle;
static job_parker parker;
static job_lock lock;
static _Atomic uint32_t count; /* of jobs */
static int contents, seen;
static bool slept;

static void *worker(void *unused)
{
	(void)unused;
	job_idler idler = {.parker = &parker, .scope = {.all = true, .jobs = true, .high = true}, .worker = true};
	job_idle_enter(&idle, &idler, false);                            /* step (1) of job_park.h */
	slept = atomic_load_explicit(&count, memory_order_relaxed) == 0; /* step (2), as in low_has */
	if (slept)
		return NULL; /* its wake-up is not part of this */
	job_idle_leave(&idle, &parker);
	job_lock_take(&lock);
	seen = contents;
	job_lock_give(&lock);
	return NULL;
}

int main(void)
{
	pthread_t other;
	job_idle_init(&idle, 1);
	pthread_create(&other, NULL, worker, NULL);
	job_lock_take(&lock); /* step (a) */
	contents = 1;
	atomic_fetch_add_explicit(&count, 1, memory_order_relaxed);
	job_lock_give(&lock);
	bool woken = job_idle_wanted_strict(&idle, 64); /* step (b) */
	if (woken)
		job_idle_wake(&idle, &(job_work){.kind = JOB_WORK_SHARED});
	pthread_join(other, NULL);
	assert(slept ? woken : seen == 1);
	return 0;
}
