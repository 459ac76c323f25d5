/*
 * job_deque: the jobs that one thread has submitted. The thread itself pushes and pops at one end, newest first, so it works
 * depth first on what is in its cache; any other thread steals at the other end, oldest first. Lock-free.
 *
 * Chase and Lev, "Dynamic Circular Work-Stealing Deque", SPAA 2005. Memory orders: where Le, Pop, Cohen and Nardelli
 * ("Correct and Efficient Work-Stealing for Weak Memory Models", PPoPP 2013) put fences, here the owner's write to bottom
 * is a seq_cst exchange and what is compared with it a seq_cst load, which the thread sanitizer sees and which costs the
 * same on x86-64. The exchange in push also orders the push before the look at the idle list (job_park.h).
 * A buffer that has become too small is kept until the end, since a thief may still be reading it: all buffers
 * together are less than twice the last.
 */
#ifndef STILB_JOB_DEQUE_H
#define STILB_JOB_DEQUE_H

#include "jobs/job_record.h"

#ifndef JOB_DEQUE_CAPACITY
#define JOB_DEQUE_CAPACITY 256 /* to begin with; a power of two */
#endif

typedef struct job_deque_buffer job_deque_buffer;
struct job_deque_buffer {
	job_deque_buffer *smaller; /* the one it replaced */
	int64_t mask;
	/* Relaxed: what a thief reads counts only if its exchange on top succeeds; the record itself comes through bottom. */
	_Atomic(job_record *) cell[];
};

typedef struct job_deque {
	alignas(JOB_LINE) _Atomic int64_t top;    /* the oldest; only ever grows */
	alignas(JOB_LINE) _Atomic int64_t bottom; /* one past the newest; written by the owner */
	_Atomic(job_deque_buffer *) buffer;       /* release in grow, pairs with acquire in job_deque_oldest */
	alignas(
		JOB_LINE) int64_t top_seen; /* by the owner, some time ago: it need not fetch the thieves' line for a push */
} job_deque;

/* 0 or -ENOMEM. */
int job_deque_init(job_deque *deque);

/* {0} is fine. [one-writer] */
void job_deque_finish(job_deque *deque);

/* Doubles the buffer. 0 or -ENOMEM, then the deque is as before. [owner] */
int job_deque_grow(job_deque *deque);

/* Appends record; seq_cst, so that who looks for work after that sees it. 0 or -ENOMEM. [owner] */
static inline int job_deque_push(job_deque *deque, job_record *record)
{
	/* Relaxed: both are the owner's own. */
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	if (bottom - deque->top_seen > buffer->mask) {
		/* Acquire pairs with the exchange in steal: the cell is overwritten after the thief has read it. */
		deque->top_seen = atomic_load_explicit(&deque->top, memory_order_acquire);
		if (bottom - deque->top_seen > buffer->mask) {
			int error = job_deque_grow(deque);
			if (error)
				return error;
			buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
		}
	}
	atomic_store_explicit(&buffer->cell[bottom & buffer->mask], record, memory_order_relaxed);
	atomic_exchange_explicit(&deque->bottom, bottom + 1, memory_order_seq_cst); /* pairs with steal */
	return 0;
}

/* The newest record, not taken; NULL if there is none. Others may take it meanwhile. [owner] */
static inline job_record *job_deque_newest(job_deque *deque)
{
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed);
	/* Relaxed: top only grows, so if it has got here the deque is empty. */
	if (atomic_load_explicit(&deque->top, memory_order_relaxed) >= bottom)
		return NULL;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	return atomic_load_explicit(&buffer->cell[(bottom - 1) & buffer->mask], memory_order_relaxed);
}

/* Takes the newest; NULL if there is none. [owner] */
static inline job_record *job_deque_pop(job_deque *deque)
{
	if (!job_deque_newest(deque))
		return NULL;
	int64_t bottom = atomic_load_explicit(&deque->bottom, memory_order_relaxed) - 1;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_relaxed);
	/* Either a thief sees the lower bottom and leaves the cell alone, or its exchange on top is seen here. */
	atomic_exchange_explicit(&deque->bottom, bottom, memory_order_seq_cst);
	int64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	job_record *record = atomic_load_explicit(&buffer->cell[bottom & buffer->mask], memory_order_relaxed);
	if (top < bottom)
		return record;
	/* The last one, or none: it belongs to who moves top. */
	if (top > bottom || !atomic_compare_exchange_strong_explicit(&deque->top, &top, top + 1, memory_order_seq_cst,
	                                                             memory_order_relaxed))
		record = NULL;
	/* Release: a thief that reads this value still sees the records below it. */
	atomic_store_explicit(&deque->bottom, bottom + 1, memory_order_release);
	return record;
}

/* True if the deque was empty at one moment during the call; sees every push that happened before it. [any-thread] */
static inline bool job_deque_empty(job_deque *deque)
{
	/* Seq_cst, see steal; the same order of loads: what came in between makes it look fuller, not emptier. */
	int64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	return top >= atomic_load_explicit(&deque->bottom, memory_order_seq_cst);
}

/* The oldest record, not taken; NULL if there is none. *top is what job_deque_steal wants. [any-thread] */
static inline job_record *job_deque_oldest(job_deque *deque, int64_t *top)
{
	/* Seq_cst: top before bottom, partners of the exchanges in push and pop. */
	*top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	if (*top >= atomic_load_explicit(&deque->bottom, memory_order_seq_cst))
		return NULL;
	job_deque_buffer *buffer = atomic_load_explicit(&deque->buffer, memory_order_acquire); /* pairs with grow */
	return atomic_load_explicit(&buffer->cell[*top & buffer->mask], memory_order_relaxed);
}

/* Takes what job_deque_oldest showed; false if somebody else did. [any-thread] */
static inline bool job_deque_steal(job_deque *deque, int64_t top)
{
	return atomic_compare_exchange_strong_explicit(&deque->top, &top, top + 1, memory_order_seq_cst,
	                                               memory_order_relaxed);
}

#endif
