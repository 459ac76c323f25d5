/*
 * bench_child: helpers for the program of a subject (an implementation that is measured, such as a queue), which
 * stilb-bench starts for one run in one case (a workload) as
 *
 *   PROGRAM SUBJECT CASE SECONDS ROUND [ARGUMENT]
 *
 * The program measures for about SECONDS, verifies its own result and prints one line for each metric:
 *
 *   int main(int argc, char **argv)
 *   {
 *       bench_child child = bench_child_args(argc, argv);
 *       if (!has_case(child.case_name))
 *           return BENCH_CHILD_SKIP;
 *       if (!measure(&child, &ns))
 *           bench_child_fail("wrong result: ...");
 *       bench_child_metric("p50", ns);
 *       return 0;
 *   }
 *
 * Exit status: 0; BENCH_CHILD_SKIP if the subject does not have the case; anything else is a failure, and the last line
 * on stderr is its reason. C and C++. Every function but bench_child_args and bench_child_metric is [any-thread].
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
	double seconds;       /* how long to measure, >= 0 */
	uint32_t round;       /* 0, 1, ...; a seed for random numbers */
	const char *argument; /* from the suite's `prepare`, or NULL */
} bench_child;

/* Reads the command line; ends the program with status 2 if it has the wrong number of arguments. */
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

/* Prints one result. metric: the name in the suite's bench_metric. Whole numbers below 10^12 are printed exactly. */
static inline void bench_child_metric(const char *metric, double value)
{
	printf("%s %.12g\n", metric, value);
}

/* Ends the program with status 1 and this line on stderr, which stilb-bench reports as the reason of the failure. */
__attribute__((format(printf, 1, 2), noreturn)) static inline void bench_child_fail(const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	vfprintf(stderr, format, arguments);
	va_end(arguments);
	fputc('\n', stderr);
	exit(1);
}

/* CLOCK_MONOTONIC, nanoseconds. */
static inline uint64_t bench_child_now_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* The number of CPUs that this process may use. They are read from the affinity mask of its main thread, so a program
 * must not pin its main thread. */
static inline uint32_t bench_child_cpu_count(void)
{
	cpu_set_t set;
	return sched_getaffinity(getpid(), sizeof set, &set) == 0 ? (uint32_t)CPU_COUNT(&set) : 1;
}

/* Pins the calling thread, which must not be the main thread, to one of the CPUs that this process may use: to number
 * i modulo bench_child_cpu_count of them. Does nothing if the system refuses. */
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

/* A clock of constant rate that is cheap to read: the time-stamp counter on x86-64, in its own ticks; else ns. */
static inline uint64_t bench_child_ticks(void)
{
#if defined(__x86_64__)
	return __builtin_ia32_rdtsc();
#else
	return bench_child_now_ns();
#endif
}

#endif
