/*
 * bench_child: the program of a subject, as stilb-bench starts it:
 *
 *   PROGRAM SUBJECT CASE SECONDS ROUND [ARGUMENT]
 *
 * It measures for about SECONDS, checks its own result and prints one line for each metric with bench_child_metric.
 * Exit status: 0; BENCH_CHILD_SKIP when the subject has no such case; anything else is a failure, and the last line on
 * stderr says why (bench_child_fail). C and C++.
 */
#ifndef BENCH_CHILD_H
#define BENCH_CHILD_H

#include <sched.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define BENCH_CHILD_SKIP 77

typedef struct bench_child {
	const char *subject, *case_name;
	double seconds;
	uint32_t round;       /* 0, 1, ...: a seed */
	const char *argument; /* what the suite prepared, or NULL */
} bench_child;

static inline bench_child bench_child_args(int argc, char **argv)
{
	if (argc != 5 && argc != 6) {
		fprintf(stderr, "%s: started by stilb-bench with SUBJECT CASE SECONDS ROUND [ARGUMENT]\n", argv[0]);
		exit(2);
	}
	bench_child child;
	child.subject = argv[1];
	child.case_name = argv[2];
	child.seconds = strtod(argv[3], NULL);
	child.round = (uint32_t)strtoul(argv[4], NULL, 10);
	child.argument = argc == 6 ? argv[5] : NULL;
	return child;
}

/* Whole numbers arrive as they are. */
static inline void bench_child_metric(const char *metric, double value)
{
	printf("%s %.12g\n", metric, value);
}

__attribute__((format(printf, 1, 2), noreturn)) static inline void bench_child_fail(const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	vfprintf(stderr, format, arguments);
	va_end(arguments);
	fputc('\n', stderr);
	exit(1);
}

/* CLOCK_MONOTONIC. */
static inline uint64_t bench_child_now_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* CPUs that this process may use: as its main thread is allowed to, so a program pins only others. */
static inline uint32_t bench_child_cpu_count(void)
{
	cpu_set_t set;
	return sched_getaffinity(getpid(), sizeof set, &set) == 0 ? (uint32_t)CPU_COUNT(&set) : 1;
}

/* Puts the calling thread (not the main one) on the i-th of them, counted round and round. */
static inline void bench_child_pin(uint32_t i)
{
	cpu_set_t all, one;
	if (sched_getaffinity(getpid(), sizeof all, &all) != 0)
		return;
	uint32_t left = i % (uint32_t)CPU_COUNT(&all);
	for (int cpu = 0; cpu < CPU_SETSIZE; cpu++)
		if (CPU_ISSET(cpu, &all) && left-- == 0) {
			CPU_ZERO(&one);
			CPU_SET(cpu, &one);
			sched_setaffinity(0, sizeof one, &one);
			return;
		}
}

/* A steady clock that is cheap to read, in ticks of its own. */
static inline uint64_t bench_child_ticks(void)
{
#if defined(__x86_64__)
	return __builtin_ia32_rdtsc();
#else
	return bench_child_now_ns();
#endif
}

#endif
