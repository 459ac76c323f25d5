/* The lock-free queue with segments of two cells: a guest pops once while the owner pushes and pops through the
 * segments, which are retired and used again: genmc.h. */
#include "genmc.h"

#define JOB_SEGMENT_CELLS 2
#define JOB_SEGMENT_ALIGN 8
#define JOB_SPARE_SEGMENTS 1
#define JOB_BACKOFF_PAUSES 0
#include "jobs/queue/job_queue_lock_free.c"

#undef NDEBUG
#include <assert.h>

enum { THREADS = 2, ITEMS = 3 };

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
	if (lock_free_pop(&queue.base, &item, 1) == 0)
		assert(*(int *)item > 0);
	return NULL;
}

int main(void)
{
	pthread_t other;
	lock_free_segment *segment = segment_create(&queue.memory);
	queue.capacity = SIZE_MAX;
	queue.thread_count = THREADS;
	queue.slot = slots;
	atomic_init(&segment->next, NULL);
	segment->first = 0;
	atomic_init(&queue.end[HEAD].segment, segment);
	atomic_init(&queue.end[TAIL].segment, segment);
	pthread_create(&other, NULL, guest, NULL);
	for (int i = 1; i <= ITEMS; i++) {
		void *item;
		item_of[i] = i;
		lock_free_push(&queue.base, &item_of[i], 0);
		lock_free_pop(&queue.base, &item, 0);
	}
	pthread_join(other, NULL);
	return 0;
}
