/* The queue for one producer and one consumer with blocks of two cells, of which one is reused: genmc.h. */
#include "genmc.h"

#define JOB_SPSC_BLOCK_CELLS 2
#include "jobs/queue/job_spsc.c"

#undef NDEBUG
#include <assert.h>

enum { ITEMS = 5 };

static stilb_job_spsc *queue;
static int item_of[ITEMS + 1], popped;

static void *consume(void *unused)
{
	(void)unused;
	void *item;
	for (int looks = 0; looks < ITEMS + 1; looks++)
		if (stilb_job_spsc_pop(queue, &item) == 0)
			assert(*(int *)item == ++popped);
	return NULL;
}

static void create(void)
{
	queue = malloc(sizeof *queue);
	queue->memory = (stilb_job_allocator){0};
	job_spsc_block *block = block_create(&queue->memory);
	queue->first = queue->writing = block;
	atomic_init(&queue->reading, block);
	queue->write = queue->read = block->cells;
	queue->closed = false;
}

int main(void)
{
	pthread_t consumer;
	create();
	pthread_create(&consumer, NULL, consume, NULL);
	for (int i = 1; i <= ITEMS; i++) {
		item_of[i] = i;
		stilb_job_spsc_push(queue, &item_of[i]);
	}
	pthread_join(consumer, NULL);
	while (popped < ITEMS) {
		void *item;
		int error = stilb_job_spsc_pop(queue, &item);
		assert(error == 0 && *(int *)item == ++popped);
	}
	return 0;
}
