/*
 * The low-lock queue: two locks, one for the producers' end and one for the consumers' end, over a ring of segments.
 *
 * Source.    Herb Sutter, "Writing a Generalized Concurrent Queue", Dr. Dobb's Journal, November 2008: two spin locks,
 *            each on a cache line together with its end of the queue, with allocation outside of them; the two-lock
 *            queue of Michael and Scott (PODC 1996). Here a node is a segment of 1024 cells that is filled and emptied
 *            many times before it is freed, and testing for an empty queue takes no lock.
 * Progress.  A linearizable FIFO in the order in which producers take their lock. Low-lock, not lock-free: a thread
 *            that is preempted inside a critical section holds up its end of the queue. The other end continues as long
 *            as there are items, or space for them.
 * Shared.    The ends share two counts: items pushed and items popped. Each is written under the lock of its own end,
 *            with release, after the cells that it covers. Their difference is the number of items in the queue, so
 *            "empty" and "full" are exact at one moment, and deciding them reads no segment, which might have been
 *            freed. Consumers read the producers' count only when they have taken everything they saw the last time.
 * Ring.      Segments are linked into a ring. Producers fill them, and consumers follow. A producer that finds the next
 *            segment still in use releases the lock, allocates a segment, writes to its pages so that the kernel maps
 *            them, takes the lock again and inserts it. So no allocation happens under a lock. The ring grows to the
 *            longest length the queue has had, and then nothing is allocated any more. Destroy frees it.
 * Speed.     Measured on two virtual CPUs of an AMD EPYC (Zen 4 or 5), with 1 producer and 1 consumer (1+1), or 2 and 2
 *            (2+2), pinned to CPUs of their own, in million items per second. The cost is not in the locks (2 to 3 ns
 *            each when free) but in cache lines that move between CPUs, and in threads on both CPUs that want the same
 *            end at the same time:
 *            - A consumer writes NULL to the cell it has read. That makes the line exclusive to its CPU and removes it
 *              from the producer's, whose prefetcher then fetches it ahead of the stores. Without it the producer keeps
 *              a shared copy that each store has to upgrade: a push costs 5 to 7 ns instead of 2.7, and 1+1 reaches 104
 *              instead of 150; in batches of 16, 243 instead of 361. Prefetching for writing did not help (112).
 *            - A thread that finds the lock taken yields after some 100 ns (job_lock.h), so that its CPU can work at
 *              the other end: 2+2 reaches 168 to 189, against 109 when it spins for 1 us; 8+8 on both CPUs reaches 175
 *              to 213, against 116.
 *            - The common case of a single push or pop calls no function, so it saves no registers, and asks with one
 *              branch whether to wake threads that sleep on the lock or wait for the queue: 4.6 ns for a push and a pop
 *              in one thread, against 5.4 with calls in between; 2+2 gains an eighth.
 *            - Keeping lock, count and the rest of an end on one line or on two makes no difference beyond noise.
 *              Making the consumer of single items wait before it reads the producers' count again, to read it less
 *              often, gains nothing with 1+1 and loses with more threads; so it does not wait.
 *            - Consumers of batches do. A consumer that follows close behind a producer takes the line of the count,
 *              which also holds the lock, from it after every batch, and both wait for that line: 1+1 in batches of 16
 *              then moves 190 to 260 million items, and 400 to 650 when the consumer lies some thousand items behind.
 *              A pause of 1 us before a look, when the one before found less than 256 items, and nothing else changed,
 *              raises the median of 1+1 from 402 to 502, of 2+2 from 380 to 516 and of 4+4 from 296 to 488.
 *            - A segment's end costs both ends a look at the other's line. Consumers that remember how far producers
 *              were, beyond the segment, save theirs; 1024 instead of 512 cells halve the rest: 2+2 in batches gains a
 *              tenth, and single items gain 8 to 20 % from both. Of 2048 and 4096 cells nothing more was seen.
 *            - In batches, these gained nothing beyond noise: prefetching cells at either end, 128 to 512 bytes ahead;
 *              count and lock on separate lines; a lock without an exchange (docs/jobs.md, "Biased locks").
 *            - A batch needs one copy and one count for all its items, and like a single push it reads the consumers'
 *              count only once a segment: in batches of 16, all threads on one CPU, 1+1 and 4+4 reach 520 and 483, and
 *              with a look at every push 457 and 455. Items pushed in one time slice may have left the cache when they
 *              are popped. On a Xeon, where that shows, an item took 3.8 instead of 6.1 ns with a capacity of 32,768.
 *              Therefore producers of batches that run ahead yield (push_should_yield); here that gains nothing.
 *              Single pushes do not: with it, 2+2 pinned was slower by a quarter.
 */
#include "jobs/job_allocate.h"
#include "jobs/job_lock.h"
#include "jobs/queue/job_queue_internal.h"

#include <errno.h>
#include <stdalign.h>
#include <string.h>

/* Producers of batches yield to consumers that lie more items than this behind: 256 KiB of pointers, which still are in
 * the level 2 cache of most CPUs when they are popped. */
#define JOB_QUEUE_AHEAD 32768

/* Producers yield at most this many times in a row without anything being popped. */
#define JOB_QUEUE_YIELDS 32

/* Consumers are close behind producers if a look at the producers' count finds fewer items than this. */
#define JOB_QUEUE_CLOSE 256

/* The pauses of a pop of a batch before the look after that one: 0.5 to 2 us, time for some hundred items. */
#define JOB_QUEUE_PAUSES 40

/* If producers add less than a quarter of JOB_QUEUE_CLOSE in a pause, so many looks follow without one. */
#define JOB_QUEUE_LOOKS 1024

/* A function that ends a rare case of a call. The common case calls no function, and so need not save registers. */
#define RARE __attribute__((noinline))

/* The model tests make both smaller. */
#ifndef JOB_SEGMENT_CELLS
#define JOB_SEGMENT_CELLS 1024
#define JOB_SEGMENT_ALIGN JOB_LINE
#endif

typedef struct segment segment;

struct segment {
	alignas(JOB_SEGMENT_ALIGN) void *cell[JOB_SEGMENT_CELLS]; /* so 16 items lie on two cache lines, not on three */
	segment *next;
};

typedef struct low_lock {
	stilb_job_queue base;
	size_t capacity;
	stilb_job_allocator memory;
	/* Each end lies on one cache line, so taking its lock fetches the rest of it as well. */
	struct {
		alignas(JOB_LINE) job_lock lock;
		_Atomic uint64_t count; /* items pushed so far; release, pairs with acquire in pop and empty */
		uint64_t stop;          /* below it a push need not check: a free cell in `at`, queue not full and not closed */
		uint64_t end;           /* the count at which the segment `at` is full */
		segment *at;            /* the segment being filled */
		uint64_t segments;      /* the number of segments in the ring */
		_Atomic bool closed;    /* release in close, pairs with acquire in pop */
		uint32_t yields;        /* how many more times producers yield before something must be popped */
		uint64_t popped;        /* the consumers' count when the last segment was begun */
	} push;
	struct {
		alignas(JOB_LINE) job_lock lock;
		_Atomic uint64_t count; /* items popped so far; release, pairs with acquire in push */
		/* The producers' count when it was last read: so many items can be popped without reading it again, which would
		 * take its cache line from the producer. Written under the lock. */
		_Atomic uint64_t seen;
		uint64_t stop; /* up to this count the segment `at` is known to hold items */
		uint64_t end;  /* the count at which the segment `at` is used up */
		segment *at;   /* the segment being emptied */
		/* Both relaxed: hints, which are also written without the lock. */
		_Atomic bool pause;     /* a pop of a batch pauses before it looks again, see JOB_QUEUE_CLOSE */
		_Atomic uint32_t looks; /* how many more looks that find few items leave `pause` unset */
		/* The thread that was last to begin a segment, or 0. Relaxed: only push_should_yield reads it, as a hint. */
		_Atomic uintptr_t consumer;
	} pop;
} low_lock;

static low_lock *low_lock_of(stilb_job_queue *queue)
{
	return (low_lock *)queue;
}

static uint64_t least(uint64_t a, uint64_t b)
{
	return a < b ? a : b;
}

/* ---- segments ------------------------------------------------------------------------------------------------- */

/* Extends the list *fresh, linked by `next`, from have to count segments; returns the number reached, which is smaller
 * if memory runs out. */
static size_t segments_create(const stilb_job_allocator *memory, segment **fresh, size_t have, size_t count)
{
	while (have < count) {
		segment *one = job_allocate(memory, sizeof *one, alignof(segment));
		if (!one)
			break;
		memset(one, 0, sizeof *one); /* maps its pages now instead of under the lock */
		one->next = *fresh;
		*fresh = one;
		have++;
	}
	return have;
}

static void segments_destroy(const stilb_job_allocator *memory, segment *first)
{
	while (first) {
		segment *next = first->next;
		job_release(memory, first, sizeof *first);
		first = next;
	}
}

/* For asserts: the ring has push.segments segments. Not checked above 64 segments, since it would take too long. */
static bool ring_is_sound(const low_lock *self)
{
	if (self->push.segments > 64)
		return true;
	uint64_t count = 1;
	for (const segment *at = self->push.at->next; at != self->push.at && count <= 64; at = at->next)
		count++;
	return count == self->push.segments;
}

/* Inserts the segments of the list into the ring, to be filled next. Caller holds push.lock. */
static void ring_insert(low_lock *self, segment *fresh)
{
	assert(job_lock_is_mine(&self->push.lock) && "the caller holds the lock");
	while (fresh) {
		segment *next = fresh->next;
		fresh->next = self->push.at->next;
		self->push.at->next = fresh;
		self->push.segments++;
		fresh = next;
	}
	JOB_CHECK(ring_is_sound(self));
}

/* The number of free segments after the one being filled: all but those from the consumers' segment up to it. Consumers
 * that have popped the last item of a segment still are in that segment, since they have yet to follow its `next`. */
static size_t ring_free(const low_lock *self, uint64_t popped)
{
	uint64_t begin = popped == 0 ? 0 : (popped - 1) / JOB_SEGMENT_CELLS * JOB_SEGMENT_CELLS;
	assert(begin < self->push.end && (self->push.end - begin) / JOB_SEGMENT_CELLS <= self->push.segments);
	return self->push.segments - (self->push.end - begin) / JOB_SEGMENT_CELLS;
}

/* ---- push ----------------------------------------------------------------------------------------------------- */

/* For asserts: count <= stop <= end, and end is the end of the segment being filled. Caller holds push.lock. */
static bool push_is_sound(const low_lock *self)
{
	uint64_t count = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
	return job_lock_is_mine(&self->push.lock) && count <= self->push.stop && self->push.stop <= self->push.end &&
	       self->push.end - count <= JOB_SEGMENT_CELLS && self->push.end % JOB_SEGMENT_CELLS == 0;
}

/* Writes the items into cells, for which there are segments, and publishes them. Caller holds push.lock. */
static void push_fill(low_lock *self, void *const *items, size_t count, uint64_t pushed)
{
	assert(job_lock_is_mine(&self->push.lock) && "the caller holds the lock");
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
	/* Release pairs with the acquire in pop: a thread that sees the count sees the cells and links that it covers. */
	atomic_store_explicit(&self->push.count, pushed, memory_order_release);
}

/* The number of items that the queue still accepts. Caller holds push.lock. */
static size_t push_left(const low_lock *self, uint64_t pushed, uint64_t popped)
{
	/* Relaxed: ordered by the lock. */
	bool closed = atomic_load_explicit(&self->push.closed, memory_order_relaxed);
	assert(popped <= pushed && pushed - popped <= self->capacity);
	return closed ? 0 : self->capacity - (pushed - popped);
}

/* True if the producer of a batch, who has just begun a segment, should let consumers run first: they lie far behind,
 * and none has popped since the last segment was begun, so they want a CPU. They may also have ended; then it gives up
 * after JOB_QUEUE_YIELDS. Never true if the producer itself is the consumer. Caller holds push.lock. */
static bool push_should_yield(low_lock *self, uint64_t pushed, uint64_t popped)
{
	if (self->push.popped != popped) {
		self->push.popped = popped;
		self->push.yields = JOB_QUEUE_YIELDS;
		return false;
	}
	/* Relaxed: an old value costs a yield or leaves one out. */
	if (pushed - popped <= JOB_QUEUE_AHEAD || self->push.yields == 0 ||
	    atomic_load_explicit(&self->pop.consumer, memory_order_relaxed) == job_this_thread())
		return false;
	self->push.yields--;
	return true;
}

/* Pushes as many of the items as it can. Caller holds push.lock, which this releases. */
static int push_and_give(low_lock *self, void *const *items, size_t count)
{
	segment *fresh = NULL;
	size_t fresh_count = 0;
	for (bool may_grow = true;;) {
		uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
		/* Acquire pairs with the release in pop: its reads of the cells come before they are overwritten here. No other
		 * thread pushes meanwhile, so at the moment of this load the queue holds exactly pushed - popped items. */
		uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);
		size_t left = push_left(self, pushed, popped), wanted = least(count, left);
		size_t cells = self->push.end - pushed + (ring_free(self, popped) + fresh_count) * JOB_SEGMENT_CELLS;
		if (wanted > cells && may_grow) {
			job_lock_give(&self->push.lock);
			size_t needed = fresh_count + (wanted - cells + JOB_SEGMENT_CELLS - 1) / JOB_SEGMENT_CELLS;
			fresh_count = segments_create(&self->memory, &fresh, fresh_count, needed);
			may_grow = fresh_count == needed;
			job_lock_take(&self->push.lock);
			continue;
		}
		ring_insert(self, fresh); /* even if consumers have freed segments meanwhile and these are not needed yet */
		size_t done = least(wanted, cells);
		uint64_t end = self->push.end;
		if (done > 0)
			push_fill(self, items, done, pushed);
		bool yield = count > 1 && self->push.end != end && push_should_yield(self, pushed + done, popped);
		self->push.stop = pushed + done + least(self->push.end - (pushed + done), left - done);
		bool closed = atomic_load_explicit(&self->push.closed, memory_order_relaxed); /* ordered by the lock */
		JOB_CHECK(push_is_sound(self));
		job_lock_give(&self->push.lock);
		if (done > 0)
			job_event_signal(&self->base.items, (uint32_t)done);
		if (yield)
			sched_yield();
		return done > 0 ? (int)done : closed ? -EPIPE : left == 0 ? -EAGAIN : -ENOMEM;
	}
}

/* push_and_give for one item, with the result of low_lock_push. */
static RARE int push_one_and_give(low_lock *self, void *item)
{
	int result = push_and_give(self, &item, 1);
	return result < 0 ? result : 0;
}

/* Pushes the item, when the lock was not free. */
static RARE int push_one_later(low_lock *self, void *item)
{
	job_lock_take(&self->push.lock);
	return push_one_and_give(self, item);
}

static RARE int push_one_and_wake(low_lock *self)
{
	job_lock_wake(&self->push.lock);
	job_event_signal(&self->base.items, 1);
	return 0;
}

static int low_lock_push(stilb_job_queue *queue, void *item, uint32_t thread)
{
	(void)thread;
	low_lock *self = low_lock_of(queue);
	if (__builtin_expect(!job_lock_take_now(&self->push.lock), 0))
		return push_one_later(self, item);
	uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
	if (__builtin_expect(pushed == self->push.stop, 0))
		return push_one_and_give(self, item);
	self->push.at->cell[pushed % JOB_SEGMENT_CELLS] = item;
	/* Release pairs with the acquire in pop: a thread that sees the count sees the cell. */
	atomic_store_explicit(&self->push.count, pushed + 1, memory_order_release);
	JOB_CHECK(push_is_sound(self));
	bool sleepers = job_lock_release(&self->push.lock), waiters = job_event_awaited(&self->base.items);
	return __builtin_expect(sleepers | waiters, 0) ? push_one_and_wake(self) : 0;
}

static int low_lock_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread)
{
	(void)thread;
	low_lock *self = low_lock_of(queue);
	job_lock_take(&self->push.lock);
	uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* ordered by the lock */
	if (count > self->push.stop - pushed)
		return push_and_give(self, items, count);
	push_fill(self, items, count, pushed);
	JOB_CHECK(push_is_sound(self));
	job_lock_give(&self->push.lock);
	job_event_signal(&self->base.items, (uint32_t)count);
	return (int)count;
}

static void low_lock_close(stilb_job_queue *queue)
{
	low_lock *self = low_lock_of(queue);
	job_lock_take(&self->push.lock);
	/* Release pairs with the acquire in pop_refused: a thread that sees the flag sees the final count. */
	atomic_store_explicit(&self->push.closed, true, memory_order_release);
	/* Ordered by the lock. */
	self->push.stop = atomic_load_explicit(&self->push.count, memory_order_relaxed);
	job_lock_give(&self->push.lock);
}

/* ---- pop ------------------------------------------------------------------------------------------------------ */

static bool low_lock_empty(stilb_job_queue *queue, uint32_t thread)
{
	(void)thread;
	low_lock *self = low_lock_of(queue);
	/* The popped count is loaded first. It never exceeds the pushed count, so if the pushed count loaded later is equal
	 * to it, the queue was empty at the first load. Acquire keeps the loads in this order; the second pairs with the
	 * release in push. */
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);
	return atomic_load_explicit(&self->push.count, memory_order_acquire) == popped;
}

/* The error of a pop that has found the queue empty. */
static int pop_refused(low_lock *self)
{
	/* Acquire pairs with the release in close. Nothing is pushed after that, so a queue that is empty now stays
	 * empty. */
	if (!atomic_load_explicit(&self->push.closed, memory_order_acquire))
		return -EAGAIN;
	return low_lock_empty(&self->base, 0) ? -EPIPE : -EAGAIN;
}

/* True if consumers know of an item: they need not read the producers' count to find one. Relaxed, both: without the
 * lock they may be old, and the answer is checked under it. */
static bool pop_is_stocked(const low_lock *self)
{
	return atomic_load_explicit(&self->pop.count, memory_order_relaxed) !=
	       atomic_load_explicit(&self->pop.seen, memory_order_relaxed);
}

/* Called before a look for a batch: gives producers some time if consumers are close behind them. */
static RARE void pop_keep_distance(low_lock *self)
{
	if (!atomic_load_explicit(&self->pop.pause, memory_order_relaxed)) /* a hint */
		return;
	uint64_t before = atomic_load_explicit(&self->push.count, memory_order_relaxed); /* both only compared */
	for (uint32_t i = 0; i < JOB_QUEUE_PAUSES; i++)
		job_sys_pause();
	uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_relaxed) - before;
	if (pushed < JOB_QUEUE_CLOSE / 4) /* no producer is running, or none is fast: it may be this thread */
		atomic_store_explicit(&self->pop.looks, JOB_QUEUE_LOOKS, memory_order_relaxed); /* a hint, as `pause` */
	atomic_store_explicit(&self->pop.pause, false, memory_order_relaxed);
}

/* Called after a look for a batch, which has found so many items: decides whether the next one pauses. */
static void pop_note_distance(low_lock *self, uint64_t found)
{
	bool close = found < least(JOB_QUEUE_CLOSE, self->capacity / 2);
	uint32_t looks = atomic_load_explicit(&self->pop.looks, memory_order_relaxed); /* all three: hints */
	if (close && looks > 0)
		atomic_store_explicit(&self->pop.looks, looks - 1, memory_order_relaxed);
	atomic_store_explicit(&self->pop.pause, close && looks == 0, memory_order_relaxed);
}

/* For asserts: count <= stop <= seen and end, and end is that of the segment being emptied. Caller holds pop.lock. */
static bool pop_is_sound(const low_lock *self)
{
	uint64_t count = atomic_load_explicit(&self->pop.count, memory_order_relaxed); /* as seen: ordered by the lock */
	uint64_t seen = atomic_load_explicit(&self->pop.seen, memory_order_relaxed);
	return job_lock_is_mine(&self->pop.lock) && count <= self->pop.stop && self->pop.stop <= seen &&
	       self->pop.stop <= self->pop.end && self->pop.end - count <= JOB_SEGMENT_CELLS &&
	       self->pop.end % JOB_SEGMENT_CELLS == 0;
}

/* Called when all items up to pop.stop have been popped, `popped` in all: raises stop, and looks for newer items if it
 * must; false if there are none. Caller holds pop.lock. */
static bool pop_refill(low_lock *self, uint64_t popped)
{
	assert(popped == self->pop.stop && "all items before it are taken");
	uint64_t seen = atomic_load_explicit(&self->pop.seen, memory_order_relaxed); /* ordered by the lock */
	if (seen == popped) {
		/* Acquire pairs with the release in push: the cells and links that the count covers are written. */
		seen = atomic_load_explicit(&self->push.count, memory_order_acquire);
		if (seen == popped)
			return false;
		/* Relaxed: pop_is_stocked alone reads it without the lock, and an old value there does no harm. */
		atomic_store_explicit(&self->pop.seen, seen, memory_order_relaxed);
	}
	if (popped == self->pop.end) {
		self->pop.at = self->pop.at->next;
		self->pop.end += JOB_SEGMENT_CELLS;
		atomic_store_explicit(&self->pop.consumer, job_this_thread(), memory_order_relaxed); /* see pop.consumer */
	}
	self->pop.stop = least(seen, self->pop.end);
	return true;
}

static RARE int pop_one_and_wake(low_lock *self)
{
	job_lock_wake(&self->pop.lock);
	job_event_signal(&self->base.space, 1);
	return 0;
}

/* Takes the next item, which lies before pop.stop. Caller holds pop.lock, which this releases. */
static inline int pop_one_and_give(low_lock *self, void **item, uint64_t popped)
{
	void **cell = self->pop.at->cell + popped % JOB_SEGMENT_CELLS;
	*item = *cell;
	assert(*item && "a published cell holds an item");
	*cell = NULL; /* fetches the line for this CPU alone, which makes the next push into it faster: see Speed above */
	/* Release pairs with the acquire in push: the cell has been read before it is overwritten. */
	atomic_store_explicit(&self->pop.count, popped + 1, memory_order_release);
	JOB_CHECK(pop_is_sound(self));
	bool sleepers = job_lock_release(&self->pop.lock), waiters = job_event_awaited(&self->base.space);
	return __builtin_expect(sleepers | waiters, 0) ? pop_one_and_wake(self) : 0;
}

/* pop_one_and_give when all items up to pop.stop have been popped: there may be newer ones. */
static RARE int pop_refill_and_give(low_lock *self, void **item, uint64_t popped)
{
	if (pop_refill(self, popped))
		return pop_one_and_give(self, item, popped);
	job_lock_give(&self->pop.lock);
	return pop_refused(self);
}

/* Caller holds pop.lock, which this releases. */
static inline int pop_any_and_give(low_lock *self, void **item)
{
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_relaxed); /* ordered by the lock */
	if (__builtin_expect(popped == self->pop.stop, 0))
		return pop_refill_and_give(self, item, popped);
	return pop_one_and_give(self, item, popped);
}

/* Pops an item when the lock was not free. */
static RARE int pop_one_later(low_lock *self, void **item)
{
	job_lock_take(&self->pop.lock);
	return pop_any_and_give(self, item);
}

/* Pops an item when consumers knew of none. */
static RARE int pop_one_newer(low_lock *self, void **item)
{
	if (low_lock_empty(&self->base, 0)) /* without the lock, for which idle consumers would contend */
		return pop_refused(self);
	return pop_one_later(self, item);
}

static int low_lock_pop(stilb_job_queue *queue, void **item, uint32_t thread)
{
	(void)thread;
	low_lock *self = low_lock_of(queue);
	if (__builtin_expect(!pop_is_stocked(self), 0))
		return pop_one_newer(self, item);
	if (__builtin_expect(!job_lock_take_now(&self->pop.lock), 0))
		return pop_one_later(self, item);
	return pop_any_and_give(self, item);
}

static int low_lock_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread)
{
	(void)thread;
	low_lock *self = low_lock_of(queue);
	bool look = !pop_is_stocked(self);
	if (look) {
		pop_keep_distance(self);
		if (low_lock_empty(&self->base, 0)) /* as in pop_one_newer */
			return pop_refused(self);
	}
	job_lock_take(&self->pop.lock);
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_relaxed), first = popped; /* by the lock */
	size_t taken = 0;
	while (taken < max) {
		if (popped == self->pop.stop) {
			if (!pop_refill(self, popped))
				break;
			continue;
		}
		size_t part = least(max - taken, self->pop.stop - popped);
		void **cell = self->pop.at->cell + popped % JOB_SEGMENT_CELLS;
		memcpy(items + taken, cell, part * sizeof *items);
		memset(cell, 0, part * sizeof *items); /* makes later pushes into these cells faster, as in low_lock_pop */
		taken += part;
		popped += part;
	}
	if (look)
		pop_note_distance(self, atomic_load_explicit(&self->pop.seen, memory_order_relaxed) - first); /* by the lock */
	/* Release pairs with the acquire in push: the cells have been read before they are overwritten. */
	atomic_store_explicit(&self->pop.count, popped, memory_order_release);
	JOB_CHECK(pop_is_sound(self));
	job_lock_give(&self->pop.lock);
	if (taken == 0)
		return pop_refused(self);
	job_event_signal(&self->base.space, (uint32_t)taken);
	return (int)taken;
}

/* ---- life ----------------------------------------------------------------------------------------------------- */

static void low_lock_rest(stilb_job_queue *queue, uint32_t thread)
{
	(void)queue; /* nothing is held between calls */
	(void)thread;
}

static void low_lock_destroy(stilb_job_queue *queue)
{
	low_lock *self = low_lock_of(queue);
	JOB_CHECK(ring_is_sound(self));
	segment *first = self->push.at->next;
	self->push.at->next = NULL; /* turns the ring into a list */
	stilb_job_allocator memory = self->memory;
	segments_destroy(&memory, first);
	job_release(&memory, self, sizeof *self);
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
	stilb_job_allocator memory = job_allocator_of(desc->allocator);
	segment *first = NULL;
	low_lock *self = job_allocate(&memory, sizeof *self, JOB_LINE);
	if (!self || segments_create(&memory, &first, 0, 1) == 0) {
		job_release(&memory, self, sizeof *self);
		return -ENOMEM;
	}
	assert(desc->capacity > 0);
	memset(self, 0, sizeof *self);
	first->next = first;
	self->base.ops = &low_lock_ops;
	self->capacity = desc->capacity;
	self->memory = memory;
	self->push.at = self->pop.at = first;
	self->push.end = self->pop.end = JOB_SEGMENT_CELLS;
	self->push.stop = least(JOB_SEGMENT_CELLS, self->capacity);
	self->push.segments = 1;
	*queue = &self->base;
	return 0;
}
