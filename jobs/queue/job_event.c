#include "jobs/queue/job_event.h"

#include "jobs/job_contract.h"

#include <errno.h>

void job_event_wake(job_event *event, uint32_t count)
{
	assert(count > 0);
	uint32_t before = atomic_load_explicit(&event->signals, memory_order_relaxed); /* checked by the exchange */
	uint32_t after;
	do
		after = count < JOB_EVENT_ALL - before ? before + count : JOB_EVENT_ALL;
	/* Seq_cst pairs with the exchange in job_event_wait: the attempt that follows it sees what was done before. */
	while (!atomic_compare_exchange_weak_explicit(&event->signals, &before, after, memory_order_seq_cst,
	                                              memory_order_relaxed));
	if (before == 0) /* else a thread has been woken, or finds the signals before it sleeps */
		job_sys_futex_wake_one(&event->signals);
}

/* The moment at which the timeout is over; JOB_EVENT_NO_LIMIT: never. */
static uint64_t event_end(uint64_t timeout_ns)
{
	if (timeout_ns == JOB_EVENT_NO_LIMIT)
		return JOB_EVENT_NO_LIMIT;
	uint64_t now = job_sys_clock_ns();
	return timeout_ns < JOB_EVENT_NO_LIMIT - now ? now + timeout_ns : JOB_EVENT_NO_LIMIT;
}

static uint64_t event_time_left(uint64_t end)
{
	if (end == JOB_EVENT_NO_LIMIT)
		return JOB_EVENT_NO_LIMIT;
	uint64_t now = job_sys_clock_ns();
	return now < end ? end - now : 0;
}

/* Tries for some ticks without sleeping. The result of the last attempt. */
static int event_spin(int (*attempt)(void *context), void *context, uint64_t spin)
{
	uint64_t start = job_sys_ticks();
	uint32_t rounds = 0;
	int result = -EAGAIN;
	while (result == -EAGAIN && job_sys_ticks() - start < spin) {
		job_sys_relax(&rounds);
		result = attempt(context);
	}
	return result;
}

/* Sleeps while there are no signals, for this time at most. ordered: the barrier was one. */
static void event_sleep(job_event *event, uint64_t time_ns, bool ordered)
{
	uint64_t most = ordered ? JOB_EVENT_NO_LIMIT : JOB_EVENT_SLEEP_NS;
	uint64_t time = time_ns < most ? time_ns : most;
	if (time == JOB_EVENT_NO_LIMIT)
		job_sys_futex_wait(&event->signals, 0);
	else
		job_sys_futex_wait_for(&event->signals, 0, time);
}

/* How many of the signals that a waiter took are for others, when it ends with this result. */
static uint32_t event_rest(int result, uint32_t signals)
{
	if (result == 0)
		return signals > 0 ? signals - 1 : 0;
	return result == -ETIMEDOUT ? 0 : signals + 1; /* closed: others end, too; out of memory: it used none */
}

int job_event_wait(job_event *event, int (*attempt)(void *context), void *context, uint64_t timeout_ns)
{
	if (timeout_ns == 0)
		return -ETIMEDOUT;
	uint64_t end = event_end(timeout_ns);
	uint64_t spin = job_sys_ticks_in(timeout_ns < JOB_EVENT_SPIN_NS ? timeout_ns : JOB_EVENT_SPIN_NS);
	int result = event_spin(attempt, context, spin);
	if (result != -EAGAIN)
		return result;
	/* Seq_cst: counted before the barrier; pairs with the load in job_event_signal. */
	atomic_fetch_add_explicit(&event->waiters, 1, memory_order_seq_cst);
	bool ordered = job_sys_membarrier();
	uint32_t signals;
	for (;;) {
		/* Seq_cst pairs with the exchange in job_event_wake: what came before these signals is seen below. */
		signals = atomic_exchange_explicit(&event->signals, 0, memory_order_seq_cst);
		result = attempt(context);
		if (result != -EAGAIN)
			break;
		uint64_t left = event_time_left(end);
		if (left == 0) {
			result = -ETIMEDOUT;
			break;
		}
		event_sleep(event, left, ordered);
	}
	uint32_t rest = event_rest(result, signals);
	/* Release pairs with the addition above in a waiter that comes later: it sees what these signals told of. */
	bool alone = atomic_fetch_sub_explicit(&event->waiters, 1, memory_order_release) == 1;
	if (!alone && rest > 0)
		job_event_wake(event, rest);
	return result;
}
