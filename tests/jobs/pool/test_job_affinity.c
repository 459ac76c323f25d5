/* Which CPUs the workers of a pool are bound to. On a machine of one CPU most of this is not tested. */
#include "tests/jobs/job_pool_fixture.h"

typedef struct masks {
	cpu_set_t worker[MOST_THREADS];
	counter taken;
	counter ran;
	uint32_t cpu;  /* CPU on which the job ran */
	uint32_t last; /* the worker that ran the last job of note_worker */
} masks;

static void take_mask(void *user, uint32_t worker)
{
	masks *m = user;
	sched_getaffinity(0, sizeof m->worker[worker], &m->worker[worker]);
	count_up(&m->taken);
}

static stilb_job_pool *pool_with_masks(masks *m, uint32_t workers, stilb_job_affinity affinity)
{
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = affinity};
	desc.hooks = (stilb_job_hooks){.user = m, .thread_start = take_mask};
	stilb_job_pool *pool = NULL;
	*m = (masks){0};
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	assert_true(await(&m->taken, workers));
	return pool;
}

/* Each of the first `workers` workers is bound to one of all CPUs, no two to the same one, none to the owner's. */
static void check_bound(const masks *m, uint32_t workers, const cpu_set_t *all, int owner)
{
	cpu_set_t used;
	CPU_ZERO(&used);
	for (uint32_t i = 1; i <= workers; i++) {
		cpu_set_t fresh;
		assert_int_equal(CPU_COUNT(&m->worker[i]), 1);
		CPU_AND(&fresh, &m->worker[i], all);
		assert_true(CPU_EQUAL(&fresh, &m->worker[i]));
		assert_false(CPU_ISSET((size_t)owner, &m->worker[i]));
		CPU_OR(&used, &used, &m->worker[i]);
	}
	assert_int_equal(CPU_COUNT(&used), workers);
}

/* One worker fewer than there are CPUs is bound, at most; the others are not. */
static void test_workers_are_bound_while_there_are_cpus(void **state)
{
	(void)state;
	cpu_set_t all, after;
	assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
	uint32_t cpus = (uint32_t)CPU_COUNT(&all);
	for (uint32_t workers = 1; cpus > 1 && workers <= MOST_WORKERS; workers++)
		for (int tries = 0;; tries++) {
			masks m;
			int before = sched_getcpu();
			stilb_job_pool *pool = pool_with_masks(&m, workers, STILB_JOB_AFFINITY_AUTO);
			bool stayed = sched_getcpu() == before;
			stilb_job_pool_destroy(pool);
			sched_getaffinity(0, sizeof after, &after);
			assert_true(CPU_EQUAL(&all, &after));
			if (stayed)
				check_bound(&m, workers < cpus ? workers : cpus - 1, &all, before);
			for (uint32_t i = cpus; i <= workers; i++)
				assert_true(CPU_EQUAL(&m.worker[i], &all));
			if (stayed)
				break;
			assert_in_range(tries, 0, 1000); /* the kernel moved the owner in between: try again */
		}
}

static void check_unbound(uint32_t workers, stilb_job_affinity affinity)
{
	masks m;
	cpu_set_t all, after;
	sched_getaffinity(0, sizeof all, &all);
	stilb_job_pool_destroy(pool_with_masks(&m, workers, affinity));
	for (uint32_t i = 1; i <= workers; i++)
		assert_true(CPU_EQUAL(&m.worker[i], &all));
	sched_getaffinity(0, sizeof after, &after);
	assert_true(CPU_EQUAL(&all, &after));
}

static void test_else_nobody_is_bound(void **state)
{
	(void)state;
	cpu_set_t all, one;
	sched_getaffinity(0, sizeof all, &all);
	check_unbound(1, STILB_JOB_AFFINITY_NONE);
	CPU_ZERO(&one);
	CPU_SET((size_t)sched_getcpu(), &one);
	assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0); /* with one CPU no worker is bound */
	check_unbound(1, STILB_JOB_AFFINITY_AUTO);
	sched_setaffinity(0, sizeof all, &all);
}

static void note_cpu(void *data, uint32_t worker)
{
	masks *m = data;
	(void)worker;
	m->cpu = (uint32_t)sched_getcpu();
	count_up(&m->ran);
}

/* The owner may move to a worker's CPU. A worker that it wakes there must move to another CPU; otherwise it could run
 * only when the owner stops. */
static void test_worker_makes_room_for_the_owner(void **state)
{
	(void)state;
	cpu_set_t all;
	sched_getaffinity(0, sizeof all, &all);
	if (CPU_COUNT(&all) < 2)
		return; /* then no worker is bound */
	sleep_log log = {0};
	stilb_job_pool_desc desc = {.worker_count = 1, .hooks = sleep_log_hooks(&log)};
	stilb_job_pool *pool = NULL;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	masks m = {0};
	for (uint32_t i = 1; i <= 20; i++) {
		assert_true(await(&log.asleep, 1));
		submit_pinned(pool, note_cpu, &m, NULL, 1, 0);
		assert_true(await(&m.ran, 2 * i - 1));
		cpu_set_t there;
		CPU_ZERO(&there);
		CPU_SET(m.cpu, &there);
		assert_true(await(&log.asleep, 1));
		assert_int_equal(sched_setaffinity(0, sizeof there, &there), 0);
		uint32_t before = m.cpu;
		assert_int_equal(stilb_job_submit(pool, note_cpu, &m, NULL, 0), 0);
		assert_true(await(&m.ran, 2 * i));
		sched_setaffinity(0, sizeof all, &all);
		assert_int_not_equal(m.cpu, before);
	}
	stilb_job_pool_destroy(pool);
}

static void note_worker(void *data, uint32_t worker)
{
	masks *m = data;
	m->last = worker;
	count_up(&m->ran);
}

/* A thread that is bound to another CPU than the waker's starts at once. */
static void test_bound_workers_are_woken_first(void **state)
{
	(void)state;
	cpu_set_t all;
	sched_getaffinity(0, sizeof all, &all);
	uint32_t cpus = (uint32_t)CPU_COUNT(&all);
	if (cpus < 2 || cpus > MOST_WORKERS)
		return;
	sleep_log log = {0};
	stilb_job_pool *pool = pool_with_hooks((shape){.workers = MOST_WORKERS}, sleep_log_hooks(&log));
	masks m = {0};
	for (uint32_t i = 1; i <= 50; i++) {
		assert_true(await(&log.asleep, MOST_WORKERS));
		assert_int_equal(stilb_job_submit(pool, note_worker, &m, NULL, 0), 0);
		assert_true(await(&m.ran, i));
		assert_in_range(m.last, 1, cpus - 1);
	}
	stilb_job_pool_destroy(pool);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_workers_are_bound_while_there_are_cpus),
		cmocka_unit_test(test_else_nobody_is_bound),
		cmocka_unit_test(test_worker_makes_room_for_the_owner),
		cmocka_unit_test(test_bound_workers_are_woken_first),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
