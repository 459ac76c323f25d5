/*
 * The lock of job_lock.h with real threads: more of them than CPUs, a holder stopped by a signal in its critical
 * section, and a kernel without membarrier. test_job_model_low_lock checks all interleavings.
 */
#include <errno.h>
#include <linux/membarrier.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
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

/* Waiters are woken by the release. Without that their sleep would end never or, without membarrier, when its time is
 * over (JOB_LOCK_SLEEP_NS), 2 ms after the release or later. */
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

/* ---- sleeps --------------------------------------------------------------------------------------------------- */

/* Linked with -Wl,--wrap=syscall. What the kernel refuses or forgets, and counts of the sleeps it was asked for.
 * Relaxed, all: they are set and read while no other thread of the test runs, or waited for. */
static _Atomic bool membarrier_refused, wakes_forgotten;
static _Atomic uint32_t sleeps, limited_sleeps, sleeps_without_barrier;
static _Thread_local bool passed_barrier; /* since the thread's last sleep */

long __real_syscall(long number, ...);
long __wrap_syscall(long number, ...);

static void note_sleep(bool limited)
{
	atomic_fetch_add_explicit(limited ? &limited_sleeps : &sleeps, 1, memory_order_relaxed);
	if (!passed_barrier)
		atomic_fetch_add_explicit(&sleeps_without_barrier, 1, memory_order_relaxed);
	passed_barrier = false;
}

long __wrap_syscall(long number, ...)
{
	long argument[6];
	va_list list;
	va_start(list, number);
	for (size_t i = 0; i < 6; i++)
		argument[i] = va_arg(list, long); /* the system call ignores those that it does not have */
	va_end(list);
	if (number == SYS_membarrier && atomic_load_explicit(&membarrier_refused, memory_order_relaxed)) {
		errno = EPERM; /* as a filter of system calls answers, and a process that is not registered gets */
		return -1;
	}
	if (number == SYS_futex && argument[1] == FUTEX_WAIT_PRIVATE)
		note_sleep(argument[3] != 0);
	if (number == SYS_futex && argument[1] == FUTEX_WAKE_PRIVATE &&
	    atomic_load_explicit(&wakes_forgotten, memory_order_relaxed))
		return 0;
	long result = __real_syscall(number, argument[0], argument[1], argument[2], argument[3], argument[4], argument[5]);
	passed_barrier |= number == SYS_membarrier && argument[0] == MEMBARRIER_CMD_PRIVATE_EXPEDITED && result == 0;
	return result;
}

static bool kernel_has_membarrier(void)
{
	long commands = __real_syscall(SYS_membarrier, MEMBARRIER_CMD_QUERY, 0, 0, 0, 0, 0);
	return commands > 0 && (commands & MEMBARRIER_CMD_PRIVATE_EXPEDITED);
}

/* A thread waits for a lock that is given when it sleeps, with a kernel that does as it is told. */
static void sleep_once(bool refuse_membarrier, bool forget_wakes)
{
	shared = (struct shared){0};
	atomic_store_explicit(&membarrier_refused, refuse_membarrier, memory_order_relaxed);
	atomic_store_explicit(&wakes_forgotten, forget_wakes, memory_order_relaxed);
	_Atomic uint32_t *counts[] = {&sleeps, &limited_sleeps, &sleeps_without_barrier};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		atomic_store_explicit(counts[i], 0, memory_order_relaxed);
	waiter w;
	job_lock_take(&shared.lock);
	assert_int_equal(pthread_create(&w.thread, NULL, enter_once, &w), 0);
	while (atomic_load_explicit(&sleeps, memory_order_relaxed) == 0 &&
	       atomic_load_explicit(&limited_sleeps, memory_order_relaxed) == 0)
		sleep_ms(1);
	job_lock_give(&shared.lock);
	pthread_join(w.thread, NULL);
	assert_int_equal(shared.entered, 1);
	atomic_store_explicit(&membarrier_refused, false, memory_order_relaxed);
	atomic_store_explicit(&wakes_forgotten, false, memory_order_relaxed);
}

static void test_sleeps_have_no_limit(void **state)
{
	(void)state;
	if (!kernel_has_membarrier())
		skip();
	assert_true(job_sys_membarrier()); /* registered when the program was started */
	sleep_once(false, false);
	assert_in_range(sleeps, 1, UINT32_MAX);
	assert_int_equal(limited_sleeps, 0);
	assert_int_equal(sleeps_without_barrier, 0);
}

/* Without membarrier a release may fail to wake. Here all of them do, and the sleeps end nevertheless. */
static void test_sleeps_without_membarrier(void **state)
{
	(void)state;
	sleep_once(true, true);
	assert_int_equal(sleeps, 0);
	assert_in_range(limited_sleeps, 1, UINT32_MAX);
	sleep_once(true, false);
	assert_int_equal(sleeps, 0);
	assert_in_range(limited_sleeps, 1, UINT32_MAX);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_one_at_a_time),        cmocka_unit_test(test_waiters_sleep_while_holder_stalls),
		cmocka_unit_test(test_nobody_is_forgotten),  cmocka_unit_test(test_a_waiter_is_woken),
		cmocka_unit_test(test_sleeps_have_no_limit), cmocka_unit_test(test_sleeps_without_membarrier),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
