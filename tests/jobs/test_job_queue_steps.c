/*
 * What the queues do at a push and a pop, counted instead of timed: how often the low-lock queue reads the consumers'
 * cache line and yields its CPU to them, and how often the queue for two threads stores outside of its cells. They are
 * compiled into this file with these operations counted.
 */
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stddef.h>
#include <stdint.h>

#include "jobs/job_lock.h"
#include "support/test.h"

/* Counts of the calling thread. */
static _Thread_local struct counts {
	uint64_t loads;  /* of `watched` */
	uint64_t stores; /* outside of cells */
	uint64_t yields;
} counts;

static _Thread_local const volatile void *watched; /* the word whose loads are counted */

static void count_load(const volatile void *word)
{
	counts.loads += word == watched;
}

/* Cells lie in blocks of their own, all else in the queue itself. */
static _Thread_local const char *queue_begin, *queue_end;

static void count_store(const volatile void *word)
{
	counts.stores += (const volatile char *)word >= queue_begin && (const volatile char *)word < queue_end;
}

static int count_yield(void)
{
	counts.yields++;
	return 0;
}

#ifdef __clang__
#define REAL_LOAD __c11_atomic_load
#define REAL_STORE __c11_atomic_store
#else
#define REAL_LOAD __atomic_load_n
#define REAL_STORE __atomic_store_n
#endif
#undef atomic_load_explicit
#undef atomic_store_explicit
#define atomic_load_explicit(word, order) (count_load(word), REAL_LOAD(word, order))
#define atomic_store_explicit(word, value, order) (count_store(word), REAL_STORE(word, value, order))
#define sched_yield count_yield
#include "jobs/queue/job_queue_low_lock.c"
#include "jobs/queue/job_spsc.c"
#undef sched_yield

enum { BATCH = 16, MANY = 32 * JOB_QUEUE_AHEAD, SEGMENTS = MANY / JOB_SEGMENT_CELLS };

static low_lock *create(size_t capacity)
{
	stilb_job_queue *queue = NULL;
	stilb_job_queue_desc desc = {.capacity = capacity, .thread_count = 1};
	assert_int_equal(job_queue_low_lock_create(&desc, &queue), 0);
	low_lock *made = low_lock_of(queue);
	watched = &made->pop.count;
	counts = (struct counts){0};
	return made;
}

/* Pushes items in batches of the given size, 1 for single pushes; returns how many of them were accepted. */
static size_t push(low_lock *queue, size_t items, size_t batch)
{
	void *item[BATCH];
	for (size_t i = 0; i < BATCH; i++)
		item[i] = queue;
	size_t done = 0;
	while (done < items) {
		int result =
			batch == 1 ? low_lock_push(&queue->base, item[0], 0) : low_lock_push_n(&queue->base, item, batch, 0);
		if (result < 0)
			break;
		done += batch == 1 ? 1 : (size_t)result;
	}
	return done;
}

static size_t pop(low_lock *queue, size_t items)
{
	size_t done = 0;
	for (void *item; done < items && low_lock_pop(&queue->base, &item, 0) == 0; done++)
		assert_ptr_equal(item, queue);
	return done;
}

/* The consumers' count is read once a segment, whatever the size of the batches; twice where a segment is allocated. */
static void test_the_consumers_line_is_left_alone(void **state)
{
	(void)state;
	for (size_t batch = 1; batch <= BATCH; batch++) {
		low_lock *queue = create(SIZE_MAX);
		assert_in_range(push(queue, MANY, batch), MANY, MANY + BATCH);
		assert_in_range(counts.loads, SEGMENTS - 1, 2 * SEGMENTS);
		low_lock_destroy(&queue->base);
	}
}

/* A queue with a capacity reads the count when it seems full, and then knows what was popped meanwhile. */
static void test_capacity_is_exact(void **state)
{
	(void)state;
	for (size_t batch = 1; batch <= BATCH; batch++) {
		low_lock *queue = create(1000);
		assert_int_equal(push(queue, MANY, batch), 1000);
		assert_int_equal(pop(queue, 100), 100);
		assert_int_equal(push(queue, MANY, batch), 100);
		assert_int_equal(pop(queue, MANY), 1000);
		assert_int_equal(counts.yields, 0);
		low_lock_destroy(&queue->base);
	}
}

static void test_nobody_pops(void **state)
{
	(void)state;
	for (size_t batch = 1; batch <= BATCH; batch += BATCH - 1) {
		low_lock *queue = create(SIZE_MAX);
		push(queue, MANY, batch);
		assert_int_equal(counts.yields, 0);
		low_lock_destroy(&queue->base);
	}
}

static void test_the_producer_is_the_consumer(void **state)
{
	(void)state;
	low_lock *queue = create(SIZE_MAX);
	for (size_t i = 0; i < 4; i++) {
		push(queue, MANY / 4, BATCH);
		assert_int_equal(pop(queue, MANY / 8), MANY / 8);
	}
	assert_int_equal(counts.yields, 0);
	low_lock_destroy(&queue->base);
}

typedef struct meal {
	low_lock *queue;
	size_t items;
} meal;

static void *pop_in_thread(void *data)
{
	meal *m = data;
	m->items = pop(m->queue, m->items);
	return NULL;
}

/* Pops items in another thread. */
static void let_pop(low_lock *queue, size_t items)
{
	meal m = {queue, items};
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, pop_in_thread, &m), 0);
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_int_equal(m.items, items);
}

/* Producers of batches that run ahead of a consumer yield once a segment in which it has not popped, and give up in the
 * end. Single pushes do not yield. */
static void test_another_thread_pops(void **state)
{
	(void)state;
	for (size_t batch = 1; batch <= BATCH; batch += BATCH - 1) {
		uint32_t yields = batch > 1;
		low_lock *queue = create(SIZE_MAX);
		push(queue, JOB_QUEUE_AHEAD, batch);
		let_pop(queue, JOB_SEGMENT_CELLS + BATCH);
		push(queue, 2 * JOB_SEGMENT_CELLS, batch);
		assert_int_equal(counts.yields, 0); /* not far ahead yet */
		for (uint32_t i = 1; i <= 3 * JOB_QUEUE_YIELDS; i++) {
			let_pop(queue, 1);
			push(queue, JOB_SEGMENT_CELLS, batch);
			assert_int_equal(counts.yields, (i - 1) * yields);
			push(queue, JOB_SEGMENT_CELLS, batch);
			assert_int_equal(counts.yields, i * yields);
		}
		let_pop(queue, 1);
		push(queue, MANY, batch);
		assert_int_equal(counts.yields, 4 * JOB_QUEUE_YIELDS * yields);
		low_lock_destroy(&queue->base);
	}
}

/* Pushes that a full queue refuses do not yield: their callers decide what to do. */
static void test_full(void **state)
{
	(void)state;
	low_lock *queue = create(2 * JOB_QUEUE_AHEAD);
	push(queue, MANY, BATCH);
	let_pop(queue, 1);
	assert_int_equal(push(queue, 2, 2), 1);
	for (uint32_t i = 0; i < JOB_QUEUE_YIELDS; i++)
		assert_int_equal(push(queue, 2, 2), 0);
	assert_int_equal(counts.yields, 0);
	low_lock_destroy(&queue->base);
}

/* The ends of the queue for two threads share cells and links alone; once a block, the consumer says that it has left
 * it. */
static void test_spsc_shares_cells_alone(void **state)
{
	(void)state;
	stilb_job_spsc *queue;
	assert_int_equal(stilb_job_spsc_create(&queue), 0);
	queue_begin = (const char *)queue;
	queue_end = queue_begin + sizeof *queue;
	counts = (struct counts){0};
	for (size_t i = 0; i < MANY; i++) {
		void *item;
		assert_int_equal(stilb_job_spsc_push(queue, queue), 0);
		assert_int_equal(stilb_job_spsc_pop(queue, &item), 0);
	}
	assert_int_equal(counts.stores, (MANY - 1) / JOB_SPSC_BLOCK_CELLS);
	queue_begin = queue_end = NULL;
	stilb_job_spsc_destroy(queue);
}

/* A cell that has been taken is clear when the last cell of its line has been taken. */
static void test_spsc_clears_cells(void **state)
{
	(void)state;
	enum { CELLS_IN_LINE = CACHE_LINE / sizeof(void *) };
	stilb_job_spsc *queue;
	assert_int_equal(stilb_job_spsc_create(&queue), 0);
	for (size_t i = 0; i < JOB_SPSC_BLOCK_CELLS; i++)
		assert_int_equal(stilb_job_spsc_push(queue, queue), 0);
	for (size_t taken = 1; taken <= JOB_SPSC_BLOCK_CELLS; taken++) {
		void *item;
		assert_int_equal(stilb_job_spsc_pop(queue, &item), 0);
		for (size_t i = 0; i < JOB_SPSC_BLOCK_CELLS; i++)
			assert_ptr_equal(queue->first->cells[i], i < taken / CELLS_IN_LINE * CELLS_IN_LINE ? NULL : queue);
	}
	stilb_job_spsc_destroy(queue);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_consumers_line_is_left_alone),
		cmocka_unit_test(test_capacity_is_exact),
		cmocka_unit_test(test_nobody_pops),
		cmocka_unit_test(test_the_producer_is_the_consumer),
		cmocka_unit_test(test_another_thread_pops),
		cmocka_unit_test(test_full),
		cmocka_unit_test(test_spsc_shares_cells_alone),
		cmocka_unit_test(test_spsc_clears_cells),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
