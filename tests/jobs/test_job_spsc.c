/* The queue for one producer and one consumer: order, close, memory, and two threads that hand over plain data. */
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "jobs/job_spsc.h"
#include "support/test.h"

enum { MANY = 1000000, BLOCK = 511 };

/* Number of allocations so far, and of further ones that succeed. Linked with
 * -Wl,--wrap=malloc,--wrap=aligned_alloc. */
static size_t allocations, allowed = SIZE_MAX;
void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);

static bool allocation_allowed(void)
{
	allocations++;
	return allowed == SIZE_MAX || (allowed > 0 && allowed--);
}

void *__wrap_malloc(size_t size)
{
	return allocation_allowed() ? __real_malloc(size) : NULL;
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return allocation_allowed() ? __real_aligned_alloc(alignment, size) : NULL;
}

static stilb_job_spsc *create(void)
{
	stilb_job_spsc *queue = NULL;
	assert_int_equal(stilb_job_spsc_create(&queue), 0);
	assert_non_null(queue);
	return queue;
}

static int push(stilb_job_spsc *queue, uintptr_t value)
{
	return stilb_job_spsc_push(queue, (void *)value);
}

/* Pops a value; 0 if the queue is empty. */
static uintptr_t pop(stilb_job_spsc *queue)
{
	void *item = NULL;
	int error = stilb_job_spsc_pop(queue, &item);
	assert_true(error == 0 || (error == -EAGAIN && !item));
	return (uintptr_t)item;
}

static void test_fifo(void **state)
{
	(void)state;
	stilb_job_spsc *queue = create();
	assert_int_equal(pop(queue), 0);
	uintptr_t pushed = 0, popped = 0;
	for (uintptr_t i = 0; i < 5000; i++) { /* crosses many block ends in both directions */
		for (uintptr_t k = 0; k < i % 7; k++)
			assert_int_equal(push(queue, ++pushed), 0);
		for (uintptr_t k = 0; k < i % 5; k++)
			assert_int_equal(pop(queue), ++popped);
	}
	assert_true(pushed - popped > 2 * BLOCK);
	while (popped < pushed)
		assert_int_equal(pop(queue), ++popped);
	assert_int_equal(pop(queue), 0);
	stilb_job_spsc_destroy(queue);
}

static void test_destroy(void **state)
{
	(void)state;
	stilb_job_spsc_destroy(NULL);
	/* Destroy with items left in several blocks, some of them reused: the address sanitizer's leak check sees
	 * mistakes. */
	stilb_job_spsc *queue = create();
	for (uintptr_t i = 1; i <= 4 * BLOCK; i++)
		assert_int_equal(push(queue, i), 0);
	for (uintptr_t i = 1; i <= 3 * BLOCK; i++)
		assert_int_equal(pop(queue), i);
	for (uintptr_t i = 1; i <= 2 * BLOCK; i++)
		assert_int_equal(push(queue, i), 0);
	stilb_job_spsc_destroy(queue);
}

static void test_close(void **state)
{
	(void)state;
	stilb_job_spsc *queue = create();
	void *item = NULL;
	assert_int_equal(stilb_job_spsc_push(queue, NULL), -EINVAL);
	assert_int_equal(push(queue, 1), 0);
	assert_int_equal(push(queue, 2), 0);
	stilb_job_spsc_close(queue);
	stilb_job_spsc_close(queue);
	assert_int_equal(push(queue, 3), -EPIPE);
	assert_int_equal(pop(queue), 1);
	assert_int_equal(pop(queue), 2);
	assert_int_equal(stilb_job_spsc_pop(queue, &item), -EPIPE);
	assert_int_equal(stilb_job_spsc_pop(queue, &item), -EPIPE);
	assert_null(item);
	stilb_job_spsc_destroy(queue);
}

static void test_memory_is_used_again(void **state)
{
	(void)state;
	enum { FULLEST = 10 * BLOCK };
	stilb_job_spsc *queue = create();
	size_t before = allocations;
	uintptr_t pushed = 0, popped = 0;
	for (int round = 0; round < 50; round++) {
		while (pushed - popped < FULLEST)
			assert_int_equal(push(queue, ++pushed), 0);
		while (popped < pushed)
			assert_int_equal(pop(queue), ++popped);
	}
	/* One block was allocated with the queue. */
	assert_in_range(allocations - before, FULLEST / BLOCK - 1, FULLEST / BLOCK + 1);
	stilb_job_spsc_destroy(queue);
}

static void test_out_of_memory(void **state)
{
	(void)state;
	for (size_t i = 0; i < 2; i++) {
		stilb_job_spsc *none = (void *)&allowed;
		allowed = i;
		int error = stilb_job_spsc_create(&none);
		allowed = SIZE_MAX;
		assert_int_equal(error, -ENOMEM);
		assert_null(none);
	}

	stilb_job_spsc *queue = create();
	uintptr_t pushed = 0;
	allowed = 1; /* a second block, but no third one */
	int error;
	while ((error = push(queue, pushed + 1)) == 0)
		pushed++;
	assert_int_equal(error, -ENOMEM);
	assert_int_equal(push(queue, pushed + 1), -ENOMEM);
	assert_int_equal(pushed, 2 * BLOCK);

	/* No item is lost, and when the consumer has left a block, its memory is available again. */
	for (uintptr_t i = 1; i <= BLOCK + 1; i++)
		assert_int_equal(pop(queue), i);
	assert_int_equal(push(queue, pushed + 1), 0);
	allowed = SIZE_MAX;
	assert_int_equal(push(queue, pushed + 2), 0);
	for (uintptr_t i = BLOCK + 2; i <= pushed + 2; i++)
		assert_int_equal(pop(queue), i);
	assert_int_equal(pop(queue), 0);
	stilb_job_spsc_destroy(queue);
}

/* The data handed over is plain memory, so that the thread sanitizer sees a missing memory order. */
typedef struct parcel {
	uint32_t number, twice;
} parcel;

static parcel parcels[MANY];
static uint32_t sent; /* written after the last push and before the close */

static void *produce(void *data)
{
	uint32_t i;
	for (i = 0; i < MANY; i++) {
		parcels[i] = (parcel){i, 2 * i};
		if (stilb_job_spsc_push(data, &parcels[i]) != 0)
			break; /* the test then fails because items are missing */
	}
	sent = i;
	stilb_job_spsc_close(data);
	return NULL;
}

static void test_two_threads(void **state)
{
	(void)state;
	stilb_job_spsc *queue = create();
	pthread_t producer;
	assert_int_equal(pthread_create(&producer, NULL, produce, queue), 0);
	uint32_t received = 0, wrong = 0;
	int error;
	void *item;
	while ((error = stilb_job_spsc_pop(queue, &item)) != -EPIPE) {
		if (error == -EAGAIN) {
			sched_yield();
			continue;
		}
		const parcel *got = item;
		wrong += got != &parcels[received] || got->number != received || got->twice != 2 * received;
		received++;
	}
	uint32_t told = sent; /* before the join, which would order it in any case */
	assert_int_equal(pthread_join(producer, NULL), 0);
	assert_int_equal(told, MANY);
	assert_int_equal(received, MANY);
	assert_int_equal(wrong, 0);
	stilb_job_spsc_destroy(queue);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_fifo),          cmocka_unit_test(test_destroy),
		cmocka_unit_test(test_close),         cmocka_unit_test(test_memory_is_used_again),
		cmocka_unit_test(test_out_of_memory), cmocka_unit_test(test_two_threads),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
