/*
 * The job system seen by the profiler: a pool with the hooks of job_prof.h. Each job is a zone "job" on the thread that
 * ran it, with the zones of its own function inside, and an arrow from where it was submitted. Give a file's name
 * (trace.json) to look at it in ui.perfetto.dev or speedscope.
 *
 * Prints: 100 jobs, 100 squares in them, 100 arrows; workers seen: 2
 */
#include <stilb/job_prof.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_trace.h>

#include <stdio.h>
#include <string.h>

enum { JOBS = 100 };

static void square(void *data, uint32_t worker)
{
	PROFILE("square");
	double *value = data;
	(void)worker;
	*value *= *value;
}

static int run_jobs(void)
{
	static double values[JOBS];
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 2;
	desc.hooks = stilb_job_prof_hooks("worker");
	stilb_job_pool *pool;
	int error = stilb_job_pool_create(&desc, &pool);
	if (error != 0)
		return error;
	PROFILE("submit and wait");
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS && error == 0; i++)
		error = stilb_job_submit(pool, square, &values[i], &group, 0);
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool);
	return error;
}

static void print_what_was_seen(const stilb_prof_snapshot *s)
{
	uint32_t jobs = 0, squares = 0, arrows = 0, workers = 0;
	for (uint32_t l = 0; l < s->lane_count; l++) {
		const stilb_prof_lane *lane = &s->lanes[l];
		workers += strncmp(lane->name, "worker ", 7) == 0;
		for (uint32_t i = 0; i < lane->zone_count; i++) {
			const stilb_prof_zone *zone = &lane->zones[i];
			bool inside = zone->parent != STILB_PROF_NONE;
			jobs += strcmp(s->labels[zone->label].name, "job") == 0;
			squares += strcmp(s->labels[zone->label].name, "square") == 0 && inside &&
			           strcmp(s->labels[lane->zones[zone->parent].label].name, "job") == 0;
		}
	}
	for (uint32_t i = 0; i < s->flow_count; i++)
		arrows += s->flows[i].from_lane != STILB_PROF_NONE && s->flows[i].to_lane != STILB_PROF_NONE;
	printf("%u jobs, %u squares in them, %u arrows; workers seen: %u\n", jobs, squares, arrows, workers);
}

int main(int argc, char **argv)
{
	stilb_prof_snapshot snapshot = {0};
	int error = run_jobs();
	if (error == 0)
		error = stilb_prof_snapshot_take(&snapshot, NULL);
	if (error == 0)
		print_what_was_seen(&snapshot);
	if (error == 0 && argc > 1)
		error = stilb_prof_trace_save(&snapshot, "job_prof", argv[1]);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return error != 0;
}
