/* The deque with a buffer of two cells, which grows, a thief, and the announcement of job_park.h: genmc.h. */
#include "genmc.h"

#define JOB_DEQUE_CAPACITY 2
#include "jobs/job_deque.c"

#undef NDEBUG
#include <assert.h>

enum { RECORDS = 3 };

static job_deque deque;
static job_record record[RECORDS];
static int contents[RECORDS]; /* written before the push */
static _Atomic bool taken[RECORDS];
static _Atomic uint32_t idlers;
static bool slept;

static void take(const job_record *one)
{
	size_t i = (size_t)(one - record);
	assert(contents[i] == 1);
	assert(!atomic_exchange_explicit(&taken[i], true, memory_order_relaxed));
}

static void *thief(void *unused)
{
	(void)unused;
	atomic_fetch_add_explicit(&idlers, 1, memory_order_seq_cst); /* step (1) of job_park.h */
	slept = job_deque_empty(&deque);                             /* step (2) */
	for (int looks = 0; looks < 2 && !slept; looks++) {
		int64_t top;
		job_record *oldest = job_deque_oldest(&deque, &top);
		if (oldest && job_deque_steal(&deque, top))
			take(oldest);
	}
	return NULL;
}

/* The owner pops fewer records than it pushes: so the thief sleeps only if it does not see a push. */
int main(void)
{
	pthread_t other;
	bool woken = false;
	job_deque_init(&deque, &(stilb_job_allocator){0});
	pthread_create(&other, NULL, thief, NULL);
	for (int i = 0; i < RECORDS; i++) {
		contents[i] = 1;
		job_deque_push(&deque, &record[i]);                               /* step (a) */
		woken |= atomic_load_explicit(&idlers, memory_order_seq_cst) > 0; /* step (b) */
	}
	for (int i = 0; i < RECORDS - 1; i++) {
		const job_record *newest = job_deque_pop(&deque);
		if (newest)
			take(newest);
	}
	pthread_join(other, NULL);
	assert(!slept || woken);
	return 0;
}
