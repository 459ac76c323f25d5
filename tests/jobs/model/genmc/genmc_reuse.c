/* The lock-free queue with segments of two cells, of which the first is emptied and used again while another thread
 * may be on its way there: it stands before its first pop: genmc.h. */
#include "genmc.h"

#define JOB_SEGMENT_CELLS 2
#define JOB_SEGMENT_ALIGN 8
#define JOB_SPARE_SEGMENTS 1
#define JOB_BACKOFF_PAUSES 0
#include "jobs/queue/job_queue_lock_free.c"

#undef NDEBUG
#include <assert.h>

enum { THREADS = 2, ITEMS = 5 };

static struct {
	lock_free queue;
	thread_state thread[THREADS]; /* queue.thread */
} all;
#define queue all.queue
static _Atomic(lock_free_segment *) slots[ENDS * THREADS + JOB_SPARE_SEGMENTS];
static int item_of[ITEMS + 1];

static void *guest(void *unused)
{
	(void)unused;
	void *item;
	assert(lock_free_pop(&queue.base, &item, 1) == 0 && *(int *)item > 2); /* the queue is never empty */
	return NULL;
}

static void push(int number)
{
	item_of[number] = number;
	lock_free_push(&queue.base, &item_of[number], 0);
}

int main(void)
{
	pthread_t other;
	void *item;
	lock_free_segment *segment = segment_create(&queue.memory);
	queue.capacity = SIZE_MAX;
	queue.thread_count = THREADS;
	queue.slot = slots;
	atomic_init(&segment->next, NULL);
	segment->first = 0;
	atomic_init(&queue.end[HEAD].segment, segment);
	atomic_init(&queue.end[TAIL].segment, segment);
	for (int i = 1; i <= 4; i++)
		push(i); /* fills two segments */
	for (int i = 0; i < 2; i++)
		lock_free_pop(&queue.base, &item, 0); /* empties the first one */
	pthread_create(&other, NULL, guest, NULL);
	lock_free_pop(&queue.base, &item, 0); /* leaves it */
	push(5);                              /* uses it again, unless the guest is there */
	pthread_join(other, NULL);
	return 0;
}
