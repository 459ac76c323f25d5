/*
 * job_spsc: an unbounded FIFO queue of pointers from one thread to one other thread. Usable alone.
 *
 * Overview.     For places where one thread feeds one other thread: the reader of a gamepad, the writer of a trace. It
 *               is a list of blocks of cells. A cell that is not NULL holds an item; nothing else is shared, so an item
 *               costs the move of its cell from one CPU to the other. Only the producer allocates, and it reuses the
 *               blocks that the consumer has left.
 * Progress.     Pop and close are wait-free: they take a bounded number of steps whatever the other thread does, even
 *               if it has stopped. So does push, except when it must allocate (see Memory), since that may take a
 *               lock, or wake a waiting consumer, which enters the kernel.
 * Life cycle.   stilb_job_spsc_create -> push by one thread, pop by one other thread -> close (optional) -> destroy.
 *               Either end may move to another thread if the program synchronises that hand-over.
 * Example.
 *                   stilb_job_spsc *queue;                             // shared by both threads
 *                   if (stilb_job_spsc_create(&queue) != 0) ...
 *                   stilb_job_spsc_push(queue, item);                  // producer
 *                   while (stilb_job_spsc_pop(queue, &item) == 0) ...  // consumer
 *                   stilb_job_spsc_destroy(queue);                     // after both have ended
 * Threads.      [producer]: the thread that pushes; [consumer]: the thread that pops; [any-thread]: every thread.
 * Items.        Pointers that are not NULL; the queue does not follow them. Everything the producer wrote before it
 *               pushed an item is visible to the consumer that popped it, and everything it wrote before it closed the
 *               queue to the consumer that was told so by -EPIPE.
 * Memory.       8 bytes an item, in blocks of 511 items. Blocks that the consumer has left are reused: a queue has at
 *               most two blocks more than its longest length filled, and allocates nothing once it has those. Only
 *               stilb_job_spsc_destroy frees them.
 * Waiting.      The consumer of an empty queue decides whether to do something else or to sleep, in
 *               stilb_job_spsc_pop_wait, until there is an item. No other function waits.
 * Errors.       Functions return 0 or a negative errno value. They print nothing, and call nothing back but
 *               the allocator.
 *
 * Sources: Herb Sutter, "Writing Lock-Free Code: A Corrected Queue", Dr. Dobb's Journal, October 2008, a list that the
 * producer alone changes; John Giacomoni, Tipp Moseley, Manish Vachharajani, "FastForward for Efficient Pipeline
 * Parallelism", PPoPP 2008, cells that say themselves whether they are empty.
 */
#ifndef STILB_JOB_SPSC_H
#define STILB_JOB_SPSC_H

#include "job_memory.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Created by stilb_job_spsc_create. */
typedef struct stilb_job_spsc stilb_job_spsc;

/* Creates an empty queue. -ENOMEM: no memory, and *queue is NULL. [any-thread] */
int stilb_job_spsc_create(stilb_job_spsc **queue);

/* stilb_job_spsc_create with memory from a copy of the allocator, which create, push and destroy call; NULL: the C
 * library. -EINVAL: it has only one of its functions. [any-thread] */
int stilb_job_spsc_create_with(const stilb_job_allocator *allocator, stilb_job_spsc **queue);

/* Frees the queue; items still in it are dropped. queue may be NULL. No other call may be in progress. [any-thread] */
void stilb_job_spsc_destroy(stilb_job_spsc *queue);

/* Appends item. -EPIPE: the queue is closed; -ENOMEM: no memory; -EINVAL: item is NULL. After an error the queue is
 * unchanged and the item still belongs to the caller. [producer] */
int stilb_job_spsc_push(stilb_job_spsc *queue, void *item);

/* Takes the oldest item and stores it in *item. -EAGAIN: the queue is empty; -EPIPE: it is closed and empty, for good.
 * After an error *item is unchanged. [consumer] */
int stilb_job_spsc_pop(stilb_job_spsc *queue, void **item);

/* stilb_job_spsc_pop that waits while the queue is empty, timeout_ns nanoseconds at most; UINT64_MAX: without limit. It
 * tries for 5 us and then sleeps, which costs no CPU. -ETIMEDOUT: the queue was empty all the time; -EPIPE: it is
 * closed and empty, for good. [consumer] */
int stilb_job_spsc_pop_wait(stilb_job_spsc *queue, void **item, uint64_t timeout_ns);

/* Refuses pushes from now on, and ends stilb_job_spsc_pop_wait; items in the queue can still be popped. May be called
 * more than once. [producer] */
void stilb_job_spsc_close(stilb_job_spsc *queue);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
