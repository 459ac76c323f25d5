/* The statistics of a pool, in arrangements in which they are exact, and read while jobs run. */
#include "tests/jobs/job_pool_fixture.h"

enum { JOBS = 100, SLICES = 50 };

typedef struct tally {
	counter ran, stolen, parks, slices;
} tally;

static void count_job(void *data, uint32_t worker)
{
	tally *t = data;
	(void)worker;
	count_up(&t->ran);
}

static void count_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	tally *t = context;
	(void)worker;
	atomic_fetch_add_explicit(&t->slices, end - begin, memory_order_acq_rel);
}

static void on_steal(void *user, uint32_t worker, uint32_t victim)
{
	tally *t = user;
	(void)worker, (void)victim;
	count_up(&t->stolen);
}

static void on_park(void *user, uint32_t worker)
{
	tally *t = user;
	(void)worker;
	count_up(&t->parks);
}

static stilb_job_thread_stats stats_of(stilb_job_pool *pool, uint32_t worker)
{
	stilb_job_thread_stats stats;
	memset(&stats, 0xff, sizeof stats); /* every field is written */
	stilb_job_pool_get_thread_stats(pool, worker, &stats);
	return stats;
}

static stilb_job_pool_stats stats_of_all(stilb_job_pool *pool)
{
	stilb_job_pool_stats stats;
	memset(&stats, 0xff, sizeof stats);
	stilb_job_pool_get_stats(pool, &stats);
	return stats;
}

static void *submit_outside(void *pool)
{
	static tally ignored;
	for (int i = 0; i < JOBS; i++)
		if (stilb_job_submit(pool, count_job, &ignored, NULL, STILB_JOB_OUTSIDE) != 0)
			return pool;
	return NULL;
}

/* Without workers nothing happens by itself. */
static void test_entries_and_jobs_of_the_owner(void **state)
{
	(void)state;
	tally t = {0};
	stilb_job_pool *pool = pool_with((shape){.workers = 0});
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS; i++)
		assert_int_equal(stilb_job_submit(pool, count_job, &t, &group, 0), 0);
	for (int i = 0; i < 3; i++)
		submit_priority(pool, count_job, &t, &group, STILB_JOB_HIGH, 0);
	for (int i = 0; i < 7; i++)
		submit_priority(pool, count_job, &t, &group, STILB_JOB_LOW, 0);
	outside_run(submit_outside, pool);
	stilb_job_pool_stats all = stats_of_all(pool);
	assert_int_equal(all.all.deque, JOBS);
	assert_int_equal(all.high, 3);
	assert_int_equal(all.low, 7);
	assert_int_equal(all.shared, JOBS);
	assert_int_equal(all.all.submitted, 2 * JOBS + 10);
	assert_int_equal(all.all.jobs, 0);
	stilb_job_wait(pool, &group, 0);
	stilb_job_thread_stats owner = stats_of(pool, 0);
	assert_int_equal(owner.submitted, JOBS + 10);
	assert_int_equal(owner.deque, 0);
	assert_int_equal(owner.steals + owner.loops_helped + owner.parks + owner.wakes, 0);
	assert_int_equal(owner.slices, 0);
	all = stats_of_all(pool);
	assert_int_equal(all.all.jobs, JOBS + 10 + JOBS - all.shared); /* the wait may have run some from outside */
	assert_int_equal(all.high + all.low, 0);
	stilb_job_parallel_for(pool, SLICES, 1, count_slice, &t, 0);
	stilb_job_parallel_for(pool, 2 * SLICES, 2, count_slice, &t, 0);
	assert_int_equal(stats_of(pool, 0).slices, 2 * SLICES);
	stilb_job_pool_destroy(pool);
}

/* The only worker is held, so that the owner runs all jobs, and then runs all jobs while the owner watches. */
static void test_jobs_and_steals_of_a_worker(void **state)
{
	(void)state;
	tally t = {0};
	blocker b = {0};
	stilb_job_pool *pool = pool_with_hooks((shape){.workers = 1}, (stilb_job_hooks){.user = &t, .steal = on_steal});
	hold_workers(pool, &b, NULL, 1, 1);
	stilb_job_group group = {0};
	for (int i = 0; i < JOBS; i++)
		assert_int_equal(stilb_job_submit(pool, count_job, &t, &group, 0), 0);
	stilb_job_wait(pool, &group, 0);
	assert_int_equal(stats_of(pool, 0).jobs, JOBS);
	assert_int_equal(stats_of(pool, 1).jobs, 0);
	for (int i = 0; i < JOBS; i++)
		assert_int_equal(stilb_job_submit(pool, count_job, &t, NULL, 0), 0);
	assert_int_equal(stats_of(pool, 0).deque, JOBS);
	blocker_release(&b);
	assert_true(await(&t.ran, 2 * JOBS));
	stilb_job_thread_stats worker = stats_of(pool, 1);
	assert_int_equal(worker.steals, JOBS);
	assert_int_equal(worker.steals, count_of(&t.stolen));
	assert_in_range(worker.jobs, JOBS, JOBS + 1); /* the last one is counted when it has returned */
	assert_int_equal(stats_of(pool, 0).deque, 0);
	assert_int_equal(stats_of(pool, 0).steals, 0);
	stilb_job_pool_destroy(pool);
}

/* Parks are those that the hook sees; a wake-up for new work follows each but the last. */
static void test_parks_and_wakes(void **state)
{
	(void)state;
	tally t = {0};
	stilb_job_pool *pool = pool_with_hooks((shape){.workers = 1}, (stilb_job_hooks){.user = &t, .park = on_park});
	for (uint32_t i = 1; i <= 20; i++) {
		assert_true(await(&t.parks, i));
		assert_int_equal(stats_of(pool, 1).parks, i);
		assert_int_equal(stats_of(pool, 1).wakes, i - 1);
		submit_pinned(pool, count_job, &t, NULL, 1, 0);
		assert_true(await(&t.ran, i));
	}
	assert_true(stats_of(pool, 1).spin_ns > 20 * 10000); /* it looks for 30 us each time before it sleeps */
	stilb_job_pool_destroy(pool);
}

typedef struct held {
	stilb_job_pool *pool;
	blocker b;
} held;

static void *release_when_the_owner_sleeps(void *data)
{
	held *h = data;
	while (stats_of(h->pool, 0).parks == 0)
		nap_us(50);
	blocker_release(&h->b);
	return NULL;
}

/* The end of the group ends the wait; no work has come. */
static void test_a_wait_that_ends_is_no_wake(void **state)
{
	(void)state;
	held h = {.pool = pool_with((shape){.workers = 1})};
	stilb_job_group group = {0};
	hold_workers(h.pool, &h.b, &group, 1, 1);
	pthread_t thread = outside_start(release_when_the_owner_sleeps, &h);
	stilb_job_wait(h.pool, &group, 0);
	pthread_join(thread, NULL);
	assert_int_equal(stats_of(h.pool, 0).parks, 1);
	assert_int_equal(stats_of(h.pool, 0).wakes, 0);
	stilb_job_pool_destroy(h.pool);
}

/* Every slice is counted by the thread that runs it, and every help by the helper. */
static void test_slices_and_help(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		tally t = {0};
		stilb_job_pool *pool = pool_with(s);
		for (uint32_t i = 1; i <= 100; i++) {
			stilb_job_parallel_for(pool, SLICES, 1, count_slice, &t, 0);
			assert_int_equal(stats_of_all(pool).all.slices, i * SLICES);
		}
		assert_int_equal(stats_of(pool, 0).loops_helped, 0);
		stilb_job_thread_stats sum = {0};
		for (uint32_t i = 1; i <= s.workers; i++) {
			stilb_job_thread_stats one = stats_of(pool, i);
			assert_true(one.loops_helped <= one.slices);
			assert_true((one.loops_helped > 0) == (one.slices > 0));
			sum.slices += one.slices;
		}
		assert_int_equal(sum.slices + stats_of(pool, 0).slices, 100 * SLICES);
		stilb_job_pool_destroy(pool);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_entries_and_jobs_of_the_owner),
		cmocka_unit_test(test_jobs_and_steals_of_a_worker),
		cmocka_unit_test(test_parks_and_wakes),
		cmocka_unit_test(test_a_wait_that_ends_is_no_wake),
		cmocka_unit_test(test_slices_and_help),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
