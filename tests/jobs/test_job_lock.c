/*
 * The lock of job_lock.h with real threads: more of them than CPUs, and a holder stopped by a signal in its critical
 * section. test_job_model_low_lock checks all interleavings.
 */
#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>
#include <unistd.h>

#include "jobs/job_lock.h"
#include "support/test.h"

enum { THREADS = 16, ROUNDS = 20000, WAITERS = 4, STALL_MS = 300 };

static double clock_ms(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static void sleep_ms(uint32_t ms)
{
	nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L}, NULL);
}

static struct shared {
	job_lock lock;
	uint32_t inside, overlaps; /* not atomic: the thread sanitizer checks the lock's memory orders */
	uint64_t entered;
} shared;

static void enter(struct shared *s)
{
	job_lock_take(&s->lock);
	s->overlaps += s->inside++ != 0;
	s->entered++;
	s->inside--;
	job_lock_give(&s->lock);
}

static void *enter_often(void *data)
{
	for (uint32_t i = 0; i < ROUNDS; i++)
		enter(data);
	return NULL;
}

static void test_one_at_a_time(void **state)
{
	(void)state;
	shared = (struct shared){0};
	pthread_t threads[THREADS];
	for (uint32_t i = 0; i < THREADS; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, enter_often, &shared), 0);
	for (uint32_t i = 0; i < THREADS; i++)
		pthread_join(threads[i], NULL);
	assert_int_equal(shared.entered, (uint64_t)THREADS * ROUNDS);
	assert_int_equal(shared.overlaps, 0);
}

/* ---- a holder that is stopped --------------------------------------------------------------------------------- */

static int stall_pipe[2];

static void stand_still(int signal)
{
	(void)signal;
	char byte;
	while (read(stall_pipe[0], &byte, 1) != 1)
		;
}

static void *enter_and_stall(void *data)
{
	struct shared *s = data;
	job_lock_take(&s->lock);
	raise(SIGUSR1);
	s->entered++;
	job_lock_give(&s->lock);
	return NULL;
}

typedef struct waiter {
	pthread_t thread;
	double cpu_ms; /* CPU time used before it got the lock */
} waiter;

static void *enter_once(void *data)
{
	waiter *w = data;
	double start = clock_ms(CLOCK_THREAD_CPUTIME_ID);
	enter(&shared);
	w->cpu_ms = clock_ms(CLOCK_THREAD_CPUTIME_ID) - start;
	return NULL;
}

static void test_waiters_sleep_while_holder_stalls(void **state)
{
	(void)state;
	shared = (struct shared){0};
	assert_int_equal(pipe(stall_pipe), 0);
	struct sigaction action = {.sa_handler = stand_still}, before;
	assert_int_equal(sigaction(SIGUSR1, &action, &before), 0);

	pthread_t holder;
	waiter waiters[WAITERS];
	assert_int_equal(pthread_create(&holder, NULL, enter_and_stall, &shared), 0);
	/* Relaxed: only waits until the holder has the lock. */
	while (!atomic_load_explicit(&shared.lock.held, memory_order_relaxed))
		sleep_ms(1);
	for (uint32_t i = 0; i < WAITERS; i++)
		assert_int_equal(pthread_create(&waiters[i].thread, NULL, enter_once, &waiters[i]), 0);
	sleep_ms(STALL_MS);
	assert_int_equal(write(stall_pipe[1], "", 1), 1);
	pthread_join(holder, NULL);
	double cpu_ms = 0;
	for (uint32_t i = 0; i < WAITERS; i++) {
		pthread_join(waiters[i].thread, NULL);
		cpu_ms += waiters[i].cpu_ms;
	}
	print_message("%d waiters used %.2f ms of CPU in %d ms\n", WAITERS, cpu_ms, STALL_MS);

	assert_int_equal(shared.entered, WAITERS + 1);
	assert_true(cpu_ms < WAITERS * STALL_MS / 20.0); /* measured: 0.5 % of it each; spinning ones use all they get */
	sigaction(SIGUSR1, &before, NULL);
	close(stall_pipe[0]);
	close(stall_pipe[1]);
}

/* ---- holders that keep the lock for long ---------------------------------------------------------------------- */

enum { LONG_THREADS = 8, LONG_ROUNDS = 10 };

static void *stay_long(void *data)
{
	struct shared *s = data;
	for (uint32_t i = 0; i < LONG_ROUNDS; i++) {
		job_lock_take(&s->lock);
		s->overlaps += s->inside++ != 0;
		s->entered++;
		sleep_ms(1); /* all other threads fall asleep meanwhile */
		s->inside--;
		job_lock_give(&s->lock);
	}
	return NULL;
}

static void test_nobody_is_forgotten(void **state)
{
	(void)state;
	shared = (struct shared){0};
	pthread_t threads[LONG_THREADS];
	for (uint32_t i = 0; i < LONG_THREADS; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, stay_long, &shared), 0);
	for (uint32_t i = 0; i < LONG_THREADS; i++)
		pthread_join(threads[i], NULL);
	assert_int_equal(shared.entered, LONG_THREADS * LONG_ROUNDS);
	assert_int_equal(shared.overlaps, 0);
	assert_int_equal(atomic_load_explicit(&shared.lock.held, memory_order_relaxed), 0); /* relaxed: all joined */
}

/* Waiters are woken by the release. Without that their sleep would end only when its time is over (JOB_LOCK_SLEEP_NS),
 * 2 ms after the release or later. */
static void test_a_waiter_is_woken(void **state)
{
	(void)state;
	enum { TIMES = 20, TIMES_WHEN_BUSY = 5000 };
	double best_ms = 1e9;
	for (uint32_t i = 0; i < TIMES || (best_ms >= 1 && i < TIMES_WHEN_BUSY); i++) {
		shared = (struct shared){0};
		waiter w;
		job_lock_take(&shared.lock);
		assert_int_equal(pthread_create(&w.thread, NULL, enter_once, &w), 0);
		/* Relaxed: only waits until the other thread announces its sleep; the sleep below lets it fall asleep. */
		while (!atomic_load_explicit(&shared.lock.sleepers, memory_order_relaxed))
			sleep_ms(1);
		sleep_ms(1);
		double start = clock_ms(CLOCK_MONOTONIC);
		job_lock_give(&shared.lock);
		pthread_join(w.thread, NULL);
		double ms = clock_ms(CLOCK_MONOTONIC) - start;
		best_ms = ms < best_ms ? ms : best_ms;
	}
	print_message("from given to got and joined: %.3f ms at best\n", best_ms);
	assert_true(best_ms < 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_one_at_a_time),
		cmocka_unit_test(test_waiters_sleep_while_holder_stalls),
		cmocka_unit_test(test_nobody_is_forgotten),
		cmocka_unit_test(test_a_waiter_is_woken),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
