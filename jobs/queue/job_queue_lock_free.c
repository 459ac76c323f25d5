/*
 * The lock-free queue: a list of segments whose cells are filled from first to last and emptied in the same order.
 *
 * Cells.        A cell is empty, then holds an item, then is taken; each change is one compare-exchange of the cell
 *               itself. There are no tickets and no counters: a producer puts its item into the first empty cell, a
 *               consumer takes the item from the first cell that is not taken. So the cells of the list are, from first
 *               to last, taken cells, then items, then empty cells. Each thread remembers how far it got and searches
 *               on from there, first with doubling steps, then by bisection. When all cells of the last segment are
 *               filled, a producer appends another; when all of the first are taken, a consumer unlinks it.
 * Linearizable. A push takes effect at its successful compare-exchange, and so does a pop. A pop that finds nothing
 *               takes effect when it reads an empty cell, or no next segment, behind a taken cell: everything before is
 *               taken, and everything behind is empty because cells are filled in order. The position of a cell in the
 *               order of all items is known exactly, so the capacity is exact, too.
 * Lock-free.    A compare-exchange of a cell, an end or a link fails only because another one has succeeded. No thread
 *               waits for another, and a thread that is preempted anywhere keeps no item from the others. Not
 *               wait-free: a thread may lose again and again. A push that needs a new segment is only as lock-free as
 *               the allocator.
 * Close.        stilb_job_queue_close sets a flag that every push reads. A push that has read the flag too early is
 *               stopped by the first consumer that finds the flag set and the queue empty: it puts a seal where the
 *               next item would go, by compare-exchange. If that fails, an item has arrived, and the consumer takes it;
 *               if it succeeds, no item can ever follow.
 * Reclamation.  Hazard pointers (Maged Michael, IEEE TPDS 2004) that stay set between calls: only when a thread moves
 *               to another segment at one end of the queue, it announces that segment and checks that the end still is
 *               there; calls in between store nothing but their cell. Retired segments lie in slots, from which
 *               producers take one that no hazard pointer names. Unlike with epochs, a thread that stops for ever keeps
 *               two segments from being reused and not all that are retired later, and a thread that continues has
 *               nothing to announce.
 * Reuse.        The marks "empty" and "taken" change roles each time a segment is reused, so it need not be cleared.
 * Memory.       Segments of JOB_SEGMENT_CELLS cells of 8 bytes: those that hold items, at most 2 more at the ends, and
 *               at most 3 * threads + JOB_SPARE_SEGMENTS retired ones, where threads is one more than the highest
 *               thread number that has called.
 *
 * Sources. Filling and emptying cells by compare-exchange, with indices that lag behind: Tsigas and Zhang, "A simple,
 * fast and scalable non-blocking concurrent FIFO queue", SPAA 2001; over linked blocks, with indices of each thread's
 * own: Gidenstam, Sundell and Tsigas, "Cache-aware lock-free queues for multiple producers/consumers and weak memory
 * consistency", OPODIS 2010. Not tickets by fetch-and-add (LCRQ, Morrison and Afek, PPoPP 2013; FAAArrayQueue,
 * Ramalhete and Correia, 2016): those take two atomic operations per push instead of one and contend for a counter's
 * line and for the cell's, and a consumer whose ticket is ahead of its producer must wait or invalidate the cell.
 */
#include "jobs/job_allocate.h"
#include "jobs/job_contract.h"
#include "jobs/job_line.h"
#include "jobs/job_sys.h"
#include "jobs/queue/job_queue_internal.h"

#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <string.h>

/* The model test (tests/jobs/model) makes all of these smaller. JOB_BACKOFF_PAUSES: the most pauses of one back-off. */
#ifndef JOB_SEGMENT_CELLS
#define JOB_SEGMENT_CELLS 1024
#define JOB_SEGMENT_ALIGN JOB_LINE
#define JOB_SPARE_SEGMENTS 8
#define JOB_BACKOFF_PAUSES 512
#endif
#define LOOKS_FOR_SEGMENT 8 /* so many retired segments may be found in use before a new one is allocated */

enum { HEAD, TAIL, ENDS };

typedef struct lock_free_segment lock_free_segment;

struct lock_free_segment {
	/* Release in segment_append, acquire in tail_move and head_move; set once. */
	_Atomic(lock_free_segment *) next;
	/* Constant from segment_append until the segment is retired. */
	uint64_t first; /* the position of cell 0 in the order of all items */
	void *empty;    /* the mark of empty cells: NULL or &other_mark; taken_mark() gives the mark of taken ones */
	alignas(JOB_SEGMENT_ALIGN) _Atomic(void *) cell[JOB_SEGMENT_CELLS];
};

/* How far a thread has got at one end of the queue. */
typedef struct thread_place {
	lock_free_segment *segment; /* the one that the thread's hazard pointer names, or NULL */
	void *empty;                /* a copy of segment->empty */
	uint32_t index;             /* all cells before it are filled (tail) or taken (head) */
	uint32_t pauses;            /* the length of the last back-off, in CPU pauses */
} thread_place;

typedef struct thread_state {
	alignas(JOB_LINE) _Atomic(lock_free_segment *) hazard[ENDS]; /* written by the thread, read by all */
	/* The thread's own, on a cache line of its own. */
	alignas(JOB_LINE / 2) thread_place place[ENDS];
	uint64_t popped;      /* a lower bound of the number of items taken since the queue was created */
	uint32_t slot;        /* index in lock_free.slot of the slot to look at first */
	job_exclusive caller; /* asserts that two calls with the same thread number do not overlap */
} thread_state;
static_assert(sizeof(thread_state) == JOB_LINE, "small and padded");

typedef struct lock_free {
	stilb_job_queue base;
	size_t capacity;
	uint32_t thread_count;
	_Atomic(lock_free_segment *) *slot; /* retired segments or NULL; ENDS per thread and JOB_SPARE_SEGMENTS more */
	_Atomic uint32_t used_count;        /* the highest thread number that has called, plus one */
	_Atomic bool closed;
	stilb_job_allocator memory;
	size_t size; /* of this struct with all that follows, in bytes */
	struct {
		alignas(JOB_LINE) _Atomic(lock_free_segment *) segment;
	} end[ENDS];
	thread_state thread[];
} lock_free;

/* Marks are addresses that no item and no segment can have. A cell, or a segment's `next`, that holds SEAL ends a
 * closed queue. */
static alignas(alignof(lock_free_segment)) char seal_mark, other_mark;
#define SEAL ((void *)&seal_mark)

/* The mark of a taken cell in a segment whose empty cells hold this mark. */
static void *taken_mark(const void *empty)
{
	return empty ? NULL : &other_mark;
}

static lock_free *lock_free_of(stilb_job_queue *queue)
{
	return (lock_free *)queue;
}

/* Begins a call with this thread number; job_exclusive_end(&self->caller) ends it. */
static thread_state *thread_begin(lock_free *queue, uint32_t thread)
{
	assert(thread < queue->thread_count);
	thread_state *self = &queue->thread[thread];
	job_exclusive_begin(&self->caller);
	return self;
}

static bool lock_free_closed(lock_free *queue)
{
	return atomic_load_explicit(&queue->closed, memory_order_acquire); /* pairs with lock_free_close */
}

/* ---- hazards and retired segments ------------------------------------------------------------------------------- */

/*
 * A segment is reused once the head has left it and no hazard pointer names it. Four steps are seq_cst: moving an end,
 * setting a hazard pointer, reloading the end after that, and reading all hazard pointers. So either the thread that
 * reads all hazard pointers finds this one, or the end was moved before it was set, and then the thread that set it
 * sees the move and drops the segment. The tail may leave a segment later than the head; until it has, the thread that
 * appended the next segment is in tail_move with its hazard pointer on this one. used_count, by which readers know how
 * many hazard pointers there are, is raised by a seq_cst exchange, or a seq_cst load finds it raised, before a thread
 * sets its first one.
 */
static void thread_announce(lock_free *queue, uint32_t thread)
{
	/* Seq_cst, also when the exchange fails: if another thread has raised the number, the load that finds it raised
	 * stands for the exchange. In the order of all seq_cst operations it comes after that thread's exchange and before
	 * this thread sets a hazard pointer; so a thread that then reads the number finds this one counted. A relaxed load
	 * has no place in that order, and C11 would let the number that is read be an old one. The number never falls. */
	uint32_t count = atomic_load_explicit(&queue->used_count, memory_order_seq_cst);
	while (count <= thread && !atomic_compare_exchange_weak_explicit(&queue->used_count, &count, thread + 1,
	                                                                 memory_order_seq_cst, memory_order_seq_cst))
		;
}

/* Moves the thread's place to the segment that is the end now. */
static void place_move(lock_free *queue, thread_state *self, uint32_t end)
{
	thread_announce(queue, (uint32_t)(self - queue->thread));
	lock_free_segment *segment,
		*seen = atomic_load_explicit(&queue->end[end].segment, memory_order_relaxed); /* checked below */
	do {
		segment = seen;
		/* Also release, pairs with segment_in_use: all accesses to the previous segment come before. */
		atomic_exchange_explicit(&self->hazard[end], segment, memory_order_seq_cst);
		/* Also acquire, pairs with end_advance: the segment's constants are visible. */
		seen = atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst);
	} while (seen != segment);
	self->place[end] =
		(thread_place){.segment = segment, .empty = segment->empty, .pauses = self->place[end].pauses / 2};
}

/* True if this call moved the end from segment to next. The caller's hazard pointer names segment, so that it cannot
 * have been reused in between. */
static bool end_advance(lock_free *queue, uint32_t end, lock_free_segment *segment, lock_free_segment *next)
{
	/* Seq_cst: see the head of this section. The load saves an exchange in vain, since in most cases another thread has
	 * moved the end already. */
	return atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst) == segment &&
	       atomic_compare_exchange_strong_explicit(&queue->end[end].segment, &segment, next, memory_order_seq_cst,
	                                               memory_order_seq_cst);
}

static bool segment_in_use(lock_free *queue, const lock_free_segment *segment)
{
	/* Seq_cst: see the head of this section. Also acquire, pairs with place_move and lock_free_rest: a thread that has
	 * left the segment has done all its accesses. */
	uint32_t count = atomic_load_explicit(&queue->used_count, memory_order_seq_cst);
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t end = 0; end < ENDS; end++)
			if (atomic_load_explicit(&queue->thread[i].hazard[end], memory_order_seq_cst) == segment)
				return true;
	return false;
}

/* The number of slots in use: enough for every segment that hazard pointers can name, and JOB_SPARE_SEGMENTS more. */
static uint32_t slot_count(lock_free *queue)
{
	/* Relaxed: the value counts this thread at least, which has raised it; later threads may or may not be counted. */
	return ENDS * atomic_load_explicit(&queue->used_count, memory_order_relaxed) + JOB_SPARE_SEGMENTS;
}

/* Puts segment into the slot that the thread looks at, self->slot, and returns what was there; both may be NULL. */
static lock_free_segment *slot_swap(lock_free *queue, thread_state *self, lock_free_segment *segment)
{
	/* Release and acquire pair with each other: a thread that takes a segment out sees all earlier uses of it. */
	assert(self->slot < ENDS * queue->thread_count + JOB_SPARE_SEGMENTS);
	return atomic_exchange_explicit(&queue->slot[self->slot], segment, memory_order_acq_rel);
}

static bool slot_occupied(lock_free *queue, thread_state *self)
{
	return atomic_load_explicit(&queue->slot[self->slot], memory_order_relaxed); /* may be old; slot_swap decides */
}

/* Puts a segment into a free slot. If all are full, frees a segment: there are more slots than hazard pointers, so one
 * of the segments is not in use. */
static void segment_retire(lock_free *queue, thread_state *self, lock_free_segment *segment)
{
	uint32_t count = slot_count(queue);
	for (uint32_t i = 0; i < count && slot_occupied(queue, self); i++)
		self->slot = (self->slot + 1) % count;
	while ((segment = slot_swap(queue, self, segment))) {
		if (!segment_in_use(queue, segment)) {
			job_release(&queue->memory, segment, sizeof *segment);
			return;
		}
		self->slot = (self->slot + 1) % count; /* NOLINT(clang-analyzer-core.DivideZero): a user has slots */
	}
}

static lock_free_segment *segment_create(const stilb_job_allocator *memory)
{
	lock_free_segment *segment = job_allocate(memory, sizeof *segment, alignof(lock_free_segment));
	if (!segment)
		return NULL;
	segment->empty = NULL;
	for (uint32_t i = 0; i < JOB_SEGMENT_CELLS; i++)
		atomic_init(&segment->cell[i], NULL);
	return segment;
}

/* A retired segment that no thread uses any more, or a new one; NULL if there is no memory. */
static lock_free_segment *segment_find(lock_free *queue, thread_state *self)
{
	uint32_t count = slot_count(queue), looks = 0;
	for (uint32_t i = 0; i < count && looks < LOOKS_FOR_SEGMENT; i++) {
		lock_free_segment *segment = slot_occupied(queue, self) ? slot_swap(queue, self, NULL) : NULL;
		if (segment) {
			if (!segment_in_use(queue, segment))
				return segment;
			segment_retire(queue, self, segment);
			looks++;
		}
		self->slot = (self->slot + 1) % count;
	}
	return segment_create(&queue->memory);
}

/* ---- cells ------------------------------------------------------------------------------------------------------ */

static bool cell_is(const lock_free_segment *segment, uint32_t index, const void *mark)
{
	/* Acquire pairs with the release of the thread that changed the cell. That thread had seen the previous cell
	 * change, and so on, so the changes of all cells before this one are visible as well. */
	return atomic_load_explicit(&segment->cell[index], memory_order_acquire) == mark;
}

/* The first cell at or after index that holds mark, or with is = false the first one that does not; JOB_SEGMENT_CELLS
 * if there is none. The cells must be sorted: those that do not meet the condition come before those that do. */
static uint32_t cell_search(const lock_free_segment *segment, uint32_t index, const void *mark, bool is)
{
	assert(index <= JOB_SEGMENT_CELLS);
	uint32_t end = index;
	for (uint32_t step = 1; end < JOB_SEGMENT_CELLS && cell_is(segment, end, mark) != is; step *= 2) {
		index = end + 1;
		end += step;
	}
	if (end > JOB_SEGMENT_CELLS)
		end = JOB_SEGMENT_CELLS;
	while (index < end) {
		uint32_t middle = index + (end - index) / 2;
		if (cell_is(segment, middle, mark) == is)
			end = middle;
		else
			index = middle + 1;
	}
	return index;
}

/* For asserts: every cell of the segment is taken, or with taken = false at least filled. Reads all cells. */
static bool segment_is_used_up(const lock_free_segment *segment, bool taken)
{
	void *mark = taken_mark(segment->empty);
	for (uint32_t i = 0; i < JOB_SEGMENT_CELLS; i++)
		if (taken ? !cell_is(segment, i, mark) : cell_is(segment, i, segment->empty))
			return false;
	return true;
}

/* Changes the cell that `place` points at from *seen to `to`. False if the cell holds something else, which is then
 * stored in *seen. */
static bool cell_change(thread_place *place, void **seen, void *to)
{
	assert(place->index < JOB_SEGMENT_CELLS);
	/* Release and acquire pair with each other and with cell_is. */
	return atomic_compare_exchange_strong_explicit(&place->segment->cell[place->index], seen, to, memory_order_acq_rel,
	                                               memory_order_acquire);
}

/* Exponential back-off after a lost compare-exchange: two threads that take the cell's cache line from each other for
 * every item are slower than either alone. The length is halved when the thread moves to another segment or finds the
 * queue empty. */
static void place_back_off(thread_place *place)
{
	uint32_t more = place->pauses * 2 + 4;
	place->pauses = more > JOB_BACKOFF_PAUSES ? JOB_BACKOFF_PAUSES : more;
	for (uint32_t i = 0; i < place->pauses; i++)
		job_sys_pause();
}

/* ---- pop -------------------------------------------------------------------------------------------------------- */

/* Leaves a segment whose cells are all taken for the next one; false if there is none. */
static bool head_move(lock_free *queue, thread_state *self)
{
	lock_free_segment *segment = self->place[HEAD].segment;
	bool unlinked = false;
	if (segment) {
		/* Acquire pairs with segment_append. */
		lock_free_segment *next = atomic_load_explicit(&segment->next, memory_order_acquire);
		if (!next || next == SEAL)
			return false;
		JOB_CHECK(segment_is_used_up(segment, true));
		unlinked = end_advance(queue, HEAD, segment, next);
	}
	place_move(queue, self, HEAD);
	if (unlinked)
		segment_retire(queue, self, segment);
	return true;
}

/* Moves the thread's place at the head to the first cell that is not taken. The item there, which stays in its cell; or
 * NULL, if the cell held no item or there is no such cell yet. */
static void *head_find(lock_free *queue, thread_state *self)
{
	thread_place *place = &self->place[HEAD];
	for (;;) {
		void *taken = taken_mark(place->empty);
		if (place->segment && place->index < JOB_SEGMENT_CELLS) {
			/* Acquire pairs with the release in cell_change: what the item points to is visible. */
			void *seen = atomic_load_explicit(&place->segment->cell[place->index], memory_order_acquire);
			if (seen != taken)
				return seen == place->empty || seen == SEAL ? NULL : seen;
			place->index = cell_search(place->segment, place->index + 1, taken, false);
		} else if (!head_move(queue, self)) {
			return NULL;
		}
	}
}

/* Called when head_find has found no item. -EAGAIN if the queue is not closed; else puts the seal there and returns
 * -EPIPE, or 0 if an item has arrived meanwhile. */
static int head_seal(lock_free *queue, thread_place *place)
{
	if (!lock_free_closed(queue))
		return -EAGAIN;
	if (place->index < JOB_SEGMENT_CELLS) {
		void *seen = place->empty;
		return cell_change(place, &seen, SEAL) || seen == SEAL ? -EPIPE : 0;
	}
	lock_free_segment *next = NULL;
	/* Release and acquire pair with tail_move and with each other. */
	return atomic_compare_exchange_strong_explicit(&place->segment->next, &next, SEAL, memory_order_acq_rel,
	                                               memory_order_acquire) ||
	               next == SEAL
	           ? -EPIPE
	           : 0;
}

static int pop_one(lock_free *queue, thread_state *self, void **item)
{
	thread_place *place = &self->place[HEAD];
	for (;;) {
		void *seen = head_find(queue, self);
		if (!seen) {
			place->pauses /= 2;
			int error = head_seal(queue, place);
			if (error)
				return error;
		} else if (*item = seen, cell_change(place, &seen, taken_mark(place->empty))) {
			place->index++;
			return 0;
		} else {
			place->index++;
			place_back_off(place);
		}
	}
}

static int lock_free_pop(stilb_job_queue *base, void **item, uint32_t thread)
{
	lock_free *queue = lock_free_of(base);
	thread_state *self = thread_begin(queue, thread);
	int error = pop_one(queue, self, item);
	job_exclusive_end(&self->caller);
	if (error == 0)
		job_event_signal(&base->space, 1);
	return error;
}

static int lock_free_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread)
{
	for (size_t i = 0; i < max; i++) {
		int error = lock_free_pop(queue, &items[i], thread);
		if (error)
			return i > 0 ? (int)i : error;
	}
	return (int)max;
}

static bool lock_free_empty(stilb_job_queue *base, uint32_t thread)
{
	lock_free *queue = lock_free_of(base);
	thread_state *self = thread_begin(queue, thread);
	bool empty = !head_find(queue, self);
	job_exclusive_end(&self->caller);
	return empty;
}

/* ---- push ------------------------------------------------------------------------------------------------------- */

/* Appends a segment to last, unless another thread has done so; *next is the segment after last, or SEAL. 0 or
 * -ENOMEM. */
static int segment_append(lock_free *queue, thread_state *self, lock_free_segment *last, lock_free_segment **next)
{
	lock_free_segment *segment = segment_find(queue, self);
	if (!segment)
		return -ENOMEM;
	atomic_init(&segment->next, NULL);
	segment->first = last->first + JOB_SEGMENT_CELLS;
	/* In a reused segment every cell, also cell 0, holds the mark of taken cells, which becomes that of empty ones. */
	if (!cell_is(segment, 0, segment->empty))
		segment->empty = taken_mark(segment->empty);
	*next = NULL;
	/* Release: this segment is initialised. Acquire, on failure: so is the other thread's. */
	if (atomic_compare_exchange_strong_explicit(&last->next, next, segment, memory_order_acq_rel, memory_order_acquire))
		*next = segment;
	else
		segment_retire(queue, self, segment);
	return 0;
}

/* Leaves a segment whose cells are all filled for the next one, which it appends if there is none. 0, -ENOMEM or
 * -EPIPE. */
static int tail_move(lock_free *queue, thread_state *self)
{
	lock_free_segment *segment = self->place[TAIL].segment;
	if (segment) {
		/* Acquire pairs with segment_append. */
		lock_free_segment *next = atomic_load_explicit(&segment->next, memory_order_acquire);
		int error = next ? 0 : segment_append(queue, self, segment, &next);
		if (error)
			return error;
		if (next == SEAL)
			return -EPIPE;
		JOB_CHECK(segment_is_used_up(segment, false));
		end_advance(queue, TAIL, segment, next);
	}
	place_move(queue, self, TAIL);
	return 0;
}

/* True if the queue holds `capacity` items. */
static bool tail_full(lock_free *queue, thread_state *self)
{
	const thread_place *tail = &self->place[TAIL], *head = &self->place[HEAD];
	uint64_t pushed = tail->segment->first + tail->index;
	if (pushed - self->popped < queue->capacity)
		return false;
	head_find(queue, self);
	self->popped = head->segment->first + head->index;
	/* pushed < popped: other threads have filled the cell at this thread's place long ago. The queue is then reported
	 * as not full; the caller's cell_change fails, and it searches on from there. */
	return pushed >= self->popped && pushed - self->popped >= queue->capacity;
}

static int push_one(lock_free *queue, thread_state *self, void *item)
{
	thread_place *place = &self->place[TAIL];
	if (lock_free_closed(queue))
		return -EPIPE;
	for (;;) {
		if (!place->segment || place->index == JOB_SEGMENT_CELLS) {
			int error = tail_move(queue, self);
			if (error)
				return error;
			continue;
		}
		if (queue->capacity != SIZE_MAX && tail_full(queue, self))
			return -EAGAIN;
		void *seen = place->empty;
		if (cell_change(place, &seen, item)) {
			place->index++;
			return 0;
		}
		if (place->index > 0) /* cell 0: this thread is new in the segment, and others may have filled it long ago */
			place_back_off(place);
		/* Only the last of the cells that are not empty can hold a seal. */
		place->index = cell_search(place->segment, place->index, place->empty, true);
		if (cell_is(place->segment, place->index - 1, SEAL))
			return -EPIPE;
	}
}

static int lock_free_push(stilb_job_queue *base, void *item, uint32_t thread)
{
	lock_free *queue = lock_free_of(base);
	thread_state *self = thread_begin(queue, thread);
	int error = push_one(queue, self, item);
	job_exclusive_end(&self->caller);
	if (error == 0)
		job_event_signal(&base->items, 1);
	return error;
}

static int lock_free_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread)
{
	for (size_t i = 0; i < count; i++) {
		int error = lock_free_push(queue, items[i], thread);
		if (error)
			return i > 0 ? (int)i : error;
	}
	return (int)count;
}

/* ---- life ------------------------------------------------------------------------------------------------------- */

static void lock_free_close(stilb_job_queue *queue)
{
	atomic_store_explicit(&lock_free_of(queue)->closed, true, memory_order_release); /* pairs with lock_free_closed */
}

static void lock_free_rest(stilb_job_queue *queue, uint32_t thread)
{
	thread_state *self = thread_begin(lock_free_of(queue), thread);
	for (uint32_t end = 0; end < ENDS; end++) {
		self->place[end].segment = NULL;
		/* Release pairs with segment_in_use: all accesses to the segment come before. */
		atomic_store_explicit(&self->hazard[end], NULL, memory_order_release);
	}
	job_exclusive_end(&self->caller);
}

static void lock_free_destroy(stilb_job_queue *base)
{
	lock_free *queue = lock_free_of(base);
	stilb_job_allocator memory = queue->memory;
	/* Relaxed throughout: no other call is in progress. */
	lock_free_segment *segment = atomic_load_explicit(&queue->end[HEAD].segment, memory_order_relaxed);
	while (segment && segment != SEAL) {
		lock_free_segment *next = atomic_load_explicit(&segment->next, memory_order_relaxed);
		job_release(&memory, segment, sizeof *segment);
		segment = next;
	}
	uint32_t slots = slot_count(queue);
	for (uint32_t i = 0; i < slots; i++)
		job_release(&memory, atomic_load_explicit(&queue->slot[i], memory_order_relaxed), sizeof *segment);
	job_release(&memory, queue, queue->size);
}

int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **created)
{
	static const job_queue_ops ops = {lock_free_push,  lock_free_push_n, lock_free_pop,  lock_free_pop_n,
	                                  lock_free_empty, lock_free_close,  lock_free_rest, lock_free_destroy};
	size_t slots_at = sizeof(lock_free) + desc->thread_count * sizeof(thread_state);
	size_t size = slots_at + (ENDS * desc->thread_count + JOB_SPARE_SEGMENTS) * sizeof(lock_free_segment *);
	stilb_job_allocator memory = job_allocator_of(desc->allocator);
	lock_free *queue = job_allocate(&memory, size, JOB_LINE);
	lock_free_segment *segment = segment_create(&memory);
	if (!queue || !segment) {
		job_release(&memory, queue, size);
		job_release(&memory, segment, sizeof *segment);
		return -ENOMEM;
	}
	memset(queue, 0, size); /* no thread has called, all slots are empty */
	queue->base.ops = &ops;
	queue->capacity = desc->capacity;
	queue->thread_count = desc->thread_count;
	queue->memory = memory;
	queue->size = size;
	queue->slot = (_Atomic(lock_free_segment *) *)((char *)queue + slots_at);
	atomic_init(&segment->next, NULL);
	segment->first = 0;
	atomic_init(&queue->end[HEAD].segment, segment);
	atomic_init(&queue->end[TAIL].segment, segment);
	*created = &queue->base;
	return 0;
}
