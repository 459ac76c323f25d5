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
#include <stdint.h>
#include <sys/syscall.h>
#include <unistd.h>

/* Looks a thread takes before it sleeps. A sleep and a wake cost some 30 us, so a few microseconds of looking pay when
 * loops follow one another closely, and are cheap when they do not. */
#define JOB_IDLE_LOOKS 200

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
		++*turns;
		job_sys_pause();
	} else {
		sched_yield();
	}
}

/* Sleeps if *word still is expected. Returns when woken, when it was not, or for no reason: callers loop. */
static inline void job_sys_futex_wait(_Atomic uint32_t *word, uint32_t expected)
{
	syscall(SYS_futex, word, FUTEX_WAIT_PRIVATE, expected, NULL, NULL, 0);
}

static inline void job_sys_futex_wake_one(_Atomic uint32_t *word)
{
	syscall(SYS_futex, word, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

#endif
