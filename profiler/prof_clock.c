/* The clock of the zones, and what its ticks mean in nanoseconds. */
#include "profiler/prof_internal.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#define PROF_CALIBRATION_NS UINT64_C(10000000) /* two anchors 20 ns off, 10 ms apart: 4 ppm */

/* The same moment on both clocks. */
typedef struct prof_anchor {
	uint64_t ticks;
	uint64_t ns;
} prof_anchor;

static pthread_once_t prof_clock_once = PTHREAD_ONCE_INIT;
static struct {
	bool forced_monotonic;
	bool tsc;
	uint64_t resolution; /* ticks */
	prof_anchor start;
} prof_clock;

uint64_t stilb_prof_clock_monotonic(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * UINT64_C(1000000000) + (uint64_t)now.tv_nsec;
}

/* CPUID 0x80000007, EDX bit 8: the TSC runs at one rate in every power state (AMD APM vol. 3, Intel SDM vol. 2). */
static bool prof_tsc_is_invariant(void)
{
#if defined(__x86_64__)
	unsigned eax, ebx, ecx, edx;
	return __get_cpuid(0x80000007, &eax, &ebx, &ecx, &edx) && (edx >> 8 & 1);
#else
	return false;
#endif
}

static uint64_t prof_ticks(void)
{
#if defined(__x86_64__)
	if (prof_clock.tsc)
		return __builtin_ia32_rdtsc();
#endif
	return stilb_prof_clock_monotonic();
}

/* The tightest of 16 tries: the fewer ticks around the read, the less it can be off. */
static prof_anchor prof_anchor_take(void)
{
	prof_anchor best = {0, 0};
	uint64_t best_width = UINT64_MAX;
	for (int i = 0; i < 16; i++) {
		const uint64_t before = prof_ticks();
		const uint64_t ns = stilb_prof_clock_monotonic();
		const uint64_t width = prof_ticks() - before;
		if (width < best_width) {
			best_width = width;
			best = (prof_anchor){before + width / 2, ns};
		}
	}
	return best;
}

static int prof_compare_u64(const void *a, const void *b)
{
	const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* The median step between two reads that differ. */
static uint64_t prof_resolution_measure(void)
{
	uint64_t step[63];
	for (int i = 0; i < 63; i++) {
		const uint64_t first = prof_ticks();
		do
			step[i] = prof_ticks() - first;
		while (step[i] == 0);
	}
	qsort(step, 63, sizeof step[0], prof_compare_u64);
	return step[31];
}

static void prof_clock_start(void)
{
	prof_clock.tsc = !prof_clock.forced_monotonic && prof_tsc_is_invariant();
	prof_clock.resolution = prof_resolution_measure();
	prof_clock.start = prof_anchor_take();
}

void prof_clock_force_monotonic(void)
{
	prof_clock.forced_monotonic = true;
}

bool prof_clock_is_tsc(void)
{
	pthread_once(&prof_clock_once, prof_clock_start);
	return prof_clock.tsc;
}

uint64_t prof_clock_now(void)
{
	pthread_once(&prof_clock_once, prof_clock_start);
	return prof_ticks();
}

prof_timeline prof_clock_timeline(void)
{
	prof_timeline timeline = {.tsc = prof_clock_is_tsc(), .base = prof_clock.start.ticks, .scale = 1};
	if (timeline.tsc) {
		const uint64_t age = stilb_prof_clock_monotonic() - prof_clock.start.ns;
		if (age < PROF_CALIBRATION_NS)
			nanosleep(&(struct timespec){.tv_nsec = (long)(PROF_CALIBRATION_NS - age)}, NULL);
		const prof_anchor now = prof_anchor_take();
		timeline.shift = 56;
		timeline.scale = (uint64_t)(((unsigned __int128)(now.ns - prof_clock.start.ns) << timeline.shift) /
		                            (now.ticks - prof_clock.start.ticks));
	}
	timeline.hz = 1e9 * (double)(UINT64_C(1) << timeline.shift) / (double)timeline.scale;
	timeline.resolution_ns = (double)prof_clock.resolution * 1e9 / timeline.hz;
	return timeline;
}

uint64_t prof_timeline_ns(const prof_timeline *timeline, uint64_t ticks)
{
	const uint64_t age = ticks > timeline->base ? ticks - timeline->base : 0;
	return (uint64_t)((unsigned __int128)age * timeline->scale >> timeline->shift);
}
