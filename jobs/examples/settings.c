/*
 * Settings: two pools of one program. The workers of the first load files in the background: they have a name that ps,
 * top and gdb show, a small stack, one CPU for all of them, and a nice value that lets other threads run first. The
 * second one has settings that cannot be, and the library says which.
 *
 * Prints: loader-2, nice +10: yes, one CPU: yes. Refused: stack_size is less than PTHREAD_STACK_MIN
 */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* pthread_getname_np, sched_getcpu */
#endif
#include <stilb/job.h>

#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <sys/resource.h>

static void load(void *data, uint32_t worker)
{
	(void)worker;
	pthread_getname_np(pthread_self(), data, 16);
}

int main(void)
{
	int own = getpriority(PRIO_PROCESS, 0);
	uint32_t cpu = (uint32_t)sched_getcpu();
	stilb_job_pool_desc desc = {.worker_count = 2,
	                            .name = "loader",
	                            .stack_size = 256 * 1024,
	                            .nice = 10,
	                            .affinity = STILB_JOB_AFFINITY_NONE,
	                            .cpus = &cpu,
	                            .cpu_count = 1};
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	/* The system may refuse a CPU, or a negative nice value: the worker then runs without, and this tells. */
	stilb_job_worker_info info;
	stilb_job_pool_worker_info(pool, 2, &info);
	char name[16];
	stilb_job_group group = {0};
	stilb_job_options on_worker_2 = {.pinned = true, .target = 2};
	if (stilb_job_submit_with(pool, load, name, &group, &on_worker_2, 0) != 0)
		return 1;
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool);

	desc.stack_size = 100;
	const char *refused = stilb_job_pool_desc_error(&desc);
	printf("%s, nice +10: %s, one CPU: %s. Refused: %s\n", name,
	       info.nice == own + 10 || info.nice == 19 ? "yes" : "no", info.affinity_error == 0 ? "yes" : "no",
	       refused ? refused : "nothing");
	return stilb_job_pool_create(&desc, &pool) == 0;
}
