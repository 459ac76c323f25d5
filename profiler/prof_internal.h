/* What the profiler's own files and its tests share. */
#ifndef STILB_PROF_INTERNAL_H
#define STILB_PROF_INTERNAL_H

#undef STILB_PROFILE_OFF /* the library is whole even where its users' macros are off */
#include "profiler/prof.h"

#include <stdbool.h>

/* ---- prof_clock.c ------------------------------------------------------------------------------------------------ */

/* Maps ticks of the clock to nanoseconds since the first call of the profiler; monotone, so order and nesting stay. */
typedef struct prof_timeline {
	uint64_t base;  /* ticks at 0 ns */
	uint64_t scale; /* ns per tick, times 2^shift */
	uint32_t shift;
	bool tsc;
	double hz;            /* ticks a second */
	double resolution_ns; /* the shortest difference seen between two reads */
} prof_timeline;

bool prof_clock_is_tsc(void);
uint64_t prof_clock_now(void);
prof_timeline prof_clock_timeline(void);
uint64_t prof_timeline_ns(const prof_timeline *timeline, uint64_t ticks);

/* For tests, before any other call: do as if the TSC could not be used. */
void prof_clock_force_monotonic(void);

/* ---- prof_ring.c --------------------------------------------------------------------------------------------------- */

#define PROF_NAME_MAX 64
#define PROF_ENDED_MAX 64
#define PROF_FRAMES_MAX 1024
#define PROF_NONE UINT32_MAX

/* A zone of a copy. Zones of a thread stand in the order in which they ended, those still open last, deepest first: so
 * parents come after their children. The second half belongs to prof_trace.c. */
typedef struct prof_zone {
	uint64_t begin; /* ticks */
	uint64_t end;   /* ticks; open zones: when they were looked at */
	const stilb_prof_site *site;
	uint32_t depth;
	bool open;

	uint32_t parent; /* index, or PROF_NONE */
	uint32_t size;   /* zones in its subtree, itself included */
	uint32_t level;  /* ancestors in this copy */
	uint64_t begin_ns, end_ns;
	uint64_t cursor_ns; /* where its next child may begin */
} prof_zone;

typedef struct prof_thread_copy {
	char name[PROF_NAME_MAX];
	prof_zone *zones;
	uint32_t count;
} prof_thread_copy;

typedef struct prof_copy {
	prof_thread_copy *threads;
	uint32_t thread_count;
	uint64_t events_recorded, events_held;
	uint64_t frame_begin[PROF_FRAMES_MAX]; /* ticks */
	uint64_t first_frame;                  /* number of frame_begin[0], counted from 0 */
	uint32_t frame_count;                  /* frame begins held */
} prof_copy;

/* Copies all rings and frames while they are written to. 0 or -ENOMEM; free it in both cases. */
int prof_copy_take(prof_copy *copy);
void prof_copy_free(prof_copy *copy);

/* The open zones of a ring alone, deepest first, all but their ends; returns their number, at most STILB_PROF_DEPTH_MAX. */
uint32_t prof_copy_open(const stilb_prof_ring *ring, prof_zone *zones);

/* Rings there are now, and how many of them belong to ended threads. */
uint32_t prof_ring_count(uint32_t *ended);

/* ---- prof_json.c --------------------------------------------------------------------------------------------------- */

/* Text on its way out, in pieces of at most sizeof bytes; after an error nothing more is written. */
typedef struct prof_json {
	int (*write)(void *user, const void *data, size_t size);
	void *user;
	int error; /* what write returned */
	uint32_t used;
	char bytes[32768];
} prof_json;

void prof_json_text(prof_json *json, const char *text);
void prof_json_string(prof_json *json,
                      const char *string); /* quoted and escaped; bytes that are not UTF-8 become U+FFFD */
void prof_json_u64(prof_json *json, uint64_t value);
void prof_json_us(prof_json *json, uint64_t ns); /* microseconds with three decimals */
int prof_json_flush(prof_json *json);

#endif
