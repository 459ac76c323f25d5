/* Jobs submitted in batches (stilb_job_submit_n), with 0, 1, 2 and 8 workers and both kinds of shared queues. Without
 * memory: test_job_failures. */
#include "job_pool_fixture.h"

typedef struct batch {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter wrong;
	uint32_t count;
	uint32_t cell[5000];
} batch;

static void mark_cell(void *data, uint32_t worker)
{
	uint32_t *cell = data;
	(void)worker;
	(*cell)++;
}

static void submit_batch(void *data, uint32_t worker)
{
	batch *b = data;
	if (stilb_job_submit_n(b->pool, mark_cell, b->cell, sizeof *b->cell, b->count, &b->group, worker) != 0)
		count_up(&b->wrong);
}

static void *submit_batch_outside(void *data)
{
	submit_batch(data, STILB_JOB_OUTSIDE);
	return NULL;
}

/* Batches that fit a deque's buffer, fill it or need a larger one; from the owner, a thread outside, and a job. */
static void test_batches(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 2, 255, 256, 257, 5000, 3};
	static batch b;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		b = (batch){.pool = pool_with(s)};
		uint32_t times[5000] = {0};
		for (uint32_t i = 0; i < 3 * sizeof counts / sizeof *counts; i++) {
			b.count = counts[i / 3];
			if (i % 3 == 0)
				submit_batch(&b, 0);
			else if (i % 3 == 1)
				outside_run(submit_batch_outside, &b);
			else
				assert_int_equal(stilb_job_submit(b.pool, submit_batch, &b, &b.group, 0), 0);
			stilb_job_wait(b.pool, &b.group, 0);
			for (uint32_t cell = 0; cell < 5000; cell++)
				assert_int_equal(b.cell[cell], times[cell] += cell < b.count);
		}
		assert_int_equal(b.wrong, 0);
		stilb_job_pool_destroy(b.pool);
	}
}

/* ---- batches whose jobs lie several in a record ---------------------------------------------------------------- */

enum { SOME = 1000 }; /* more than one job in a record, with any number of workers */

typedef struct company {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter started, ran, wrong;
	counter submits, begins, tags[SOME];
	bool in_tagged[MOST_THREADS];
} company;

static void wait_for_others(void *data, uint32_t worker)
{
	company *c = data;
	(void)worker;
	if (count_up(&c->started) == 0 && !await(&c->ran, SOME - 1))
		count_up(&c->wrong);
	count_up(&c->ran);
}

/* While the job that started first runs, all others do: none of them hides behind it. */
static void test_a_running_job_keeps_no_other_back(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		/* The owner does not run what an outside thread has submitted. */
		for (uint32_t outside = 0; outside < 2 && s.workers > outside; outside++) {
			company c = {.pool = pool_with(s)};
			uint32_t worker = outside ? STILB_JOB_OUTSIDE : 0;
			assert_int_equal(stilb_job_submit_n(c.pool, wait_for_others, &c, 0, SOME, &c.group, worker), 0);
			stilb_job_wait(c.pool, &c.group, 0);
			assert_int_equal(c.ran, SOME);
			assert_int_equal(c.wrong, 0);
			stilb_job_pool_destroy(c.pool);
		}
	}
}

static uint64_t hook_submit(void *user, uint32_t worker)
{
	company *c = user;
	(void)worker;
	return count_up(&c->submits);
}

static void hook_begin(void *user, uint32_t worker, uint64_t tag)
{
	company *c = user;
	count_up(&c->begins);
	if (tag >= SOME || c->in_tagged[worker])
		count_up(&c->wrong);
	else
		count_up(&c->tags[tag]);
	c->in_tagged[worker] = true;
}

static void hook_end(void *user, uint32_t worker)
{
	company *c = user;
	c->in_tagged[worker] = false;
}

static void count_company(void *data, uint32_t worker)
{
	company *c = *(company **)data;
	if (!c->in_tagged[worker])
		count_up(&c->wrong);
	count_up(&c->ran);
}

/* Each job has a tag of its own, or 0 without a hook that makes tags; also jobs that are submitted one by one after a
 * batch. */
static void test_hooks_are_told_of_each_job(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (uint32_t tagged = 0; tagged < 2; tagged++) {
			static company c, *of[SOME / 4];
			c = (company){0};
			for (uint32_t i = 0; i < SOME / 4; i++)
				of[i] = &c;
			stilb_job_hooks hooks = {.user = &c, .job_begin = hook_begin, .job_end = hook_end};
			hooks.submit = tagged ? hook_submit : NULL;
			c.pool = pool_with_hooks(s, hooks);
			for (uint32_t i = 0; i < 2; i++) {
				assert_int_equal(stilb_job_submit_n(c.pool, count_company, of, sizeof *of, SOME / 4, &c.group, 0), 0);
				stilb_job_wait(c.pool, &c.group, 0);
			}
			for (uint32_t i = 0; i < SOME / 2; i++)
				assert_int_equal(stilb_job_submit(c.pool, count_company, of, &c.group, 0), 0);
			stilb_job_wait(c.pool, &c.group, 0);
			assert_int_equal(c.ran, SOME);
			assert_int_equal(c.begins, SOME);
			assert_int_equal(c.submits, tagged ? SOME : 0);
			for (uint32_t i = 0; i < SOME; i++)
				assert_int_equal(c.tags[i], tagged ? 1 : i == 0 ? SOME : 0);
			assert_int_equal(c.wrong, 0);
			stilb_job_pool_destroy(c.pool);
		}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_batches),
		cmocka_unit_test(test_a_running_job_keeps_no_other_back),
		cmocka_unit_test(test_hooks_are_told_of_each_job),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
