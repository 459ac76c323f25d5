/*
 * queue_subjects: queues of other designs with the interface of stilb_job_queue (jobs/queue/job_queue_internal.h), with
 * which benchmarks and tests compare Stilb's own:
 *
 *   stilb_job_queue_desc desc = stilb_job_queue_desc_default();
 *   stilb_job_queue *queue;
 *   if (queue_mutex_create(&desc, &queue) == 0)
 *       ... stilb_job_queue_push, _pop, ..., stilb_job_queue_destroy(queue);
 *
 *   sutter  the queue of Herb Sutter, "Writing a Generalized Concurrent Queue" (Dr. Dobb's Journal, November 2008): two
 *           spin locks, one for each end; a node and a box allocated for each item. Unbounded only.
 *   mutex   a linked list under one pthread mutex.
 *   kernel  the same list behind a lock that enters the kernel for every lock and unlock.
 * All of them push and pop batches item by item.
 */
#ifndef STILB_BENCH_QUEUE_SUBJECTS_H
#define STILB_BENCH_QUEUE_SUBJECTS_H

#include "jobs/queue/job_queue_internal.h"

/* Return 0 or -ENOMEM; queue_sutter_create also -EINVAL if desc->capacity is not SIZE_MAX, queue_kernel_create also
 * eventfd's error. On errors *queue is NULL. The functions are [any-thread], and so are the queues' operations. */
int queue_sutter_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int queue_mutex_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int queue_kernel_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

#endif
