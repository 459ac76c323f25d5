/*
 * job_queue: unbounded or bounded multi-producer, multi-consumer FIFO queues of pointers. Usable alone.
 *
 * Two kinds behind one interface; both are linearisable FIFOs: there is one order of all items, and it agrees with the
 * real-time order of the calls.
 *   low-lock    Sutter's two locks, one for producers and one for consumers, over recycled segments of 512 cells. The
 *               fastest. Not lock-free: a thread stalled inside one of its sections (a few instructions long) stops
 *               its own side for as long as it is stalled; the other side goes on.
 *   lock-free   Segments whose cells are filled and emptied in order, each by a compare-exchange. A thread stalled anywhere
 *               stops nobody. Costs more, and needs to know its threads (see below).
 * Life cycle.   stilb_job_queue_create -> push / pop from any of its threads -> close (optional) -> destroy.
 * Threads.      A queue is made for thread_count threads. Each passes its own number below that to every call, and no two
 *               threads use one number at the same time. The low-lock kind ignores the number. A thread of a lock-free
 *               queue that will not call for a while says so with stilb_job_queue_rest: segments that it might still be
 *               reading cannot be used again until it calls or rests.
 * Items.        Pointers, never null; the queue does not look at what they point to. What a thread wrote before it pushed
 *               an item is visible to the thread that popped it.
 * Errors.       0, a count, or a negative errno. Nothing here prints, blocks for long or calls back.
 */
#ifndef STILB_JOB_QUEUE_H
#define STILB_JOB_QUEUE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STILB_JOB_QUEUE_MAX_THREADS 1024

typedef struct stilb_job_queue stilb_job_queue;

typedef enum stilb_job_queue_kind { STILB_JOB_QUEUE_LOW_LOCK, STILB_JOB_QUEUE_LOCK_FREE } stilb_job_queue_kind;

typedef struct stilb_job_queue_desc {
	stilb_job_queue_kind kind;
	size_t capacity;       /* items it holds at most; SIZE_MAX: as many as memory can hold; 0 is refused */
	uint32_t thread_count; /* 1..STILB_JOB_QUEUE_MAX_THREADS */
} stilb_job_queue_desc;

/* Low-lock, unbounded, STILB_JOB_QUEUE_MAX_THREADS threads. [any-thread] */
stilb_job_queue_desc stilb_job_queue_desc_default(void);

/* -EINVAL: unknown kind, capacity 0 or thread_count out of range; -ENOMEM. After an error *queue is NULL. [any-thread] */
int stilb_job_queue_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

/* Frees the queue; items in it are forgotten. NULL is fine. No other call may be running. [one-writer] */
void stilb_job_queue_destroy(stilb_job_queue *queue);

/* Appends item. -EAGAIN: full; -EPIPE: closed; -ENOMEM; -EINVAL: item is NULL. After an error the queue is as before and
 * the item still the caller's. [any-thread] */
int stilb_job_queue_push(stilb_job_queue *queue, void *item, uint32_t thread);

/* Appends items[0..count) in this order; those of other threads may come to lie between them only in the lock-free
 * kind. Returns how many were appended, always the first ones; if that is none, the error of stilb_job_queue_push.
 * count: 0..INT32_MAX, 0 returns 0. [any-thread] */
int stilb_job_queue_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread);

/* Takes the oldest item. -EAGAIN: empty; -EPIPE: closed and empty, and so it stays. [any-thread] */
int stilb_job_queue_pop(stilb_job_queue *queue, void **item, uint32_t thread);

/* Takes up to max of the oldest items, oldest first. Returns how many; if that is none, the error of
 * stilb_job_queue_pop. [any-thread] */
int stilb_job_queue_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread);

/* True if the queue was empty at one moment during the call. Takes no lock. [any-thread] */
bool stilb_job_queue_empty(stilb_job_queue *queue, uint32_t thread);

/* From now on pushes are refused; what is in the queue can still be popped. Pushes that run at the same moment either
 * succeed, and their items come out, or are refused. May be called more than once. [any-thread] */
void stilb_job_queue_close(stilb_job_queue *queue);

/* This thread holds nothing of the queue until its next call. Cheap. [any-thread] */
void stilb_job_queue_rest(stilb_job_queue *queue, uint32_t thread);

#ifdef __cplusplus
}
#endif
#endif
