/*
 * job_deque: the jobs that one thread has submitted. That thread, the owner, pushes and pops at one end, newest first,
 * so that it works depth first on data that is in its cache; all other threads steal at the other end, oldest first.
 * Lock-free.
 *
 * Chase and Lev, "Dynamic Circular Work-Stealing Deque", SPAA 2005. Le, Pop, Cohen and Nardelli ("Correct and Efficient
 * Work-Stealing for Weak Memory Models", PPoPP 2013) give the memory orders with fences. Here each fence is a seq_cst
 * exchange of bottom by the owner, and the loads that are compared with it are seq_cst: the thread sanitizer
 * understands that, and it costs the same on x86-64. The exchange in push also orders the push before the look at the
 * idle list (job_park.h). A buffer that has become too small is kept until the deque is finished, since a thief may
 * still be reading it. All buffers together are less than twice as large as the last one.
 *
 * Threads: [owner] functions are for the deque's own thread, [any-thread] for all.
 */
#ifndef STILB_JOB_DEQUE_H
#define STILB_JOB_DEQUE_H

#include "jobs/job_allocate.h"
#include "jobs/job_contract.h"
#include "jobs/job_record.h"

#ifndef JOB_DEQUE_CAPACITY
#define JOB_DEQUE_CAPACITY 256 /* records in the first buffer; a power of two */
#endif

typedef struct job_deque_buffer job_deque_buffer;
struct job_deque_buffer {
	job_deque_buffer *smaller; /* the buffer this one replaced */
	int64_t mask;              /* capacity - 1; record i lies in cell[i & mask] */
	/* Relaxed: a thief uses what it reads only if its exchange of top succeeds; the record is published by bottom. */
	_Atomic(job_record *) cell[];
};

typedef struct job_deque {
	alignas(JOB_LINE) _Atomic int64_t top;    /* index of the oldest record; only ever grows */
	alignas(JOB_LINE) _Atomic int64_t bottom; /* one past the index of the newest; written by the owner alone */
	_Atomic(job_deque_buffer *) buffer;       /* release in grow, pairs with acquire in job_deque_oldest */
	/* top as the owner last read it, so never more than top is now: most pushes can tell from it that the buffer is not
	 * full, and need not fetch the cache line that thieves write. */
	alignas(JOB_LINE) int64_t top_seen;
	const stilb_job_allocator *memory;
} job_deque;

/* Makes an empty deque, whose buffers come from `memory`. 0 or -ENOMEM. */
int job_deque_init(job_deque *deque, const stilb_job_allocator *memory);

/* Frees the buffers of an empty deque. No other call may be in progress. A deque of all zeros, which job_deque_init has
 * not been called for, is allowed. */
void job_deque_finish(job_deque *deque);

/* Replaces the buffer, which has no room for `more` records, by one that has: twice as large, or a larger power of two.
 * 0, or -ENOMEM and the deque is unchanged. [owner] */
int job_deque_grow(job_deque *deque, int64_t more);

/* Says whether a record is one of those that the caller looks for. Called for records that another thread may take and
 * reuse meanwhile: reads nothing but their atomic fields. */
typedef bool job_deque_test(const job_record *record, const void *context);

/* Moves records that pass the test to the newest end, in their order, so that job_deque_pop takes them next: the newest
 * such record, those not much deeper than it, but not the oldest record of the deque. False: there is none. True also
 * if a thief came between; the caller then looks again. For a moment during a call that returns true, other threads do
 * not see the newest records: the caller then wakes threads that may have missed them. Takes time in proportion to the
 * depth of the newest such record, or to the number of records if there is none. [owner] */
bool job_deque_dig(job_deque *deque, job_deque_test *test, const void *context);

/* True if there is a record that passes the test; *index is its index, the oldest's if there are several. Sees every
 * record whose push happened before the call, unless job_deque_dig hides it. [any-thread] */
bool job_deque_find(job_deque *deque, job_deque_test *test, const void *context, int64_t *index);

/* For asserts: ends, buffers and the newest cell fit together. [owner] */
bool job_deque_is_sound(job_deque *deque);

/* Appends record. Its store of bottom is seq_cst, so that a thread that looks for work afterwards sees the record. 0 or
 * -ENOMEM. [owner] */
static inline int job_deque_push(job_deque *deque, job_record *record)
{
	assert(record);
	/* Relaxed: only the owner, the calling thread, writes bottom and buffer. */
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	if (bottom - deque->top_seen > buffer->mask) {
		/* Acquire pairs with the exchange in steal: the thief has read the cell before it is overwritten here. */
		deque->top_seen = atomic_load_explicit(&deque->top, memory_order_acquire);
		if (bottom - deque->top_seen > buffer->mask) {
			int error = job_deque_grow(deque, 1);
			if (error)
				return error;
			buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
		}
	}
	atomic_store_explicit(&buffer->cell[bottom & buffer->mask], record, memory_order_relaxed);
	atomic_exchange_explicit(&deque->bottom, bottom + 1, memory_order_seq_cst); /* pairs with steal */
	JOB_CHECK(job_deque_is_sound(deque));
	return 0;
}

/* Appends the records of a list linked by next, `count` of them. They become visible together: thieves see all or none.
 * 0, or -ENOMEM and none is appended. [owner] */
int job_deque_push_list(job_deque *deque, job_record *first, int64_t count);

/* The newest record, which stays in the deque; NULL if there is none. A thief may take it meanwhile. [owner] */
static inline job_record *job_deque_newest(job_deque *deque)
{
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	/* Relaxed: top only grows, so even if this value is old, the deque is empty once it has reached bottom. */
	if (atomic_load_explicit(&deque->top, memory_order_relaxed) >= bottom)
		return NULL;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	return atomic_load_explicit(&buffer->cell[(bottom - 1) & buffer->mask], memory_order_relaxed);
}

/* job_deque_pop after job_deque_newest has returned a record; NULL if a thief has taken it meanwhile. [owner] */
static inline job_record *job_deque_pop_newest(job_deque *deque)
{
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed) - 1;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	/* Seq_cst, both: either a thief sees the lower bottom and leaves the cell alone, or its exchange of top is seen
	 * here. */
	atomic_exchange_explicit(&deque->bottom, bottom, memory_order_seq_cst);
	int64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	job_record *record = atomic_load_explicit(&buffer->cell[bottom & buffer->mask], memory_order_relaxed);
	if (top < bottom)
		return record;
	/* One record at most is left; it belongs to the thread that moves top past it. */
	if (top > bottom || !atomic_compare_exchange_strong_explicit(&deque->top, &top, top + 1, memory_order_seq_cst,
	                                                             memory_order_relaxed))
		record = NULL;
	/* Release: a thief that reads this value of bottom sees the records of the cells before it. */
	atomic_store_explicit(&deque->bottom, bottom + 1, memory_order_release);
	JOB_CHECK(job_deque_is_sound(deque));
	return record;
}

/* Takes the newest record; NULL if there is none. [owner] */
static inline job_record *job_deque_pop(job_deque *deque)
{
	return job_deque_newest(deque) ? job_deque_pop_newest(deque) : NULL;
}

/* True if the deque was empty at some moment during the call; sees every push that happened before it. [any-thread] */
static inline bool job_deque_empty(job_deque *deque)
{
	/* Seq_cst, partners of the exchanges in push and pop. top is loaded first and only grows, so if it is not below
	 * bottom here, the deque was empty when bottom was loaded. */
	int64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	return top >= atomic_load_explicit(&deque->bottom, memory_order_seq_cst);
}

/* The number of records, or one that it had a moment ago; 0 if the deque is empty. [any-thread] */
static inline int64_t job_deque_count(job_deque *deque)
{
	/* Relaxed, both: only a guess. */
	int64_t count = -atomic_load_explicit(&deque->top, memory_order_relaxed);
	count += atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	return count > 0 ? count : 0;
}

/* The oldest record, which stays in the deque; NULL if there is none. *top is the argument for job_deque_steal.
 * [any-thread] */
static inline job_record *job_deque_oldest(job_deque *deque, int64_t *top)
{
	/* Seq_cst: top is loaded before bottom; partners of the exchanges of bottom in push and pop. */
	*top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	if (*top >= atomic_load_explicit(&deque->bottom, memory_order_seq_cst))
		return NULL;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_acquire); /* pairs with grow */
	return atomic_load_explicit(&buffer->cell[*top & buffer->mask], memory_order_relaxed);
}

/* Takes the record that job_deque_oldest returned; false if another thread has taken it. [any-thread] */
static inline bool job_deque_steal(job_deque *deque, int64_t top)
{
	return atomic_compare_exchange_strong_explicit(&deque->top, &top, top + 1, memory_order_seq_cst,
	                                               memory_order_relaxed);
}

#endif
