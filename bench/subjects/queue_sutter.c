/*
 * The queue of Sutter's article (Dr. Dobb's Journal, November 2008) as published: spin locks without a pause
 * instruction, each item in an allocated box, node and box allocated and freed outside the locks, nodes padded to a
 * cache line. The list always starts with a node without an item, so producers and consumers share one word: the `next`
 * of that node if the queue is empty.
 *
 * close is an addition to the article's queue: push reads the flag `closed` under the producers' lock, and pop reads it
 * only if the queue is empty.
 */
#include "bench/subjects/queue_subjects.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>

#define LINE 64 /* the article's padding */

typedef struct node {
	void **box;
	struct node *_Atomic next;
	char pad[LINE - 2 * sizeof(void *)];
} node;

typedef struct sutter {
	stilb_job_queue base;
	_Alignas(LINE) node *first; /* under the consumers' lock */
	_Alignas(LINE) atomic_bool consumer_lock;
	_Alignas(LINE) node *last; /* under the producers' lock */
	_Atomic bool closed;       /* written under the producers' lock; release, pairs with the acquire in sutter_pop */
	_Alignas(LINE) atomic_bool producer_lock;
} sutter;

static void lock(atomic_bool *flag)
{
	while (atomic_exchange_explicit(flag, true, memory_order_acquire)) { /* pairs with unlock */
	}
}

static void unlock(atomic_bool *flag)
{
	atomic_store_explicit(flag, false, memory_order_release); /* pairs with lock */
}

static node *node_new(void *item)
{
	node *made = malloc(sizeof *made);
	void **box = malloc(sizeof *box);
	if (!made || !box) {
		free(made);
		free(box);
		return NULL;
	}
	*box = item;
	made->box = box;
	atomic_init(&made->next, NULL);
	return made;
}

static int sutter_push(stilb_job_queue *base, void *item, uint32_t thread)
{
	(void)thread;
	sutter *queue = (sutter *)base;
	node *made = node_new(item);
	if (!made)
		return -ENOMEM;
	lock(&queue->producer_lock);
	/* Relaxed: the lock orders it against sutter_close. */
	bool closed = atomic_load_explicit(&queue->closed, memory_order_relaxed);
	if (!closed) {
		/* Release, pairs with the acquires in sutter_pop and sutter_empty: publishes the node and its item. */
		atomic_store_explicit(&queue->last->next, made, memory_order_release);
		queue->last = made;
	}
	unlock(&queue->producer_lock);
	if (!closed)
		return 0;
	free(made->box);
	free(made);
	return -EPIPE;
}

static int sutter_pop(stilb_job_queue *base, void **item, uint32_t thread)
{
	(void)thread;
	sutter *queue = (sutter *)base;
	lock(&queue->consumer_lock);
	node *old = queue->first;
	node *next = atomic_load_explicit(&old->next, memory_order_acquire); /* pairs with sutter_push */
	if (!next) {
		/* Acquire, pairs with the release in sutter_close: makes items visible that were pushed before the close. */
		bool closed = atomic_load_explicit(&queue->closed, memory_order_acquire);
		next = closed ? atomic_load_explicit(&old->next, memory_order_acquire) : NULL; /* pairs with sutter_push */
		if (!next) {
			unlock(&queue->consumer_lock);
			return closed ? -EPIPE : -EAGAIN;
		}
	}
	void **box = next->box;
	next->box = NULL;
	queue->first = next;
	unlock(&queue->consumer_lock);
	*item = *box;
	free(box);
	free(old);
	return 0;
}

static int sutter_push_n(stilb_job_queue *base, void *const *items, size_t count, uint32_t thread)
{
	for (size_t i = 0; i < count; i++) {
		int error = sutter_push(base, items[i], thread);
		if (error)
			return i ? (int)i : error;
	}
	return (int)count;
}

static int sutter_pop_n(stilb_job_queue *base, void **items, size_t max, uint32_t thread)
{
	for (size_t i = 0; i < max; i++) {
		int error = sutter_pop(base, &items[i], thread);
		if (error)
			return i ? (int)i : error;
	}
	return (int)max;
}

static bool sutter_empty(stilb_job_queue *base, uint32_t thread)
{
	(void)thread;
	sutter *queue = (sutter *)base;
	lock(&queue->consumer_lock);
	bool empty = !atomic_load_explicit(&queue->first->next, memory_order_acquire); /* pairs with sutter_push */
	unlock(&queue->consumer_lock);
	return empty;
}

static void sutter_close(stilb_job_queue *base)
{
	sutter *queue = (sutter *)base;
	lock(&queue->producer_lock);
	atomic_store_explicit(&queue->closed, true, memory_order_release); /* pairs with sutter_pop */
	unlock(&queue->producer_lock);
}

static void sutter_rest(stilb_job_queue *base, uint32_t thread)
{
	(void)base, (void)thread;
}

static void sutter_destroy(stilb_job_queue *base)
{
	sutter *queue = (sutter *)base;
	for (node *at = queue->first, *next; at; at = next) {
		next = atomic_load_explicit(&at->next, memory_order_relaxed); /* relaxed: no other thread uses the queue */
		free(at->box);
		free(at);
	}
	free(queue);
}

int queue_sutter_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	static const job_queue_ops ops = {sutter_push,  sutter_push_n, sutter_pop,  sutter_pop_n,
	                                  sutter_empty, sutter_close,  sutter_rest, sutter_destroy};
	*queue = NULL;
	if (desc->capacity != SIZE_MAX)
		return -EINVAL;
	sutter *made = aligned_alloc(LINE, sizeof *made);
	node *first = calloc(1, sizeof *first);
	if (!made || !first) {
		free(made);
		free(first);
		return -ENOMEM;
	}
	*made = (sutter){.base.ops = &ops, .first = first, .last = first};
	*queue = &made->base;
	return 0;
}
