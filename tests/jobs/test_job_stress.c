/*
 * Jobs, batches, waits and loops mixed at random, handing over plain data: a missing memory order is a data race for
 * the thread sanitizer, and a wrong sum without it. Also with more threads than CPUs.
 */
#include <stddef.h>
#include <stdint.h>

#include "jobs/job.h"
#include "support/test.h"

enum { ROUNDS = TEST_TSAN ? 800 : TEST_EMULATED ? 2000 : 6000, FAN = 3, CELLS = 48 };

/* A node of a random tree of work. All of its members are plain memory. */
typedef struct task {
	stilb_job_pool *pool;
	uint64_t random;
	uint32_t depth;
	uint64_t result;           /* read by the parent after its wait */
	uint64_t cells[CELLS];     /* written by slices, read after the loop */
	uint64_t by_worker[1 + 8]; /* each written by one thread only */
} task;

static uint64_t next_random(uint64_t *state)
{
	/* splitmix64. Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014. */
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
	z = (z ^ z >> 27) * 0x94d049bb133111ebu;
	return z ^ z >> 31;
}

static uint64_t leaf_value(uint64_t random)
{
	return next_random(&random) % 1000;
}

/* The result of a tree, computed by one thread. */
static uint64_t expected(uint64_t random, uint32_t depth)
{
	uint64_t sum = leaf_value(random), state = random;
	for (uint32_t i = 0; i < CELLS; i++)
		sum += leaf_value(random + i);
	for (int i = 0; i < FAN && depth > 0; i++)
		sum += expected(next_random(&state), depth - 1);
	return sum;
}

static void fill_cells(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	task *t = context;
	for (uint32_t i = begin; i < end; i++) {
		t->cells[i] = leaf_value(t->random + i);
		t->by_worker[worker]++;
	}
}

static void fill_cell(void *data, uint32_t worker)
{
	uint64_t *cell = data;
	(void)worker;
	*cell = leaf_value(*cell);
}

/* The same as a loop over fill_cells, as a batch of jobs. */
static void fill_in_batch(task *t, uint32_t worker)
{
	stilb_job_group cells = {0};
	for (uint32_t i = 0; i < CELLS; i++)
		t->cells[i] = t->random + i;
	if (stilb_job_submit_n(t->pool, fill_cell, t->cells, sizeof *t->cells, CELLS, &cells, worker) != 0)
		t->cells[0] = 0; /* makes the sum wrong */
	stilb_job_wait(t->pool, &cells, worker);
	t->by_worker[worker] = CELLS;
}

static void run(void *data, uint32_t worker)
{
	task *t = data;
	task children[FAN];
	stilb_job_group group = {0};
	uint64_t state = t->random, filled = 0;
	for (int i = 0; i < FAN && t->depth > 0; i++) {
		children[i] = (task){.pool = t->pool, .random = next_random(&state), .depth = t->depth - 1};
		if (stilb_job_submit(t->pool, run, &children[i], &group, worker) != 0)
			run(&children[i], worker);
	}
	if (t->random % 4 == 0)
		fill_in_batch(t, worker);
	else
		stilb_job_parallel_for(t->pool, CELLS, 1 + (uint32_t)(t->random % 9), fill_cells, t, worker);
	t->result = leaf_value(t->random);
	for (int i = 0; i < CELLS; i++)
		t->result += t->cells[i];
	for (int i = 0; i <= 8; i++)
		filled += t->by_worker[i];
	if (filled != CELLS)
		t->result = 0; /* makes the sum wrong */
	stilb_job_wait(t->pool, &group, worker);
	for (int i = 0; i < FAN && t->depth > 0; i++)
		t->result += children[i].result;
}

static void stress(uint32_t workers, uint32_t rounds)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool = NULL;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	for (uint32_t i = 0; i < rounds; i++) {
		task root = {.pool = pool, .random = i, .depth = i % 4};
		stilb_job_group group = {0};
		if (i % 2) {
			assert_int_equal(stilb_job_submit(pool, run, &root, &group, 0), 0);
			stilb_job_wait(pool, &group, 0);
		} else {
			run(&root, 0);
		}
		assert_int_equal(root.result, expected(i, i % 4));
	}
	stilb_job_pool_destroy(pool);
}

static void test_stress(void **state)
{
	(void)state;
	for (uint32_t workers = 0; workers <= 8; workers = workers ? workers * 2 : 1)
		stress(workers, ROUNDS);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_stress)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
