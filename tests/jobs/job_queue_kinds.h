/*
 * job_queue_kinds: all queues behind job_queue_ops, for tests that run on each of them: the two kinds of the library,
 * and those of bench/subjects that the library is compared with.
 */
#ifndef JOB_QUEUE_KINDS_H
#define JOB_QUEUE_KINDS_H

#include "jobs/queue/job_queue_internal.h"

typedef struct queue_kind {
	const char *name;
	int (*create)(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
	bool bounded;      /* capacity may be less than SIZE_MAX */
	bool whole_pushes; /* items of one push_n stay together */
	bool recycles;     /* does not allocate while it stays short */
	bool lock_free;    /* a stopped thread does not block the others */
} queue_kind;

enum { QUEUE_KINDS_OURS = 2, QUEUE_KINDS = 4 }; /* the library's kinds come first */
extern const queue_kind queue_kinds[QUEUE_KINDS];

/* Creates a queue; a failure fails the test. */
stilb_job_queue *queue_kind_create(const queue_kind *kind, size_t capacity, uint32_t thread_count);

#endif
