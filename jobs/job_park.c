#include "jobs/job_park.h"

/* PARKER_CHOSEN is a token, too: from a waker that has taken the thread off the idle list. */
enum { PARKER_EMPTY, PARKER_TOKEN, PARKER_ASLEEP, PARKER_CHOSEN };

#define SPINNER JOB_IDLE_SPINNER
#define IDLERS(state) ((state) & (SPINNER - 1))
#define SPINNERS(state) ((state) / SPINNER)

/* ---- one thread ------------------------------------------------------------------------------------------------ */

void job_parker_sleep(job_parker *parker)
{
	uint32_t state = PARKER_EMPTY;
	/* Fails if the token is there: acquire then pairs with the release in leave_token. Success needs no order, since
	 * the word itself is all that it tells other threads. */
	if (atomic_compare_exchange_strong_explicit(&parker->state, &state, PARKER_ASLEEP, memory_order_acquire,
	                                            memory_order_acquire)) {
		/* Relaxed: only decides whether to sleep again; job_parker_clear acquires what the waker wrote. */
		while (atomic_load_explicit(&parker->state, memory_order_relaxed) == PARKER_ASLEEP)
			job_sys_futex_wait(&parker->state, PARKER_ASLEEP);
	} else {
		assert(state != PARKER_ASLEEP && "no other thread sleeps on this parker");
	}
	job_parker_clear(parker);
}

bool job_parker_sleep_for(job_parker *parker, uint64_t nanoseconds)
{
	uint32_t state = PARKER_EMPTY;
	/* Both exchanges fail if the token is there: acquire then pairs with the release in leave_token. Success needs no
	 * order, since the word itself is all that it tells other threads. */
	if (atomic_compare_exchange_strong_explicit(&parker->state, &state, PARKER_ASLEEP, memory_order_acquire,
	                                            memory_order_acquire)) {
		job_sys_futex_wait_for(&parker->state, PARKER_ASLEEP, nanoseconds);
		state = PARKER_ASLEEP;
		if (atomic_compare_exchange_strong_explicit(&parker->state, &state, PARKER_EMPTY, memory_order_acquire,
		                                            memory_order_acquire))
			return false;
	}
	assert(state != PARKER_ASLEEP && "no other thread sleeps on this parker");
	job_parker_clear(parker);
	return true;
}

void job_parker_clear(job_parker *parker)
{
	/* An exchange and not a store: a second token may have been left on top of the first, and everything done before
	 * that one must be visible, too. Acquire pairs with the release in leave_token. */
	if (atomic_exchange_explicit(&parker->state, PARKER_EMPTY, memory_order_acquire) == PARKER_CHOSEN)
		parker->chosen = true;
}

/* Leaves a token of this kind. True if the thread sleeps and must be woken through the kernel. */
static bool leave_token(job_parker *parker, uint32_t token)
{
	/* Release pairs with the acquire in job_parker_clear. */
	return atomic_exchange_explicit(&parker->state, token, memory_order_release) == PARKER_ASLEEP;
}

void job_parker_wake(job_parker *parker)
{
	if (leave_token(parker, PARKER_TOKEN))
		job_sys_futex_wake_one(&parker->state);
}

/* ---- all of them ----------------------------------------------------------------------------------------------- */

void job_idle_init(job_idle_list *list, uint32_t workers)
{
	assert(workers <= STILB_JOB_MAX_WORKERS);
	atomic_init(&list->state, 0);
	atomic_init(&list->roots, 0);
	list->lock = (job_lock){0};
	list->spare = false;
	list->workers = workers;
	list->waiting = 0;
}

static bool idler_waits(const job_idler *idler)
{
	return idler->scope.jobs && !idler->scope.all;
}

/* The bits of the roots that the first `count` idlers wait for. Caller holds list->lock. */
static uint64_t list_roots(const job_idle_list *list, uint32_t count)
{
	uint64_t roots = 0;
	for (uint32_t i = 0; i < count; i++)
		if (idler_waits(&list->idler[i]))
			roots |= job_idle_root_bit(list->idler[i].scope.root);
	return roots;
}

/* For asserts: `waiting` and the counts in `state` agree with the idlers listed. Caller holds list->lock. */
static bool list_is_sound(const job_idle_list *list)
{
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed); /* idlers are ordered by the lock */
	uint32_t waiting = 0;
	for (uint32_t i = 0; i < IDLERS(state); i++)
		waiting += list->idler[i].worker && !list->idler[i].scope.all;
	return job_lock_is_mine(&list->lock) && IDLERS(state) <= list->workers + 1 && waiting == list->waiting &&
	       SPINNERS(state) <= list->workers &&
	       atomic_load_explicit(&list->roots, memory_order_relaxed) == list_roots(list, IDLERS(state));
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
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed); /* the first guess of the exchange */
	while (SPINNERS(state) < limit)
		/* Seq_cst like every change of the word, so that its changes form one chain (see the head of job_park.h). */
		if (atomic_compare_exchange_weak_explicit(&list->state, &state, state + SPINNER, memory_order_seq_cst,
		                                          memory_order_relaxed))
			return true;
	return false;
}

void job_idle_spin_stop(job_idle_list *list)
{
	/* Seq_cst, partner of step (b) in job_park.h: a thread that still saw this spinner there, and so woke nobody, had
	 * published its work before; the calling thread looks for more work after this, and finds it. */
	uint32_t state = atomic_fetch_sub_explicit(&list->state, SPINNER, memory_order_seq_cst);
	assert(SPINNERS(state) > 0 && "a spinner stops once");
	(void)state;
}

/* The index of a thread on the list plus one; 0 if it is not there. Caller holds list->lock. */
static uint32_t list_find(const job_idle_list *list, const job_parker *parker)
{
	uint32_t i = IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)); /* ordered by the lock */
	while (i > 0 && list->idler[i - 1].parker != parker)
		i--;
	return i;
}

bool job_idle_enter(job_idle_list *list, const job_idler *idler, bool spinning)
{
	job_lock_take(&list->lock);
	assert(list_find(list, idler->parker) == 0 && "a thread is on the list once");
	if (idler_waits(idler)) /* relaxed: see the declaration */
		atomic_fetch_or_explicit(&list->roots, job_idle_root_bit(idler->scope.root), memory_order_relaxed);
	/* Seq_cst: step (1) of job_park.h, partner of (b). One addition counts an idler in and, if spinning, a spinner out:
	 * unsigned arithmetic wraps. */
	uint32_t state = atomic_fetch_add_explicit(&list->state, spinning ? 1u - SPINNER : 1u, memory_order_seq_cst);
	uint32_t count = IDLERS(state);
	assert(count <= list->workers && "the owner and the workers at most");
	list->idler[count] = *idler;
	idler->parker->rescue = false;
	if (idler->worker && !idler->scope.all)
		list->waiting++;
	JOB_CHECK(list_is_sound(list));
	bool alone = list->waiting == list->workers;
	job_lock_give(&list->lock);
	return alone;
}

/* Removes idler i and keeps the others in order. spins: it becomes a spinner. Caller holds list->lock. */
static void list_remove(job_idle_list *list, uint32_t i, bool spins)
{
	assert(i < IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed))); /* ordered by the lock */
	/* Seq_cst like every change of the word, so that its changes form one chain (see the head of job_park.h). */
	uint32_t state = atomic_fetch_add_explicit(&list->state, spins ? SPINNER - 1u : -1u, memory_order_seq_cst);
	if (list->idler[i].worker && !list->idler[i].scope.all)
		list->waiting--;
	bool waited = idler_waits(&list->idler[i]);
	for (; i + 1 < IDLERS(state); i++)
		list->idler[i] = list->idler[i + 1];
	if (waited) /* relaxed: see the declaration */
		atomic_store_explicit(&list->roots, list_roots(list, IDLERS(state) - 1), memory_order_relaxed);
	JOB_CHECK(list_is_sound(list));
}

job_idle_outcome job_idle_leave(job_idle_list *list, job_parker *parker)
{
	uint32_t place = 0;
	job_parker_clear(parker);
	if (!parker->chosen) { /* or its token lies under one from job_parker_wake */
		job_lock_take(&list->lock);
		place = list_find(list, parker);
		if (place > 0)
			list_remove(list, place - 1, false);
		job_lock_give(&list->lock);
		/* A waker removes a thread from the list and leaves the token in one critical section. So if this thread was
		 * chosen, the token is there by now, and no other can follow. */
		job_parker_clear(parker);
	}
	parker->chosen = false;
	return place > 0 ? JOB_IDLE_NOT_CHOSEN : parker->rescue ? JOB_IDLE_RESCUE : JOB_IDLE_CHOSEN;
}

/* True if a thread with this scope may do this work. */
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

/* True if the idler starts at once when it is woken: it is bound, and so can be on another CPU than the waker (see
 * move_away). If no worker is bound, one is as good as another. */
static bool is_first_choice(const job_idle_list *list, const job_idler *idler)
{
	return idler->parker->bound || !list->spare;
}

/* The index plus one of an idler whose scope includes this work: the newest bound one if there is one, else the newest;
 * 0 if there is none. all: idlers that may do any work may be chosen. Caller holds list->lock. */
static uint32_t list_choose(const job_idle_list *list, const job_work *work, bool all)
{
	uint32_t found = 0;
	/* Relaxed: ordered by the lock. */
	for (uint32_t i = IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)); i > 0; i--) {
		const job_idler *idler = &list->idler[i - 1];
		if (!scope_accepts(&idler->scope, work) || (idler->scope.all && !all))
			continue;
		if (is_first_choice(list, idler))
			return i;
		found = found > 0 ? found : i;
	}
	return found;
}

/* list_choose for job_idle_wake. If there is none but every worker waits, some idler that may do jobs, and *rescue is
 * true. Caller holds list->lock. */
static uint32_t list_find_for(const job_idle_list *list, const job_work *work, bool *rescue)
{
	uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed); /* idlers are ordered by the lock */
	uint32_t found = list_choose(list, work, SPINNERS(state) <= work->spinners);
	*rescue = false;
	if (found > 0)
		return found;
	if (work->kind == JOB_WORK_LOOP || list->waiting < list->workers)
		return 0;
	*rescue = true;
	uint32_t i = IDLERS(state);
	while (i > 0 && !list->idler[i - 1].scope.jobs)
		i--;
	return i;
}

/* If the thread to be woken is bound to the CPU of its waker, which keeps running there, binds it to the spare CPU
 * instead. Caller holds list->lock. */
static void move_away(job_idle_list *list, job_parker *parker)
{
	if (!parker->bound || !list->spare || parker->cpu != job_sys_cpu() ||
	    !job_sys_bind(parker->thread, list->spare_cpu))
		return;
	uint32_t cpu = parker->cpu;
	parker->cpu = list->spare_cpu;
	list->spare_cpu = cpu;
}

/* Removes the idler with index place - 1 and leaves the token. Returns its parker if its thread must be woken by the
 * kernel, else NULL. Caller holds list->lock. */
static job_parker *choose_idler(job_idle_list *list, uint32_t place, bool rescue)
{
	assert(place > 0);
	job_parker *parker = list->idler[place - 1].parker;
	parker->rescue = rescue;
	move_away(list, parker);
	list_remove(list, place - 1, list->idler[place - 1].scope.all);
	return leave_token(parker, PARKER_CHOSEN) ? parker : NULL;
}

/* Chooses the idler with index place - 1, releases list->lock, which the caller holds, and wakes the idler's thread. */
static void wake_idler(job_idle_list *list, uint32_t place, bool rescue)
{
	job_parker *parker = choose_idler(list, place, rescue);
	job_lock_give(&list->lock);
	if (parker)
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
		wake_idler(list, place, rescue);
	return place > 0;
}

void job_idle_wake_waiting(job_idle_list *list)
{
	/* Seq_cst: step (b) of job_park.h, partner of (1). */
	uint32_t count = IDLERS(atomic_load_explicit(&list->state, memory_order_seq_cst));
	if (count == 0)
		return;
	job_idle_wake(list, &(job_work){.kind = JOB_WORK_SHARED});
	for (; count > 0; count--) { /* a woken thread may come back, so the number is limited */
		job_lock_take(&list->lock);
		uint32_t place = IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)); /* ordered by the lock */
		while (place > 0 && !idler_waits(&list->idler[place - 1]))
			place--;
		if (place == 0) {
			job_lock_give(&list->lock);
			return;
		}
		wake_idler(list, place, false);
	}
}

void job_idle_wake_thread(job_idle_list *list, job_parker *parker)
{
	/* Seq_cst: step (b) of job_park.h, partner of (1). A load suffices, since the caller has put the job into the
	 * thread's inbox by a seq_cst exchange. */
	if (IDLERS(atomic_load_explicit(&list->state, memory_order_seq_cst)) == 0)
		return;
	job_lock_take(&list->lock);
	uint32_t place = list_find(list, parker);
	if (place == 0)
		job_lock_give(&list->lock);
	else
		wake_idler(list, place, false);
}

uint32_t job_idle_wake_spinners(job_idle_list *list, uint32_t limit, uint32_t count)
{
	job_parker *parkers[JOB_WAKE_FAN];
	uint32_t chosen = 0, asleep = 0;
	assert(count <= JOB_WAKE_FAN);
	if (IDLERS(atomic_load_explicit(&list->state, memory_order_relaxed)) == 0) /* may miss one: see the declaration */
		return 0;
	job_lock_take(&list->lock);
	for (; chosen < count; chosen++) {
		/* Only idlers that may do any work may do a job from a shared queue. Relaxed: ordered by the lock. */
		uint32_t state = atomic_load_explicit(&list->state, memory_order_relaxed);
		uint32_t place = SPINNERS(state) < limit ? list_choose(list, &(job_work){.kind = JOB_WORK_SHARED}, true) : 0;
		if (place == 0)
			break;
		job_parker *parker = choose_idler(list, place, false);
		if (parker)
			parkers[asleep++] = parker;
	}
	job_lock_give(&list->lock);
	for (uint32_t i = 0; i < asleep; i++)
		job_sys_futex_wake_one(&parkers[i]->state);
	return chosen;
}
