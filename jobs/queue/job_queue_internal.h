/*
 * job_queue_internal: the operations that a kind of queue implements. Tests and benchmarks implement them for further
 * queues, to run the same checks on those, and the pool on top of them.
 */
#ifndef STILB_JOB_QUEUE_INTERNAL_H
#define STILB_JOB_QUEUE_INTERNAL_H

#include "jobs/job_queue.h"
#include "jobs/queue/job_event.h"

/* Each operation implements the function of job_queue.h of the same name, which has checked the arguments: items are
 * not NULL, and count and max are 1..INT32_MAX. A push ends with job_event_signal(&queue->items, pushed) and a pop with
 * job_event_signal(&queue->space, popped); a kind that does not do so can be used, but not waited for. */
typedef struct job_queue_ops {
	int (*push)(stilb_job_queue *queue, void *item, uint32_t thread);
	int (*push_n)(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread);
	int (*pop)(stilb_job_queue *queue, void **item, uint32_t thread);
	int (*pop_n)(stilb_job_queue *queue, void **items, size_t max, uint32_t thread);
	bool (*empty)(stilb_job_queue *queue, uint32_t thread);
	void (*close)(stilb_job_queue *queue);
	void (*rest)(stilb_job_queue *queue, uint32_t thread);
	void (*destroy)(stilb_job_queue *queue);
} job_queue_ops;

/* The first member of the struct of every kind of queue. The kind sets ops, by which job_queue.c finds its operations,
 * and the rest to 0. Written only when threads wait, so every CPU keeps a copy of this cache line. */
struct stilb_job_queue {
	const job_queue_ops *ops;
	job_event items; /* for pops that wait */
	job_event space; /* for pushes that wait */
};

/* Create a queue of one kind. 0 or -ENOMEM; the caller has checked that desc is in range. */
int job_queue_low_lock_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

#endif
