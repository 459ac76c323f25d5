#include "jobs/job_queue.h"

#include <errno.h>
#include <stdlib.h>

struct job_node {
	_Atomic(job_node *) next; /* release in push, pairs with acquire in pop and empty; null at the end */
	job_item item;
};

static job_node *node_create(const job_item *item)
{
	job_node *node = malloc(sizeof *node);
	if (node) {
		atomic_init(&node->next, NULL);
		node->item = *item;
	}
	return node;
}

int job_queue_init(job_queue *queue)
{
	job_node *dummy = node_create(&(job_item){0});
	if (!dummy)
		return -ENOMEM;
	atomic_init(&queue->first, dummy);
	atomic_init(&queue->last, dummy);
	atomic_init(&queue->consumer_lock.held, false);
	atomic_init(&queue->producer_lock.held, false);
	return 0;
}

void job_queue_finish(job_queue *queue)
{
	/* Relaxed throughout: the caller is alone. */
	job_node *node = atomic_load_explicit(&queue->first, memory_order_relaxed);
	while (node) {
		job_node *next = atomic_load_explicit(&node->next, memory_order_relaxed);
		free(node);
		node = next;
	}
	atomic_store_explicit(&queue->first, NULL, memory_order_relaxed);
	atomic_store_explicit(&queue->last, NULL, memory_order_relaxed);
}

int job_queue_push(job_queue *queue, const job_item *item)
{
	job_node *node = node_create(item);
	if (!node)
		return -ENOMEM;
	job_lock_take(&queue->producer_lock);
	job_node *last = atomic_load_explicit(&queue->last, memory_order_relaxed); /* ordered by the lock */
	/* Release: whoever sees the node through next sees its item. From here on consumers may take it; `last` stays
	 * valid all the same, for the newest node is the dummy they leave behind. */
	atomic_store_explicit(&last->next, node, memory_order_release);
	atomic_store_explicit(&queue->last, node, memory_order_relaxed);
	job_lock_give(&queue->producer_lock);
	return 0;
}

bool job_queue_pop(job_queue *queue, job_item *item)
{
	job_lock_take(&queue->consumer_lock);
	job_node *dummy = atomic_load_explicit(&queue->first, memory_order_relaxed); /* ordered by the lock */
	job_node *node = atomic_load_explicit(&dummy->next, memory_order_acquire);   /* pairs with push */
	if (!node) {
		job_lock_give(&queue->consumer_lock);
		return false;
	}
	*item = node->item; /* inside the lock: once node is the dummy, the next consumer frees it */
	atomic_store_explicit(&queue->first, node, memory_order_relaxed);
	job_lock_give(&queue->consumer_lock);
	free(dummy);
	return true;
}

bool job_queue_empty(job_queue *queue)
{
	job_lock_take(&queue->consumer_lock); /* keeps the dummy from being freed under the load */
	job_node *dummy = atomic_load_explicit(&queue->first, memory_order_relaxed);
	bool empty = !atomic_load_explicit(&dummy->next, memory_order_acquire); /* pairs with push */
	job_lock_give(&queue->consumer_lock);
	return empty;
}

bool job_queue_looks_empty(const job_queue *queue)
{
	/* Addresses are compared, never followed: the nodes may be gone already. Relaxed: a guess. */
	return atomic_load_explicit(&queue->first, memory_order_relaxed) ==
	       atomic_load_explicit(&queue->last, memory_order_relaxed);
}
