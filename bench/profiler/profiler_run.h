/*
 * profiler_run: what a subject of the suite `profiler` provides, a file for each profiler, and the loops that all of
 * them are measured with. A subject defines PROFILER_SCOPE, a zone to the end of the enclosing scope, includes this
 * file and fills a profiler_subject; profiler_run.c has the program.
 */
#ifndef PROFILER_RUN_H
#define PROFILER_RUN_H

#include "bench/harness/bench_child.h"
#include "bench/profiler/profiler_cases.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As many zones as the microprofile subject's buffer takes before it has to be emptied, and less than a time slice. */
#define PROFILER_TURN 20000u

/* Runs its body `count` times. */
typedef void profiler_loop(uint32_t count);

typedef struct profiler_subject {
	const char *name;
	profiler_loop *zones, *next, *precise; /* NULL: it cannot */
	profiler_loop *work;                   /* profiler_work in a zone */
	void (*thread_start)(const char *name);
	void (*thread_stop)(void);
	void (*record)(int on);     /* NULL: it has no switch */
	void (*frame)(void);        /* after each turn, outside of what is timed; NULL: not needed */
	uint64_t (*recorded)(void); /* zones so far, to check that they were recorded; NULL: it does not tell */
	int (*special)(profiler_kind kind, const bench_child *child); /* cases of its own: exit status; NULL: none */
} profiler_subject;

/* NULL-terminated. */
extern const profiler_subject *const profiler_subjects[];

/* The work in the middle of the case `work`: multiplications and additions that wait for each other, 4 cycles each; 41
 * ns at
 * 3.7 GHz, with which other profilers were measured. Without a branch: whether the end of a loop is foreseen depends on
 * what stands around it, and would be measured instead. */
#define PROFILER_WORK_STEPS 38

extern uint64_t profiler_work_value;

static inline void profiler_work(void)
{
	uint64_t value = profiler_work_value;
#pragma GCC unroll 38
	for (int i = 0; i < PROFILER_WORK_STEPS; i++) {
		value = value * UINT64_C(6364136223846793005) + 1;
		__asm__ volatile("" : "+r"(value));
	}
	profiler_work_value = value;
}

#ifdef PROFILER_SCOPE
static void profiler_loop_zones(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		PROFILER_SCOPE;
		__asm__ volatile("" ::: "memory");
	}
}

static void profiler_loop_work(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		PROFILER_SCOPE;
		profiler_work();
	}
}
#endif

#ifdef __cplusplus
}
#endif
#endif
