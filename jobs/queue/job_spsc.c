#include "jobs/job_spsc.h"

#include "jobs/job_allocate.h"
#include "jobs/job_contract.h"
#include "jobs/job_line.h"
#include "jobs/queue/job_event.h"

#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/*
 * The cells are the queue; no count or position is shared. NULL in a cell means that nothing has been pushed there yet.
 * So an item moves the cache line of its cell from one CPU to the other, and no other line.
 *
 *   producer   fills the cells of a block in order; at the end of the block it links another one
 *   consumer   looks at its next cell; if that is not NULL, it takes the item, and later clears the cell; at the end of
 *              a block it follows the link
 *
 * Blocks.    The consumer publishes which block it reads, once a block. The producer reuses the blocks before that one;
 *            their cells are clear.
 * Closing.   The producer stores END, which is no item, in the next cell, or in the link at the end of a block. Since
 *            this needs no memory, it cannot fail. The consumer never passes END.
 * Clearing.  The consumer clears cells a cache line at a time, after it has taken the last item of the line: a store
 *            takes the line away from the producer, which is perhaps still filling it.
 *
 * Sources (job_spsc.h has their titles): NULL as the only signal is FastForward's, which has a ring of fixed size. The
 * list of which the producer reuses what the consumer has left is Sutter's, with a block for each of his nodes.
 */
#ifndef JOB_SPSC_BLOCK_CELLS
#define JOB_SPSC_BLOCK_CELLS 511 /* 4 KiB together with the link */
#endif

#define CACHE_LINE 64 /* bytes; cells are cleared in groups of this size */

typedef _Atomic(void *) job_spsc_cell;

typedef struct job_spsc_block job_spsc_block;

struct job_spsc_block {
	alignas(CACHE_LINE) job_spsc_cell cells[JOB_SPSC_BLOCK_CELLS]; /* filled with release, read with acquire */
	_Atomic(job_spsc_block *) next;                                /* set with release, followed with acquire */
};

struct stilb_job_spsc {
	/* The producer's. */
	alignas(JOB_LINE) job_spsc_cell *write; /* the next cell to fill, or the end of the block */
	job_spsc_block *writing;                /* the block in which that cell lies */
	job_spsc_block *first;                  /* the oldest block */
	bool closed;
	job_exclusive producer;
	job_event items; /* written by the consumer only when it waits */
	stilb_job_allocator memory;

	/* The consumer's. */
	alignas(JOB_LINE) job_spsc_cell *read; /* the next cell to take from, or the end of the block */
	/* The block in which that cell lies. Release, pairs with the acquire in block_take. */
	_Atomic(job_spsc_block *) reading;
	job_exclusive consumer;
};

static char end_mark;
#define END ((void *)&end_mark)

static job_spsc_block *block_create(const stilb_job_allocator *memory)
{
	job_spsc_block *block = job_allocate(memory, sizeof *block, alignof(job_spsc_block));
	if (block)
		memset(block, 0, sizeof *block);
	return block;
}

/* Returns a block to follow the full one: a block that the consumer has left, or a new one. NULL: no memory. */
static job_spsc_block *block_take(stilb_job_spsc *queue)
{
	/* Acquire pairs with the release in block_follow: the consumer has cleared the blocks before this one, and read
	 * their links. */
	job_spsc_block *block = queue->first, *reading = atomic_load_explicit(&queue->reading, memory_order_acquire);
	if (block == reading)
		return block_create(&queue->memory);
	assert(block != queue->writing && "the consumer is in a later block");
	queue->first = atomic_load_explicit(&block->next, memory_order_relaxed); /* the producer's own store */
	/* Relaxed, as the block is not linked yet. */
	atomic_store_explicit(&block->next, NULL, memory_order_relaxed);
	return block;
}

int stilb_job_spsc_create(stilb_job_spsc **queue)
{
	return stilb_job_spsc_create_with(NULL, queue);
}

int stilb_job_spsc_create_with(const stilb_job_allocator *allocator, stilb_job_spsc **created)
{
	assert(created);
	*created = NULL;
	if (!job_allocator_is_whole(allocator))
		return -EINVAL;
	stilb_job_allocator memory = job_allocator_of(allocator);
	stilb_job_spsc *queue = job_allocate(&memory, sizeof *queue, JOB_LINE);
	job_spsc_block *block = block_create(&memory);
	if (!queue || !block) {
		job_release(&memory, block, sizeof *block);
		job_release(&memory, queue, sizeof *queue);
		return -ENOMEM;
	}
	memset(queue, 0, sizeof *queue);
	queue->memory = memory;
	queue->first = queue->writing = block;
	atomic_init(&queue->reading, block);
	queue->write = queue->read = block->cells;
	*created = queue;
	return 0;
}

void stilb_job_spsc_destroy(stilb_job_spsc *queue)
{
	if (!queue)
		return;
	stilb_job_allocator memory = queue->memory;
	for (job_spsc_block *block = queue->first; block && block != END;) {
		/* Relaxed: no other call is in progress. */
		job_spsc_block *next = atomic_load_explicit(&block->next, memory_order_relaxed);
		job_release(&memory, block, sizeof *block);
		block = next;
	}
	job_release(&memory, queue, sizeof *queue);
}

static job_spsc_cell *block_end(job_spsc_block *block)
{
	return block->cells + JOB_SPSC_BLOCK_CELLS;
}

/* For asserts: the next cell to fill lies in the block that is being filled, and is clear. [producer] */
static bool producer_is_sound(const stilb_job_spsc *queue)
{
	if (queue->write == block_end(queue->writing))
		return true;
	/* Relaxed: the producer's own, since the consumer stores only in cells that have been filled. */
	return queue->write >= queue->writing->cells && queue->write < block_end(queue->writing) &&
	       (queue->closed || !atomic_load_explicit(queue->write, memory_order_relaxed));
}

/* For asserts: the next cell to take from lies in the block that is being emptied. [consumer] */
static bool consumer_is_sound(stilb_job_spsc *queue)
{
	job_spsc_block *reading = atomic_load_explicit(&queue->reading, memory_order_relaxed); /* the consumer's own */
	return queue->read >= reading->cells && queue->read <= block_end(reading);
}

static int spsc_push(stilb_job_spsc *queue, void *item)
{
	if (queue->closed)
		return -EPIPE;
	if (queue->write == block_end(queue->writing)) {
		job_spsc_block *block = block_take(queue);
		if (!block)
			return -ENOMEM;
		/* Release pairs with the acquire in block_follow: the cells are seen as NULL until they are filled. */
		atomic_store_explicit(&queue->writing->next, block, memory_order_release);
		queue->writing = block;
		queue->write = block->cells;
	}
	/* Release pairs with the acquire in spsc_pop: what the producer wrote before is visible with the item. */
	atomic_store_explicit(queue->write, item, memory_order_release);
	queue->write++;
	return 0;
}

int stilb_job_spsc_push(stilb_job_spsc *queue, void *item)
{
	assert(queue);
	if (!item)
		return -EINVAL;
	job_exclusive_begin(&queue->producer);
	int result = spsc_push(queue, item);
	if (result == 0)
		job_event_signal(&queue->items, 1);
	JOB_CHECK(producer_is_sound(queue));
	job_exclusive_end(&queue->producer);
	return result;
}

static bool line_begins(const job_spsc_cell *cell)
{
	return (uintptr_t)cell % CACHE_LINE == 0;
}

/* Clears the cells in the line of the last cell that was taken, from the begin of the line up to this cell. */
static void clear_line(stilb_job_spsc *queue)
{
	job_spsc_cell *cell = queue->read;
	do {
		cell--;
		/* Relaxed: ordered before a reuse by the release in block_follow. */
		atomic_store_explicit(cell, NULL, memory_order_relaxed);
	} while (!line_begins(cell));
}

/* Called at the end of a block: moves on to the next one. Returns 0, or the error of a pop if there is no next one. */
static int block_follow(stilb_job_spsc *queue)
{
	/* Relaxed: the consumer's own. Acquire pairs with the release in spsc_push or close. */
	job_spsc_block *block = atomic_load_explicit(&queue->reading, memory_order_relaxed);
	job_spsc_block *next = atomic_load_explicit(&block->next, memory_order_acquire);
	if (!next)
		return -EAGAIN;
	if (next == END)
		return -EPIPE;
	if (!line_begins(queue->read))
		clear_line(queue);
	queue->read = next->cells;
	/* Release pairs with the acquire in block_take: the block has been cleared and its link been read. */
	atomic_store_explicit(&queue->reading, next, memory_order_release);
	return 0;
}

static int spsc_pop(stilb_job_spsc *queue, void **item)
{
	/* Relaxed: the consumer's own. */
	if (queue->read == block_end(atomic_load_explicit(&queue->reading, memory_order_relaxed))) {
		int error = block_follow(queue);
		if (error != 0)
			return error;
	}
	void *found = atomic_load_explicit(queue->read, memory_order_acquire); /* pairs with the release in push or close */
	if (!found)
		return -EAGAIN;
	if (found == END)
		return -EPIPE;
	*item = found;
	queue->read++;
	if (line_begins(queue->read))
		clear_line(queue);
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

/* The arguments of a call that waits. */
typedef struct spsc_waiting_call {
	stilb_job_spsc *queue;
	void **item;
} spsc_waiting_call;

static int spsc_pop_again(void *context)
{
	const spsc_waiting_call *call = context;
	return stilb_job_spsc_pop(call->queue, call->item);
}

int stilb_job_spsc_pop_wait(stilb_job_spsc *queue, void **item, uint64_t timeout_ns)
{
	int error = stilb_job_spsc_pop(queue, item);
	if (error != -EAGAIN)
		return error;
	return job_event_wait(&queue->items, spsc_pop_again, &(spsc_waiting_call){queue, item}, timeout_ns);
}

void stilb_job_spsc_close(stilb_job_spsc *queue)
{
	assert(queue);
	job_exclusive_begin(&queue->producer);
	queue->closed = true;
	/* Release, both, pair with the acquire in block_follow and spsc_pop: what the producer wrote before is visible. */
	if (queue->write == block_end(queue->writing))
		atomic_store_explicit(&queue->writing->next, END, memory_order_release);
	else
		atomic_store_explicit(queue->write, END, memory_order_release);
	job_event_signal(&queue->items, JOB_EVENT_ALL);
	job_exclusive_end(&queue->producer);
}
