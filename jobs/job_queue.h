/*
 * job_queue: FIFO queues of pointers for any number of producers and consumers, bounded or unbounded. Usable alone.
 *
 * Two kinds implement one interface. Both are linearizable: there is a single order of all items, and it agrees with
 * the real-time order of the calls.
 *   low-lock    Two locks, one for producers and one for consumers, over reused segments of 1024 cells. The fastest
 *               kind. It is not lock-free: a thread that is preempted inside one of its critical sections, which are a
 *               few instructions long, holds up the other threads at the same end; the other end continues.
 *   lock-free   Segments of cells that are filled and emptied in order, each by one compare-exchange. A thread that is
 *               preempted anywhere holds up nobody. Costs more, and must know its threads (see Threads).
 * Life cycle.   stilb_job_queue_create -> push and pop from any of its threads -> close (optional) -> destroy.
 * Waiting.      Two calls wait: stilb_job_queue_pop_wait for an item, stilb_job_queue_push_wait for space. They try for
 *               5 us and then sleep, so they cost no CPU; close ends them. All other calls return at once (pop_n within
 *               2 us), and cost the same whether or not anybody waits.
 * Example.
 *                   stilb_job_queue_desc desc = stilb_job_queue_desc_default();
 *                   stilb_job_queue *queue;
 *                   if (stilb_job_queue_create(&desc, &queue) == 0) {
 *                       stilb_job_queue_push(queue, item, 0);
 *                       while (stilb_job_queue_pop(queue, &item, 0) == 0)
 *                           use(item);
 *                       stilb_job_queue_destroy(queue);
 *                   }
 * Threads.      A queue is created for thread_count threads. Each of them passes its own number below thread_count to
 *               every call, and no two threads use the same number at the same time. The low-lock kind ignores the
 *               number. A thread that will not use a lock-free queue for a while calls stilb_job_queue_rest: until it
 *               rests or calls again, segments that it might still be reading cannot be reused.
 * Items.        Pointers that are not NULL; the queue does not follow them. Everything a thread wrote before it pushed
 *               an item is visible to the thread that popped it.
 * Errors.       Functions return 0, a count or a negative errno value. They print nothing, and call nothing back but
 *               the allocator.
 */
#ifndef STILB_JOB_QUEUE_H
#define STILB_JOB_QUEUE_H

#include "job_memory.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The most threads that a queue can be created for. */
#define STILB_JOB_QUEUE_MAX_THREADS 1024

/* Created by stilb_job_queue_create. */
typedef struct stilb_job_queue stilb_job_queue;

/* See the head of this file. */
typedef enum stilb_job_queue_kind { STILB_JOB_QUEUE_LOW_LOCK, STILB_JOB_QUEUE_LOCK_FREE } stilb_job_queue_kind;

/* The settings of a queue; start from stilb_job_queue_desc_default. */
typedef struct stilb_job_queue_desc {
	stilb_job_queue_kind kind;
	size_t capacity;                      /* the most items it holds, at least 1; SIZE_MAX: limited by memory alone */
	uint32_t thread_count;                /* 1..STILB_JOB_QUEUE_MAX_THREADS */
	const stilb_job_allocator *allocator; /* where its memory comes from (job_memory.h); NULL: the C library */
} stilb_job_queue_desc;

/* Low-lock, unbounded, for STILB_JOB_QUEUE_MAX_THREADS threads, with memory of the C library. [any-thread] */
stilb_job_queue_desc stilb_job_queue_desc_default(void);

/* Creates an empty queue; the allocator is copied. -EINVAL: kind, capacity or thread_count is out of range, or the
 * allocator has only one of its functions; -ENOMEM: no memory. After an error *queue is NULL. [any-thread] */
int stilb_job_queue_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

/* Frees the queue; items still in it are dropped. queue may be NULL. No other call may be in progress. [any-thread] */
void stilb_job_queue_destroy(stilb_job_queue *queue);

/* Appends item. -EAGAIN: the queue is full; -EPIPE: it is closed; -ENOMEM: no memory; -EINVAL: item is NULL. After an
 * error the queue is unchanged and the item still belongs to the caller. [any-thread] */
int stilb_job_queue_push(stilb_job_queue *queue, void *item, uint32_t thread);

/* Appends items[0] to items[count - 1] in this order; in the lock-free kind, items of other threads may come to lie
 * between them. count is 0..INT32_MAX. Returns how many items were appended, always the first ones; if none was, the
 * error of stilb_job_queue_push. A count of 0 returns 0. In the low-lock kind, a thread that is more than 32,768 items
 * ahead of consumers that do not run may yield its CPU to them. [any-thread] */
int stilb_job_queue_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread);

/* Takes the oldest item and stores it in *item. -EAGAIN: the queue is empty; -EPIPE: it is closed and empty, for good.
 * [any-thread] */
int stilb_job_queue_pop(stilb_job_queue *queue, void **item, uint32_t thread);

/* Takes up to max of the oldest items and stores them in items[0..max), oldest first. Returns how many there were; if
 * none, the error of stilb_job_queue_pop. A max of 0 returns 0. In the low-lock kind, a call that has caught up with
 * producers of batches may give them 0.5 to 2 us before it looks for more items. [any-thread] */
int stilb_job_queue_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread);

/* stilb_job_queue_pop that waits while the queue is empty, timeout_ns nanoseconds at most; UINT64_MAX: without limit.
 * -ETIMEDOUT: the queue was empty all the time; -EPIPE: it is closed and empty, for good. Items of a closed queue are
 * popped first. Several waiting threads are not served in any order. A job of a pool that waits here keeps its worker
 * from other jobs. [any-thread] */
int stilb_job_queue_pop_wait(stilb_job_queue *queue, void **item, uint32_t thread, uint64_t timeout_ns);

/* stilb_job_queue_push that waits while the queue is full, as stilb_job_queue_pop_wait does for an item. -ETIMEDOUT: it
 * was full all the time. [any-thread] */
int stilb_job_queue_push_wait(stilb_job_queue *queue, void *item, uint32_t thread, uint64_t timeout_ns);

/* True if the queue was empty at some moment during the call. Takes no lock. [any-thread] */
bool stilb_job_queue_empty(stilb_job_queue *queue, uint32_t thread);

/* Refuses pushes from now on, and ends the calls that wait for space, and those that wait for an item when all items
 * have been popped. Items in the queue can still be popped. A push in progress either succeeds, and its item
 * can be popped, or is refused. May be called more than once. [any-thread] */
void stilb_job_queue_close(stilb_job_queue *queue);

/* Declares that the calling thread reads no part of the queue until its next call, so that a lock-free queue can reuse
 * all its segments meanwhile (see Threads). Costs a few stores. [any-thread] */
void stilb_job_queue_rest(stilb_job_queue *queue, uint32_t thread);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
