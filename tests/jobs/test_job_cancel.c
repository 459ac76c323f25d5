/* Cancelling a group: its jobs are dropped and handed back, all others run. Cancelling a pool. And parallel loops of
 * threads outside the pool, which are never dropped. With 0, 1, 2 and 8 workers and both kinds of shared queues. */
#include "job_pool_fixture.h"

enum { EACH = 100 };

typedef struct cancelling {
	stilb_job_pool *pool;
	stilb_job_group group, other, gate, then;
	counter ran, dropped, others, end, slices;
} cancelling;

static void count_ran(void *data, uint32_t worker)
{
	cancelling *c = data;
	(void)worker;
	count_up(&c->ran);
}

static void count_dropped(void *data, uint32_t worker)
{
	cancelling *c = data;
	(void)worker;
	count_up(&c->dropped);
}

static void count_other(void *data, uint32_t worker)
{
	cancelling *c = data;
	(void)worker;
	count_up(&c->others);
}

static void ran_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end;
	count_ran(context, worker);
}

/* Submits 5 * EACH + 1 jobs to the group that is cancelled, in all ways, and EACH to each of two others. */
static void submit_all(cancelling *c, uint32_t threads)
{
	stilb_job_options after = {.after = &c->group}, after_gate = {.after = &c->gate};
	for (uint32_t i = 0; i < EACH; i++) {
		assert_int_equal(stilb_job_submit(c->pool, count_ran, c, &c->group, 0), 0);
		assert_int_equal(stilb_job_submit_with(c->pool, count_ran, c, &c->group, &after_gate, 0), 0);
		submit_priority(c->pool, count_ran, c, &c->group, i % 2 ? STILB_JOB_HIGH : STILB_JOB_LOW, 0);
		submit_pinned(c->pool, count_ran, c, &c->group, i % threads, 0);
		assert_int_equal(stilb_job_submit(c->pool, count_other, c, &c->other, 0), 0);
		assert_int_equal(stilb_job_submit_with(c->pool, count_other, c, &c->then, &after, 0), 0);
	}
	assert_int_equal(stilb_job_submit_n(c->pool, count_ran, c, 0, EACH, &c->group, 0), 0);
	assert_int_equal(stilb_job_submit_array(c->pool, 100, 1, ran_slice, c, &c->group, 0), 0);
}

static void check_dropped(cancelling *c)
{
	stilb_job_wait(c->pool, &c->group, 0);
	assert_false(stilb_job_group_is_cancelled(&c->group));
	stilb_job_wait(c->pool, &c->other, 0);
	stilb_job_wait(c->pool, &c->then, 0);
	assert_int_equal(c->ran, 0);
	assert_int_equal(c->dropped, 5 * EACH + 1);
	assert_int_equal(c->others, 2 * EACH);
}

static void test_jobs_of_a_cancelled_group_are_handed_back(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		blocker b = {0};
		cancelling c = {.pool = pool_with(s), .group.dropped = count_dropped};
		for (int round = 0; round < 3; round++) { /* a group is used again after it was cancelled */
			c.dropped = c.others = b.go = 0;
			hold_workers(c.pool, &b, &c.gate, 1, s.workers);
			submit_pinned(c.pool, count_other, &c, &c.gate, 0, 0);
			submit_all(&c, s.workers + 1);
			stilb_job_group_cancel(c.pool, &c.group);
			stilb_job_group_cancel(c.pool, &c.group); /* twice is as good as once */
			assert_true(stilb_job_group_is_cancelled(&c.group));
			blocker_release(&b);
			stilb_job_wait(c.pool, &c.gate, 0);
			c.others--; /* the job of the gate */
			check_dropped(&c);
		}
		stilb_job_group_cancel(c.pool, &c.group); /* without unfinished jobs it does nothing */
		assert_false(stilb_job_group_is_cancelled(&c.group));
		assert_int_equal(stilb_job_submit(c.pool, count_ran, &c, &c.group, 0), 0);
		stilb_job_wait(c.pool, &c.group, 0);
		assert_int_equal(c.ran, 1);
		stilb_job_pool_destroy(c.pool);
	}
}

/* The third job to run cancels its own group, and submits into it. */
static void cancel_own(void *data, uint32_t worker)
{
	cancelling *c = data;
	if (count_up(&c->ran) != 2)
		return;
	stilb_job_group_cancel(c->pool, &c->group);
	for (int i = 0; i < EACH; i++)
		if (stilb_job_submit(c->pool, count_other, c, &c->group, worker) != 0)
			count_up(&c->others);
}

static void test_a_job_cancels_its_own_group(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		cancelling c = {.pool = pool_with(s), .group.dropped = count_dropped};
		for (int i = 0; i < EACH; i++)
			assert_int_equal(stilb_job_submit(c.pool, cancel_own, &c, &c.group, 0), 0);
		stilb_job_wait(c.pool, &c.group, 0);
		assert_int_equal(c.ran + c.dropped, 2 * EACH);
		assert_int_equal(c.others, 0);
		assert_true(c.dropped >= EACH);
		stilb_job_pool_destroy(c.pool);
	}
}

static void *cancel_often(void *data)
{
	cancelling *c = data;
	while (count_of(&c->end) == 0) {
		stilb_job_group_cancel(c->pool, &c->group);
		nap_us(20);
	}
	return NULL;
}

/* An outside thread cancels a group over and over while it is used: each job either runs or is dropped. */
static void test_cancels_at_any_time(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		cancelling c = {.pool = pool_with(s), .group.dropped = count_dropped};
		pthread_t thread = outside_start(cancel_often, &c);
		for (int round = 0; round < 200; round++) {
			for (int i = 0; i < EACH; i++)
				assert_int_equal(stilb_job_submit(c.pool, count_ran, &c, &c.group, 0), 0);
			stilb_job_wait(c.pool, &c.group, 0);
			assert_int_equal(c.ran + c.dropped, (round + 1) * EACH);
		}
		count_up(&c.end);
		pthread_join(thread, NULL);
		stilb_job_pool_destroy(c.pool);
	}
}

static void test_a_cancelled_pool_hands_back_jobs_in_groups(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		blocker b = {0};
		cancelling c = {.pool = pool_with(s), .group.dropped = count_dropped};
		hold_workers(c.pool, &b, NULL, 1, s.workers);
		for (int i = 0; i < EACH; i++) {
			assert_int_equal(stilb_job_submit(c.pool, count_ran, &c, &c.group, 0), 0);
			assert_int_equal(stilb_job_submit(c.pool, count_ran, &c, NULL, 0), 0);
		}
		stilb_job_pool_cancel(c.pool);
		blocker_release(&b);
		stilb_job_wait(c.pool, &c.group, 0);
		stilb_job_pool_destroy(c.pool);
		assert_int_equal(c.ran, 0);
		assert_int_equal(c.dropped, EACH);
	}
}

/* ---- a cancelled pool ------------------------------------------------------------------------------------------ */

static void count_slices(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	cancelling *c = context;
	(void)worker;
	if (begin == 0)
		stilb_job_pool_cancel(c->pool);
	atomic_fetch_add_explicit(&c->slices, end - begin, memory_order_relaxed);
}

static void submit_to_cancel(cancelling *c, uint32_t threads)
{
	stilb_job_options after = {.after = &c->gate};
	for (uint32_t i = 0; i < 100; i++) {
		assert_int_equal(stilb_job_submit(c->pool, count_ran, c, &c->group, 0), 0);
		assert_int_equal(stilb_job_submit_with(c->pool, count_ran, c, &c->then, &after, 0), 0);
		submit_priority(c->pool, count_ran, c, &c->group, i % 2 ? STILB_JOB_HIGH : STILB_JOB_LOW, 0);
		submit_pinned(c->pool, count_ran, c, &c->group, i % threads, 0);
	}
	assert_int_equal(stilb_job_submit_array(c->pool, 100, 1, ran_slice, c, &c->group, 0), 0);
}

static void test_cancelled_jobs_do_not_run(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		blocker b = {0};
		cancelling c = {.pool = pool_with(s)};
		hold_workers(c.pool, &b, &c.gate, 1, s.workers);
		submit_pinned(c.pool, count_ran, &c, &c.gate, 0, 0);
		submit_to_cancel(&c, s.workers + 1);
		stilb_job_pool_cancel(c.pool);
		blocker_release(&b);
		stilb_job_wait(c.pool, &c.group, 0);
		stilb_job_wait(c.pool, &c.then, 0);
		stilb_job_wait(c.pool, &c.gate, 0);
		submit_to_cancel(&c, s.workers + 1); /* jobs submitted after the cancel must not run either */
		stilb_job_wait(c.pool, &c.group, 0);
		stilb_job_pool_destroy(c.pool);
		assert_int_equal(c.ran, 0);
	}
}

static void test_loop_that_has_begun_ends(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		cancelling c = {.pool = pool_with(s)};
		assert_int_equal(stilb_job_submit_array(c.pool, 1000, 1, count_slices, &c, &c.group, 0), 0);
		stilb_job_wait(c.pool, &c.group, 0);
		assert_int_equal(c.slices, 1000);
		stilb_job_pool_destroy(c.pool);
	}
}

static void sleep_long(void *data, uint32_t worker)
{
	count_ran(data, worker);
	nap_us(1000);
}

static void test_cancelled_pool_is_gone_soon(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		cancelling c = {.pool = pool_with(s)};
		for (uint32_t i = 0; i < 20000; i++)
			assert_int_equal(stilb_job_submit(c.pool, sleep_long, &c, &c.group, 0), 0);
		stilb_job_pool_cancel(c.pool);
		stilb_job_pool_destroy(c.pool); /* without the jobs that had not begun */
		assert_int_equal(c.group.state, 0);
		assert_true(c.ran < 20000);
	}
}

/* ---- loops of outside threads ---------------------------------------------------------------------------------- */

enum { GUESTS = 3, LOOPS = 50, INDICES = 1000 };

typedef struct visit {
	stilb_job_pool *pool;
	uint32_t workers;
	counter *ended, wrong;
	uint32_t cell[INDICES];
} visit;

static void add_one(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	visit *v = context;
	if (worker > v->workers)
		count_up(&v->wrong);
	for (uint32_t i = begin; i < end; i++)
		v->cell[i]++;
}

static void *run_loops(void *data)
{
	visit *v = data;
	for (uint32_t i = 0; i < LOOPS; i++) {
		stilb_job_parallel_for(v->pool, INDICES, i % 2 ? 7 : 0, add_one, v, STILB_JOB_OUTSIDE);
		for (uint32_t j = 0; j < INDICES; j++)
			if (v->cell[j] != i + 1)
				count_up(&v->wrong);
	}
	count_up(v->ended);
	return NULL;
}

static void do_nothing(void *data, uint32_t worker)
{
	(void)data, (void)worker;
}

static void run_visits(shape s, bool cancelled)
{
	static visit v[GUESTS];
	counter ended = 0;
	pthread_t thread[GUESTS];
	stilb_job_pool *pool = pool_with(s);
	if (cancelled)
		stilb_job_pool_cancel(pool);
	for (uint32_t i = 0; i < GUESTS; i++) {
		v[i] = (visit){.pool = pool, .workers = s.workers, .ended = &ended};
		thread[i] = outside_start(run_loops, &v[i]);
	}
	/* Without workers, the owner runs jobs of outside threads while it waits for another such job. */
	while (count_of(&ended) < GUESTS) {
		stilb_job_group group = {0};
		assert_int_equal(stilb_job_submit(pool, do_nothing, NULL, &group, STILB_JOB_OUTSIDE), 0);
		stilb_job_wait(pool, &group, 0);
	}
	for (uint32_t i = 0; i < GUESTS; i++) {
		pthread_join(thread[i], NULL);
		assert_int_equal(v[i].wrong, 0);
	}
	stilb_job_pool_destroy(pool);
}

static void test_loops_of_outside_threads(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		run_visits(s, false);
		run_visits(s, true); /* no loop is dropped */
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_jobs_of_a_cancelled_group_are_handed_back),
		cmocka_unit_test(test_a_job_cancels_its_own_group),
		cmocka_unit_test(test_cancels_at_any_time),
		cmocka_unit_test(test_cancelled_jobs_do_not_run),
		cmocka_unit_test(test_loop_that_has_begun_ends),
		cmocka_unit_test(test_cancelled_pool_is_gone_soon),
		cmocka_unit_test(test_a_cancelled_pool_hands_back_jobs_in_groups),
		cmocka_unit_test(test_loops_of_outside_threads),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
