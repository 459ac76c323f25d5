#include "jobs/job_park.h"

#include <assert.h>

enum { PARKER_EMPTY, PARKER_TOKEN, PARKER_ASLEEP };

void job_parker_sleep(job_parker *parker)
{
	uint32_t state = PARKER_EMPTY;
	/* Acquire on failure pairs with the release in leave_token, as below; success publishes nothing but the word. */
	if (atomic_compare_exchange_strong_explicit(&parker->state, &state, PARKER_ASLEEP, memory_order_acquire,
	                                            memory_order_acquire)) {
		/* Relaxed: only whether to go on sleeping; the exchange in job_parker_clear synchronises. */
		while (atomic_load_explicit(&parker->state, memory_order_relaxed) == PARKER_ASLEEP)
			job_sys_futex_wait(&parker->state, PARKER_ASLEEP);
	}
	job_parker_clear(parker);
}

void job_parker_clear(job_parker *parker)
{
	/* An exchange, not a store: a second token may have been laid on the first, and the thread must see what its giver
	 * did as well. Acquire pairs with the release in leave_token. */
	atomic_exchange_explicit(&parker->state, PARKER_EMPTY, memory_order_acquire);
}

/* True if the thread slept and must be woken by the kernel. */
static bool leave_token(job_parker *parker)
{
	/* Release pairs with the acquire in job_parker_clear. */
	return atomic_exchange_explicit(&parker->state, PARKER_TOKEN, memory_order_release) == PARKER_ASLEEP;
}

void job_parker_wake(job_parker *parker)
{
	if (leave_token(parker))
		job_sys_futex_wake_one(&parker->state);
}

void job_idle_init(job_idle_list *list)
{
	atomic_init(&list->count, 0);
	atomic_init(&list->lock.held, false);
}

void job_idle_enter(job_idle_list *list, job_idler idler)
{
	job_lock_take(&list->lock);
	/* Seq_cst, partner of the one in job_idle_wake: see the head of job_park.h. (Acquire and release would do, as both
	 * are read-modify-writes of one word; seq_cst costs no more and is this project's rule where a fence would stand.) */
	uint32_t count = atomic_fetch_add_explicit(&list->count, 1, memory_order_seq_cst);
	assert(count <= STILB_JOB_MAX_WORKERS);
	list->idler[count] = idler;
	job_lock_give(&list->lock);
}

/* Takes idler i off, keeping the order of the rest; the lock is held. */
static void list_remove(job_idle_list *list, uint32_t i)
{
	/* Seq_cst keeps the chain of read-modify-writes unbroken from any (1) to any (b). */
	uint32_t count = atomic_fetch_sub_explicit(&list->count, 1, memory_order_seq_cst);
	for (; i + 1 < count; ++i)
		list->idler[i] = list->idler[i + 1];
}

bool job_idle_leave(job_idle_list *list, job_parker *parker)
{
	job_lock_take(&list->lock);
	uint32_t i = atomic_load_explicit(&list->count, memory_order_relaxed); /* ordered by the lock */
	while (i > 0 && list->idler[i - 1].parker != parker)
		--i;
	bool found = i > 0;
	if (found)
		list_remove(list, i - 1);
	job_lock_give(&list->lock);
	/* Who takes a thread off leaves its token under the lock, so here it is there already: none is left for later. */
	job_parker_clear(parker);
	return !found;
}

/* The newest idler that would do such work, or 0; the number is its place plus one. The lock is held. */
static uint32_t list_find(const job_idle_list *list, uint32_t work)
{
	uint32_t i = atomic_load_explicit(&list->count, memory_order_relaxed); /* ordered by the lock */
	for (; i > 0; --i) {
		const job_idler *idler = &list->idler[i - 1];
		if (work == JOB_WORK_JOB ? idler->jobs : work > idler->level)
			break;
	}
	return i;
}

bool job_idle_wake(job_idle_list *list, uint32_t work)
{
	/* Adding nothing is the point: a plain load would not be ordered after the publishing of the work. Seq_cst, partner
	 * of the one in job_idle_enter. */
	if (atomic_fetch_add_explicit(&list->count, 0, memory_order_seq_cst) == 0)
		return false;
	job_parker *parker = NULL;
	bool asleep = false;
	job_lock_take(&list->lock);
	uint32_t place = list_find(list, work);
	if (place > 0) {
		parker = list->idler[place - 1].parker;
		list_remove(list, place - 1);
		asleep = leave_token(parker);
	}
	job_lock_give(&list->lock);
	if (asleep)
		job_sys_futex_wake_one(&parker->state); /* outside the lock: it takes microseconds */
	return parker != NULL;
}

bool job_idle_any(const job_idle_list *list)
{
	return atomic_load_explicit(&list->count, memory_order_relaxed) > 0;
}
