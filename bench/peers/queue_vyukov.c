/* A subject of the suite `queue`: Vyukov's bounded queue (Dmitry Vyukov, "Bounded MPMC queue", 1024cores.net), a ring
 * of cells, each with a turn number that tells whether the cell is to be filled or emptied next, and in which round. */
#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#define CELLS 4096

typedef struct cell {
	uint64_t turn; /* release in subject_push and subject_pop, pairs with the acquire in claim */
	void *item;
} cell;

typedef struct subject_queue {
	cell cells[CELLS];
	__attribute__((aligned(128))) uint64_t in; /* next ticket of push; relaxed: the cells' turns order the items */
	__attribute__((aligned(128))) uint64_t out;
} subject_queue;

typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static_assert(CELLS == QUEUE_LOAD_BOUNDED, "every bounded queue has the same capacity");

static void subject_open(subject_queue *queue, const queue_load *load)
{
	(void)load;
	for (uint64_t i = 0; i < CELLS; i++)
		queue->cells[i].turn = i;
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue, (void)self, (void)thread;
}

/* Takes the next ticket if the turn of its cell is ticket + offset, and returns the cell. NULL: the queue is full
 * (offset 0) or empty (offset 1). */
static inline cell *claim(cell *cells, uint64_t *tickets, uint64_t offset, uint64_t *ticket)
{
	*ticket = __atomic_load_n(tickets, __ATOMIC_RELAXED);
	for (;;) {
		cell *at = &cells[*ticket % CELLS];
		int64_t ahead = (int64_t)(__atomic_load_n(&at->turn, __ATOMIC_ACQUIRE) - (*ticket + offset));
		if (ahead < 0)
			return NULL;
		if (ahead > 0)
			*ticket = __atomic_load_n(tickets, __ATOMIC_RELAXED);
		else if (__atomic_compare_exchange_n(tickets, ticket, *ticket + 1, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
			return at;
	}
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	(void)self;
	uint64_t ticket;
	cell *at = claim(queue->cells, &queue->in, 0, &ticket);
	if (!at)
		return false;
	at->item = item;
	__atomic_store_n(&at->turn, ticket + 1, __ATOMIC_RELEASE);
	return true;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	(void)self;
	uint64_t ticket;
	cell *at = claim(queue->cells, &queue->out, 1, &ticket);
	if (!at)
		return false;
	*item = at->item;
	__atomic_store_n(&at->turn, ticket + CELLS, __ATOMIC_RELEASE);
	return true;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
