/* What the profiler's own files and its tests share. */
#ifndef STILB_PROF_INTERNAL_H
#define STILB_PROF_INTERNAL_H

#include "profiler/prof.h"
#include "profiler/prof_contract.h"
#include "profiler/prof_snapshot.h"

#include <stdbool.h>

/* The library is whole even where the macros of its users are off. */
#undef stilb_prof_zone_begin
#undef stilb_prof_zone_end
#undef stilb_prof_flow_begin
#undef stilb_prof_flow_end
#undef stilb_prof_lane_zone

#define PROF_NAME_MAX 64
#define PROF_ENDED_MAX 64
#define PROF_FRAMES_MAX 1024
#define PROF_NONE UINT32_MAX

/* ---- prof_clock.c ------------------------------------------------------------------------------------------------ */

/* The same moment on both clocks: ticks of the profiler's, nanoseconds of CLOCK_MONOTONIC. */
typedef struct prof_anchor {
	uint64_t ticks;
	uint64_t ns;
} prof_anchor;

/* Maps ticks to nanoseconds since the profiler's first call: straight lines between anchors, so that what
 * CLOCK_MONOTONIC is corrected by does not add up. Monotone, so order and nesting stay. */
typedef struct prof_timeline {
	uint64_t epoch_ns; /* 0 ns, on CLOCK_MONOTONIC; times that are on that clock anyway need no more than this */
	const char *clock;
	double hz;            /* ticks a second */
	double resolution_ns; /* the shortest difference seen between two reads */
	uint32_t count;
	uint32_t cursor; /* where the last time was found */
	struct {
		uint64_t ticks, ns; /* the line's beginning */
		uint64_t scale;     /* ns per tick, times 2^56 */
	} lines[PROF_FRAMES_MAX + 2];
} prof_timeline;

bool prof_clock_is_tsc(void);
uint64_t prof_clock_now(void);

/* Now, as exactly as three tries give it. */
prof_anchor prof_clock_anchor(void);

/* anchors: any that are known, ascending; those less than 50 ms after another are left out, for a line is as exact as
 * it is long. A call within 10 ms of the profiler's first waits that time out. */
void prof_clock_timeline(prof_timeline *timeline, const prof_anchor *anchors, uint32_t count);
uint64_t prof_timeline_ns(prof_timeline *timeline, uint64_t ticks);

/* How much shorter than it was a zone reads, and what recording one costs: measured at the first call, which takes less
 * than a millisecond. */
double prof_clock_bias_ns(void);
double prof_clock_zone_cost_ns(void);

/* For tests, before any other call: do as if the TSC could not be used. */
void prof_clock_force_monotonic(void);

/* ---- prof_ring.c: events ----------------------------------------------------------------------------------------- */

/* An event taken apart; what its site's kind does not have is 0. */
typedef struct prof_record {
	const stilb_prof_site *site;
	uint64_t begin, end; /* ticks of the lane's clock; the same for all but zones */
	uint64_t flow;
	double value;   /* of a counter */
	uint32_t depth; /* of a zone; of a flow: the zones that were open then */
} prof_record;

static inline bool prof_kind_is_zone(uint32_t kind)
{
	return kind == STILB_PROF_KIND_ZONE || kind == STILB_PROF_KIND_PRECISE;
}

/* The event holds the low 52 bits of its time: that is the latest such time up to limit, which is right for ten days (5
 * GHz). */
static inline prof_record prof_event_unpack(const stilb_prof_event *event, uint64_t limit)
{
	uint64_t offset = (event->end & 0x3ffff) << 12 | (event->begin & 0xfc0);
	int64_t distance = (int64_t)(offset << 34) >> 34; /* 30 bits, signed */
	uint64_t time = limit - ((limit - (event->begin >> 12)) & ((UINT64_C(1) << 52) - 1));
	uint64_t low = event->begin & 0x3f, payload = event->end >> 18;
	prof_record record = {
		.site = (const stilb_prof_site *)((uintptr_t)__start_stilb_prof_section + (uintptr_t)distance),
		.begin = time,
		.end = time,
	};
	assert(record.site->kind <= STILB_PROF_KIND_FLOW_END && "an event refers to a site");
	if (prof_kind_is_zone(record.site->kind)) {
		record.end = time + payload;
		record.depth = (uint32_t)low;
	} else if (record.site->kind == STILB_PROF_KIND_COUNTER) {
		uint64_t bits = payload << 18 | low << 12;
		__builtin_memcpy(&record.value, &bits, sizeof bits);
	} else {
		record.flow = payload;
		record.depth = (uint32_t)low;
	}
	return record;
}

/* ---- prof_ring.c: copies ----------------------------------------------------------------------------------------- */

typedef struct prof_lane_copy {
	char name[PROF_NAME_MAX];
	bool device;    /* its times are CLOCK_MONOTONIC nanoseconds, not ticks */
	uint32_t index; /* the lane's number in flows' ids, modulo 1,024 */
	uint32_t tid;
	uint64_t begun_ns;              /* CLOCK_MONOTONIC: when the thread that has the ring, or had it last, took it */
	uint64_t ended_ns;              /* when it left; 0: it is there */
	uint64_t now;                   /* when its open zones were looked at: their end */
	uint64_t limit;                 /* for prof_event_unpack */
	const stilb_prof_event *events; /* in the order of their ends: children before parents */
	size_t event_count;
	uint32_t open_count; /* all began before now and are parents of the zones in events that have none there */
	stilb_prof_open_zone open[STILB_PROF_DEPTH_MAX]; /* open[d] is at depth d */
	const struct prof_switch_event *switches;        /* ascending; the first may lie before the window */
	uint32_t switch_count;
	const char *no_switches;    /* why there are none; NULL when they are known */
	size_t first, first_switch; /* where they begin in the copy's */
} prof_lane_copy;

/* What is held, raw. {0} is empty; prof_copy_take uses its memory again. */
typedef struct prof_copy {
	prof_lane_copy *lanes; /* in their order in a snapshot */
	uint32_t lane_count;
	size_t lane_capacity;
	stilb_prof_event *events;
	struct prof_switch_event *switches;
	size_t event_count, event_capacity, switch_count, switch_capacity;
	uint64_t events_recorded, events_held, too_deep, without_ring; /* of all lanes, whatever the window */
	prof_anchor frames[PROF_FRAMES_MAX];                           /* where each frame began; the last is not whole */
	uint64_t first_frame;                                          /* number of frames[0], counted from 0 */
	uint32_t frame_count;                                          /* frame begins held */
	uint32_t window_first, window_count;                           /* whole frames in the window: indices into frames */
	prof_anchor begin, end; /* the window: {0} and {UINT64_MAX} where it is open */
} prof_copy;

/* Copies the events that end at or after the window's begin and begin before its end, the open zones, and all frames,
 * while they are written to. 0 or -ENOMEM, and then the copy is empty. [any-thread] */
int prof_copy_take(prof_copy *copy, const stilb_prof_window *window);
void prof_copy_free(prof_copy *copy);

/* The parts of a flow's number, 46 bits: frame % 2^16 << 30 | lane % 2^10 << 20 | 1 .. 2^20 - 1. */
static inline uint64_t prof_flow_id(uint64_t frame, uint32_t lane, uint32_t sequence)
{
	return (frame & 0xffff) << 30 | (uint64_t)(lane & 0x3ff) << 20 | (sequence % 0xfffff + 1);
}

/* The frame in which a flow was begun, when newest was the last to begin: the latest of that number. */
static inline uint64_t prof_flow_frame(uint64_t id, uint64_t newest)
{
	return newest - ((newest - (id >> 30)) & 0xffff);
}

/* The open zones of a ring, outermost first; returns their number. */
uint32_t prof_copy_open(const stilb_prof_ring *ring, stilb_prof_open_zone *zones);

/* Rings there are now, and how many of them belong to ended threads and lanes. */
uint32_t prof_ring_count(uint32_t *ended);

/* ---- prof_switch.c ----------------------------------------------------------------------------------------------- */

#define PROF_SWITCHES_MAX 4096

/* What the kernel notes of one thread: when it left the CPU and when it came back. */
typedef struct prof_switches {
	const void *page;    /* NULL: nothing is noted; {0} is a valid value */
	size_t size;         /* of the mapping */
	int process;         /* whose mapping it is: a child of fork has none */
	const char *refused; /* why not; NULL when page is not */
	uint32_t schedstat;  /* what is known instead: prof_schedstat_open */
} prof_switches;

typedef struct prof_switch_event {
	uint64_t ns;    /* CLOCK_MONOTONIC */
	bool in;        /* came back; else it left */
	bool preempted; /* left though it could have run on */
} prof_switch_event;

/* The calling thread's, if stilb_prof_switches_set said so. It takes no descriptor; call it without the lock. */
prof_switches prof_switches_open(const char *name);
void prof_switches_close(prof_switches *switches);

/* What is held, ascending, from the last event at or before since_ns on; returns how many, at most PROF_SWITCHES_MAX.
 * The thread may be running, waiting or ended. */
uint32_t prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);

/* ---- prof_schedstat.c -------------------------------------------------------------------------------------------- */

/* From here on the time that the calling thread runs and waits is recorded frame by frame, as counters that have its
 * name. A handle, or 0: not possible. close takes both. [any-thread] */
uint32_t prof_schedstat_open(const char *name);
void prof_schedstat_close(uint32_t handle);

extern uint32_t prof_schedstat_count; /* threads */
void prof_schedstat_sample(void);

/* Once a frame, by the thread that marks them. */
static inline void prof_schedstat_mark(void)
{
	if (__builtin_expect(__atomic_load_n(&prof_schedstat_count, __ATOMIC_RELAXED) > 0, 0)) /* no data depends on it */
		prof_schedstat_sample();
}

/* ---- prof_capture.c calls, prof_ring.c provides ------------------------------------------------------------------ */

/* Called by stilb_prof_frame_mark after the mark is stored, with the number of the frame that has just ended and how
 * long it took on CLOCK_MONOTONIC; not for the first mark. NULL: nobody. */
typedef void prof_frame_hook(uint64_t number, uint64_t duration_ns);
void prof_frame_hook_set(prof_frame_hook *hook);

/* Frames begun so far. Safe in signal handlers. [any-thread] */
uint64_t prof_frames_begun(void);

/* The last frame marks in CLOCK_MONOTONIC ns, oldest first, at most max; *first is the number of the frame that
 * begin_ns[0] begins. [any-thread] */
uint32_t prof_frames_last(uint64_t *begin_ns, uint32_t max, uint64_t *first);

/* ---- write/prof_trace.c ------------------------------------------------------------------------------------------ */

/* As stilb_prof_trace_save, but a file that is there is never replaced: -EEXIST. */
int prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);

/* ---- prof_background.c ------------------------------------------------------------------------------------------- */

extern __thread bool prof_background;

/* Makes the calling thread one that gets what CPU time the others leave. */
void prof_background_begin(void);
void prof_background_yield(void);

/* To be called in each round of loops over all events or zones. A low priority alone does not keep a thread from taking
 * the CPU from one that never sleeps: rarely, but then for some milliseconds, until the next tick. So such a thread
 * offers it back every 50 us. Other threads do nothing here. */
static inline void prof_give_way(size_t round)
{
	if (__builtin_expect((round & 255) == 0, 0) && prof_background)
		prof_background_yield();
}

/* ---- read/prof_snapshot_sound.c ---------------------------------------------------------------------------------- */

/* All that prof_snapshot.h promises of a snapshot holds: order, nesting, indices. Linear in its size. */
bool prof_snapshot_is_sound(const stilb_prof_snapshot *snapshot);

/* ---- memory of snapshots ----------------------------------------------------------------------------------------- */

/* What stilb_prof_snapshot.memory points to begins with this: a snapshot is taken or read, and finished by one call. */
typedef struct prof_memory {
	void (*destroy)(void *memory);
} prof_memory;

#endif
