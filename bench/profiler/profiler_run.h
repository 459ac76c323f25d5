/*
 * profiler_run: the interface between the suite `profiler` and a subject, which is a profiler, and the loops that all
 * profilers are measured with. C and C++. A subject's file defines PROFILER_SCOPE, a zone (recorded span of code) that
 * lasts to the end of the enclosing scope, includes this header and defines profiler_subjects; profiler_run.c has main.
 */
#ifndef PROFILER_RUN_H
#define PROFILER_RUN_H

#include "bench/harness/bench_child.h"
#include "bench/profiler/profiler_cases.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Zones in one turn: as many as microprofile's buffer holds, and shorter than a time slice. */
#define PROFILER_TURN 20000u

/* A loop that runs its body `count` times. */
typedef void profiler_loop(uint32_t count);

typedef struct profiler_subject {
	const char *name;
	/* Loops over a zone: an empty zone, one that begins where the last one ended, one whose end waits for the
	 * instructions before it (profiler_cases.h). NULL: the subject has no such zone. */
	profiler_loop *zones, *next, *precise;
	profiler_loop *work; /* its body is profiler_work, 41 ns of arithmetic (below), inside a zone; NULL: not measured */
	void (*thread_start)(const char *name);
	void (*thread_stop)(void);
	void (*record)(int on);     /* switches recording on or off; NULL: it cannot */
	void (*frame)(void);        /* called after each turn, not timed; NULL: not needed */
	uint64_t (*recorded)(void); /* zones recorded so far, to verify the run; NULL: unknown */
	int (*special)(profiler_kind kind, const bench_child *child); /* cases that only it has: exit status; NULL: none */
} profiler_subject;

/* The subjects of this program, NULL-terminated. */
extern const profiler_subject *const profiler_subjects[];

/* Steps of profiler_work, the work of the case `work`: multiplications and additions that depend on each other, 4
 * cycles each; 41 ns at 3.7 GHz, the work with which other profilers were measured. It has no branch: the code around a
 * branch affects how often it is mispredicted, and that would be measured instead. */
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
