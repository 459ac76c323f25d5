#include "jobs/job_park.h"

enum { PARKER_EMPTY, PARKER_TOKEN, PARKER_ASLEEP };

#define SPINNER JOB_IDLE_SPINNER
#define IDLERS(state) ((state) & (SPINNER - 1))
#define SPINNERS(state) ((state) / SPINNER)

/* ---- one thread ------------------------------------------------------------------------------------------------ */

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

/* ---- all of them ----------------------------------------------------------------------------------------------- */

void job_idle_init(job_idle_list *list, uint32_t workers)
{
	atomic_init(&list->state, 0);
	list->lock = (job_lock){0};
	list->spare = false;
	list->workers = workers;
	list->waiting = 0;
}

void job_idle_bound(job_idle_list *list, job_parker *parker, uint32_t cpu)
{
	job_lock_take(&list->lock);
	parker->bound = true;
	parker->cpu = cpu;
	parker->thread = job_sys_thread();
	job_lock_give(&list->lock);
}

bool job_idle_spin_start(job_idle_list *list, uint32_t limit)
{
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed); /* a first guess for the exchange */
	while (SPINNERS(state) < limit)
		/* Seq_cst as every change of the word, so that its changes are one chain (see the head of job_park.h). */
		if (atomic_compare_exchange_weak_explicit(&list->state, &state, state + SPINNER, memory_order_seq_cst,
		                                          memory_order_relaxed))
			return true;
	return false;
}

void job_idle_spin_stop(job_idle_list *list)
{
	/* Seq_cst, partner of (b): who saw the spinner published before the spinner looks for more. */
	atomic_fetch_sub_explicit(&list->state, SPINNER, memory_order_seq_cst);
}

bool job_idle_enter(job_idle_list *list, const job_idler *idler, bool spinning)
{
	job_lock_take(&list->lock);
	/* Seq_cst: step (1), partner of (b). Unsigned, so subtracting a spinner works by wrapping. */
	uint32_t state = atomic_fetch_add_explicit(&list->state, spinning ? 1u - SPINNER : 1u, memory_order_seq_cst);
	uint32_t count = IDLERS(state);
	assert(count <= STILB_JOB_MAX_WORKERS);
	list->idler[count] = *idler;
	idler->parker->rescue = false;
	if (idler->worker && !idler->scope.all)
		list->waiting++;
	bool alone = list->waiting == list->workers;
	job_lock_give(&list->lock);
	return alone;
}

/* Takes idler i off, keeping the order of the rest; the lock is held. */
static void list_remove(job_idle_list *list, uint32_t i, bool spins)
{
	/* Seq_cst keeps the chain of changes unbroken from any (1) to any (b). */
	uint32_t state = atomic_fetch_add_explicit(&list->state, spins ? SPINNER - 1u : -1u, memory_order_seq_cst);
	if (list->idler[i].worker && !list->idler[i].scope.all)
		list->waiting--;
	for (; i + 1 < IDLERS(state); i++)
		list->idler[i] = list->idler[i + 1];
}

/* The place of a thread on the list plus one, or 0. The lock is held. */
static uint32_t list_find(const job_idle_list *list, const job_parker *parker)
{
	uint32_t i = IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)); /* ordered by the lock */
	while (i > 0 && list->idler[i - 1].parker != parker)
		i--;
	return i;
}

job_idle_fate job_idle_leave(job_idle_list *list, job_parker *parker)
{
	job_lock_take(&list->lock);
	uint32_t place = list_find(list, parker);
	if (place > 0)
		list_remove(list, place - 1, false);
	bool rescue = parker->rescue;
	job_lock_give(&list->lock);
	/* Who takes a thread off leaves its token under the lock, so here it is there already: none is left for later. */
	job_parker_clear(parker);
	return place > 0 ? JOB_IDLE_UNMOVED : rescue ? JOB_IDLE_RESCUE : JOB_IDLE_CHOSEN;
}

static bool scope_accepts(const job_scope *scope, const job_work *work)
{
	if (scope->all)
		return true;
	bool inside = work->root == scope->root && work->level > scope->level;
	switch (work->kind) {
	case JOB_WORK_JOB:
		return scope->jobs && inside;
	case JOB_WORK_HIGH:
		return scope->high;
	case JOB_WORK_LOOP:
		return inside;
	case JOB_WORK_OWN:
	case JOB_WORK_SHARED:
		return false;
	}
	return false;
}

/* The newest idler that would do such work, as list_find; *rescue if that is because every worker waits. */
static uint32_t list_find_for(const job_idle_list *list, const job_work *work, bool *rescue)
{
	uint32_t count = IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)); /* ordered by the lock */
	*rescue = false;
	for (uint32_t i = count; i > 0; i--)
		if (scope_accepts(&list->idler[i - 1].scope, work))
			return i;
	if (work->kind == JOB_WORK_LOOP || list->waiting < list->workers)
		return 0;
	*rescue = true;
	uint32_t i = count;
	while (i > 0 && !list->idler[i - 1].scope.jobs)
		i--;
	return i;
}

/* The waker goes on running: a thread bound to its CPU would have to wait for it. The lock is held. */
static void move_away(job_idle_list *list, job_parker *parker)
{
	if (!parker->bound || !list->spare || parker->cpu != job_sys_cpu() ||
	    !job_sys_bind(parker->thread, list->spare_cpu))
		return;
	uint32_t cpu = parker->cpu;
	parker->cpu = list->spare_cpu;
	list->spare_cpu = cpu;
}

/* Takes the idler at that place off the list and gives the lock back; then wakes it. */
static void wake_place(job_idle_list *list, uint32_t place, bool rescue)
{
	job_parker *parker = list->idler[place - 1].parker;
	parker->rescue = rescue;
	move_away(list, parker);
	list_remove(list, place - 1, list->idler[place - 1].scope.all);
	bool asleep = leave_token(parker);
	job_lock_give(&list->lock);
	if (asleep)
		job_sys_futex_wake_one(&parker->state); /* outside the lock: it takes microseconds */
}

bool job_idle_wake(job_idle_list *list, const job_work *work)
{
	bool rescue;
	job_lock_take(&list->lock);
	uint32_t place = list_find_for(list, work, &rescue);
	if (place == 0)
		job_lock_give(&list->lock);
	else
		wake_place(list, place, rescue);
	return place > 0;
}

void job_idle_wake_thread(job_idle_list *list, job_parker *parker)
{
	/* Seq_cst: (b), partner of (1); the inbox was published by a seq_cst exchange. */
	if (IDLERS(atomic_load_explicit(&list->state, memory_order_seq_cst)) == 0)
		return;
	job_lock_take(&list->lock);
	uint32_t place = list_find(list, parker);
	if (place == 0)
		job_lock_give(&list->lock);
	else
		wake_place(list, place, false);
}

bool job_idle_wake_spinner(job_idle_list *list, uint32_t limit)
{
	job_lock_take(&list->lock);
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed); /* ordered by the lock */
	uint32_t place = SPINNERS(state) < limit ? IDLERS(state) : 0;
	while (place > 0 && !list->idler[place - 1].scope.all)
		place--;
	if (place == 0)
		job_lock_give(&list->lock);
	else
		wake_place(list, place, false);
	return place > 0;
}
