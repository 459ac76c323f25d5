/* What the profiler sees of a pool with the hooks of job_prof.h: names, jobs, loops, waits, sleep; and a pool of
 * another name. */
#include <stilb/job_graph.h>
#include <stilb/job_prof.h>
#include <stilb/prof_snapshot.h>

#include <pthread.h>
#include <semaphore.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static stilb_prof_snapshot s; /* {0} between tests */

static int shut_down(void **state)
{
	(void)state;
	stilb_prof_snapshot_finish(&s);
	stilb_prof_shutdown();
	return 0;
}

static stilb_job_pool *pool_make(uint32_t workers, const char *name)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool = NULL;
	desc.worker_count = workers;
	desc.affinity = STILB_JOB_AFFINITY_NONE;
	desc.hooks = stilb_job_prof_hooks(name);
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static const char *zone_name(const stilb_prof_lane *lane, uint32_t zone)
{
	return zone == STILB_PROF_NONE ? "" : s.labels[lane->zones[zone].label].name;
}

/* Zones of that name on all lanes, or on that one. */
static uint32_t zone_count(const char *lane, const char *name)
{
	uint32_t count = 0;
	for (uint32_t l = 0; l < s.lane_count; l++)
		for (uint32_t i = 0; i < s.lanes[l].zone_count && (!lane || strcmp(s.lanes[l].name, lane) == 0); i++)
			count += strcmp(zone_name(&s.lanes[l], i), name) == 0;
	return count;
}

static bool has_lane(const char *name)
{
	for (uint32_t l = 0; l < s.lane_count; l++)
		if (strcmp(s.lanes[l].name, name) == 0)
			return true;
	return false;
}

static void work(void *data, uint32_t worker)
{
	PROFILE("work");
	(void)data, (void)worker;
}

static void jobs_are_zones_with_arrows(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_make(3, NULL);
	stilb_job_group group = {0};
	for (int i = 0; i < 200; i++)
		assert_int_equal(stilb_job_submit(pool, work, NULL, &group, 0), 0);
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool);
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_int_equal(zone_count(NULL, "job"), 200);
	assert_true(has_lane("worker 1") && has_lane("worker 2") && has_lane("worker 3"));
	for (uint32_t l = 0; l < s.lane_count; l++)
		for (uint32_t i = 0; i < s.lanes[l].zone_count; i++) {
			if (strcmp(zone_name(&s.lanes[l], i), "work") == 0)
				assert_string_equal(zone_name(&s.lanes[l], s.lanes[l].zones[i].parent), "job");
			assert_false(s.lanes[l].zones[i].open);
		}
	assert_int_equal(s.flow_count, 200);
	for (uint32_t i = 0; i < s.flow_count; i++) {
		assert_true(s.flows[i].from_lane < s.lane_count && s.flows[i].to_lane < s.lane_count);
		assert_string_equal(s.labels[s.flows[i].label].name, "job");
		assert_string_equal(s.lanes[s.flows[i].from_lane].name, "main");
	}
}

static void nodes_are_zones_of_their_names(void **state)
{
	(void)state;
	static const char *const names[] = {"cull", "draw", NULL, "show"};
	stilb_job_pool *pool = pool_make(2, NULL);
	stilb_job_graph *graph;
	assert_int_equal(stilb_job_graph_create(&graph), 0);
	for (uint32_t i = 0, node; i < 4; i++) {
		assert_int_equal(stilb_job_graph_add_node(graph, work, NULL, names[i], &node), 0);
		if (i > 0)
			assert_int_equal(stilb_job_graph_add_edge(graph, i / 3, i), 0);
	}
	assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0);
	for (int frame = 0; frame < 10; frame++) {
		stilb_job_group group = {0};
		assert_int_equal(stilb_job_graph_run(graph, pool, &group, 0), 0);
		stilb_job_wait(pool, &group, 0);
	}
	stilb_job_pool_destroy(pool);
	stilb_job_graph_destroy(graph);
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_int_equal(zone_count(NULL, "job"), 40);
	for (uint32_t i = 0; i < 4; i++)
		if (names[i])
			assert_int_equal(zone_count(NULL, names[i]), 10);
	for (uint32_t l = 0; l < s.lane_count; l++)
		for (uint32_t i = 0; i < s.lanes[l].zone_count; i++) {
			const char *name = zone_name(&s.lanes[l], i), *parent = zone_name(&s.lanes[l], s.lanes[l].zones[i].parent);
			if (strcmp(name, "cull") == 0 || strcmp(name, "draw") == 0 || strcmp(name, "show") == 0)
				assert_string_equal(parent, "job");
			if (strcmp(name, "work") == 0)
				assert_true(strcmp(parent, "job") == 0 || strcmp(parent, "cull") == 0 || strcmp(parent, "draw") == 0 ||
				            strcmp(parent, "show") == 0);
		}
	assert_int_equal(s.flow_count, 40);
}

static void spin(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	for (uint32_t i = 1000 * begin; i < 1000 * end; i++)
		__asm__ volatile("" ::: "memory");
}

/* Loops are repeated until the worker has helped with one: on a busy machine it may come too late for the first. */
static void help_with_a_loop_is_a_job(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_make(1, "helper");
	for (int i = 0; i < 2000 && zone_count("helper 1", "job") == 0; i++) {
		stilb_job_parallel_for(pool, 10000, 1, spin, NULL, 0);
		assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	}
	assert_true(zone_count("helper 1", "job") > 0);
	stilb_job_pool_destroy(pool);
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_int_equal(zone_count("main", "job"), 0); /* the caller helps nobody */
	assert_int_equal(s.lanes[s.flows[0].from_lane].tid, gettid());
}

/* ---- waits and sleep --------------------------------------------------------------------------------------------- */

static sem_t go;

static void wait_for_go(void *data, uint32_t worker)
{
	(void)data, (void)worker;
	while (sem_wait(&go) != 0)
		;
}

static bool is_open(const stilb_prof_snapshot *snapshot, const char *lane, const char *name)
{
	for (uint32_t l = 0; l < snapshot->lane_count; l++)
		for (uint32_t i = 0; i < snapshot->lanes[l].zone_count; i++) {
			const stilb_prof_zone *zone = &snapshot->lanes[l].zones[i];
			if (zone->open && strcmp(snapshot->lanes[l].name, lane) == 0 &&
			    strcmp(snapshot->labels[zone->label].name, name) == 0)
				return true;
		}
	return false;
}

/* Lets the job go when all others sleep. */
static void *let_go(void *unused)
{
	stilb_prof_snapshot seen = {0};
	for (int i = 0; i < 50000; i++) {
		if (stilb_prof_snapshot_take(&seen, NULL) != 0 ||
		    (is_open(&seen, "main", "wait for workers") && is_open(&seen, "worker 2", "parked")))
			break;
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	}
	stilb_prof_snapshot_finish(&seen);
	sem_post(&go);
	return unused;
}

/* The owner sleeps in its wait: that is a wait, and no "parked" lies in it. A worker that sleeps is parked. */
static void a_wait_is_a_wait_and_sleep_is_parked(void **state)
{
	(void)state;
	pthread_t thread;
	stilb_job_pool *pool = pool_make(2, NULL);
	stilb_job_group group = {0};
	stilb_job_options to_worker_1 = {.pinned = true, .target = 1};
	sem_init(&go, 0, 0);
	assert_int_equal(stilb_job_submit_with(pool, wait_for_go, NULL, &group, &to_worker_1, 0), 0);
	assert_int_equal(pthread_create(&thread, NULL, let_go, NULL), 0);
	stilb_job_wait(pool, &group, 0);
	pthread_join(thread, NULL);
	stilb_job_pool_destroy(pool);
	sem_destroy(&go);
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_true(zone_count("main", "wait for workers") >= 1);
	assert_int_equal(zone_count("main", "parked"), 0);
	assert_true(zone_count("worker 2", "parked") >= 1);
	assert_int_equal(zone_count("worker 1", "job"), 1);
}

static void pools_have_names(void **state)
{
	(void)state;
	stilb_job_pool *one = pool_make(1, "render"), *two = pool_make(1, "load");
	stilb_job_pool_destroy(two);
	stilb_job_pool_destroy(one);
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_true(has_lane("render 1") && has_lane("load 1"));
}

#define GLUE_TEST(f) cmocka_unit_test_teardown(f, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		GLUE_TEST(jobs_are_zones_with_arrows), GLUE_TEST(nodes_are_zones_of_their_names),
		GLUE_TEST(help_with_a_loop_is_a_job),  GLUE_TEST(a_wait_is_a_wait_and_sleep_is_parked),
		GLUE_TEST(pools_have_names),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
