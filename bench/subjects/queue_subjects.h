/*
 * queue_subjects: queues to measure and to test against, behind the operations of jobs/job_queue_internal.h: create
 * one with a function below and use it with stilb_job_queue_push, pop, ... _destroy.
 *
 *   sutter  the article's queue, line by line: Herb Sutter, "Writing a Generalized Concurrent Queue", Dr. Dobb's
 *           Journal, November 2008. Two spin locks, one for each end; a node and a box allocated for each item.
 *           Unbounded only.
 *   mutex   what everybody writes first: a list under one pthread mutex.
 *   kernel  the same list behind a lock that asks the kernel at every call.
 * All push and pop a batch item by item.
 */
#ifndef STILB_BENCH_QUEUE_SUBJECTS_H
#define STILB_BENCH_QUEUE_SUBJECTS_H

#include "jobs/job_queue_internal.h"

/* All return 0 or -ENOMEM; queue_sutter_create -EINVAL when desc->capacity is not SIZE_MAX; queue_kernel_create also
 * what eventfd says. Any number of threads. */
int queue_sutter_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int queue_mutex_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
int queue_kernel_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue);

#endif
