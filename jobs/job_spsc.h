/*
 * job_spsc: an unbounded FIFO queue of pointers from one thread to one other thread. Usable alone.
 *
 * What it is.   Sutter's corrected queue, for the places where one thread feeds one thread: the reader of a game pad, the
 *               writer of a trace. A list whose `divider` parts what has been consumed from what has not; the producer
 *               alone owns memory and uses again what lies before the divider.
 * Guarantee.    Pop and close are wait-free: a bounded number of steps, whatever the other thread does, stalled or not.
 *               So is push as long as it need not allocate (see Memory); a push that does is as good as malloc, which
 *               may take a lock.
 * Life cycle.   stilb_job_spsc_create -> push by one thread, pop by one other -> close (optional) -> destroy. Either end
 *               may be handed to another thread if that hand-over is itself synchronised.
 * Threads.      [producer]: the one thread that pushes; [consumer]: the one that pops; [any-thread].
 * Items.        Pointers, never null; the queue does not look at what they point to. What the producer wrote before it
 *               pushed an item is visible to the consumer that popped it.
 * Memory.       8 bytes an item, in blocks of 511 items. Blocks that the consumer has left are used again: a queue has at
 *               most two more than its fullest moment filled, and from then on allocates nothing. They are freed by
 *               stilb_job_spsc_destroy alone.
 * Errors.       0 or a negative errno. Nothing here prints, waits or calls back: a consumer that finds the queue empty
 *               decides itself whether to spin, sleep or do something else.
 *
 * Source: Herb Sutter, "Writing Lock-Free Code: A Corrected Queue", Dr. Dobb's Journal, October 2008.
 */
#ifndef STILB_JOB_SPSC_H
#define STILB_JOB_SPSC_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stilb_job_spsc stilb_job_spsc;

/* 0 or -ENOMEM; after an error *queue is NULL. [any-thread] */
int stilb_job_spsc_create(stilb_job_spsc **queue);

/* Frees the queue; items in it are forgotten. NULL is fine. No other call may be running. [any-thread] */
void stilb_job_spsc_destroy(stilb_job_spsc *queue);

/* Appends item. -EPIPE: closed; -ENOMEM; -EINVAL: item is NULL. After an error the queue is as before and the item still
 * the caller's. [producer] */
int stilb_job_spsc_push(stilb_job_spsc *queue, void *item);

/* Takes the oldest item. -EAGAIN: empty; -EPIPE: closed and empty, and so it stays. After an error *item is as before.
 * [consumer] */
int stilb_job_spsc_pop(stilb_job_spsc *queue, void **item);

/* From now on pushes are refused; what is in the queue can still be popped. May be called more than once. [producer] */
void stilb_job_spsc_close(stilb_job_spsc *queue);

#ifdef __cplusplus
}
#endif
#endif
