/* A subject of the suite `queue`: Concurrency Kit's linked queue for many producers and consumers. Its user provides
 * the nodes: here consumers return used nodes to the producers in chains of 256, so memory is allocated only while the
 * queue grows. This is an advantage over queues that allocate in each call. */
#include <ck_fifo.h>

#include <stdint.h>

#define CHAIN 256

typedef struct entry {
	ck_fifo_mpmc_entry_t fifo; /* the first member: pointers to it are cast to entry */
	struct entry *next;        /* in the same chain */
	struct entry *next_chain;
} entry;

typedef struct subject_queue {
	ck_fifo_mpmc_t fifo;
	__attribute__((aligned(128)))
	entry *chains; /* used, given back by consumers. Release in give_entry, pairs with the acquire in take_entry */
} subject_queue;

typedef struct subject_thread {
	entry *free, *chains; /* producer: entries to use, then chains of them; consumer: free is the chain of used ones */
	uint32_t count;       /* consumer: length of free */
} subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *load)
{
	(void)load;
	entry *stub = load_allocate(sizeof *stub);
	ck_fifo_mpmc_init(&queue->fifo, &stub->fifo);
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue, (void)self, (void)thread;
}

/* Allocates a chain of CHAIN entries as one block of memory. */
static entry *new_chain(void)
{
	entry *block = load_allocate(CHAIN * sizeof *block);
	for (uint32_t i = 0; i + 1 < CHAIN; i++)
		block[i].next = &block[i + 1];
	return block;
}

static inline entry *take_entry(subject_queue *queue, subject_thread *self)
{
	if (!self->free) {
		if (!self->chains)
			self->chains = __atomic_exchange_n(&queue->chains, NULL, __ATOMIC_ACQUIRE);
		self->free = self->chains ? self->chains : new_chain();
		self->chains = self->free->next_chain;
	}
	entry *taken = self->free;
	self->free = taken->next;
	return taken;
}

static inline void give_entry(subject_queue *queue, subject_thread *self, entry *used)
{
	used->next = self->free;
	self->free = used;
	if (++self->count < CHAIN)
		return;
	used->next_chain = __atomic_load_n(&queue->chains, __ATOMIC_RELAXED);
	while (!__atomic_compare_exchange_n(&queue->chains, &used->next_chain, used, true, __ATOMIC_RELEASE,
	                                    __ATOMIC_RELAXED)) {
	}
	self->free = NULL;
	self->count = 0;
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	ck_fifo_mpmc_enqueue(&queue->fifo, &take_entry(queue, self)->fifo, item);
	return true;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	ck_fifo_mpmc_entry_t *used;
	if (!ck_fifo_mpmc_dequeue(&queue->fifo, item, &used))
		return false;
	give_entry(queue, self, (entry *)used);
	return true;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
