/* A linked list under one pthread mutex; nodes are allocated and freed outside the lock. */
#include "bench/subjects/queue_subjects.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

typedef struct node {
	void *item;
	struct node *next;
} node;

typedef struct mutex_queue {
	stilb_job_queue base;
	pthread_mutex_t mutex;
	node *first, **end; /* end: the pointer that the next node is stored in */
	size_t count, capacity;
	bool closed;
} mutex_queue;

static int mutex_push(stilb_job_queue *base, void *item, uint32_t thread)
{
	(void)thread;
	mutex_queue *queue = (mutex_queue *)base;
	node *made = malloc(sizeof *made);
	if (!made)
		return -ENOMEM;
	*made = (node){item, NULL};
	pthread_mutex_lock(&queue->mutex);
	int error = queue->closed ? -EPIPE : queue->count == queue->capacity ? -EAGAIN : 0;
	if (!error) {
		*queue->end = made;
		queue->end = &made->next;
		queue->count++;
	}
	pthread_mutex_unlock(&queue->mutex);
	if (error)
		free(made);
	return error;
}

static int mutex_pop(stilb_job_queue *base, void **item, uint32_t thread)
{
	(void)thread;
	mutex_queue *queue = (mutex_queue *)base;
	pthread_mutex_lock(&queue->mutex);
	node *old = queue->first;
	int error = old ? 0 : queue->closed ? -EPIPE : -EAGAIN;
	if (old) {
		queue->first = old->next;
		if (!queue->first)
			queue->end = &queue->first;
		queue->count--;
	}
	pthread_mutex_unlock(&queue->mutex);
	if (old)
		*item = old->item;
	free(old);
	return error;
}

static int mutex_push_n(stilb_job_queue *base, void *const *items, size_t count, uint32_t thread)
{
	for (size_t i = 0; i < count; i++) {
		int error = mutex_push(base, items[i], thread);
		if (error)
			return i ? (int)i : error;
	}
	return (int)count;
}

static int mutex_pop_n(stilb_job_queue *base, void **items, size_t max, uint32_t thread)
{
	for (size_t i = 0; i < max; i++) {
		int error = mutex_pop(base, &items[i], thread);
		if (error)
			return i ? (int)i : error;
	}
	return (int)max;
}

static bool mutex_empty(stilb_job_queue *base, uint32_t thread)
{
	(void)thread;
	mutex_queue *queue = (mutex_queue *)base;
	pthread_mutex_lock(&queue->mutex);
	bool empty = !queue->first;
	pthread_mutex_unlock(&queue->mutex);
	return empty;
}

static void mutex_close(stilb_job_queue *base)
{
	mutex_queue *queue = (mutex_queue *)base;
	pthread_mutex_lock(&queue->mutex);
	queue->closed = true;
	pthread_mutex_unlock(&queue->mutex);
}

static void mutex_rest(stilb_job_queue *base, uint32_t thread)
{
	(void)base, (void)thread;
}

static void mutex_destroy(stilb_job_queue *base)
{
	mutex_queue *queue = (mutex_queue *)base;
	for (node *at = queue->first, *next; at; at = next) {
		next = at->next;
		free(at);
	}
	pthread_mutex_destroy(&queue->mutex);
	free(queue);
}

int queue_mutex_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	static const job_queue_ops ops = {mutex_push,  mutex_push_n, mutex_pop,  mutex_pop_n,
	                                  mutex_empty, mutex_close,  mutex_rest, mutex_destroy};
	mutex_queue *made = malloc(sizeof *made);
	*queue = NULL;
	if (!made)
		return -ENOMEM;
	*made = (mutex_queue){.base.ops = &ops, .end = &made->first, .capacity = desc->capacity};
	pthread_mutex_init(&made->mutex, NULL);
	*queue = &made->base;
	return 0;
}
