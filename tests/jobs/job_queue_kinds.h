/*
 * job_queue_kinds: every kind of queue there is behind job_queue_ops, for tests that run on all of them: the two of the
 * library, and those of bench/subjects that the library is measured against.
 */
#ifndef JOB_QUEUE_KINDS_H
#define JOB_QUEUE_KINDS_H

#include "jobs/job_queue_internal.h"

typedef struct queue_kind {
	const char *name;
	int (*create)(const stilb_job_queue_desc *desc, stilb_job_queue **queue);
	bool bounded;      /* takes a capacity */
	bool whole_pushes; /* the items of one push_n stay together */
	bool recycles;     /* allocates nothing while it stays short */
	bool lock_free;    /* a stopped thread holds up no other */
} queue_kind;

enum { QUEUE_KINDS_OURS = 2, QUEUE_KINDS = 4 }; /* the library's come first */
extern const queue_kind queue_kinds[QUEUE_KINDS];

/* Fails the test if it cannot. */
stilb_job_queue *queue_kind_create(const queue_kind *kind, size_t capacity, uint32_t thread_count);

#endif
