#include "jobs/job_spsc.h"

#include "jobs/job_contract.h"
#include "jobs/job_line.h"

#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/*
 * The list of Sutter's article (job_spsc.h names it):   first ... divider ... last
 *
 * A node of the list is a cell of a block. The next node is the next cell; after the last cell of a block it is the
 * first cell of the following block. So the list needs no pointer and no malloc per node. The nodes up to and including
 * divider have been consumed; those after divider, up to and including last, hold items. The queue is empty if divider
 * equals last. There is always one consumed node between the two ends, so they never touch the same cell.
 *
 *   producer   writes the item, then publishes last; reuses the blocks before the one that holds divider
 *   consumer   copies the item, then publishes divider
 *
 * All other memory is plain: whatever an end reads of it was written before the other end published.
 */
#ifndef JOB_SPSC_BLOCK_CELLS
#define JOB_SPSC_BLOCK_CELLS 511 /* 4 KiB together with the link */
#endif

typedef struct job_spsc_block {
	struct job_spsc_block *next; /* set once last has left this block */
	void *cells[JOB_SPSC_BLOCK_CELLS];
} job_spsc_block;

struct stilb_job_spsc {
	/* Written by the producer alone. */
	alignas(JOB_LINE) _Atomic(void **) last;
	_Atomic bool closed;
	job_spsc_block *first;   /* the oldest block */
	job_spsc_block *writing; /* the block that last points into */
	job_exclusive producer;

	/* Written by the consumer alone. */
	alignas(JOB_LINE) _Atomic(void **) divider;
	void **seen;             /* `last` as the consumer last read it; read again when all nodes up to it are consumed */
	job_spsc_block *reading; /* the block that divider points into */
	job_exclusive consumer;
};

static bool block_holds(const job_spsc_block *block, void **cell)
{
	/* As integers, since C does not define the difference of pointers into different blocks. For a cell at a lower
	 * address than the block the difference wraps around to a large number. */
	return (uintptr_t)cell - (uintptr_t)block->cells < sizeof block->cells;
}

/* Returns a block to follow the full one: a block that the consumer has left, or a new one. NULL: no memory. */
static job_spsc_block *block_take(stilb_job_spsc *queue)
{
	/* Acquire pairs with the release in pop: the consumer has finished reading the blocks before divider's block. */
	void **divider = atomic_load_explicit(&queue->divider, memory_order_acquire);
	job_spsc_block *block = queue->first;
	if (block_holds(block, divider))
		return malloc(sizeof *block);
	queue->first = block->next;
	assert(block != queue->writing && queue->first && "the divider is in a later block");
	return block;
}

int stilb_job_spsc_create(stilb_job_spsc **created)
{
	assert(created);
	*created = NULL;
	stilb_job_spsc *queue = aligned_alloc(JOB_LINE, sizeof *queue);
	job_spsc_block *block = malloc(sizeof *block);
	if (!queue || !block) {
		free(block);
		free(queue);
		return -ENOMEM;
	}
	void **consumed = block->cells; /* the consumed node between the ends; no item was ever in it */
	atomic_init(&queue->last, consumed);
	atomic_init(&queue->closed, false);
	queue->first = queue->writing = block;
	atomic_init(&queue->divider, consumed);
	queue->seen = consumed;
	queue->reading = block;
	queue->producer = queue->consumer = (job_exclusive){0};
	*created = queue;
	return 0;
}

void stilb_job_spsc_destroy(stilb_job_spsc *queue)
{
	if (!queue)
		return;
	queue->writing->next = NULL; /* the newest block, whose link has not been set yet */
	for (job_spsc_block *block = queue->first; block;) {
		job_spsc_block *next = block->next;
		free(block);
		block = next;
	}
	free(queue);
}

/* For asserts: last lies in the block that is being filled. [producer] */
static bool producer_is_sound(const stilb_job_spsc *queue)
{
	return block_holds(queue->writing,
	                   atomic_load_explicit(&queue->last, memory_order_relaxed)); /* the producer's own */
}

/* For asserts: divider lies in the block that is being emptied. [consumer] */
static bool consumer_is_sound(const stilb_job_spsc *queue)
{
	/* Relaxed: the consumer's own. */
	return block_holds(queue->reading, atomic_load_explicit(&queue->divider, memory_order_relaxed));
}

static int spsc_push(stilb_job_spsc *queue, void *item)
{
	/* Relaxed, both: only the producer, the calling thread, writes closed and last. */
	if (atomic_load_explicit(&queue->closed, memory_order_relaxed))
		return -EPIPE;
	void **last = atomic_load_explicit(&queue->last, memory_order_relaxed);
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
	/* Release pairs with the acquire in pop: the link and the item are written before last says so. */
	atomic_store_explicit(&queue->last, node, memory_order_release);
	return 0;
}

int stilb_job_spsc_push(stilb_job_spsc *queue, void *item)
{
	assert(queue);
	if (!item)
		return -EINVAL;
	job_exclusive_begin(&queue->producer);
	int result = spsc_push(queue, item);
	JOB_CHECK(producer_is_sound(queue));
	job_exclusive_end(&queue->producer);
	return result;
}

static int spsc_pop(stilb_job_spsc *queue, void **item)
{
	void **divider = atomic_load_explicit(&queue->divider, memory_order_relaxed); /* the consumer's own */
	if (divider == queue->seen) {
		/* Closed is loaded before last: a consumer that sees the queue closed (acquire pairs with the release in close)
		 * then sees the final last. Acquire of last pairs with the release in push. */
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
	assert(*item && "push refuses NULL");
	/* Release pairs with the acquire in block_take: the item and the link have been read before the producer may
	 * overwrite them. */
	atomic_store_explicit(&queue->divider, node, memory_order_release);
	return 0;
}

int stilb_job_spsc_pop(stilb_job_spsc *queue, void **item)
{
	assert(queue && item);
	job_exclusive_begin(&queue->consumer);
	int result = spsc_pop(queue, item);
	JOB_CHECK(consumer_is_sound(queue));
	job_exclusive_end(&queue->consumer);
	return result;
}

void stilb_job_spsc_close(stilb_job_spsc *queue)
{
	assert(queue);
	job_exclusive_begin(&queue->producer);
	atomic_store_explicit(&queue->closed, true, memory_order_release); /* pairs with the acquire in pop */
	job_exclusive_end(&queue->producer);
}
