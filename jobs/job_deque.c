#include "jobs/job_deque.h"

#include <errno.h>
#include <stdlib.h>

static_assert((JOB_DEQUE_CAPACITY & (JOB_DEQUE_CAPACITY - 1)) == 0, "cells are found by a mask");

static job_deque_buffer *buffer_create(int64_t capacity)
{
	job_deque_buffer *buffer = malloc(sizeof *buffer + (size_t)capacity * sizeof buffer->cell[0]);
	if (buffer) {
		buffer->smaller = NULL;
		buffer->mask = capacity - 1;
		for (int64_t i = 0; i < capacity; i++)
			atomic_init(&buffer->cell[i], NULL);
	}
	return buffer;
}

int job_deque_init(job_deque *deque)
{
	job_deque_buffer *buffer = buffer_create(JOB_DEQUE_CAPACITY);
	if (!buffer)
		return -ENOMEM;
	atomic_init(&deque->top, 0);
	atomic_init(&deque->bottom, 0);
	atomic_init(&deque->buffer, buffer);
	deque->top_seen = 0;
	JOB_CHECK(job_deque_is_sound(deque));
	return 0;
}

void job_deque_finish(job_deque *deque)
{
	assert(job_deque_empty(deque) && "a record left here would never run");
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed); /* no other call runs */
	while (buffer) {
		job_deque_buffer *smaller = buffer->smaller;
		free(buffer);
		buffer = smaller;
	}
}

int job_deque_grow(job_deque *deque)
{
	/* Relaxed: only the owner writes buffer and bottom. top, loaded in the loop below, may be an old value: then some
	 * records that thieves have taken are copied, too, and nobody reads these copies. */
	job_deque_buffer *old = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	assert(bottom - deque->top_seen == old->mask + 1 && "the buffer is full");
	job_deque_buffer *buffer = buffer_create((old->mask + 1) * 2);
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

/* For asserts: each buffer is twice as large as the one it replaced; the first has JOB_DEQUE_CAPACITY cells. */
static bool buffers_double(const job_deque_buffer *buffer)
{
	for (; buffer->smaller; buffer = buffer->smaller)
		if (buffer->mask + 1 != (buffer->smaller->mask + 1) * 2)
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
