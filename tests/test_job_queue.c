/* The queue by itself: order, emptiness, memory, and four producers against four consumers. */
#include <errno.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "jobs/job_queue.h"

enum { PRODUCERS = 4, CONSUMERS = 4, EACH = 50000 };

/* malloc fails while this is set (linked with -Wl,--wrap=malloc). */
static bool out_of_memory;
void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return out_of_memory ? NULL : __real_malloc(size);
}

static int push(job_queue *queue, uintptr_t value)
{
	return job_queue_push(queue, &(job_item){.data = (void *)value});
}

static uintptr_t pop(job_queue *queue)
{
	job_item item = {0};
	return job_queue_pop(queue, &item) ? (uintptr_t)item.data : UINTPTR_MAX;
}

static void test_fifo(void **state)
{
	(void)state;
	job_queue queue;
	assert_int_equal(job_queue_init(&queue), 0);
	assert_true(job_queue_empty(&queue));
	assert_true(job_queue_looks_empty(&queue));
	assert_int_equal(pop(&queue), UINTPTR_MAX);
	for (uintptr_t round = 0; round < 3; ++round) {
		for (uintptr_t i = 0; i < 1000; ++i)
			assert_int_equal(push(&queue, i), 0);
		assert_false(job_queue_empty(&queue));
		assert_false(job_queue_looks_empty(&queue));
		for (uintptr_t i = 0; i < 1000; ++i)
			assert_int_equal(pop(&queue), i);
		assert_int_equal(pop(&queue), UINTPTR_MAX);
		assert_true(job_queue_empty(&queue));
	}
	job_queue_finish(&queue);
}

static void test_ends_interleaved(void **state)
{
	(void)state;
	job_queue queue;
	assert_int_equal(job_queue_init(&queue), 0);
	uintptr_t pushed = 0, popped = 0;
	for (uintptr_t i = 0; i < 1000; ++i) {
		for (uintptr_t k = 0; k < i % 7; ++k)
			assert_int_equal(push(&queue, pushed++), 0);
		for (uintptr_t k = 0; k < i % 5 && popped < pushed; ++k)
			assert_int_equal(pop(&queue), popped++);
	}
	assert_true(popped < pushed); /* finish frees the rest: the leak check of the sanitizer build sees it */
	job_queue_finish(&queue);
	job_queue_finish(&queue); /* nothing left: fine */
}

static void test_out_of_memory(void **state)
{
	(void)state;
	job_queue queue;
	out_of_memory = true;
	int error = job_queue_init(&queue);
	out_of_memory = false;
	assert_int_equal(error, -ENOMEM);
	assert_int_equal(job_queue_init(&queue), 0);
	assert_int_equal(push(&queue, 7), 0);
	out_of_memory = true;
	error = push(&queue, 8);
	out_of_memory = false;
	assert_int_equal(error, -ENOMEM);
	assert_int_equal(pop(&queue), 7);
	assert_true(job_queue_empty(&queue));
	job_queue_finish(&queue);
}

typedef struct crowd {
	job_queue queue;
	_Atomic uint32_t popped;                /* relaxed: only says when to stop */
	_Atomic uint8_t seen[PRODUCERS * EACH]; /* relaxed: read after the join */
} crowd;

typedef struct member {
	crowd *crowd;
	pthread_t thread;
	uintptr_t index;
	uint64_t sum;
	uint32_t disorder; /* items of one producer seen in the wrong order */
} member;

static void *produce(void *data)
{
	member *self = data;
	for (uintptr_t i = 0; i < EACH; ++i)
		while (push(&self->crowd->queue, self->index * EACH + i) != 0)
			sched_yield();
	return NULL;
}

static void *consume(void *data)
{
	member *self = data;
	crowd *all = self->crowd;
	uintptr_t newest[PRODUCERS] = {0}; /* plus one */
	while (atomic_load_explicit(&all->popped, memory_order_relaxed) < PRODUCERS * EACH) {
		uintptr_t value = pop(&all->queue);
		if (value >= PRODUCERS * EACH) {
			sched_yield();
			continue;
		}
		self->disorder += value % EACH + 1 <= newest[value / EACH];
		newest[value / EACH] = value % EACH + 1;
		self->sum += value;
		atomic_fetch_add_explicit(&all->seen[value], 1, memory_order_relaxed);
		atomic_fetch_add_explicit(&all->popped, 1, memory_order_relaxed);
	}
	return NULL;
}

static void test_crowd(void **state)
{
	(void)state;
	crowd *all = calloc(1, sizeof *all + JOB_LINE);
	crowd *aligned = (crowd *)(((uintptr_t)all + JOB_LINE - 1) / JOB_LINE * JOB_LINE);
	assert_int_equal(job_queue_init(&aligned->queue), 0);
	member members[PRODUCERS + CONSUMERS] = {0};
	for (uintptr_t i = 0; i < PRODUCERS + CONSUMERS; ++i) {
		members[i] = (member){.crowd = aligned, .index = i};
		assert_int_equal(pthread_create(&members[i].thread, NULL, i < PRODUCERS ? produce : consume, &members[i]), 0);
	}
	uint64_t sum = 0;
	for (uintptr_t i = 0; i < PRODUCERS + CONSUMERS; ++i) {
		pthread_join(members[i].thread, NULL);
		assert_int_equal(members[i].disorder, 0);
		sum += members[i].sum;
	}
	const uint64_t n = PRODUCERS * EACH;
	assert_int_equal(sum, n * (n - 1) / 2);
	assert_int_equal(aligned->popped, n);
	for (uint64_t i = 0; i < n; ++i)
		assert_int_equal(aligned->seen[i], 1);
	assert_true(job_queue_empty(&aligned->queue));
	job_queue_finish(&aligned->queue);
	free(all);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_fifo),
		cmocka_unit_test(test_ends_interleaved),
		cmocka_unit_test(test_out_of_memory),
		cmocka_unit_test(test_crowd),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
