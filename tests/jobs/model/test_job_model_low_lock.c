/*
 * All interleavings of the real low-lock queue with segments of two cells, so that a few items cross several segment
 * ends and reuse segments, and of its lock by itself. job_model.h tells what that covers.
 *
 * The queue's scenarios use a lock of one step, since the states of the real lock would multiply with theirs.
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
	if (model_fault_now == MODEL_FAULT_NO_LOCK) {
		model_step(&lock->held, "take", __LINE__);
		return;
	}
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
#include "jobs/queue/job_event.h"
#define job_event_awaited(event) ((void)(event), false)
#define job_event_signal(event, count) ((void)(event), (void)(count)) /* test_job_model_wait checks calls that wait */
#include "jobs/queue/job_queue_low_lock.c"
#include "support/test.h"
#undef job_lock_take
#undef job_lock_give
#undef job_lock_take_now
#undef job_lock_release

#undef free
#undef malloc

enum { PER_THREAD = 8, UNLIMITED = 0 };

static struct shared {
	stilb_job_queue *queue;
	job_lock lock;
	uint32_t inside;
	uint32_t producers_left;
	/* The queue's content, derived by the checks from the calls. */
	int32_t pushed, popped;         /* items of calls that have succeeded */
	int32_t pushing[4], popping[4]; /* items that each thread's current call may add or take */
	bool may_be_empty[4];           /* the queue was empty (full) at some moment of the thread's call */
	bool may_be_full[4];
	uint32_t refused;
	uint32_t seen[PER_THREAD * 4];
	uint32_t last[4][4]; /* per consumer and producer: the last item popped */
} shared;

/* Parameters of a scenario, constant while the checker runs it: so it need not save and restore them. */
static struct {
	uint32_t producers, consumers, each, batch;
	uint32_t before; /* items that the first thread pushes before the others exist */
	int32_t capacity;
	bool closer; /* another thread closes at any time; otherwise the last producer closes after its last item */
} with;
static model_arguments arguments;

static void fail_unless(bool condition, const char *why)
{
	if (!condition)
		model_fail(why);
}

/* ---- possible results of a call ------------------------------------------------------------------------------- */

static int32_t sum_but(const int32_t *of, uint32_t thread)
{
	int32_t sum = 0;
	for (uint32_t i = 0; i < 4; i++)
		sum += i == thread ? 0 : of[i];
	return sum;
}

/* Called when a call begins or ends: notes for each call in progress whether the queue may be empty or full now. A call
 * ends for the other threads when its stores are in memory. */
static void note_moment(void)
{
	for (uint32_t i = 0; i < 4; i++) {
		int32_t surely = shared.pushed - shared.popped - sum_but(shared.popping, i);
		int32_t at_most = shared.pushed + sum_but(shared.pushing, i) - shared.popped;
		if (surely <= 0)
			shared.may_be_empty[i] = true;
		if (with.capacity != UNLIMITED && at_most >= with.capacity)
			shared.may_be_full[i] = true;
		fail_unless(with.capacity == UNLIMITED ||
		                shared.pushed - shared.popped - sum_but(shared.popping, UINT32_MAX) <= with.capacity,
		            "more items than the capacity");
	}
}

static void push_begin(uint32_t thread, int32_t count)
{
	shared.may_be_full[thread] = false;
	shared.pushing[thread] = count;
	note_moment();
}

static void push_end(uint32_t thread, int result)
{
	model_barrier();
	note_moment();
	fail_unless(result != -EAGAIN || shared.may_be_full[thread], "refused, though never full");
	shared.pushing[thread] = 0;
	shared.pushed += result > 0 ? result : 0;
	note_moment();
}

static void pop_begin(uint32_t thread, int32_t count)
{
	shared.may_be_empty[thread] = false;
	shared.popping[thread] = count;
	note_moment();
}

static void pop_end(uint32_t thread, int result)
{
	model_barrier();
	note_moment();
	fail_unless(result > 0 || shared.may_be_empty[thread], "found nothing, though never empty");
	shared.popping[thread] = 0;
	shared.popped += result > 0 ? result : 0;
	note_moment();
}

/* ---- threads -------------------------------------------------------------------------------------------------- */

static stilb_job_queue *queue_create(void)
{
	stilb_job_queue_desc desc = {.capacity = with.capacity == UNLIMITED ? SIZE_MAX : (size_t)with.capacity,
	                             .thread_count = 4};
	stilb_job_queue *queue = NULL;
	fail_unless(job_queue_low_lock_create(&desc, &queue) == 0, "create");
	return queue;
}

static int push(uint32_t thread, uintptr_t first, uint32_t count)
{
	void *items[PER_THREAD];
	for (uint32_t i = 0; i < count; i++)
		items[i] = (void *)(first + i);
	push_begin(thread, (int32_t)count);
	int result = 0;
	if (with.batch == 1)
		result = shared.queue->ops->push(shared.queue, items[0], thread) ?: 1;
	else
		result = shared.queue->ops->push_n(shared.queue, items, count, thread);
	push_end(thread, result);
	return result;
}

static int pop(uint32_t thread, uintptr_t *items)
{
	void *taken[PER_THREAD];
	pop_begin(thread, (int32_t)with.batch);
	int result = 0;
	if (with.batch == 1)
		result = shared.queue->ops->pop(shared.queue, taken, thread) ?: 1;
	else
		result = shared.queue->ops->pop_n(shared.queue, taken, with.batch, thread);
	pop_end(thread, result);
	for (int i = 0; i < result; i++)
		items[i] = (uintptr_t)taken[i];
	return result;
}

/* Items of thread t are t * PER_THREAD + 1, + 2, ... */
static void produce_from(uint32_t thread, uint32_t done, uint32_t all)
{
	while (done < all) {
		uint32_t count = all - done < with.batch ? all - done : with.batch;
		int result = push(thread, thread * PER_THREAD + 1 + done, count);
		if (result == -EPIPE)
			break;
		fail_unless(result > 0 || (result == -EAGAIN && with.capacity != UNLIMITED), "push");
		done += result > 0 ? (uint32_t)result : 0;
	}
	if (--shared.producers_left == 0 && !with.closer)
		shared.queue->ops->close(shared.queue);
}

static void *produce(void *data)
{
	produce_from((uint32_t)(uintptr_t)data, 0, with.each);
	return NULL;
}

static void see(uint32_t consumer, uintptr_t item)
{
	uint32_t producer = (uint32_t)((item - 1) / PER_THREAD);
	fail_unless(item != 0 && producer < with.producers, "an item nobody pushed");
	fail_unless(item > shared.last[consumer][producer], "one producer's items out of order");
	shared.last[consumer][producer] = (uint32_t)item;
	shared.seen[item - 1]++;
}

static void *consume(void *data)
{
	uint32_t thread = (uint32_t)(uintptr_t)data;
	uintptr_t items[PER_THREAD];
	int result;
	while ((result = pop(thread, items)) != -EPIPE)
		for (int i = 0; i < result; i++)
			see(thread, items[i]);
	fail_unless(shared.pushed <= shared.popped || sum_but(shared.popping, thread) > 0,
	            "closed and empty, but items are left");
	return NULL;
}

static void *close_any_time(void *data)
{
	(void)data;
	shared.queue->ops->close(shared.queue);
	return NULL;
}

static void queue_main(void)
{
	shared.queue = queue_create();
	shared.producers_left = with.producers;
	for (uint32_t i = 0; i < with.before; i++)
		push(0, i + 1, 1);
	uintptr_t thread = 1;
	for (; thread < with.producers; thread++)
		model_spawn(produce, (void *)thread);
	for (; thread < with.producers + with.consumers; thread++)
		model_spawn(consume, (void *)thread);
	if (with.closer)
		model_spawn(close_any_time, NULL);
	produce_from(0, with.before, with.before + with.each);
}

static void queue_check(void)
{
	int32_t seen = 0;
	for (uint32_t i = 0; i < PER_THREAD * 4; i++) {
		fail_unless(shared.seen[i] <= 1, "an item seen twice");
		seen += (int32_t)shared.seen[i];
	}
	fail_unless(seen == shared.pushed && seen == shared.popped, "an item lost");
	fail_unless(with.closer || seen == (int32_t)(with.before + with.producers * with.each),
	            "not all items were pushed");
	fail_unless(low_lock_empty(shared.queue, 0), "not empty at the end");
	low_lock_destroy(shared.queue);
	fail_unless(model_heap_blocks() == 0, "leaked segments");
}

/* One thread, many items, never more than three in the queue: three segments must be enough. */
static void recycle_main(void)
{
	shared.queue = queue_create();
	for (uint32_t i = 0; i < 20; i++) {
		uint32_t count = i % 3 + 1;
		for (uint32_t j = 0; j < count; j++)
			fail_unless(shared.queue->ops->push(shared.queue, (void *)(uintptr_t)(j + 1), 0) == 0, "push");
		for (uint32_t j = 0; j < count; j++) {
			void *item = NULL;
			fail_unless(shared.queue->ops->pop(shared.queue, &item, 0) == 0, "pop");
			fail_unless((uintptr_t)item == j + 1, "order");
		}
		fail_unless(low_lock_empty(shared.queue, 0), "not empty");
	}
	fail_unless(model_heap_blocks() <= 3, "segments were not used again");
	low_lock_destroy(shared.queue);
}

static void *lock_and_leave(void *data)
{
	(void)data;
	for (uint32_t i = 0; i < with.each; i++) {
		job_lock_take(&shared.lock);
		fail_unless(shared.inside++ == 0, "two threads in one section");
		model_step(NULL, "inside", __LINE__);
		shared.inside--;
		job_lock_give(&shared.lock);
	}
	return NULL;
}

static void lock_main(void)
{
	for (uint32_t i = 1; i < with.producers; i++)
		model_spawn(lock_and_leave, NULL);
	lock_and_leave(NULL);
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

static void run_queue(const char *name, uint32_t producers, uint32_t consumers, uint32_t each, uint32_t before,
                      uint32_t batch, int32_t capacity, bool closer)
{
	with.producers = producers;
	with.consumers = consumers;
	with.each = each;
	with.before = before;
	with.batch = batch;
	with.capacity = capacity;
	with.closer = closer;
	run(name, queue_main, queue_check);
}

static void run_lock(const char *name, uint32_t threads, uint32_t each, uint64_t spin)
{
	with.producers = threads;
	with.each = each;
	model_spin_ticks = spin;
	run(name, lock_main, NULL);
}

static void run_all(void)
{
	run_lock("lock, 3 threads spinning", 3, 2, 1);
	run_lock("lock, 2 threads sleeping", 2, 3, 0);
	run_lock("lock, 3 threads sleeping", 3, 1, 0);
	run("one thread, segments used again", recycle_main, NULL);
	run_queue("1 producer, 1 consumer", 1, 1, 8, 0, 1, UNLIMITED, false);
	run_queue("2 producers, 1 consumer", 2, 1, 2, 1, 1, UNLIMITED, false);
	run_queue("1 producer, 2 consumers", 1, 2, 2, 2, 1, UNLIMITED, false);
	run_queue("2 producers, 2 consumers", 2, 2, 1, 1, 1, UNLIMITED, false);
	run_queue("batches, 1 and 1", 1, 1, 8, 0, 3, UNLIMITED, false);
	run_queue("batches, 2 and 1", 2, 1, 3, 0, 3, UNLIMITED, false);
	run_queue("capacity 1, 2 and 1", 2, 1, 2, 0, 1, 1, false);
	run_queue("capacity 3, 1 and 2", 1, 2, 2, 2, 1, 3, false);
	run_queue("capacity 3, batches, 1 and 1", 1, 1, 7, 0, 2, 3, false);
	run_queue("closed at any time, 1 and 1", 1, 1, 4, 0, 1, UNLIMITED, true);
	run_queue("closed at any time, 2 and 1", 2, 1, 1, 1, 1, UNLIMITED, true);
	run_queue("closed at any time, 1 and 2", 1, 2, 2, 0, 1, UNLIMITED, true);
}

static void test_every_interleaving(void **state)
{
	(void)state;
	failed = false;
	run_all();
	assert_int_equal(failed, arguments.must_fail);
}

/* The checker's own operations are broken on purpose (model_fault): it must find that, too. */
static void test_faults_are_found(void **state)
{
	(void)state;
	if (arguments.must_fail)
		return; /* this build has a planted fault already */
	arguments.must_fail = true;
	static const model_fault faults[] = {MODEL_FAULT_NO_LOCK, MODEL_FAULT_NO_WAKE};
	for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
		model_fault_now = faults[i];
		failed = false;
		run_all();
		model_fault_now = MODEL_FAULT_NONE;
		assert_true(failed);
	}
	arguments.must_fail = false;
}

int main(int argc, char **argv)
{
	if (!model_available())
		return 77;
	arguments = model_arguments_of(argc, argv);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_every_interleaving),
		cmocka_unit_test(test_faults_are_found),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
