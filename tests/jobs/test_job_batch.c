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

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_batches)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
