/*
 * job_sys: what this library asks of the CPU and the kernel while threads race: pause, yield, sleep, wake.
 * The model test (tests/test_job_model.c) puts its own version of this header in its place and so drives the real
 * sources through every interleaving.
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

/* Pauses before a waiting thread gives its time slice away: the holder of a lock may be waiting for just that. */
#define JOB_PAUSES_BEFORE_YIELD 64

static inline void job_sys_pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
	__builtin_ia32_pause();
#elif defined(__aarch64__)
	__asm__ volatile("isb");
#endif
}

/* One turn of a loop that waits for another thread. */
static inline void job_sys_relax(uint32_t *turns)
{
	if (*turns < JOB_PAUSES_BEFORE_YIELD) {
		(*turns)++;
		job_sys_pause();
	} else {
		sched_yield();
	}
}

/* A clock for short waits: steady, the same on every CPU, in ticks of its own. */
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

/* How many ticks there are in so many nanoseconds. The first call in a process measures, which takes 50 us. [any-thread] */
uint64_t job_sys_ticks_in(uint64_t nanoseconds);

/* The CPU this thread runs on at the moment. */
static inline uint32_t job_sys_cpu(void)
{
	int cpu = sched_getcpu();
	return cpu < 0 ? UINT32_MAX : (uint32_t)cpu;
}

/* This thread's number in the kernel. */
static inline int32_t job_sys_thread(void)
{
	return (int32_t)syscall(SYS_gettid);
}

/* Binds a thread of this process to one CPU; false if that cannot be. */
bool job_sys_bind(int32_t thread, uint32_t cpu);

/* Sleeps if *word still is expected. Returns when woken, when it was not, or for no reason: callers loop. */
static inline void job_sys_futex_wait(_Atomic uint32_t *word, uint32_t expected)
{
	syscall(SYS_futex, word, FUTEX_WAIT_PRIVATE, expected, NULL, NULL, 0);
}

/* The same, for at most so long. */
static inline void job_sys_futex_wait_for(_Atomic uint32_t *word, uint32_t expected, uint64_t nanoseconds)
{
	struct timespec timeout = {.tv_sec = (time_t)(nanoseconds / 1000000000u),
	                           .tv_nsec = (long)(nanoseconds % 1000000000u)};
	syscall(SYS_futex, word, FUTEX_WAIT_PRIVATE, expected, &timeout, NULL, 0);
}

/* Sleeps about so long. */
static inline void job_sys_nap(uint64_t nanoseconds)
{
	struct timespec time = {.tv_sec = (time_t)(nanoseconds / 1000000000u),
	                        .tv_nsec = (long)(nanoseconds % 1000000000u)};
	nanosleep(&time, NULL);
}

static inline void job_sys_futex_wake_one(_Atomic uint32_t *word)
{
	syscall(SYS_futex, word, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

#endif
