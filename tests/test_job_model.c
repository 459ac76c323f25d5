/*
 * Every interleaving of the real queue, parking and pool, for few threads and few jobs (see job_model.h for what that
 * covers and what not); and faults put in on purpose, to see that each is found.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "job_model_sys.h"

#define job_lock_take real_lock_take
#include "jobs/job_lock.h"
#undef job_lock_take
static void model_lock_take(job_lock *lock)
{
	if (model_fault_now != MODEL_FAULT_NO_LOCK)
		real_lock_take(lock);
}
#define job_lock_take model_lock_take

#include "jobs/job_queue.c"

static bool model_queue_empty(job_queue *queue)
{
	return model_fault_now == MODEL_FAULT_NO_RECHECK || job_queue_empty(queue);
}
#define job_queue_empty model_queue_empty
#include "jobs/job_park.c"

#include "jobs/job_wait.c"

static bool model_announce(stilb_job_group *group, uint32_t worker)
{
	return model_fault_now == MODEL_FAULT_NO_ANNOUNCE || job_group_announce(group, worker);
}
#define job_group_announce model_announce
#include "jobs/job_pool.c"

static void model_wait(stilb_job_pool *pool, stilb_job_group *group, uint32_t worker, bool jobs)
{
	if (model_fault_now != MODEL_FAULT_EARLY_RETURN)
		job_group_wait(pool, group, worker, jobs);
}
#define job_group_wait model_wait
#include "jobs/job_for.c"

#undef free
#undef malloc

uint32_t stilb_job_cpu_count(void)
{
	return 2;
}

static struct shared {
	job_queue queue;
	stilb_job_pool *pool;
	uint32_t producers, consumers, each;
	uint32_t popped;
	uint32_t seen[8];
	uint32_t last[2][2]; /* per consumer and producer: the newest item seen, plus one */
	uint32_t ran;
	uint32_t slice_runs[4];
	stilb_job_group group;
} shared;

/* Parameters of a run, and how often workers had a part in it over all interleavings; not part of the state. */
static struct {
	uint32_t producers, consumers, each, workers, jobs;
} with;
static uint64_t worker_runs, owner_runs;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

/* ---- the queue ------------------------------------------------------------------------------------------------ */

static void *produce(void *data)
{
	uintptr_t producer = (uintptr_t)data;
	for (uintptr_t i = 0; i < with.each; ++i)
		job_queue_push(&shared.queue, &(job_item){.data = (void *)(producer * with.each + i)});
	return NULL;
}

static void *consume(void *data)
{
	uintptr_t consumer = (uintptr_t)data;
	while (shared.popped < with.producers * with.each) {
		job_item item;
		if (!job_queue_pop(&shared.queue, &item))
			continue;
		uintptr_t value = (uintptr_t)item.data;
		fail_unless(value < with.producers * with.each, "an item nobody pushed");
		uint32_t *last = &shared.last[consumer][value / with.each];
		fail_unless(*last < value % with.each + 1, "one producer's items out of order");
		*last = (uint32_t)(value % with.each) + 1;
		++shared.seen[value];
		++shared.popped;
	}
	return NULL;
}

static void queue_main(void)
{
	job_queue_init(&shared.queue);
	for (uintptr_t i = 1; i < with.producers; ++i)
		model_spawn(produce, (void *)i);
	for (uintptr_t i = 0; i < with.consumers; ++i)
		model_spawn(consume, (void *)i);
	produce(0);
}

static void queue_check(void)
{
	for (uint32_t i = 0; i < with.producers * with.each; ++i)
		fail_unless(shared.seen[i] == 1, "an item lost or seen twice");
	fail_unless(job_queue_empty(&shared.queue), "not empty at the end");
	fail_unless(model_heap_blocks() == 1, "leaked nodes");
}

/* ---- the pool ------------------------------------------------------------------------------------------------- */

static void count_run(void *data, uint32_t worker)
{
	(void)data;
	++*(worker ? &worker_runs : &owner_runs);
	++shared.ran; /* between two steps, so atomic here */
}

static void pool_begin(void)
{
	stilb_job_pool_desc desc = {.worker_count = with.workers};
	fail_unless(stilb_job_pool_create(&desc, &shared.pool) == 0, "create");
}

/* The owner does not help: the workers alone must get everything done, woken by the submits. Ends there. */
static void submit_main(void)
{
	pool_begin();
	for (uint32_t i = 0; i < with.jobs; ++i)
		stilb_job_submit(shared.pool, count_run, NULL, NULL);
	model_block_until(&shared.ran, with.jobs);
}

static void destroy_main(void)
{
	pool_begin();
	for (uint32_t i = 0; i < with.jobs; ++i)
		stilb_job_submit(shared.pool, count_run, NULL, NULL);
	stilb_job_pool_destroy(shared.pool);
}

static void submit_child(void *data, uint32_t worker)
{
	count_run(data, worker);
	stilb_job_submit(shared.pool, count_run, NULL, NULL);
}

/* The second job comes while the pool is going down. */
static void destroy_child_main(void)
{
	pool_begin();
	stilb_job_submit(shared.pool, submit_child, NULL, NULL);
	stilb_job_pool_destroy(shared.pool);
}

static void wait_main(void)
{
	pool_begin();
	for (uint32_t i = 0; i < with.jobs; ++i)
		stilb_job_submit(shared.pool, count_run, NULL, &shared.group);
	stilb_job_wait(shared.pool, &shared.group, 0);
	fail_unless(shared.ran == with.jobs, "wait returned too early");
	stilb_job_pool_destroy(shared.pool);
}

/* A job that submits another and waits for it, on a group on its own stack. */
static void submit_and_wait(void *data, uint32_t worker)
{
	(void)data;
	stilb_job_group inner = {0};
	stilb_job_submit(shared.pool, count_run, NULL, &inner);
	stilb_job_wait(shared.pool, &inner, worker);
	fail_unless(shared.ran >= 1, "inner wait returned too early");
	++shared.ran;
}

static void nested_main(void)
{
	pool_begin();
	stilb_job_submit(shared.pool, submit_and_wait, NULL, &shared.group);
	stilb_job_wait(shared.pool, &shared.group, 0);
	fail_unless(shared.ran == with.jobs, "wait returned too early");
	stilb_job_pool_destroy(shared.pool);
}

static void run_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)context;
	++*(worker ? &worker_runs : &owner_runs);
	for (uint32_t i = begin; i < end; ++i) {
		model_step(NULL, "slice", __LINE__); /* others may run in the middle of it */
		++shared.slice_runs[i];
	}
}

static void loop_main(void)
{
	pool_begin();
	stilb_job_parallel_for(shared.pool, with.jobs, 1, run_slice, NULL, 0);
	for (uint32_t i = 0; i < with.jobs; ++i)
		fail_unless(shared.slice_runs[i] == 1, "a slice lost, run twice or not finished");
	shared.ran = with.jobs;
	stilb_job_pool_destroy(shared.pool);
}

static void pool_check(void)
{
	fail_unless(shared.ran == with.jobs, "a job lost or run twice");
}

/* After destroy. */
static void destroyed_check(void)
{
	pool_check();
	fail_unless(model_heap_blocks() == 0, "leaked nodes");
}

/* ---- tests ---------------------------------------------------------------------------------------------------- */

static model_result run(void (*entry)(void), void (*check)(void), model_fault fault)
{
	model_scenario scenario = {.main = entry,
	                           .check = check,
	                           .data = &shared,
	                           .data_size = sizeof shared,
	                           .main_ends_all = check == pool_check,
	                           .max_states = 4000000};
	model_fault_now = fault;
	model_result result = model_run(&scenario, fault == MODEL_FAULT_NONE);
	model_fault_now = MODEL_FAULT_NONE;
	print_message("%8u states %8u steps, path %u: %s\n", result.states, result.steps, result.depth,
	              result.failure ? result.failure : "ends well");
	return result;
}

static void queue_run(uint32_t producers, uint32_t consumers, uint32_t each)
{
	with.producers = producers;
	with.consumers = consumers;
	with.each = each;
	assert_null(run(queue_main, queue_check, MODEL_FAULT_NONE).failure);
}

static void test_queue(void **state)
{
	(void)state;
	queue_run(1, 1, 3);
	queue_run(2, 1, 2);
	queue_run(1, 2, 3);
	queue_run(2, 2, 1);
}

/* Every interleaving of entry; where both can run things, both must have done so in some of them. */
static void pool_run(void (*entry)(void), uint32_t workers, uint32_t jobs)
{
	with.workers = workers;
	with.jobs = jobs;
	worker_runs = owner_runs = 0;
	print_message("%u workers, %u jobs: ", workers, jobs);
	assert_null(run(entry, entry == submit_main ? pool_check : destroyed_check, MODEL_FAULT_NONE).failure);
	assert_true(workers == 0 || worker_runs > 0);
	assert_true(entry == submit_main || owner_runs > 0);
}

static void test_submit_wakes(void **state)
{
	(void)state;
	pool_run(submit_main, 1, 1);
	pool_run(submit_main, 1, 2);
	pool_run(submit_main, 2, 1);
}

static void test_destroy_runs_all(void **state)
{
	(void)state;
	pool_run(destroy_main, 0, 2);
	pool_run(destroy_main, 1, 2);
	pool_run(destroy_child_main, 0, 2);
	pool_run(destroy_child_main, 1, 2);
}

static void test_wait(void **state)
{
	(void)state;
	pool_run(wait_main, 0, 2);
	pool_run(wait_main, 1, 1);
	pool_run(wait_main, 1, 2);
}

static void test_nested_wait(void **state)
{
	(void)state;
	pool_run(nested_main, 0, 2);
	pool_run(nested_main, 1, 2);
}

static void test_loop(void **state)
{
	(void)state;
	pool_run(loop_main, 0, 2);
	pool_run(loop_main, 1, 2);
	pool_run(loop_main, 1, 3);
}

static void must_fail(void (*entry)(void), void (*check)(void), model_fault fault)
{
	assert_non_null(run(entry, check, fault).failure);
}

static void test_faults_are_found(void **state)
{
	(void)state;
	with.workers = 1;
	with.jobs = 1;
	must_fail(submit_main, pool_check, MODEL_FAULT_NO_RECHECK);
	must_fail(submit_main, pool_check, MODEL_FAULT_NO_WAKE);
	must_fail(submit_main, pool_check, MODEL_FAULT_BLIND_SLEEP);
	must_fail(wait_main, destroyed_check, MODEL_FAULT_NO_ANNOUNCE);
	with.jobs = 2;
	must_fail(loop_main, destroyed_check, MODEL_FAULT_EARLY_RETURN);
	with.producers = with.consumers = 2;
	with.each = 1;
	must_fail(queue_main, queue_check, MODEL_FAULT_NO_LOCK);
}

int main(void)
{
	if (!model_available())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_queue),
		cmocka_unit_test(test_submit_wakes),
		cmocka_unit_test(test_destroy_runs_all),
		cmocka_unit_test(test_wait),
		cmocka_unit_test(test_nested_wait),
		cmocka_unit_test(test_loop),
		cmocka_unit_test(test_faults_are_found),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
