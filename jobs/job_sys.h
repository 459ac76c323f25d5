/*
 * job_sys: what the library asks of the CPU and the kernel: pause, yield, sleep, wake, clock, CPU binding. The model
 * tests replace this header (tests/jobs/model/job_model_sys.h) to run the sources through every interleaving.
 */
#ifndef STILB_JOB_SYS_H
#define STILB_JOB_SYS_H

#include <linux/futex.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* How often a waiting thread pauses before it yields its CPU, which the thread it waits for may need. */
#define JOB_PAUSES_BEFORE_YIELD 64

static inline void job_sys_pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
	__builtin_ia32_pause();
#elif defined(__aarch64__)
	__asm__ volatile("isb");
#endif
}

/* One round of a loop that waits for another thread: a pause in the first JOB_PAUSES_BEFORE_YIELD rounds, then yields.
 * *rounds counts the pauses; the caller sets it to 0 before the loop. */
static inline void job_sys_relax(uint32_t *rounds)
{
	if (*rounds < JOB_PAUSES_BEFORE_YIELD) {
		(*rounds)++;
		job_sys_pause();
	} else {
		sched_yield();
	}
}

/* A steady clock for short intervals, the same on all CPUs. job_sys_ticks_in converts nanoseconds to its unit. */
static inline uint64_t job_sys_ticks(void)
{
#if defined(__x86_64__)
	return __builtin_ia32_rdtsc();
#else
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
#endif
}

/* The number of ticks in an interval of less than 2^32 ns, wrong by at most 2 %. The first call of a process measures
 * the rate, which takes 50 us, and longer only if the thread is interrupted meanwhile. [any-thread] */
uint64_t job_sys_ticks_in(uint64_t nanoseconds);

/* The steady clock in nanoseconds, for times that are compared with timeouts. */
static inline uint64_t job_sys_clock_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* The CPU that the calling thread runs on at this moment; UINT32_MAX if the kernel does not say. */
static inline uint32_t job_sys_cpu(void)
{
	int cpu = sched_getcpu();
	return cpu < 0 ? UINT32_MAX : (uint32_t)cpu;
}

/* The kernel's id of the calling thread. */
static inline int32_t job_sys_thread(void)
{
	return (int32_t)syscall(SYS_gettid);
}

/* Binds a thread of this process, 0 for the calling one, to one CPU; false if the kernel refuses. */
bool job_sys_bind(int32_t thread, uint32_t cpu);

/* Keeps the compiler from moving memory accesses from one side to the other. Costs nothing by itself. */
static inline void job_sys_compiler_barrier(void)
{
	__asm__ volatile("" ::: "memory");
}

/* A full memory barrier in every thread of this process at some moment during the call: each thread's accesses before a
 * job_sys_compiler_barrier happen before that moment, or those after it happen after the moment. So a thread that does
 * this seldom saves others a barrier that they would need often. Takes 0.5 us, and 10 us if other threads are running.
 * False if the kernel refuses it, which is so until Linux 4.14 and in some containers; then it was no barrier.
 * [any-thread] */
bool job_sys_membarrier(void);

/* Sleeps if *word is expected. Returns when woken, at once if *word differs, or spuriously: callers loop. */
static inline void job_sys_futex_wait(_Atomic uint32_t *word, uint32_t expected)
{
	syscall(SYS_futex, word, FUTEX_WAIT_PRIVATE, expected, NULL, NULL, 0);
}

/* job_sys_futex_wait that returns after the given time at the latest. */
static inline void job_sys_futex_wait_for(_Atomic uint32_t *word, uint32_t expected, uint64_t nanoseconds)
{
	struct timespec timeout = {.tv_sec = (time_t)(nanoseconds / 1000000000u),
	                           .tv_nsec = (long)(nanoseconds % 1000000000u)};
	syscall(SYS_futex, word, FUTEX_WAIT_PRIVATE, expected, &timeout, NULL, 0);
}

/* Sleeps for about the given time. */
static inline void job_sys_nap(uint64_t nanoseconds)
{
	struct timespec time = {.tv_sec = (time_t)(nanoseconds / 1000000000u),
	                        .tv_nsec = (long)(nanoseconds % 1000000000u)};
	nanosleep(&time, NULL);
}

/* Wakes one thread that sleeps on word, if there is one. */
static inline void job_sys_futex_wake_one(_Atomic uint32_t *word)
{
	syscall(SYS_futex, word, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

#endif
