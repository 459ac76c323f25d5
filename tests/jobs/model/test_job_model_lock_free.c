/*
 * All interleavings of the real lock-free queue with segments of two cells, so that a few items cross several segment
 * ends and reuse segments; also with a thread that stops for ever at any step. job_model.h tells what that covers. The
 * same test is built around copies with one planted fault each (CMakeLists.txt in this folder) and run with the
 * arguments of model_arguments: some scenario must find the fault.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "job_model_sys.h"

#define JOB_SEGMENT_CELLS 2
#define JOB_SEGMENT_ALIGN 8
#define JOB_SPARE_SEGMENTS 1
#define JOB_BACKOFF_PAUSES 0
#include "jobs/queue/job_event.h"
#define job_event_signal(event, count) ((void)(event), (void)(count)) /* test_job_model_wait checks calls that wait */
#include "jobs/queue/job_queue_lock_free.c"
#include "support/test.h"

#undef free
#undef malloc

enum { THREADS = 4, PER_THREAD = 8, UNLIMITED = 0 };

/* Sets of items are bit masks: item i of thread t is bit t * PER_THREAD + i; the pointer pushed is this number plus
 * one. */
static struct shared {
	stilb_job_queue *queue;
	uint32_t began, pushed, popped;                   /* pushes begun; pushes and pops that have succeeded */
	uint32_t older[THREADS * PER_THREAD];             /* for each item, those pushed before its push began */
	bool in_push[THREADS], in_pop[THREADS];           /* the call that each thread is inside of */
	bool may_be_empty[THREADS], may_be_full[THREADS]; /* the queue was empty (full) at some moment of the call */
	uint32_t producers_left, ended;
	bool over; /* a pop has reported closed and empty, which must be final */
} shared;

/* Parameters of a scenario, constant while the checker runs it: so it need not save and restore them. */
static struct {
	uint32_t producers, consumers, each;
	uint32_t before; /* items pushed before the other threads exist, */
	uint32_t left;   /* and how many of them are left then */
	uint32_t rounds; /* of a thread that alternates push and pop, instead of producers and consumers */
	uint32_t guests; /* further threads that push or pop one item and rest, `visits` times */
	uint32_t visits;
	bool visit_pushes;
	uint32_t stops; /* one of the threads may stop for ever */
	size_t capacity;
	bool closer; /* another thread closes at any time; otherwise the last producer closes after its last item */
} with;
static model_arguments arguments;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

static int32_t count_but(const bool *of, uint32_t thread)
{
	int32_t count = 0;
	for (uint32_t i = 0; i < THREADS; i++)
		count += of[i] && i != thread;
	return count;
}

/* Called when a call begins or ends: notes for each call in progress whether the queue may be empty or full now. */
static void note_moment(void)
{
	int32_t surely = __builtin_popcount(shared.pushed & ~shared.popped);
	int32_t at_most = __builtin_popcount(shared.began & ~shared.popped);
	for (uint32_t i = 0; i < THREADS; i++) {
		if (shared.in_pop[i] && surely - count_but(shared.in_pop, i) <= 0)
			shared.may_be_empty[i] = true;
		/* at_most - 1: without the item that thread i itself is pushing */
		if (shared.in_push[i] && at_most - 1 >= (int32_t)with.capacity)
			shared.may_be_full[i] = true;
	}
	fail_unless(with.capacity == UNLIMITED || surely - count_but(shared.in_pop, THREADS) <= (int32_t)with.capacity,
	            "more items than the capacity");
}

static int push(uint32_t thread, uint32_t i)
{
	uint32_t item = thread * PER_THREAD + i;
	shared.older[item] = shared.pushed;
	shared.began |= 1u << item;
	shared.in_push[thread] = true;
	shared.may_be_full[thread] = false;
	note_moment();
	int result = shared.queue->ops->push(shared.queue, (void *)(uintptr_t)(item + 1), thread);
	note_moment();
	shared.in_push[thread] = false;
	if (result == 0)
		shared.pushed |= 1u << item;
	else
		shared.began &= ~(1u << item);
	fail_unless(result != -EAGAIN || shared.may_be_full[thread], "refused, though never full");
	shared.may_be_full[thread] = false;
	note_moment();
	return result;
}

/* Every item older than a popped one was popped too, or is held by a pop that has not returned. */
static void check_order(uint32_t thread, uint32_t item)
{
	int32_t missing = __builtin_popcount(shared.older[item] & ~shared.popped);
	fail_unless(missing <= count_but(shared.in_pop, thread), "an item overtook another");
}

static int pop(uint32_t thread)
{
	shared.in_pop[thread] = true;
	shared.may_be_empty[thread] = false;
	note_moment();
	bool over = shared.over;
	void *taken = NULL;
	int result = shared.queue->ops->pop(shared.queue, &taken, thread);
	note_moment();
	fail_unless(!over || result == -EPIPE, "something after the end");
	shared.over |= result == -EPIPE;
	shared.in_pop[thread] = false;
	if (result == 0) {
		uint32_t item = (uint32_t)(uintptr_t)taken - 1;
		fail_unless(item < THREADS * PER_THREAD && (shared.began >> item & 1), "an item nobody pushed");
		fail_unless(!(shared.popped >> item & 1), "an item seen twice");
		check_order(thread, item);
		shared.popped |= 1u << item;
		shared.older[item] = 0; /* not needed any more; states that differ only in it become one */
	} else {
		fail_unless(shared.may_be_empty[thread], "found nothing, though never empty");
	}
	shared.may_be_empty[thread] = false;
	note_moment();
	return result;
}

/* ---- threads -------------------------------------------------------------------------------------------------- */

static void produce_from(uint32_t thread, uint32_t first)
{
	for (uint32_t i = first; i < first + with.each;) {
		int result = push(thread, i);
		if (result == -EPIPE)
			break;
		fail_unless(result == 0 || with.capacity != UNLIMITED, "push");
		i += result == 0;
	}
	if (--shared.producers_left == 0 && !with.closer)
		shared.queue->ops->close(shared.queue);
	shared.ended++;
}

static void *produce(void *data)
{
	produce_from((uint32_t)(uintptr_t)data, 0);
	return NULL;
}

static void *consume(void *data)
{
	while (pop((uint32_t)(uintptr_t)data) != -EPIPE)
		;
	shared.ended++;
	return NULL;
}

static void *close_any_time(void *data)
{
	(void)data;
	shared.queue->ops->close(shared.queue);
	shared.ended++;
	return NULL;
}

static void *visit(void *data)
{
	uint32_t thread = (uint32_t)(uintptr_t)data;
	for (uint32_t i = 0; i < with.visits; i++) {
		if (with.visit_pushes)
			fail_unless(push(thread, i) == 0, "push");
		else
			pop(thread);
		shared.queue->ops->rest(shared.queue, thread);
	}
	shared.ended++;
	return NULL;
}

/* Pushes and pops through all segments while the other threads are at arbitrary steps. */
static void churn(void)
{
	for (uint32_t i = with.before; i < with.before + with.rounds; i++) {
		fail_unless(push(0, i) == 0, "push");
		pop(0);
	}
	shared.ended++;
}

static void queue_main(void)
{
	size_t capacity = with.capacity == UNLIMITED ? SIZE_MAX : with.capacity;
	stilb_job_queue_desc desc = {.capacity = capacity, .thread_count = THREADS};
	fail_unless(job_queue_lock_free_create(&desc, &shared.queue) == 0, "create");
	for (uint32_t i = 0; i < with.before; i++)
		fail_unless(push(0, i) == 0 && (i >= with.before - with.left || pop(0) == 0), "before");
	shared.producers_left = with.producers;
	for (uintptr_t i = 1; i <= with.guests; i++)
		model_spawn(visit, (void *)i);
	for (uintptr_t i = 1; i < with.producers + with.consumers; i++)
		model_spawn(i < with.producers ? produce : consume, (void *)i);
	if (with.closer)
		model_spawn(close_any_time, NULL);
	if (with.rounds > 0)
		churn();
	else
		produce_from(0, with.before);
}

static void queue_check(void)
{
	uint32_t threads = with.rounds > 0 ? 1 + with.guests : with.producers + with.consumers + with.closer;
	int32_t stopped = (int32_t)(threads - shared.ended);
	fail_unless(stopped <= (int32_t)with.stops, "a thread did not end");
	/* The item that a stopped thread was pushing may be in the queue; the one that it was popping is lost. */
	while (pop(0) == 0)
		;
	fail_unless(__builtin_popcount(shared.pushed & ~shared.popped) <= count_but(shared.in_pop, THREADS),
	            "an item lost");
	fail_unless(with.closer || with.rounds > 0 ||
	                __builtin_popcount(shared.popped) == (int)(with.before + with.producers * with.each),
	            "not all items were pushed");
	fail_unless(shared.queue->ops->empty(shared.queue, 0), "not empty at the end");
	shared.queue->ops->destroy(shared.queue);
	fail_unless((int32_t)model_heap_blocks() <= stopped, "leaked segments");
}

/* One thread, many items, never more than three in the queue: a few segments must be enough. */
static void recycle_main(void)
{
	stilb_job_queue_desc desc = {.capacity = SIZE_MAX, .thread_count = 1};
	fail_unless(job_queue_lock_free_create(&desc, &shared.queue) == 0, "create");
	for (uintptr_t i = 0; i < 20; i++) {
		for (uintptr_t j = 0; j <= i % 3; j++)
			fail_unless(shared.queue->ops->push(shared.queue, (void *)(j + 1), 0) == 0, "push");
		for (uintptr_t j = 0; j <= i % 3; j++) {
			void *item = NULL;
			fail_unless(shared.queue->ops->pop(shared.queue, &item, 0) == 0 && (uintptr_t)item == j + 1, "order");
		}
		fail_unless(shared.queue->ops->empty(shared.queue, 0), "not empty");
	}
	fail_unless(model_heap_blocks() <= 4, "segments were not used again");
	shared.queue->ops->destroy(shared.queue);
	fail_unless(model_heap_blocks() == 0, "leaked segments");
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
	                           .may_stop = with.stops << with.guests,
	                           .max_states = 4000000};
	model_result result = model_run(&scenario, !arguments.must_fail);
	print_message("%-34s %8u states %8u steps, path %u: %s\n", name, result.states, result.steps, result.depth,
	              result.failure ? result.failure : "ends well");
	/* An inconclusive run, with too many states, has not found the planted fault. */
	failed = failed || (result.failure && !(arguments.must_fail && result.states >= scenario.max_states));
}

static void run_queue(const char *name, uint32_t producers, uint32_t consumers, uint32_t each, uint32_t before,
                      size_t capacity, bool closer)
{
	memset(&with, 0, sizeof with);
	with.producers = producers;
	with.consumers = consumers;
	with.each = each;
	with.before = before;
	with.capacity = capacity;
	with.closer = closer;
	run(name, queue_main, queue_check);
}

static void run_guests(const char *name, uint32_t guests, uint32_t visits, bool visit_pushes, uint32_t rounds,
                       uint32_t left, bool stops)
{
	memset(&with, 0, sizeof with);
	with.guests = guests;
	with.visits = visits;
	with.visit_pushes = visit_pushes;
	with.before = left + 1;
	with.left = left;
	with.rounds = rounds;
	with.stops = stops;
	run(name, queue_main, queue_check);
}

static void run_all(void)
{
	memset(&with, 0, sizeof with);
	run("one thread, segments used again", recycle_main, NULL);
	run_queue("1 producer, 1 consumer", 1, 1, 5, 1, UNLIMITED, false);
	run_queue("closed at any time, 1 and 1", 1, 1, 3, 1, UNLIMITED, true);
	run_queue("closed at any time, 2 and 1", 2, 1, 1, 1, UNLIMITED, true);
	run_queue("closed at any time, 1 and 2", 1, 2, 1, 1, UNLIMITED, true);
	run_guests("a guest pops, never empty", 1, 1, false, 5, 2, false);
	run_guests("a guest pops and stops for ever", 1, 1, false, 5, 0, true);
	run_guests("a guest pops, rests and pops", 1, 2, false, 5, 0, false);
	run_guests("a guest pushes and stops for ever", 1, 1, true, 5, 0, true);
	run_guests("two guests pop, one stops", 2, 1, false, 2, 0, true);
	run_guests("two guests push, one stops", 2, 1, true, 1, 0, true);
	run_queue("capacity 3, 1 and 2", 1, 2, 2, 2, 3, false);
	run_queue("capacity 1, 2 and 1", 2, 1, 1, 1, 1, false);
	run_queue("1 producer, 2 consumers", 1, 2, 2, 3, UNLIMITED, false);
	run_queue("2 producers, 1 consumer", 2, 1, 2, 3, UNLIMITED, false);
	run_queue("2 producers, 2 consumers", 2, 2, 1, 3, UNLIMITED, false);
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
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_interleaving)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
