#include "jobs/job_deque.h"

#include <errno.h>
#include <stdlib.h>

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
	return 0;
}

void job_deque_finish(job_deque *deque)
{
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed); /* the caller is alone */
	while (buffer) {
		job_deque_buffer *smaller = buffer->smaller;
		free(buffer);
		buffer = smaller;
	}
}

int job_deque_grow(job_deque *deque)
{
	/* Relaxed: the owner's own, and top may be older than it is: then a record too many is copied. */
	job_deque_buffer *old = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
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
