/* The low-lock queue with segments of two cells: one thread pushes, singly and a batch, the other
 * one pops, and may empty the segment that is used again: genmc.h. */
#include "genmc.h"

#define JOB_SEGMENT_CELLS 2
#define JOB_SEGMENT_ALIGN 8
#include "jobs/queue/job_queue_low_lock.c"

#undef NDEBUG
#include <assert.h>

enum { ITEMS = 6 };

static low_lock queue;
static int item_of[ITEMS + 1], popped;

static void take(void *const *items, int count)
{
	for (int i = 0; i < count; i++)
		assert(*(int *)items[i] == ++popped);
}

static void *consume(void *unused)
{
	(void)unused;
	void *items[2];
	take(items, low_lock_pop_n(&queue.base, items, 2, 0));
	if (low_lock_pop(&queue.base, items, 0) == 0)
		take(items, 1);
	return NULL;
}

static void *numbered(int number)
{
	item_of[number] = number;
	return &item_of[number];
}

int main(void)
{
	pthread_t consumer;
	segment *first = NULL;
	segments_create(&queue.memory, &first, 0, 1);
	first->next = first;
	queue.capacity = SIZE_MAX;
	queue.push.at = queue.pop.at = first;
	queue.push.end = queue.pop.end = queue.push.stop = JOB_SEGMENT_CELLS;
	queue.push.segments = 1;
	for (int i = 1; i <= 3; i++)
		low_lock_push(&queue.base, numbered(i), 0);
	void *items[ITEMS];
	take(items, low_lock_pop_n(&queue.base, items, 1, 0));
	pthread_create(&consumer, NULL, consume, NULL);
	low_lock_push(&queue.base, numbered(4), 0);
	void *const batch[] = {numbered(5), numbered(6)};
	low_lock_push_n(&queue.base, batch, 2, 0);
	pthread_join(consumer, NULL);
	take(items, low_lock_pop_n(&queue.base, items, ITEMS, 0));
	assert(popped == ITEMS);
	return 0;
}
