/*
 * job_queue: an unbounded multi-producer, multi-consumer FIFO of jobs.
 *
 * Sutter's generalised concurrent queue (Dr. Dobb's Journal, November 2008; the two-lock queue of Michael and Scott,
 * PODC 1996, with spin locks): a list with one lock for producers and one for consumers. The first node is a dummy whose
 * item has been consumed, so the ends never touch the same node's item, and all they share is the last node's `next`:
 * stored with release by the producer that appends, loaded with acquire by the consumer that takes. Nodes are made
 * and freed outside the locks. Unlike in the article the items, being small and plain, lie in the nodes by value.
 *
 * Promises: linearisable FIFO, in the order in which producers got their lock. Low-lock, not lock-free: a thread
 * stalled inside one of the two sections stops its own end (the other end goes on) until it runs again.
 */
#ifndef STILB_JOB_QUEUE_H
#define STILB_JOB_QUEUE_H

#include "jobs/job.h"
#include "jobs/job_lock.h"

#include <stdalign.h>

typedef struct job_item {
	stilb_job_fn *fn;
	void *data;
	stilb_job_group *group;
} job_item;

typedef struct job_node job_node;

typedef struct job_queue {
	/* first and last are written under their locks; atomic (relaxed) for job_queue_looks_empty alone. */
	alignas(JOB_LINE) _Atomic(job_node *) first;
	alignas(JOB_LINE) job_lock consumer_lock;
	alignas(JOB_LINE) _Atomic(job_node *) last;
	alignas(JOB_LINE) job_lock producer_lock;
} job_queue;

/* 0 or -ENOMEM. */
int job_queue_init(job_queue *queue);

/* Frees what is left, without running it. {0} is fine. [one-writer] */
void job_queue_finish(job_queue *queue);

/* Appends a copy of *item. 0, or -ENOMEM with the queue unchanged. [any-thread] */
int job_queue_push(job_queue *queue, const job_item *item);

/* Takes the oldest item; false when the queue is empty. [any-thread] */
bool job_queue_pop(job_queue *queue, job_item *item);

/* True if the queue was empty at one moment during the call. [any-thread] */
bool job_queue_empty(job_queue *queue);

/* A guess without locks, for deciding whether to look closer; may be wrong while others push and pop. [any-thread] */
bool job_queue_looks_empty(const job_queue *queue);

#endif
