/*
 * All interleavings of calls that wait on a queue (job_event.h), on the real low-lock queue and the real queue of one
 * producer and one consumer. job_model.h tells what that covers. A wake-up that is lost ends in a state in which no
 * thread can run.
 *
 * The low-lock queue has a lock of one step here, and its other operations are checked in test_job_model_low_lock.
 *
 * CMakeLists.txt in this folder also builds this file around copies of the sources with one planted fault each. Those
 * are run with the arguments of model_arguments: some scenario must find the fault.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "job_model_sys.h"

#include "jobs/job_lock.h"

static void model_lock_take(job_lock *lock)
{
	model_block_until((const uint32_t *)&lock->held, 0); /* one step, which can be made when the lock is free */
	lock->held = 1;
}

static void model_lock_give(job_lock *lock)
{
	atomic_store_explicit(&lock->held, 0, memory_order_release);
}

#define job_lock_take model_lock_take
#define job_lock_give model_lock_give
#define job_lock_take_now(lock) (model_lock_take(lock), true)
#define job_lock_release(lock) (model_lock_give(lock), false)
#define JOB_SEGMENT_CELLS 2
#define JOB_SEGMENT_ALIGN 8
#define JOB_SPSC_BLOCK_CELLS 2
#include "jobs/queue/job_event.c"
#include "jobs/queue/job_queue.c"
#include "jobs/queue/job_queue_low_lock.c"
#include "jobs/queue/job_spsc.c"
#include "support/test.h"
#undef job_lock_take
#undef job_lock_give
#undef job_lock_take_now
#undef job_lock_release

#undef free
#undef malloc

/* Not reached: all queues here are low-lock. */
int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	(void)desc, (void)queue;
	return -ENOMEM;
}

static struct shared {
	stilb_job_queue *queue;
	stilb_job_spsc *spsc;
	uint32_t pushers_left;
	uint32_t pushed, popped; /* items of calls that have succeeded */
	uint32_t ended;          /* pushes refused because the queue was closed */
} shared;

/* Parameters of a scenario, constant while the checker runs it: so it need not save and restore them. */
static struct {
	uint32_t pushers, poppers, each;
	uint32_t takes; /* the items that a popper takes before it leaves; 0: as many as there are before the end */
	size_t capacity;
	bool batch; /* a pusher pushes its items in one call */
	bool close; /* the last pusher closes the queue; with capacity, another thread does so at any time */
} with;
static model_arguments arguments;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

/* ---- threads -------------------------------------------------------------------------------------------------- */

static int item;

static void *push_all(void *data)
{
	uint32_t thread = (uint32_t)(uintptr_t)data;
	void *const items[] = {&item, &item, &item};
	if (with.batch)
		fail_unless(stilb_job_queue_push_n(shared.queue, items, with.each, thread) == (int)with.each, "push_n");
	for (uint32_t i = 0; i < with.each && !with.batch; i++) {
		int error = stilb_job_queue_push_wait(shared.queue, &item, thread, UINT64_MAX);
		fail_unless(error == 0 || (error == -EPIPE && with.close), "push");
		shared.ended += error != 0;
	}
	shared.pushed += with.each;
	if (--shared.pushers_left == 0 && with.close && with.capacity == SIZE_MAX)
		stilb_job_queue_close(shared.queue);
	return NULL;
}

static void *pop_all(void *data)
{
	uint32_t thread = (uint32_t)(uintptr_t)data;
	int error = 0;
	for (uint32_t i = 0; error == 0 && (with.takes == 0 || i < with.takes); i++) {
		void *taken = NULL;
		error = stilb_job_queue_pop_wait(shared.queue, &taken, thread, UINT64_MAX);
		fail_unless(error == 0 ? taken == &item : error == -EPIPE && with.close, "pop");
		shared.popped += error == 0;
	}
	return NULL;
}

static void queue_main(void)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.capacity = with.capacity;
	fail_unless(stilb_job_queue_create(&desc, &shared.queue) == 0, "create");
	shared.pushers_left = with.pushers;
	uintptr_t thread = 0;
	for (uint32_t i = 0; i < with.poppers; i++)
		model_spawn(pop_all, (void *)++thread);
	for (uint32_t i = 1; i < with.pushers; i++)
		model_spawn(push_all, (void *)++thread);
	push_all(NULL);
}

static void queue_check(void)
{
	fail_unless(shared.popped + shared.ended == with.pushers * with.each, "an item lost");
	stilb_job_queue_destroy(shared.queue); /* asserts that nobody is counted as waiting */
	fail_unless(model_heap_blocks() == 0, "leaked segments");
}

/* Pushers wait for space that never comes, until the queue is closed. */
static void full_main(void)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.capacity = with.capacity;
	fail_unless(stilb_job_queue_create(&desc, &shared.queue) == 0, "create");
	for (uintptr_t i = 0; i < with.pushers; i++)
		model_spawn(push_all, (void *)i);
	stilb_job_queue_close(shared.queue);
}

static void full_check(void)
{
	fail_unless(shared.pushed - shared.ended <= with.capacity, "more items than the capacity");
	stilb_job_queue_destroy(shared.queue);
}

static void *spsc_pop_all(void *data)
{
	(void)data;
	void *taken;
	while (stilb_job_spsc_pop_wait(shared.spsc, &taken, UINT64_MAX) == 0)
		shared.popped++;
	return NULL;
}

static void spsc_main(void)
{
	fail_unless(stilb_job_spsc_create(&shared.spsc) == 0, "create");
	model_spawn(spsc_pop_all, NULL);
	for (uint32_t i = 0; i < with.each; i++)
		fail_unless(stilb_job_spsc_push(shared.spsc, &item) == 0, "push");
	stilb_job_spsc_close(shared.spsc);
}

static void spsc_check(void)
{
	fail_unless(shared.popped == with.each, "an item lost");
}

/* ---- tests ---------------------------------------------------------------------------------------------------- */

static bool failed; /* a scenario has failed */

static void run(const char *name, void (*entry)(void), void (*check)(void))
{
	if ((failed && arguments.must_fail) || !model_chosen(&arguments, name))
		return;
	model_scenario scenario = {.memory = arguments.memory,
	                           .main = entry,
	                           .check = check,
	                           .data = &shared,
	                           .data_size = sizeof shared,
	                           .max_states = 2000000};
	model_result result = model_run(&scenario, !arguments.must_fail);
	print_message("%-34s %8u states %8u steps, path %u: %s\n", name, result.states, result.steps, result.depth,
	              result.failure ? result.failure : "ends well");
	failed = failed || result.failure;
}

static void run_queue(const char *name, uint32_t pushers, uint32_t poppers, uint32_t each, uint32_t takes,
                      size_t capacity)
{
	with.pushers = pushers;
	with.poppers = poppers;
	with.each = each;
	with.takes = takes;
	with.capacity = capacity;
	with.close = takes == 0;
	run(name,
	    pushers == 0                    ? spsc_main
	    : capacity == 1 && poppers == 0 ? full_main
	                                    : queue_main,
	    pushers == 0                    ? spsc_check
	    : capacity == 1 && poppers == 0 ? full_check
	                                    : queue_check);
}

static void run_all(void)
{
	model_spin_ticks = 0; /* time stands still: a waiter does not try for a while first */
	run_queue("one producer, one consumer", 0, 1, 3, 0, SIZE_MAX);
	run_queue("a pop waits for the end", 1, 1, 1, 0, SIZE_MAX);
	run_queue("two pops wait for an item each", 1, 2, 2, 1, SIZE_MAX);
	run_queue("two pops wait for the end", 1, 2, 1, 0, SIZE_MAX);
	with.batch = true;
	run_queue("two pops wait for a batch", 1, 2, 2, 1, SIZE_MAX);
	with.batch = false;
	run_queue("a push waits for space", 1, 1, 3, 3, 1);
	run_queue("two pushes wait for space", 2, 1, 1, 2, 1);
	run_queue("two pushes wait, closed", 2, 0, 1, 0, 1);
}

static void test_every_interleaving(void **state)
{
	(void)state;
	failed = false;
	run_all();
	assert_int_equal(failed, arguments.must_fail);
}

int main(int argc, char **argv)
{
	if (!model_available())
		return 77;
	arguments = model_arguments_of(argc, argv);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_every_interleaving),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
