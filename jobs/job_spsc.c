#include "jobs/job_spsc.h"

#include "jobs/job_line.h"

#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/*
 * The list of the article:   first ... divider ... last
 *
 * A node is one cell of a block, the node after it the next cell, and after a block's end the first cell of the block
 * that follows: so a list of nodes without a pointer and a malloc for each. The nodes up to divider, itself included, have
 * been consumed; those after it up to last wait. Divider and last are equal when the queue is empty: there is always one
 * consumed node between the two ends, and they never touch the same cell.
 *
 *   producer   writes the item, then publishes last; uses the blocks before the divider's again
 *   consumer   copies the item, then publishes divider
 *
 * Both do their work first and publish it then. All other memory is plain: what an end reads of it was written before
 * the other end published.
 */
#ifndef JOB_SPSC_BLOCK_CELLS
#define JOB_SPSC_BLOCK_CELLS 511 /* with the link 4 KiB */
#endif

typedef struct job_spsc_block {
	struct job_spsc_block *next; /* valid once last has left this block */
	void *cells[JOB_SPSC_BLOCK_CELLS];
} job_spsc_block;

struct stilb_job_spsc {
	/* the producer's */
	alignas(JOB_LINE) _Atomic(void **) last;
	_Atomic bool closed;
	job_spsc_block *first;   /* the oldest block */
	job_spsc_block *writing; /* the block of last */

	/* the consumer's */
	alignas(JOB_LINE) _Atomic(void **) divider;
	void **seen;             /* last when the consumer looked: only when it has used that up does it look again */
	job_spsc_block *reading; /* the block of divider */
};

static bool block_holds(const job_spsc_block *block, void **cell)
{
	/* As numbers: the cell may be of another block. Below the block the difference wraps to a large number. */
	return (uintptr_t)cell - (uintptr_t)block->cells < sizeof block->cells;
}

/* A block to follow the one that is full: one that the consumer has left, or a new one. NULL: out of memory. */
static job_spsc_block *block_take(stilb_job_spsc *queue)
{
	/* Acquire pairs with the release in pop: the consumer's reads of blocks before the divider are over. */
	void **divider = atomic_load_explicit(&queue->divider, memory_order_acquire);
	job_spsc_block *block = queue->first;
	if (block_holds(block, divider))
		return malloc(sizeof *block);
	queue->first = block->next;
	return block;
}

int stilb_job_spsc_create(stilb_job_spsc **created)
{
	*created = NULL;
	stilb_job_spsc *queue = aligned_alloc(JOB_LINE, sizeof *queue);
	job_spsc_block *block = malloc(sizeof *block);
	if (!queue || !block) {
		free(block);
		free(queue);
		return -ENOMEM;
	}
	void **consumed = block->cells; /* the node between the ends; it never held an item */
	atomic_init(&queue->last, consumed);
	atomic_init(&queue->closed, false);
	queue->first = queue->writing = block;
	atomic_init(&queue->divider, consumed);
	queue->seen = consumed;
	queue->reading = block;
	*created = queue;
	return 0;
}

void stilb_job_spsc_destroy(stilb_job_spsc *queue)
{
	if (!queue)
		return;
	queue->writing->next = NULL; /* the newest block links nowhere yet */
	for (job_spsc_block *block = queue->first; block;) {
		job_spsc_block *next = block->next;
		free(block);
		block = next;
	}
	free(queue);
}

int stilb_job_spsc_push(stilb_job_spsc *queue, void *item)
{
	if (!item)
		return -EINVAL;
	if (atomic_load_explicit(&queue->closed, memory_order_relaxed)) /* the producer's own */
		return -EPIPE;
	void **last = atomic_load_explicit(&queue->last, memory_order_relaxed); /* the producer's own */
	void **node = last + 1;
	if (node == queue->writing->cells + JOB_SPSC_BLOCK_CELLS) {
		job_spsc_block *block = block_take(queue);
		if (!block)
			return -ENOMEM;
		node = block->cells;
		queue->writing->next = block;
		queue->writing = block;
	}
	*node = item;
	/* Release pairs with the acquire in pop: the link and the item are there before last says so. */
	atomic_store_explicit(&queue->last, node, memory_order_release);
	return 0;
}

int stilb_job_spsc_pop(stilb_job_spsc *queue, void **item)
{
	void **divider = atomic_load_explicit(&queue->divider, memory_order_relaxed); /* the consumer's own */
	if (divider == queue->seen) {
		/* Closed before last: who sees that it was closed (acquire pairs with the release in close) sees the final
		 * last. Acquire pairs with the release in push. */
		bool closed = atomic_load_explicit(&queue->closed, memory_order_acquire);
		queue->seen = atomic_load_explicit(&queue->last, memory_order_acquire);
		if (divider == queue->seen)
			return closed ? -EPIPE : -EAGAIN;
	}
	void **node = divider + 1;
	if (node == queue->reading->cells + JOB_SPSC_BLOCK_CELLS) {
		queue->reading = queue->reading->next;
		node = queue->reading->cells;
	}
	*item = *node;
	/* Release pairs with the acquire in block_take: the item and the link have been read before the producer may
	 * write over them. */
	atomic_store_explicit(&queue->divider, node, memory_order_release);
	return 0;
}

void stilb_job_spsc_close(stilb_job_spsc *queue)
{
	atomic_store_explicit(&queue->closed, true, memory_order_release); /* pairs with the acquire in pop */
}
