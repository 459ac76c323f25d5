/* A group of two jobs of two threads, which a third one waits for and lets a job follow: genmc.h. */
#include "genmc.h"

#include "jobs/job_park.c"
#include "jobs/job_wait.c"

#undef NDEBUG
#include <assert.h>

static struct {
	stilb_job_pool pool;
	job_slot slot[3]; /* pool.slot */
} all;
static stilb_job_group group;
static job_record follower;
static int contents[2]; /* written by the jobs */

static void check(void)
{
	assert(contents[0] == 1 && contents[1] == 1);
}

/* Instead of job_submit.c: the follower runs at once. */
void job_submit_record(job_slot *slot, job_record *record)
{
	(void)slot;
	assert(record == &follower);
	check();
}

static void *job(void *number)
{
	uintptr_t i = (uintptr_t)number;
	contents[i] = 1;
	job_group_finish(&all.slot[1 + i], &group, 1);
	return NULL;
}

int main(void)
{
	pthread_t worker[2];
	all.pool.worker_count = 2;
	for (uint32_t i = 0; i < 3; i++)
		all.slot[i].pool = &all.pool;
	job_group_add(&group, 2);
	for (uintptr_t i = 0; i < 2; i++)
		pthread_create(&worker[i], NULL, job, (void *)i);
	if (!job_group_follow(&all.pool, &group, &follower))
		check();
	bool waits = group_announce(&group, 1);
	if (!waits) {
		assert(job_group_done(&group));
		check();
	}
	for (int i = 0; i < 2; i++)
		pthread_join(worker[i], NULL);
	assert(job_group_done(&group));
	assert(!waits || atomic_load_explicit(&all.slot[0].parker.state, memory_order_relaxed) == PARKER_TOKEN);
	return 0;
}
