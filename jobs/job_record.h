/*
 * job_record: one job that has been submitted and not started, 64 bytes, and where such records come from.
 *
 * Each thread keeps a few free records and takes and gives without any atomic operation; what it has too many of (a
 * thief frees what others made) goes as one list to a stack that all share, and who has none takes that whole stack: a stack that is only ever emptied as a whole knows no ABA problem, so it is lock-free with one
 * plain compare-exchange. Records come from malloc in slabs and go back when the pool is destroyed, so a guess at a
 * record that another thread has taken meanwhile reads valid memory.
 */
#ifndef STILB_JOB_RECORD_H
#define STILB_JOB_RECORD_H

#include "jobs/job.h"
#include "jobs/job_lock.h"

#include <assert.h>
#include <stdalign.h>

#ifndef JOB_RECORD_LIST
#define JOB_RECORD_LIST 128u /* records given back that a thread keeps at most */
#define JOB_RECORD_SLAB 63u  /* records per malloc */
#endif

typedef struct job_record {
	/* An array of jobs (count > 0) has a range function; else it is one job. */
	union {
		stilb_job_fn *one;
		stilb_job_range_fn *range;
	} fn;
	void *data;
	stilb_job_group *group;
	uint64_t tag;            /* what the submit hook gave; without one 0 for ever */
	struct job_record *next; /* in a free list, an inbox or the list of a group's followers */
	/* What it belongs to, see job_internal.h. Relaxed: thieves read it to decide what to steal, and a wrong guess makes
	 * their exchange fail. */
	_Atomic uintptr_t root;
	_Atomic uint32_t level;
	uint32_t count;
	uint32_t grain;
	uint16_t target; /* the worker that runs it, or JOB_ANYONE */
	uint8_t priority;
} job_record;

static_assert(sizeof(job_record) <= 64, "a record fits a line");

#define JOB_ANYONE UINT16_MAX

typedef struct job_record_slab job_record_slab;

/* What all threads share. */
typedef struct job_record_store {
	alignas(JOB_LINE) _Atomic(job_record *) spare; /* chained by next; pushed as lists, taken as a whole */
	_Atomic(job_record_slab *) slabs;
} job_record_store;

/* What one thread has. {0} to begin with. */
typedef struct job_record_cache {
	job_record *given; /* given back by this thread, newest first: still in its CPU's cache */
	job_record *given_last;
	uint32_t given_count;
	job_record *taken; /* from the store */
} job_record_cache;

void job_record_store_init(job_record_store *store);

/* Frees all records. [one-writer] */
void job_record_store_finish(job_record_store *store);

/* An uninitialised record, NULL if there is no memory. [its thread] */
job_record *job_record_take(job_record_store *store, job_record_cache *cache);

/* Gives back a record of the same pool, taken by whichever thread. [its thread] */
void job_record_give(job_record_store *store, job_record_cache *cache, job_record *record);

#endif
