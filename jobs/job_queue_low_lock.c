/*
 * The low-lock queue: two locks, one for the producers' end and one for the consumers', over a ring of segments.
 *
 * From.      Herb Sutter, "Writing a Generalized Concurrent Queue", Dr. Dobb's Journal, November 2008: two spin locks, each
 *            with its end of the queue on cache lines of its own, allocation and clean-up outside of them. It is the
 *            two-lock queue of Michael and Scott (PODC 1996). Here a node is a segment of 512 cells, filled and emptied
 *            many times before it is freed, and a look whether the queue is empty takes no lock.
 * Promise.   A linearisable FIFO: the order is that in which producers get their lock. Low-lock, never lock-free: a thread
 *            that is stopped inside a section stops its end of the queue until it goes on. The other end goes on as long
 *            as there are items, or room for them.
 * Shared.    What the ends know of one another are two counts: items pushed, items popped. Each is written under its own
 *            end's lock, with release, after the cells it speaks of. Their difference is what the queue holds, so empty
 *            and full are exact at one moment, and no segment need be touched to know (none is ever read that might
 *            be gone). Consumers read the producers' count only when they have taken all they saw last time.
 * Ring.      Segments are linked in a ring. Producers walk ahead, consumers behind them. A producer that finds the next
 *            segment still in use gives the lock, allocates, writes to the pages so that the kernel maps them, takes the
 *            lock and puts the new segment in between. So nothing is allocated under a lock, and the ring grows to the
 *            longest the queue has ever been; then malloc is not called again. It is freed with the queue.
 * Speed.     Measured on two virtual CPUs of an EPYC (Zen 4 or 5; 1 producer and 1 consumer, or 2 and 2, on CPUs of their
 *            own; millions of items in a second). What costs is not the locks (2 to 3 ns each when free) but cache lines on
 *            their way between CPUs, and CPUs whose threads want the same end at the same time:
 *            - A consumer writes null to the cell it has read. The line is then its own, and the producer's CPU, which has
 *              no copy of it any more, fetches it ahead of the stores. Without it the producer keeps a shared copy that
 *              it has to upgrade at the store: pushes cost 5 to 7 ns instead of 2.7, and 1 and 1 do 104 instead of
 *              150; batches of 16, 243 instead of 361. Prefetching for writing did not help (112).
 *            - Who finds the lock taken yields after some 100 ns (job_lock.h), so that the CPU goes to the other end
 *              instead: 2 and 2 do 168 to 189 instead of 109 with 1 us, 8 and 8 on both CPUs 175 to 213 instead of 116.
 *            - Lock, count and the rest of an end on one line or on two makes no difference that can be told from noise.
 *              Nor does a consumer that waits before it reads the producers' count again, so that it reads it less often:
 *              no gain with 1 and 1, and a loss with more. It is not done.
 *            - Batches: one copy and one count for all of their items. How far the producers run ahead then decides, as
 *              what is pushed in one time slice has left the cache when it is popped.
 */
#include "jobs/job_lock.h"
#include "jobs/job_queue_internal.h"

#include <errno.h>
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

#ifndef JOB_SEGMENT_CELLS
#define JOB_SEGMENT_CELLS 512
#endif

typedef struct segment segment;

struct segment {
	void *cell[JOB_SEGMENT_CELLS];
	segment *next;
};

typedef struct low_lock {
	stilb_job_queue base;
	size_t capacity;
	/* All of an end lies on one line: who takes its lock has then fetched the rest too. */
	struct {
		alignas(JOB_LINE) job_lock lock;
		_Atomic uint64_t count; /* items pushed so far; release, pairs with acquire in pop and empty */
		uint64_t stop;          /* at this count push_slow has to look: end of segment, full or closed */
		uint64_t end;           /* the count at which the segment is full */
		segment *at;            /* the segment being filled */
		uint64_t segments;      /* in the ring */
		_Atomic bool closed;    /* release in close, pairs with acquire in pop */
	} push;
	struct {
		alignas(JOB_LINE) job_lock lock;
		_Atomic uint64_t count; /* items popped so far; release, pairs with acquire in push */
		_Atomic uint64_t stop;  /* up to here there are items in the segment; written under the lock */
		uint64_t end;           /* the count at which the segment is used up */
		segment *at;            /* the segment being emptied */
	} pop;
} low_lock;

static low_lock *self_of(stilb_job_queue *queue)
{
	return (low_lock *)queue;
}

static uint64_t least(uint64_t a, uint64_t b)
{
	return a < b ? a : b;
}

/* ---- segments ------------------------------------------------------------------------------------------------- */

/* Adds up to count segments to those in *fresh, which are linked by `next`; how many there are now. */
static size_t segments_create(segment **fresh, size_t have, size_t count)
{
	while (have < count) {
		segment *one = malloc(sizeof *one);
		if (!one)
			break;
		memset(one, 0, sizeof *one); /* the kernel finds its pages now, not under the lock */
		one->next = *fresh;
		*fresh = one;
		have++;
	}
	return have;
}

static void segments_destroy(segment *first)
{
	while (first) {
		segment *next = first->next;
		free(first);
		first = next;
	}
}

/* Puts the segments of the list into the ring, to be filled next. */
static void ring_insert(low_lock *self, segment *fresh)
{
	while (fresh) {
		segment *next = fresh->next;
		fresh->next = self->push.at->next;
		self->push.at->next = fresh;
		self->push.segments++;
		fresh = next;
	}
}

/* How many of the segments after the one that is being filled are free: all but those from where consumers stand up to
 * it. Having popped the last item of a segment they still stand there, for they have yet to follow its `next`. */
static size_t ring_free(const low_lock *self, uint64_t popped)
{
	uint64_t begin = popped == 0 ? 0 : (popped - 1) / JOB_SEGMENT_CELLS * JOB_SEGMENT_CELLS;
	return self->push.segments - (self->push.end - begin) / JOB_SEGMENT_CELLS;
}

/* ---- push ----------------------------------------------------------------------------------------------------- */

/* Writes the items into the cells, for which there are segments, and publishes them. The lock is held. */
static void push_fill(low_lock *self, void *const *items, size_t count, uint64_t pushed)
{
	while (count > 0) {
		if (pushed == self->push.end) {
			self->push.at = self->push.at->next;
			self->push.end += JOB_SEGMENT_CELLS;
		}
		size_t part = least(count, self->push.end - pushed);
		memcpy(self->push.at->cell + pushed % JOB_SEGMENT_CELLS, items, part * sizeof *items);
		items += part;
		count -= part;
		pushed += part;
	}
	/* Release pairs with the acquire in pop: whoever sees the count sees the cells and the links up to there. */
	atomic_store_explicit(&self->push.count, pushed, memory_order_release);
}

/* How many more the queue will take. The lock is held. */
static size_t push_left(const low_lock *self, uint64_t pushed, uint64_t popped)
{
	/* Relaxed: ordered by the lock. */
	bool closed = atomic_load_explicit(&self->push.closed, memory_order_relaxed);
	return closed ? 0 : self->capacity - (pushed - popped);
}

/* Pushes what it can. The lock is held, and given in here. */
static int push_and_give(low_lock *self, void *const *items, size_t count)
{
	segment *fresh = NULL;
	size_t fresh_count = 0;
	for (bool may_grow = true;;) {
		uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
		/* Acquire pairs with the release in pop: its use of the cells comes before we write them again. Nobody pushes
		 * meanwhile, so at the moment of this load the queue holds exactly pushed - popped items. */
		uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);
		size_t left = push_left(self, pushed, popped), wanted = least(count, left);
		size_t cells = self->push.end - pushed + (ring_free(self, popped) + fresh_count) * JOB_SEGMENT_CELLS;
		if (wanted > cells && may_grow) {
			job_lock_give(&self->push.lock);
			size_t needed = fresh_count + (wanted - cells + JOB_SEGMENT_CELLS - 1) / JOB_SEGMENT_CELLS;
			fresh_count = segments_create(&fresh, fresh_count, needed);
			may_grow = fresh_count == needed;
			job_lock_take(&self->push.lock);
			continue;
		}
		ring_insert(self, fresh); /* needed or, if others have made room meanwhile, not yet */
		size_t done = least(wanted, cells);
		if (done > 0)
			push_fill(self, items, done, pushed);
		self->push.stop = pushed + done + least(self->push.end - (pushed + done), left - done);
		bool closed = atomic_load_explicit(&self->push.closed, memory_order_relaxed); /* ordered by the lock */
		job_lock_give(&self->push.lock);
		return done > 0 ? (int)done : closed ? -EPIPE : left == 0 ? -EAGAIN : -ENOMEM;
	}
}

static int low_lock_push(stilb_job_queue *queue, void *item, uint32_t thread)
{
	(void)thread;
	low_lock *self = self_of(queue);
	job_lock_take(&self->push.lock);
	uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
	if (__builtin_expect(pushed == self->push.stop, 0)) {
		int result = push_and_give(self, &item, 1);
		return result < 0 ? result : 0;
	}
	self->push.at->cell[pushed % JOB_SEGMENT_CELLS] = item;
	/* Release pairs with the acquire in pop: whoever sees the count sees the cell. */
	atomic_store_explicit(&self->push.count, pushed + 1, memory_order_release);
	job_lock_give(&self->push.lock);
	return 0;
}

static int low_lock_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread)
{
	(void)thread;
	low_lock *self = self_of(queue);
	job_lock_take(&self->push.lock);
	return push_and_give(self, items, count);
}

static void low_lock_close(stilb_job_queue *queue)
{
	low_lock *self = self_of(queue);
	job_lock_take(&self->push.lock);
	/* Release pairs with the acquire in pop_refused: who sees it sees the count of all that was ever pushed. */
	atomic_store_explicit(&self->push.closed, true, memory_order_release);
	/* Ordered by the lock. */
	self->push.stop = atomic_load_explicit(&self->push.count, memory_order_relaxed);
	job_lock_give(&self->push.lock);
}

/* ---- pop ------------------------------------------------------------------------------------------------------ */

static bool low_lock_empty(stilb_job_queue *queue, uint32_t thread)
{
	(void)thread;
	low_lock *self = self_of(queue);
	/* What was popped, then what was pushed: if they are equal, nothing was pushed between the two loads, for nothing is
	 * popped before it is pushed; so the queue was empty at the first of them. Acquire keeps them in this order; the
	 * second pairs with the release in push. */
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);
	return atomic_load_explicit(&self->push.count, memory_order_acquire) == popped;
}

/* Why an empty queue gives nothing. */
static int pop_refused(low_lock *self)
{
	/* Acquire pairs with the release in close. Nothing is pushed after it, so what is empty now stays so. */
	if (!atomic_load_explicit(&self->push.closed, memory_order_acquire))
		return -EAGAIN;
	return low_lock_empty(&self->base, 0) ? -EPIPE : -EAGAIN;
}

/* A look before the lock is taken, so that idle consumers do not keep one another from it. */
static bool pop_hopeless(low_lock *self)
{
	/* Relaxed: while there are items left of those seen at the last refill, the producers' line is left alone. */
	return atomic_load_explicit(&self->pop.count, memory_order_relaxed) ==
	           atomic_load_explicit(&self->pop.stop, memory_order_relaxed) &&
	       low_lock_empty(&self->base, 0);
}

/* Looks for more after `popped` items, where the last refill ended; false if there are none. The lock is held. */
static bool pop_refill(low_lock *self, uint64_t popped)
{
	/* Acquire pairs with the release in push: the cells and the links up to there are written. */
	uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_acquire);
	if (pushed == popped)
		return false;
	if (popped == self->pop.end) {
		self->pop.at = self->pop.at->next;
		self->pop.end += JOB_SEGMENT_CELLS;
	}
	/* Relaxed: a hint to pop_hopeless. */
	atomic_store_explicit(&self->pop.stop, least(pushed, self->pop.end), memory_order_relaxed);
	return true;
}

static int low_lock_pop(stilb_job_queue *queue, void **item, uint32_t thread)
{
	(void)thread;
	low_lock *self = self_of(queue);
	if (pop_hopeless(self))
		return pop_refused(self);
	job_lock_take(&self->pop.lock);
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_relaxed); /* both ordered by the lock */
	if (popped == atomic_load_explicit(&self->pop.stop, memory_order_relaxed) && !pop_refill(self, popped)) {
		job_lock_give(&self->pop.lock);
		return pop_refused(self);
	}
	void **cell = self->pop.at->cell + popped % JOB_SEGMENT_CELLS;
	*item = *cell;
	*cell = NULL; /* for speed: see the top */
	/* Release pairs with the acquire in push: our read of the cell comes before it is written again. */
	atomic_store_explicit(&self->pop.count, popped + 1, memory_order_release);
	job_lock_give(&self->pop.lock);
	return 0;
}

static int low_lock_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread)
{
	(void)thread;
	low_lock *self = self_of(queue);
	if (pop_hopeless(self))
		return pop_refused(self);
	job_lock_take(&self->pop.lock);
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_relaxed); /* ordered by the lock */
	size_t taken = 0;
	while (taken < max) {
		uint64_t stop = atomic_load_explicit(&self->pop.stop, memory_order_relaxed); /* ordered by the lock */
		if (popped == stop) {
			if (!pop_refill(self, popped))
				break;
			continue;
		}
		size_t part = least(max - taken, stop - popped);
		void **cell = self->pop.at->cell + popped % JOB_SEGMENT_CELLS;
		memcpy(items + taken, cell, part * sizeof *items);
		memset(cell, 0, part * sizeof *items); /* for speed: see the top */
		taken += part;
		popped += part;
	}
	/* Release pairs with the acquire in push: our reads of the cells come before they are written again. */
	atomic_store_explicit(&self->pop.count, popped, memory_order_release);
	job_lock_give(&self->pop.lock);
	return taken > 0 ? (int)taken : pop_refused(self);
}

/* ---- life ----------------------------------------------------------------------------------------------------- */

static void low_lock_rest(stilb_job_queue *queue, uint32_t thread)
{
	(void)queue; /* nothing is held between calls */
	(void)thread;
}

static void low_lock_destroy(stilb_job_queue *queue)
{
	low_lock *self = self_of(queue);
	segment *first = self->push.at->next;
	self->push.at->next = NULL; /* opens the ring */
	segments_destroy(first);
	free(self);
}

static const job_queue_ops low_lock_ops = {.push = low_lock_push,
                                           .push_n = low_lock_push_n,
                                           .pop = low_lock_pop,
                                           .pop_n = low_lock_pop_n,
                                           .empty = low_lock_empty,
                                           .close = low_lock_close,
                                           .rest = low_lock_rest,
                                           .destroy = low_lock_destroy};

int job_queue_low_lock_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	segment *first = NULL;
	low_lock *self = aligned_alloc(JOB_LINE, sizeof *self);
	if (!self || segments_create(&first, 0, 1) == 0) {
		free(self);
		return -ENOMEM;
	}
	memset(self, 0, sizeof *self);
	first->next = first;
	self->base.ops = &low_lock_ops;
	self->capacity = desc->capacity;
	self->push.at = self->pop.at = first;
	self->push.end = self->pop.end = JOB_SEGMENT_CELLS;
	self->push.stop = least(JOB_SEGMENT_CELLS, self->capacity);
	self->push.segments = 1;
	*queue = &self->base;
	return 0;
}
