/*
 * job_queue_internal: what every kind of queue implements. Tests and benchmarks put other queues behind the same
 * operations and run the same checks on them, and the pool on top of them.
 */
#ifndef STILB_JOB_QUEUE_INTERNAL_H
#define STILB_JOB_QUEUE_INTERNAL_H

#include "jobs/job_queue.h"

/* Each does what the function of job_queue.h with that name promises; arguments have been checked there: no null item, no
 * count of 0. */
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

/* The first member of every kind's own struct. */
struct stilb_job_queue {
	const job_queue_ops *ops;
};

/* 0 or -ENOMEM. */
int job_queue_low_lock_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

#endif
