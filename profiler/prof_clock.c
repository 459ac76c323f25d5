/* The clock that zones are timed with (rdtsc or CLOCK_MONOTONIC), the conversion of its ticks to nanoseconds, and its
 * errors: resolution, bias and the cost of a zone. */
#include "profiler/prof_internal.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#define PROF_CALIBRATION_NS UINT64_C(10000000) /* of the only line: two anchors wrong by 20 ns give a slope 4 ppm off */
#define PROF_LINE_NS UINT64_C(50000000)        /* the shortest line if there are several: 1 ppm */
#define PROF_SCALE_SHIFT 56

static pthread_once_t prof_clock_once = PTHREAD_ONCE_INIT;
static struct {
	bool forced_monotonic;
	bool tsc;
	uint64_t resolution; /* ticks */
	uint64_t width;      /* ticks that an undisturbed read of CLOCK_MONOTONIC takes */
	prof_anchor start;
} prof_clock;

uint64_t stilb_prof_clock_monotonic(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * UINT64_C(1000000000) + (uint64_t)now.tv_nsec;
}

/* CPUID 0x80000007, EDX bit 8: the TSC runs at one rate in every power state; 0x80000001, EDX bit 27: there is rdtscp
 * (AMD APM vol. 3, Intel SDM vol. 2). */
static bool prof_tsc_is_invariant(void)
{
#if defined(__x86_64__)
	unsigned eax, ebx, ecx, edx;
	return __get_cpuid(0x80000007, &eax, &ebx, &ecx, &edx) && (edx >> 8 & 1) &&
	       __get_cpuid(0x80000001, &eax, &ebx, &ecx, &edx) && (edx >> 27 & 1);
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

/* Reads both clocks up to `tries` times and returns the try whose read of CLOCK_MONOTONIC took the fewest ticks. These
 * are *width, the bound of its error. A try that took at most `tight` ticks ends the search. */
static prof_anchor prof_anchor_take(int tries, uint64_t tight, uint64_t *width)
{
	assert(tries > 0);
	prof_anchor best = {0, 0};
	*width = UINT64_MAX;
	for (int i = 0; i < tries; i++) {
		uint64_t before = prof_ticks();
		uint64_t ns = stilb_prof_clock_monotonic();
		uint64_t ticks = prof_ticks() - before;
		if (ticks < *width) {
			*width = ticks;
			best = (prof_anchor){before + ticks / 2, ns};
		}
		if (ticks <= tight)
			break;
	}
	return best;
}

static int prof_compare_u64(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* The resolution of the clock: the median difference, in ticks, of two successive reads that differ. */
static uint64_t prof_resolution_measure(void)
{
	uint64_t step[63];
	for (int i = 0; i < 63; i++) {
		uint64_t first = prof_ticks();
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
	prof_clock.start = prof_anchor_take(16, 0, &prof_clock.width);
	if (!prof_clock.tsc)
		prof_clock.start.ticks = prof_clock.start.ns; /* both are CLOCK_MONOTONIC */
}

void prof_clock_force_monotonic(void)
{
	assert(prof_clock.start.ns == 0 && "before the clock is first read");
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

prof_anchor prof_clock_anchor(void)
{
	uint64_t width;
	if (prof_clock_is_tsc())
		return prof_anchor_take(3, prof_clock.width * 3 / 2, &width);
	uint64_t now = stilb_prof_clock_monotonic();
	return (prof_anchor){now, now};
}

/* ---- timelines --------------------------------------------------------------------------------------------------- */

/* For asserts: lines ascend, and none reaches a later time than the next one begins with. Then the map from ticks to
 * nanoseconds is monotone. */
static bool timeline_is_sound(const prof_timeline *timeline)
{
	bool sound = timeline->count > 0;
	for (uint32_t i = 1; sound && i < timeline->count; i++) {
		uint64_t ticks = timeline->lines[i].ticks - timeline->lines[i - 1].ticks;
		unsigned __int128 ns = (unsigned __int128)ticks * timeline->lines[i - 1].scale >> PROF_SCALE_SHIFT;
		sound = timeline->lines[i - 1].ticks < timeline->lines[i].ticks &&
		        timeline->lines[i - 1].ns <= timeline->lines[i].ns &&
		        ns <= timeline->lines[i].ns - timeline->lines[i - 1].ns;
	}
	return sound;
}

/* Begins a new line at anchor, which is also the end of the line before. */
static void prof_timeline_add(prof_timeline *timeline, prof_anchor anchor)
{
	assert(timeline->count < sizeof timeline->lines / sizeof *timeline->lines && anchor.ns >= timeline->epoch_ns);
	uint32_t n = timeline->count++;
	timeline->lines[n].ticks = anchor.ticks;
	timeline->lines[n].ns = anchor.ns - timeline->epoch_ns;
	timeline->lines[n].scale = UINT64_C(1) << PROF_SCALE_SHIFT;
	if (n == 0)
		return;
	assert(anchor.ticks > timeline->lines[n - 1].ticks && "anchors ascend");
	uint64_t ticks = anchor.ticks - timeline->lines[n - 1].ticks;
	uint64_t ns = timeline->lines[n].ns - timeline->lines[n - 1].ns;
	timeline->lines[n - 1].scale = (uint64_t)(((unsigned __int128)ns << PROF_SCALE_SHIFT) / ticks);
	timeline->lines[n].scale = timeline->lines[n - 1].scale; /* extrapolates until the next anchor */
}

/* Makes the lines from the anchors and the present moment. All lines are at least PROF_LINE_NS long; only if there is
 * but one, it may be as short as PROF_CALIBRATION_NS, and if even that has not passed since its anchor, this sleeps. */
static void prof_timeline_anchors(prof_timeline *timeline, const prof_anchor *anchors, uint32_t count)
{
	prof_anchor last = prof_clock.start;
	for (uint32_t i = 0; i < count; i++) {
		if (anchors[i].ns < last.ns + PROF_LINE_NS || anchors[i].ticks <= last.ticks)
			continue;
		last = anchors[i];
		prof_timeline_add(timeline, last);
	}
	uint64_t age = stilb_prof_clock_monotonic() - last.ns, width;
	while (timeline->count == 1 && age < PROF_CALIBRATION_NS) { /* a signal may end the sleep */
		nanosleep(&(struct timespec){.tv_nsec = (long)(PROF_CALIBRATION_NS - age)}, NULL);
		age = stilb_prof_clock_monotonic() - last.ns;
	}
	if (timeline->count == 1 || age >= PROF_LINE_NS)
		prof_timeline_add(timeline, prof_anchor_take(16, 0, &width));
}

void prof_clock_timeline(prof_timeline *timeline, const prof_anchor *anchors, uint32_t count)
{
	assert((anchors || count == 0) && count <= PROF_FRAMES_MAX);
	timeline->count = timeline->cursor = 0;
	timeline->clock = prof_clock_is_tsc() ? "rdtsc" : "CLOCK_MONOTONIC";
	timeline->epoch_ns = prof_clock.start.ns;
	timeline->hz = 1e9;
	prof_timeline_add(timeline, prof_clock.start);
	if (prof_clock.tsc) {
		prof_timeline_anchors(timeline, anchors, count);
		uint32_t last = timeline->count - 1;
		timeline->hz = (double)(timeline->lines[last].ticks - timeline->lines[0].ticks) * 1e9 /
		               (double)(timeline->lines[last].ns - timeline->lines[0].ns);
	}
	timeline->resolution_ns = (double)prof_clock.resolution * 1e9 / timeline->hz;
	PROF_CHECK(timeline_is_sound(timeline));
}

uint64_t prof_timeline_ns(prof_timeline *timeline, uint64_t ticks)
{
	assert(timeline->cursor < timeline->count && "the timeline is made");
	uint32_t i = timeline->cursor;
	while (i > 0 && ticks < timeline->lines[i].ticks)
		i--;
	while (i + 1 < timeline->count && ticks >= timeline->lines[i + 1].ticks)
		i++;
	timeline->cursor = i;
	uint64_t age = ticks > timeline->lines[i].ticks ? ticks - timeline->lines[i].ticks : 0;
	return timeline->lines[i].ns + (uint64_t)((unsigned __int128)age * timeline->lines[i].scale >> PROF_SCALE_SHIFT);
}

/* ---- the cost of a zone, and by how much it reads too short ------------------------------------------------------ */

#define PROF_COST_ROUNDS 200
#define PROF_COST_ZONES 20

static pthread_once_t prof_costs_once = PTHREAD_ONCE_INIT;
static struct {
	double bias_ns;
	double zone_ns;
} prof_costs;

/* The mean of the middle half of the values: finer than the steps of the clock, and without disturbed measurements. */
static double prof_middle(uint64_t *values, uint32_t count)
{
	assert(count > 0);
	uint64_t sum = 0;
	qsort(values, count, sizeof *values, prof_compare_u64);
	uint32_t quarter = count / 4;
	for (uint32_t i = quarter; i < count - quarter; i++)
		sum += values[i];
	return (double)sum / (double)(count - 2 * quarter);
}

#if defined(__x86_64__)
/* A chain of multiplications, each of which needs the result of the one before. */
static inline uint64_t prof_chain(uint64_t value, int steps)
{
	for (int i = 0; i < steps; i++) {
		value *= UINT64_C(0x9e3779b97f4a7c15);
		__asm__ volatile("" : "+r"(value));
	}
	return value;
}

static inline uint64_t prof_ticks_fenced(void)
{
	__asm__ volatile("lfence" ::: "memory");
	uint64_t now = __builtin_ia32_rdtsc();
	__asm__ volatile("lfence" ::: "memory");
	return now;
}

/* Measured length of a chain of `steps` multiplications, in ticks. fenced: the reads of the clock wait until all
 * earlier instructions have finished, which gives the true length. */
static double prof_chain_ticks(int steps, bool fenced)
{
	uint64_t ticks[PROF_COST_ROUNDS], value = 1;
	for (int i = 0; i < PROF_COST_ROUNDS; i++) {
		uint64_t begin = fenced ? prof_ticks_fenced() : __builtin_ia32_rdtsc();
		value = prof_chain(value, steps);
		ticks[i] = (fenced ? prof_ticks_fenced() : __builtin_ia32_rdtsc()) - begin;
		prof_ticks_fenced(); /* lets this round finish before the next one begins */
	}
	return prof_middle(ticks, PROF_COST_ROUNDS);
}

/* The difference between the true length of a chain, read with fences, and the length that two plain reads give. */
static double prof_bias_ticks(void)
{
	int steps = 64; /* few enough for all of them to be in flight at once */
	if (!prof_clock.tsc)
		return 0; /* reading the kernel's clock waits for earlier instructions */
	return prof_chain_ticks(steps, true) - prof_chain_ticks(0, true) - prof_chain_ticks(steps, false);
}
#else
static double prof_bias_ticks(void)
{
	return 0;
}
#endif

/* This file is linked into every program that records or reads traces. So there is at least one site, and the linker
 * defines the bounds of the array. */
static const stilb_prof_site prof_site_cost STILB_PROF_SECTION_ =
	STILB_PROF_SITE_INIT_("what a zone costs", "", 0, STILB_PROF_KIND_ZONE);

/* Records zones into a ring that no snapshot sees, and returns the ticks per zone. */
static double prof_zone_ticks(void)
{
	static stilb_prof_event events[64];
	static stilb_prof_ring ring = {.events = events, .mask = 63};
	uint64_t ticks[PROF_COST_ROUNDS];
	ring.tsc = prof_clock.tsc;
	for (int i = 0; i < PROF_COST_ROUNDS; i++) {
		uint64_t begin = prof_ticks();
		for (int k = 0; k < PROF_COST_ZONES; k++) {
			uint32_t scope = stilb_prof_push(&ring, &prof_site_cost);
			stilb_prof_pop(&ring, scope - 1, stilb_prof_clock(&ring));
		}
		ticks[i] = prof_ticks() - begin;
	}
	assert(ring.depth == 0 && ring.head == (uint64_t)PROF_COST_ROUNDS * PROF_COST_ZONES);
	return prof_middle(ticks, PROF_COST_ROUNDS) / PROF_COST_ZONES;
}

static void prof_costs_measure(void)
{
	/* Measured before the timeline is made: prof_clock_timeline sleeps until 10 ms have passed since the clock was
	 * first read, so the time that these two take need not be slept. */
	double zone = prof_zone_ticks(), bias = prof_bias_ticks();
	prof_timeline *timeline = malloc(sizeof *timeline);
	if (!timeline)
		return;
	prof_clock_timeline(timeline, NULL, 0);
	prof_costs.zone_ns = zone * 1e9 / timeline->hz;
	prof_costs.bias_ns = bias > 0 ? bias * 1e9 / timeline->hz : 0;
	free(timeline);
}

double prof_clock_bias_ns(void)
{
	pthread_once(&prof_costs_once, prof_costs_measure);
	return prof_costs.bias_ns;
}

double prof_clock_zone_cost_ns(void)
{
	pthread_once(&prof_costs_once, prof_costs_measure);
	return prof_costs.zone_ns;
}
