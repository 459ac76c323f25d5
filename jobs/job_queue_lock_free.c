/*
 * The lock-free queue: a list of segments of cells that are filled from the first to the last and taken in the same order.
 *
 * Cells.        A cell of a segment is empty, then holds an item, then is taken; each change is one compare-exchange of
 *               the cell itself. There are no tickets and no counters: a producer puts its item into the first empty
 *               cell, a consumer takes the item from the first cell that is not taken. So the filled cells are always
 *               the first ones of the list, and so are the taken ones; each thread remembers how far it got and
 *               searches on from there, with doubled steps and then by halves. When all cells of the last segment are
 *               filled, a producer appends another; when all of the first are taken, a consumer unlinks it.
 * Linearisable. A push happens at its successful compare-exchange, a pop too. A pop that finds nothing happens when it
 *               reads an empty cell, or no next segment, behind a taken cell: all before is taken and, cells being
 *               filled in order, all behind is empty. Positions are exact, so the capacity is as well.
 * Lock-free.    A compare-exchange on a cell, an end or a link fails only because another one succeeded; nobody waits
 *               for anybody, a thread stalled anywhere stops nobody, and an item is never in the hands of a stalled
 *               thread but by that thread's own finished pop. Not wait-free: a thread may lose again and again.
 *               Strictness ends at malloc: push asks for a segment when no retired one is free.
 * Close.        stilb_job_queue_close sets a flag that every push reads. A push that read it too early is stopped by
 *               the first consumer that finds the flag and then nothing in the queue: it puts a seal where the next
 *               item would go, by compare-exchange. If that fails an item has come, and it is taken; if not, nothing
 *               ever comes.
 * Reclamation.  Hazard pointers (Maged Michael, IEEE TPDS 2004), but left up between calls: a thread names the segment
 *               it works in at either end, and checks that it still is the end, only when it goes on to another
 *               segment. In between a call stores nothing but its cell. Retired segments lie in slots, from which
 *               producers take one that nobody names. Unlike with epochs, a thread that stops for ever keeps two
 *               segments from being used again, not all that are retired later; and a thread that comes back has
 *               nothing to announce first.
 * Reuse.        The marks "empty" and "taken" change roles each time a segment is used, so nothing has to be cleared.
 * Memory.       Segments of JOB_SEGMENT_CELLS cells of 8 bytes: those with items in them, at most 2 more at the ends,
 *               and at most 3 * threads + JOB_SPARE_SEGMENTS retired, where threads is the highest number that has
 *               called plus one.
 *
 * Sources. Filling and taking cells by compare-exchange, with indices that lag: Tsigas and Zhang, "A simple, fast and
 * scalable non-blocking concurrent FIFO queue", SPAA 2001; over linked blocks with each thread's own indices:
 * Gidenstam, Sundell and Tsigas, "Cache-aware lock-free queues for multiple producers/consumers and weak memory
 * consistency", OPODIS 2010.
 * Why not tickets by fetch-and-add (LCRQ, Morrison and Afek, PPoPP 2013; FAAArrayQueue, Ramalhete and Correia, 2016):
 * they take two atomic operations per push instead of one, contend on a counter's line and on the cell's, and a consumer
 * whose ticket is ahead of its producer must wait or spoil the cell.
 */
#include "jobs/job_line.h"
#include "jobs/job_queue_internal.h"
#include "jobs/job_sys.h"

#include <assert.h>
#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* The model test makes all of these smaller. */
#ifndef JOB_SEGMENT_CELLS
#define JOB_SEGMENT_CELLS 1024
#define JOB_SEGMENT_ALIGN JOB_LINE
#define JOB_SPARE_SEGMENTS 8
#define JOB_BACKOFF_PAUSES 512
#endif
#define LOOKS_FOR_SEGMENT 8 /* retired segments that may turn out to be in use before a new one is made */

enum { HEAD, TAIL, ENDS };

typedef struct job_segment job_segment;

struct job_segment {
	_Atomic(job_segment *) next; /* release in segment_append, acquire in tail_move and head_move; then never changed */
	/* Constant from segment_append until the segment is retired. */
	uint64_t first; /* the position of cell 0 in the order of all items */
	void *empty;    /* the mark that a cell holds before its item; after it the other one */
	alignas(JOB_SEGMENT_ALIGN) _Atomic(void *) cell[JOB_SEGMENT_CELLS];
};

/* Where a thread works at one end. */
typedef struct job_place {
	job_segment *segment; /* the one that the thread's hazard names, or null */
	void *empty;          /* the segment's */
	uint32_t index;       /* all cells before it are filled (tail) or taken (head) */
	uint32_t pauses;      /* how long to back off next time */
} job_place;

typedef struct job_record {
	alignas(JOB_LINE) _Atomic(job_segment *) hazard[ENDS]; /* set by the thread, read by all */
	/* The thread's own, in a line of its own. */
	alignas(JOB_LINE / 2) job_place place[ENDS];
	uint64_t popped; /* at least so many items have been taken since the queue was made */
	uint32_t slot;   /* where to look first */
} job_record;
static_assert(sizeof(job_record) == JOB_LINE, "small and padded");

typedef struct job_lock_free {
	stilb_job_queue base;
	size_t capacity;
	_Atomic(job_segment *) *slot;  /* ENDS per record and JOB_SPARE_SEGMENTS more; retired segments or null */
	_Atomic uint32_t record_count; /* records that have been in use: 0..record_count-1 */
	_Atomic bool closed;
	struct {
		alignas(JOB_LINE) _Atomic(job_segment *) segment;
	} end[ENDS];
	job_record record[];
} job_lock_free;

/* A cell or a link that holds it ends the queue. Marks are addresses that no item and no segment can have. */
static alignas(alignof(job_segment)) char seal_mark, other_mark;
#define SEAL ((void *)&seal_mark)

/* What a cell holds after its item, if it held this before. */
static void *taken_mark(const void *empty)
{
	return empty ? NULL : &other_mark;
}

static job_lock_free *lock_free_of(stilb_job_queue *queue)
{
	return (job_lock_free *)queue;
}

static bool is_closed(job_lock_free *queue)
{
	return atomic_load_explicit(&queue->closed, memory_order_acquire); /* pairs with lock_free_close */
}

/* ---- hazards and retired segments ------------------------------------------------------------------------------- */

/*
 * A segment is used again when, after the head has left it, no hazard names it. Moving an end, setting a hazard, looking at
 * the end once more and reading the hazards are sequentially consistent. So either the reader finds the hazard, or the end
 * had been moved before the hazard was set, and then the thread that set it sees that and lets go. The tail may be later
 * than the head in leaving a segment, but as long as it has not left, the thread that appended the next segment is in
 * tail_move with its hazard on this one. The same goes for record_count, which is raised before the first hazard is set.
 */
static void record_announce(job_lock_free *queue, uint32_t thread)
{
	/* Relaxed: a hint, the exchange decides. */
	uint32_t count = atomic_load_explicit(&queue->record_count, memory_order_relaxed);
	while (count <= thread && !atomic_compare_exchange_weak_explicit(&queue->record_count, &count, thread + 1,
	                                                                 memory_order_seq_cst, memory_order_relaxed))
		;
}

/* Goes to the segment that is the end now. */
static void place_move(job_lock_free *queue, job_record *self, uint32_t end)
{
	record_announce(queue, (uint32_t)(self - queue->record));
	job_segment *segment, *seen = atomic_load_explicit(&queue->end[end].segment, memory_order_relaxed); /* a hint */
	do {
		segment = seen;
		/* Also release, pairs with segment_in_use: what was done in the segment left is done. */
		atomic_exchange_explicit(&self->hazard[end], segment, memory_order_seq_cst);
		/* Also acquire, pairs with end_advance: the segment's constants are there. */
		seen = atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst);
	} while (seen != segment);
	self->place[end] = (job_place){.segment = segment, .empty = segment->empty, .pauses = self->place[end].pauses / 2};
}

/* True if this call moved the end from segment to next. The caller's hazard is on segment: it cannot have come back. */
static bool end_advance(job_lock_free *queue, uint32_t end, job_segment *segment, job_segment *next)
{
	/* Sequentially consistent: see above. Looked at first, for mostly another thread has been here. */
	return atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst) == segment &&
	       atomic_compare_exchange_strong_explicit(&queue->end[end].segment, &segment, next, memory_order_seq_cst,
	                                               memory_order_seq_cst);
}

static bool segment_in_use(job_lock_free *queue, const job_segment *segment)
{
	/* Sequentially consistent: see above. Also acquire, pairs with place_move and lock_free_rest. */
	uint32_t count = atomic_load_explicit(&queue->record_count, memory_order_seq_cst);
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t end = 0; end < ENDS; end++)
			if (atomic_load_explicit(&queue->record[i].hazard[end], memory_order_seq_cst) == segment)
				return true;
	return false;
}

static uint32_t slot_count(job_lock_free *queue)
{
	/* Relaxed: at least what this thread announced; any number up to the true one will do. */
	return ENDS * atomic_load_explicit(&queue->record_count, memory_order_relaxed) + JOB_SPARE_SEGMENTS;
}

/* Swaps a segment, or null, with what is in the slot where the thread looks first. */
static job_segment *slot_swap(job_lock_free *queue, job_record *self, job_segment *segment)
{
	/* Release and acquire pair with each other: who takes a segment out sees what was done before it was put in. */
	return atomic_exchange_explicit(&queue->slot[self->slot], segment, memory_order_acq_rel);
}

static bool slot_occupied(job_lock_free *queue, job_record *self)
{
	return atomic_load_explicit(&queue->slot[self->slot], memory_order_relaxed); /* a hint, the exchange decides */
}

/* Puts a segment into a slot, or frees one if all are full: slots outnumber hazards, so then one can be freed. */
static void segment_retire(job_lock_free *queue, job_record *self, job_segment *segment)
{
	uint32_t count = slot_count(queue);
	for (uint32_t i = 0; i < count && slot_occupied(queue, self); i++)
		self->slot = (self->slot + 1) % count;
	while ((segment = slot_swap(queue, self, segment))) {
		if (!segment_in_use(queue, segment)) {
			free(segment);
			return;
		}
		self->slot = (self->slot + 1) % count;
	}
}

static job_segment *segment_create(void)
{
	job_segment *segment = aligned_alloc(alignof(job_segment), sizeof *segment);
	if (!segment)
		return NULL;
	segment->empty = NULL;
	for (uint32_t i = 0; i < JOB_SEGMENT_CELLS; i++)
		atomic_init(&segment->cell[i], NULL);
	return segment;
}

/* A segment that nobody uses, or null if there is no memory. */
static job_segment *segment_find(job_lock_free *queue, job_record *self)
{
	uint32_t count = slot_count(queue), looks = 0;
	for (uint32_t i = 0; i < count && looks < LOOKS_FOR_SEGMENT; i++) {
		job_segment *segment = slot_occupied(queue, self) ? slot_swap(queue, self, NULL) : NULL;
		if (segment) {
			if (!segment_in_use(queue, segment))
				return segment;
			segment_retire(queue, self, segment);
			looks++;
		}
		self->slot = (self->slot + 1) % count;
	}
	return segment_create();
}

/* ---- cells ------------------------------------------------------------------------------------------------------ */

static bool cell_is(const job_segment *segment, uint32_t index, const void *mark)
{
	/* Acquire pairs with the release of those who changed the cell. As each of them had seen the cell before it changed
	 * as well, all changes of the cells before it are seen too. */
	return atomic_load_explicit(&segment->cell[index], memory_order_acquire) == mark;
}

/* The first cell from index on that holds mark (is: true) or does not (is: false); JOB_SEGMENT_CELLS if there is none. No
 * cell before that does, and all behind it do. */
static uint32_t cell_search(const job_segment *segment, uint32_t index, const void *mark, bool is)
{
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

/* Changes the cell of the place; false if it does not hold *seen any more, and then *seen is what it holds. */
static bool cell_change(job_place *place, void **seen, void *to)
{
	/* Release and acquire pair with each other and with cell_is. */
	return atomic_compare_exchange_strong_explicit(&place->segment->cell[place->index], seen, to, memory_order_acq_rel,
	                                               memory_order_acquire);
}

/* Another thread works in the same cells at the same time. Leaves them to it for a while, the longer the more often that
 * happens: two threads that take the line from one another for every item are slower than either alone. The length is
 * halved when the thread goes to another segment or finds the queue empty. */
static void place_back_off(job_place *place)
{
	uint32_t more = place->pauses * 2 + 4;
	place->pauses = more > JOB_BACKOFF_PAUSES ? JOB_BACKOFF_PAUSES : more;
	for (uint32_t i = 0; i < place->pauses; i++)
		job_sys_pause();
}

/* ---- pop -------------------------------------------------------------------------------------------------------- */

/* Goes on from a segment whose cells are all taken; false if there is no other. */
static bool head_move(job_lock_free *queue, job_record *self)
{
	job_segment *segment = self->place[HEAD].segment;
	bool unlinked = false;
	if (segment) {
		job_segment *next = atomic_load_explicit(&segment->next, memory_order_acquire); /* pairs with segment_append */
		if (!next || next == SEAL)
			return false;
		unlinked = end_advance(queue, HEAD, segment, next);
	}
	place_move(queue, self, HEAD);
	if (unlinked)
		segment_retire(queue, self, segment);
	return true;
}

/* The oldest item, which is in the cell of the head's place; or null, and there was nothing in that cell. */
static void *head_find(job_lock_free *queue, job_record *self)
{
	job_place *place = &self->place[HEAD];
	for (;;) {
		void *taken = taken_mark(place->empty);
		if (place->segment && place->index < JOB_SEGMENT_CELLS) {
			/* Acquire pairs with the release in cell_change: the item is all there. */
			void *seen = atomic_load_explicit(&place->segment->cell[place->index], memory_order_acquire);
			if (seen != taken)
				return seen == place->empty || seen == SEAL ? NULL : seen;
			place->index = cell_search(place->segment, place->index + 1, taken, false);
		} else if (!head_move(queue, self)) {
			return NULL;
		}
	}
}

/* Nothing was found where the next item would go. -EAGAIN; or -EPIPE, if nothing will ever come; or 0, if it just came. */
static int head_seal(job_lock_free *queue, job_place *place)
{
	if (!is_closed(queue))
		return -EAGAIN;
	if (place->index < JOB_SEGMENT_CELLS) {
		void *seen = place->empty;
		return cell_change(place, &seen, SEAL) || seen == SEAL ? -EPIPE : 0;
	}
	job_segment *next = NULL;
	/* Release and acquire pair with tail_move and with each other. */
	return atomic_compare_exchange_strong_explicit(&place->segment->next, &next, SEAL, memory_order_acq_rel,
	                                               memory_order_acquire) ||
	               next == SEAL
	           ? -EPIPE
	           : 0;
}

static int lock_free_pop(stilb_job_queue *base, void **item, uint32_t thread)
{
	job_lock_free *queue = lock_free_of(base);
	job_record *self = &queue->record[thread];
	job_place *place = &self->place[HEAD];
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
	job_lock_free *queue = lock_free_of(base);
	return !head_find(queue, &queue->record[thread]);
}

/* ---- push ------------------------------------------------------------------------------------------------------- */

/* Appends a segment to the last one, or finds that another thread has done so. */
static int segment_append(job_lock_free *queue, job_record *self, job_segment *last, job_segment **next)
{
	job_segment *segment = segment_find(queue, self);
	if (!segment)
		return -ENOMEM;
	atomic_init(&segment->next, NULL);
	segment->first = last->first + JOB_SEGMENT_CELLS;
	if (!cell_is(segment, 0, segment->empty)) /* all are taken */
		segment->empty = taken_mark(segment->empty);
	*next = NULL;
	/* Release: the segment is ready. Acquire: so is the other one. */
	if (atomic_compare_exchange_strong_explicit(&last->next, next, segment, memory_order_acq_rel, memory_order_acquire))
		*next = segment;
	else
		segment_retire(queue, self, segment);
	return 0;
}

/* Goes on from a segment whose cells are all filled. */
static int tail_move(job_lock_free *queue, job_record *self)
{
	job_segment *segment = self->place[TAIL].segment;
	if (segment) {
		job_segment *next = atomic_load_explicit(&segment->next, memory_order_acquire); /* pairs with segment_append */
		int error = next ? 0 : segment_append(queue, self, segment, &next);
		if (error)
			return error;
		if (next == SEAL)
			return -EPIPE;
		end_advance(queue, TAIL, segment, next);
	}
	place_move(queue, self, TAIL);
	return 0;
}

/* Are there as many items before the tail's place as there may be? */
static bool tail_full(job_lock_free *queue, job_record *self)
{
	const job_place *tail = &self->place[TAIL], *head = &self->place[HEAD];
	uint64_t pushed = tail->segment->first + tail->index;
	if (pushed - self->popped < queue->capacity)
		return false;
	head_find(queue, self);
	self->popped = head->segment->first + head->index;
	/* The head may have passed this place by now: then it is behind the times, and cell_change will say so. */
	return pushed >= self->popped && pushed - self->popped >= queue->capacity;
}

static int lock_free_push(stilb_job_queue *base, void *item, uint32_t thread)
{
	job_lock_free *queue = lock_free_of(base);
	job_record *self = &queue->record[thread];
	job_place *place = &self->place[TAIL];
	if (is_closed(queue))
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
		if (place->index > 0) /* in a segment new to this thread others have been busy before */
			place_back_off(place);
		/* A seal is the last of the cells that are not empty. */
		place->index = cell_search(place->segment, place->index, place->empty, true);
		if (cell_is(place->segment, place->index - 1, SEAL))
			return -EPIPE;
	}
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
	atomic_store_explicit(&lock_free_of(queue)->closed, true, memory_order_release); /* pairs with is_closed */
}

static void lock_free_rest(stilb_job_queue *queue, uint32_t thread)
{
	job_record *self = &lock_free_of(queue)->record[thread];
	for (uint32_t end = 0; end < ENDS; end++) {
		self->place[end].segment = NULL;
		/* Release pairs with segment_in_use: what was done in the segment is done. */
		atomic_store_explicit(&self->hazard[end], NULL, memory_order_release);
	}
}

static void lock_free_destroy(stilb_job_queue *base)
{
	job_lock_free *queue = lock_free_of(base);
	/* Relaxed throughout: the caller is alone. */
	job_segment *segment = atomic_load_explicit(&queue->end[HEAD].segment, memory_order_relaxed);
	while (segment && segment != SEAL) {
		job_segment *next = atomic_load_explicit(&segment->next, memory_order_relaxed);
		free(segment);
		segment = next;
	}
	uint32_t slots = slot_count(queue);
	for (uint32_t i = 0; i < slots; i++)
		free(atomic_load_explicit(&queue->slot[i], memory_order_relaxed));
	free(queue);
}

int job_queue_lock_free_create(const stilb_job_queue_desc *desc, stilb_job_queue **created)
{
	static const job_queue_ops ops = {lock_free_push,  lock_free_push_n, lock_free_pop,  lock_free_pop_n,
	                                  lock_free_empty, lock_free_close,  lock_free_rest, lock_free_destroy};
	size_t slots_at = sizeof(job_lock_free) + desc->thread_count * sizeof(job_record);
	size_t size = slots_at + (ENDS * desc->thread_count + JOB_SPARE_SEGMENTS) * sizeof(job_segment *);
	size = (size + JOB_LINE - 1) / JOB_LINE * JOB_LINE;
	job_lock_free *queue = aligned_alloc(JOB_LINE, size);
	job_segment *segment = segment_create();
	if (!queue || !segment) {
		free(queue);
		free(segment);
		return -ENOMEM;
	}
	memset(queue, 0, size); /* records that nobody uses, empty slots */
	queue->base.ops = &ops;
	queue->capacity = desc->capacity;
	queue->slot = (_Atomic(job_segment *) *)((char *)queue + slots_at);
	atomic_init(&segment->next, NULL);
	segment->first = 0;
	atomic_init(&queue->end[HEAD].segment, segment);
	atomic_init(&queue->end[TAIL].segment, segment);
	*created = &queue->base;
	return 0;
}
