#include "jobs/job_deque.h"

#include <errno.h>

static_assert((JOB_DEQUE_CAPACITY & (JOB_DEQUE_CAPACITY - 1)) == 0, "cells are found by a mask");

/* In bytes. */
static size_t buffer_size(int64_t capacity)
{
	return sizeof(job_deque_buffer) + (size_t)capacity * sizeof(_Atomic(job_record *));
}

static job_deque_buffer *buffer_create(const stilb_job_allocator *memory, int64_t capacity)
{
	job_deque_buffer *buffer = job_allocate(memory, buffer_size(capacity), alignof(job_deque_buffer));
	if (buffer) {
		buffer->smaller = NULL;
		buffer->mask = capacity - 1;
		for (int64_t i = 0; i < capacity; i++)
			atomic_init(&buffer->cell[i], NULL);
	}
	return buffer;
}

int job_deque_init(job_deque *deque, const stilb_job_allocator *memory)
{
	job_deque_buffer *buffer = buffer_create(memory, JOB_DEQUE_CAPACITY);
	if (!buffer)
		return -ENOMEM;
	atomic_init(&deque->top, 0);
	atomic_init(&deque->bottom, 0);
	atomic_init(&deque->buffer, buffer);
	deque->top_seen = 0;
	deque->memory = memory;
	JOB_CHECK(job_deque_is_sound(deque));
	return 0;
}

void job_deque_finish(job_deque *deque)
{
	assert(job_deque_empty(deque) && "a record left here would never run");
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed); /* no other call runs */
	while (buffer) {
		job_deque_buffer *smaller = buffer->smaller;
		job_release(deque->memory, buffer, buffer_size(buffer->mask + 1));
		buffer = smaller;
	}
}

int job_deque_grow(job_deque *deque, int64_t more)
{
	/* Relaxed: only the owner writes buffer and bottom. top, loaded in the loop below, may be an old value: then some
	 * records that thieves have taken are copied, too, and nobody reads these copies. */
	job_deque_buffer *old = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	int64_t capacity = old->mask + 1, wanted = bottom - deque->top_seen + more;
	assert(wanted > capacity && "the buffer is too small");
	while (capacity < wanted)
		capacity *= 2;
	job_deque_buffer *buffer = buffer_create(deque->memory, capacity);
	if (!buffer)
		return -ENOMEM;
	buffer->smaller = old;
	for (int64_t i = atomic_load_explicit(&deque->top, memory_order_relaxed); i < bottom; i++)
		atomic_store_explicit(&buffer->cell[i & buffer->mask],
		                      atomic_load_explicit(&old->cell[i & old->mask], memory_order_relaxed),
		                      memory_order_relaxed);
	atomic_store_explicit(&deque->buffer, buffer, memory_order_release); /* pairs with job_deque_oldest */
	return 0;
}

int job_deque_push_list(job_deque *deque, job_record *first, int64_t count)
{
	assert(first && count > 0);
	/* Relaxed, both: only the owner, the calling thread, writes bottom and buffer. */
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	deque->top_seen = atomic_load_explicit(&deque->top, memory_order_acquire); /* pairs with steal, as in push */
	if (bottom - deque->top_seen + count > buffer->mask + 1) {
		int error = job_deque_grow(deque, count);
		if (error)
			return error;
		buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed); /* the owner's own */
	}
	int64_t at = bottom;
	for (job_record *record = first; record; record = record->next, at++)
		atomic_store_explicit(&buffer->cell[at & buffer->mask], record, memory_order_relaxed); /* see bottom */
	assert(at == bottom + count);
	atomic_exchange_explicit(&deque->bottom, at, memory_order_seq_cst); /* pairs with steal, as in push */
	JOB_CHECK(job_deque_is_sound(deque));
	return 0;
}

/* The index of the oldest record that passes the test among the newest records: those down to twice the depth of the
 * newest that does. So a dig that serves several waits does not cost more than their depths together. bottom: there is
 * none. The oldest record of all, at index top, is not looked at, because it is left to thieves. */
static int64_t dig_begin(job_deque *deque, int64_t bottom, job_deque_test *test, const void *context)
{
	/* Relaxed, both: the owner's own buffer; and if top is an old value, the look at top after hiding decides. */
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	int64_t end = atomic_load_explicit(&deque->top, memory_order_relaxed), begin = bottom;
	for (int64_t i = bottom - 1; i > end; i--) {
		if (!test(atomic_load_explicit(&buffer->cell[i & buffer->mask], memory_order_relaxed), context))
			continue;
		int64_t twice = bottom - 2 * (bottom - i);
		if (begin == bottom && twice > end)
			end = twice;
		begin = i;
	}
	return begin;
}

/* Reorders the records from begin to bottom: first those that fail the test, then those that pass, each in their order.
 * No thief can reach them. */
static void dig_sort(job_deque *deque, int64_t begin, int64_t bottom, job_deque_test *test, const void *context)
{
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed); /* the owner's own */
	job_record *passed = NULL, **end = &passed;
	int64_t to = begin;
	/* Relaxed, all: the cells are published by bottom. */
	for (int64_t i = begin; i < bottom; i++) {
		job_record *record = atomic_load_explicit(&buffer->cell[i & buffer->mask], memory_order_relaxed);
		if (test(record, context)) {
			*end = record;
			end = &record->next;
		} else {
			atomic_store_explicit(&buffer->cell[to & buffer->mask], record, memory_order_relaxed);
			to++;
		}
	}
	*end = NULL;
	for (; passed; passed = passed->next, to++)
		atomic_store_explicit(&buffer->cell[to & buffer->mask], passed, memory_order_relaxed);
	assert(to == bottom && "no record is lost");
}

bool job_deque_dig(job_deque *deque, job_deque_test *test, const void *context)
{
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed); /* the owner's own */
	int64_t begin = dig_begin(deque, bottom, test, context);
	if (begin == bottom)
		return false;
	/* Hides the records from begin on. Seq_cst, both, as in job_deque_pop: a thief that takes a record at or above
	 * begin has seen top there. If top is lower here, it saw that later than this exchange, and with it the lower
	 * bottom. */
	atomic_exchange_explicit(&deque->bottom, begin, memory_order_seq_cst);
	if (atomic_load_explicit(&deque->top, memory_order_seq_cst) < begin)
		dig_sort(deque, begin, bottom, test, context);
	/* Publishes them again, as job_deque_push does. */
	atomic_exchange_explicit(&deque->bottom, bottom, memory_order_seq_cst);
	JOB_CHECK(job_deque_is_sound(deque));
	return true;
}

bool job_deque_find(job_deque *deque, job_deque_test *test, const void *context, int64_t *index)
{
	/* Seq_cst and acquire: as in job_deque_oldest. */
	int64_t i = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_seq_cst);
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_acquire); /* pairs with grow */
	for (; i < bottom; i++) {
		/* Relaxed, as in job_deque_oldest. The cell of a record that has been taken meanwhile may hold a newer record,
		 * or NULL if the buffer is new. */
		job_record *record = atomic_load_explicit(&buffer->cell[i & buffer->mask], memory_order_relaxed);
		if (record && test(record, context)) {
			*index = i;
			return true;
		}
	}
	return false;
}

/* For asserts: capacities are powers of two, each at least twice that of the buffer that it replaced; the first is
 * JOB_DEQUE_CAPACITY. */
static bool buffers_double(const job_deque_buffer *buffer)
{
	for (; buffer->smaller; buffer = buffer->smaller)
		if (buffer->mask + 1 < (buffer->smaller->mask + 1) * 2 || (buffer->mask & (buffer->mask + 1)) != 0)
			return false;
	return buffer->mask + 1 == JOB_DEQUE_CAPACITY;
}

bool job_deque_is_sound(job_deque *deque)
{
	/* Relaxed: thieves may move top meanwhile, but only up, and never past bottom. */
	int64_t top = atomic_load_explicit(&deque->top, memory_order_relaxed);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	const job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	return 0 <= deque->top_seen && deque->top_seen <= top && top <= bottom && bottom - top <= buffer->mask + 1 &&
	       (top == bottom || atomic_load_explicit(&buffer->cell[(bottom - 1) & buffer->mask], memory_order_relaxed)) &&
	       buffers_double(buffer);
}
