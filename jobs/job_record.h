/*
 * job_record: a job that has been submitted and has not started, or several of them, in 64 bytes, and the allocator of
 * such records.
 *
 * Each thread keeps a cache of free records, which it takes and gives back without atomic operations. A thread that
 * runs jobs of others collects their records; when its cache holds JOB_RECORD_LIST of them it pushes them as one list
 * onto a stack shared by all threads. A thread that has none takes the whole stack. A stack that is only ever emptied
 * as a whole has no ABA problem, so one plain compare-exchange makes it lock-free. Records are allocated in slabs that
 * are freed with the pool: a thread that looks at a record which another one has taken meanwhile still reads valid
 * memory.
 */
#ifndef STILB_JOB_RECORD_H
#define STILB_JOB_RECORD_H

#include "jobs/job.h"
#include "jobs/job_allocate.h"
#include "jobs/job_contract.h"
#include "jobs/job_lock.h"

#include <stdalign.h>

#ifndef JOB_RECORD_LIST
#define JOB_RECORD_LIST 128u /* the most records given back that a thread keeps before it passes them on */
#define JOB_RECORD_SLAB 63u  /* records of one slab */
#endif

/* What a record holds. */
typedef enum job_kind {
	JOB_SINGLE,
	JOB_LOOP,  /* a parallel loop submitted as a job */
	JOB_BATCH, /* jobs that were submitted together and have not started: the same function, one datum after another */
	JOB_NODES  /* ready nodes of a graph */
} job_kind;

typedef struct job_record {
	/* `graph` of JOB_NODES, `range` of JOB_LOOP, else `one`. */
	union {
		stilb_job_fn *one;
		stilb_job_range_fn *range;
		struct stilb_job_graph *graph;
	} fn;
	union {
		void *data;     /* of a batch: the first job's */
		uint32_t chain; /* of a graph: the first of some more ready nodes, see job_graph.c */
	};
	stilb_job_group *group;
	union {
		uint64_t tag;  /* the submit hook's result; 0 without that hook */
		size_t stride; /* of a batch, which has no tags: bytes from the data of one job to those of the next */
	};
	struct job_record *next; /* in a free list, an inbox or a group's list of followers */
	/* The root and level of the job, see job_internal.h. Relaxed: thieves read them to decide what to steal; if the
	 * record has been reused meanwhile, their exchange of the deque's top fails. */
	_Atomic uintptr_t root;
	_Atomic uint32_t level;
	uint32_t count;  /* of the loop's indices, the batch's jobs or the ready nodes */
	uint32_t grain;  /* indices of one slice of the loop; of a graph: where the numbers of these nodes lie */
	uint16_t target; /* index of the only thread that may run it, or JOB_ANYONE */
	uint8_t priority;
	uint8_t kind; /* job_kind */
} job_record;

static_assert(sizeof(job_record) <= 64, "a record fits one cache line");

#define JOB_ANYONE UINT16_MAX

typedef struct job_record_slab job_record_slab;

/* Shared by all threads of a pool. */
typedef struct job_record_store {
	alignas(JOB_LINE) _Atomic(job_record *) spare; /* a stack linked by next; pushed to in lists, emptied as a whole */
	_Atomic(job_record_slab *) slabs;              /* all slabs, for job_record_store_finish */
	const stilb_job_allocator *memory;
} job_record_store;

/* The free records that one thread keeps for itself. All zero: empty. */
typedef struct job_record_cache {
	job_record *given; /* given back by this thread, newest first, since that one is still in its CPU's cache */
	job_record *given_last;
	uint32_t given_count;
	job_record *taken; /* from the store; used when given is empty */
} job_record_cache;

/* Makes an empty store, whose slabs come from `memory`. */
void job_record_store_init(job_record_store *store, const stilb_job_allocator *memory);

/* Frees all records. No other call may be in progress. */
void job_record_store_finish(job_record_store *store);

/* job_record_take for a cache in which `given` is empty. */
job_record *job_record_take_other(job_record_store *store, job_record_cache *cache);

/* Moves the records that the thread has collected in `given` to the store, for all threads. */
void job_record_spill(job_record_store *store, job_record_cache *cache);

/* A record whose fields are unset, or NULL if there is no memory. cache is the calling thread's. */
static inline job_record *job_record_take(job_record_store *store, job_record_cache *cache)
{
	job_record *record = cache->given;
	assert(!record == (cache->given_count == 0));
	if (!record)
		return job_record_take_other(store, cache);
	cache->given = record->next;
	cache->given_count--;
	return record;
}

/* Gives back a record of this store, which any thread may have taken. cache is the calling thread's. */
static inline void job_record_give(job_record_store *store, job_record_cache *cache, job_record *record)
{
	assert(record && record != cache->given && "a record is given back once");
	if (cache->given_count == JOB_RECORD_LIST)
		job_record_spill(store, cache);
	if (cache->given_count++ == 0)
		cache->given_last = record;
	record->next = cache->given;
	cache->given = record;
	assert(cache->given_count <= JOB_RECORD_LIST);
}

#endif
