/*
 * Three priorities: high before normal before low. Without workers the owner runs everything in its wait, so the order
 * is visible; with workers it is the order in which jobs start. Long background jobs have low priority.
 *
 * Prints: high high normal normal low low
 */
#include <stilb/job.h>

#include <stdio.h>

enum { JOBS = 6 };

typedef struct log {
	const char *names[JOBS];
	int count;
} log;

typedef struct entry {
	log *log;
	const char *name;
} entry;

static void write_name(void *data, uint32_t worker)
{
	(void)worker;
	entry *e = data;
	e->log->names[e->log->count++] = e->name;
}

int main(void)
{
	static const struct {
		stilb_job_priority priority;
		const char *name;
	} kinds[] = {{STILB_JOB_LOW, "low"}, {STILB_JOB_NORMAL, "normal"}, {STILB_JOB_HIGH, "high"}};
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 0;
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;

	log order = {.count = 0};
	entry entries[JOBS];
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS; i++) {
		entries[i] = (entry){&order, kinds[i % 3].name};
		stilb_job_options options = {.priority = kinds[i % 3].priority};
		if (stilb_job_submit_with(pool, write_name, &entries[i], &group, &options, 0) != 0)
			return 1;
	}
	stilb_job_wait(pool, &group, 0);
	for (int i = 0; i < order.count; i++)
		printf("%s%s", order.names[i], i + 1 < order.count ? " " : "\n");
	stilb_job_pool_destroy(pool);
	return 0;
}
