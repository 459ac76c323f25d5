/* The deque with a buffer of two cells, which grows, a thief, and the idle list of job_park.h: genmc.h. */
#include "genmc.h"

#include "jobs/job_park.c"
#define JOB_DEQUE_CAPACITY 2
#include "jobs/job_deque.c"

#undef NDEBUG
#include <assert.h>

enum { RECORDS = 3 };

static job_deque deque;
static job_record record[RECORDS];
static int contents[RECORDS]; /* written before the push */
static _Atomic bool taken[RECORDS];
static job_idle_list idle;
static job_parker parker;
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
	job_idler idler = {.parker = &parker, .scope = {.all = true, .jobs = true, .high = true}, .worker = true};
	job_idle_enter(&idle, &idler, false); /* step (1) of job_park.h */
	slept = job_deque_empty(&deque);      /* step (2) */
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
	job_idle_init(&idle, 1);
	pthread_create(&other, NULL, thief, NULL);
	for (int i = 0; i < RECORDS; i++) {
		contents[i] = 1;
		job_deque_push(&deque, &record[i]);  /* step (a) */
		woken |= job_idle_wanted(&idle, 64); /* step (b) */
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
