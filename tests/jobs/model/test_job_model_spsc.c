/*
 * All interleavings of the real queue for one producer and one consumer, with blocks of two cells, so that a few items
 * cross several block ends and reuse blocks. job_model.h tells what that covers.
 *
 * CMakeLists.txt in this folder also builds this file around copies of jobs/queue/job_spsc.c with one planted fault
 * each. Those are run with the arguments of model_arguments: some scenario must find the fault.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "job_model_sys.h"

#define JOB_SPSC_BLOCK_CELLS 2
#include "jobs/queue/job_event.c"
#define job_event_signal(event, count) ((void)(event), (void)(count)) /* test_job_model_wait checks calls that wait */
#include "jobs/queue/job_spsc.c"
#include "support/test.h"

#undef free
#undef malloc

static struct shared {
	stilb_job_spsc *queue;
	uintptr_t received, longest; /* items received so far; the most that were in the queue */
	uint32_t consumer_done;
} shared;

/* Parameters of a scenario, constant while the checker runs it: so it need not save and restore them with `shared`. */
static uintptr_t item_count;
static model_arguments arguments;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

static void *consume(void *data)
{
	(void)data;
	void *item;
	int error;
	while ((error = stilb_job_spsc_pop(shared.queue, &item)) != -EPIPE)
		if (error == 0)
			fail_unless((uintptr_t)item == ++shared.received, "an item lost, out of order or not there yet");
	fail_unless(shared.received == item_count, "closed before the last item came out");
	model_barrier(); /* as the end of a thread is */
	shared.consumer_done = 1;
	return NULL;
}

/* The first thread is the producer. */
static void produce(void)
{
	fail_unless(stilb_job_spsc_create(&shared.queue) == 0, "create");
	model_spawn(consume, NULL);
	for (uintptr_t i = 1; i <= item_count; i++) {
		fail_unless(stilb_job_spsc_push(shared.queue, (void *)i) == 0, "push");
		uintptr_t length = i - shared.received;
		shared.longest = length > shared.longest ? length : shared.longest;
	}
	stilb_job_spsc_close(shared.queue);
	fail_unless(stilb_job_spsc_push(shared.queue, (void *)1) == -EPIPE, "a push after close");
	model_block_until(&shared.consumer_done, 1);
	/* With store buffers the producer learns later that the consumer has left a block. */
	uintptr_t longest = arguments.memory == MODEL_SC ? shared.longest : item_count;
	fail_unless(model_heap_blocks() <= longest / JOB_SPSC_BLOCK_CELLS + 2, "more blocks than promised");
	stilb_job_spsc_destroy(shared.queue);
	fail_unless(model_heap_blocks() == 0, "leaked blocks");
}

static const char *failure_with(uintptr_t items)
{
	model_scenario scenario = {.memory = arguments.memory,
	                           .main = produce,
	                           .data = &shared,
	                           .data_size = sizeof shared,
	                           .max_states = 1000000};
	item_count = items;
	model_result result = model_run(&scenario, !arguments.must_fail);
	print_message("%u items: %7u states %7u steps, path %u: %s\n", (unsigned)items, result.states, result.steps,
	              result.depth, result.failure ? result.failure : "ends well");
	return result.failure;
}

static void test_spsc(void **state)
{
	(void)state;
	const char *failure = NULL;
	for (uintptr_t items = 0; items <= 9 && !failure; items++)
		failure = failure_with(items);
	if (arguments.must_fail)
		assert_non_null(failure);
	else
		assert_null(failure);
}

int main(int argc, char **argv)
{
	if (!model_available())
		return 77;
	arguments = model_arguments_of(argc, argv);
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_spsc)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
