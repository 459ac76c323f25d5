/* A subject of the suite `queue`: Concurrency Kit's bounded ring for many producers and consumers. */
#include <ck_ring.h>

typedef struct subject_queue {
	ck_ring_t ring;
	ck_ring_buffer_t *cells;
} subject_queue;

typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *load)
{
	(void)load;
	ck_ring_init(&queue->ring, QUEUE_LOAD_BOUNDED);
	queue->cells = load_allocate(QUEUE_LOAD_BOUNDED * sizeof *queue->cells);
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue, (void)self, (void)thread;
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	(void)self;
	return ck_ring_enqueue_mpmc(&queue->ring, queue->cells, item);
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	(void)self;
	return ck_ring_dequeue_mpmc(&queue->ring, queue->cells, item);
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
