/* The deque: its owner pushes a batch, digs for one record of it and pops, while a thief looks and steals: genmc.h. */
#include "genmc.h"

#define JOB_DEQUE_CAPACITY 4
#include "jobs/job_deque.c"

#undef NDEBUG
#include <assert.h>

enum { RECORDS = 3 };

static job_deque deque;
static job_record record[RECORDS];
static int contents[RECORDS]; /* written before the push */
static _Atomic bool taken[RECORDS];

static void take(const job_record *one)
{
	size_t i = (size_t)(one - record);
	assert(contents[i] == 1);
	assert(!atomic_exchange_explicit(&taken[i], true, memory_order_relaxed));
}

static bool is_wanted(const job_record *one, const void *root)
{
	return atomic_load_explicit(&one->root, memory_order_relaxed) == (uintptr_t)root;
}

static void *thief(void *unused)
{
	(void)unused;
	int64_t top;
	if (!job_deque_find(&deque, is_wanted, (void *)64, &top))
		return NULL;
	for (int looks = 0; looks < 2; looks++) {
		job_record *oldest = job_deque_oldest(&deque, &top);
		if (oldest && job_deque_steal(&deque, top))
			take(oldest);
	}
	return NULL;
}

int main(void)
{
	pthread_t other;
	job_deque_init(&deque, &(stilb_job_allocator){0});
	atomic_init(&record[1].root, 64);
	pthread_create(&other, NULL, thief, NULL);
	for (int i = 0; i < RECORDS; i++) {
		contents[i] = 1;
		record[i].next = i + 1 < RECORDS ? &record[i + 1] : NULL;
	}
	job_deque_push_list(&deque, record, RECORDS);
	job_deque_dig(&deque, is_wanted, (void *)64);
	const job_record *newest;
	while ((newest = job_deque_pop(&deque)))
		take(newest);
	pthread_join(other, NULL);
	for (int i = 0; i < RECORDS; i++)
		assert(atomic_load_explicit(&taken[i], memory_order_relaxed));
	return 0;
}
