/* record_child: shared by the programs of the suite `record`: the case, sample sets, the picture's checksum.
 * [main-thread] */
#ifndef RECORD_CHILD_H
#define RECORD_CHILD_H

#include "bench/harness/bench_child.h"
#include "bench/record/record_cases.h"

#include "base/base.h"

#include <string.h>

/* The case of this name; ends the program if there is none. */
static inline const record_case *record_case_find(const char *name)
{
	static const record_case cases[] = {
#define CASE(NAME, TITLE, KIND, ...) {.name = NAME, .kind = RECORD_##KIND, __VA_ARGS__},
		RECORD_CASES(CASE)
#undef CASE
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(cases[i].name, name) == 0)
			return &cases[i];
	bench_child_fail("no case %s", name);
}

static inline uint64_t record_deadline(double seconds)
{
	return bench_child_now_ns() + (uint64_t)(seconds * 1e9);
}

/* Allocates count * size bytes, not initialised; ends the program if there is no memory. */
static inline void *record_alloc(size_t count, size_t size)
{
	void *memory = stilb_memory_alloc(count, size);
	if (!memory)
		bench_child_fail("out of memory");
	return memory;
}

/* ---- times ------------------------------------------------------------------------------------------------------- */

#define RECORD_MAX_SAMPLES 65536u

/* Measured times of one kind, ns; those beyond the capacity are dropped. */
typedef struct record_samples {
	uint32_t count;
	double at[RECORD_MAX_SAMPLES];
} record_samples;

static inline void record_samples_add(record_samples *set, uint64_t ns)
{
	if (set->count < RECORD_MAX_SAMPLES)
		set->at[set->count++] = (double)ns;
}

static inline int record_samples_order(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* The median; sorts the samples. */
static inline double record_samples_median(record_samples *set)
{
	if (set->count == 0)
		bench_child_fail("there was no time for a single sample");
	qsort(set->at, set->count, sizeof *set->at, record_samples_order);
	return 0.5 * (set->at[set->count / 2] + set->at[(set->count - 1) / 2]);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* The argument of this suite's programs: the picture's checksum (decimal), or RECORD_NO_PICTURE if there is no
 * lavapipe. The checksum may be followed by RECORD_SHORT (--quick): only `picture` of the cases picture* is run. */
#define RECORD_NO_PICTURE "none"
#define RECORD_SHORT " short"

/* True if the case draws pictures and the argument says to skip it. */
static inline bool record_picture_skips(const record_case *on, const char *argument)
{
	return on->kind == RECORD_PICTURE && argument &&
	       (strcmp(argument, RECORD_NO_PICTURE) == 0 ||
	        (on->materials != RECORD_INDEX && strstr(argument, RECORD_SHORT)));
}

/* Frames not measured: with two frames in flight, the fourth is the first one that waits for a whole frame. */
#define RECORD_PICTURE_WARM_UP 3u

/* Time and CPU time of a sequence of frames. */
typedef struct record_picture_times {
	uint32_t frames;    /* frames so far, those that are not measured included */
	uint64_t last;      /* time at which the last frame was submitted, ns */
	uint64_t first_cpu; /* CPU time of all threads when the first measured frame began, ns */
	uint64_t last_cpu;  /* the same at the end of the last frame */
} record_picture_times;

static inline uint64_t record_cpu_ns(void)
{
	struct timespec used;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
	return (uint64_t)used.tv_sec * 1000000000u + (uint64_t)used.tv_nsec;
}

/* Call it after each frame. The time of a frame runs from the end of the previous frame to its own end. False: at least
 * one frame is measured, and the time `until` (ns) has passed. */
static inline bool record_picture_frame(record_picture_times *times, record_samples *samples, uint64_t until)
{
	uint64_t now = bench_child_now_ns();
	times->last_cpu = record_cpu_ns();
	if (++times->frames == RECORD_PICTURE_WARM_UP)
		times->first_cpu = times->last_cpu;
	if (times->frames > RECORD_PICTURE_WARM_UP)
		record_samples_add(samples, now - times->last);
	times->last = now;
	return samples->count == 0 || now < until;
}

static inline void record_picture_print(const record_picture_times *times, record_samples *samples)
{
	bench_child_metric("frame", record_samples_median(samples) * 1e-6);
	bench_child_metric("least", samples->at[0] * 1e-6);
	bench_child_metric("cpu", (double)(times->last_cpu - times->first_cpu) / samples->count * 1e-6);
}

/* FNV-1a of the pixels, three bytes each, folded to 48 bits, which fit into two printed numbers exactly. */
static inline uint64_t record_picture_sum(const unsigned char *pixels, size_t count)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, pixels, 3 * count);
	return (hash ^ hash >> 48) & ((UINT64_C(1) << 48) - 1);
}

static inline void record_picture_check(uint64_t sum, const char *expected)
{
	if (expected && strtoull(expected, NULL, 10) != sum)
		bench_child_fail("wrong picture: its checksum is %llu, that of the bare program's %s", (unsigned long long)sum,
		                 expected);
}

#endif
