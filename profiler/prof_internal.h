/* Declarations that the profiler's files and its tests share. */
#ifndef STILB_PROF_INTERNAL_H
#define STILB_PROF_INTERNAL_H

#include "profiler/prof.h"
#include "profiler/prof_contract.h"
#include "profiler/prof_snapshot.h"

#include <stdbool.h>

/* The library defines all functions, also when it is compiled with STILB_PROFILE_OFF. prof.h then defines macros of
 * these names, which are removed here. */
#undef stilb_prof_zone_begin
#undef stilb_prof_zone_end
#undef stilb_prof_flow_begin
#undef stilb_prof_flow_end
#undef stilb_prof_lane_zone

#define PROF_NAME_MAX 64     /* bytes of a lane's name, with the 0 at its end */
#define PROF_ENDED_MAX 64    /* rings of ended threads and lanes that are kept */
#define PROF_FRAMES_MAX 1024 /* frame marks that are remembered */
#define PROF_NONE UINT32_MAX

/* ---- prof_clock.c ------------------------------------------------------------------------------------------------ */

/* One moment on two clocks: in ticks of the profiler's clock, and in nanoseconds of CLOCK_MONOTONIC. */
typedef struct prof_anchor {
	uint64_t ticks;
	uint64_t ns;
} prof_anchor;

/* Maps ticks to nanoseconds since the profiler's first call, by straight lines between anchors, so that corrections of
 * CLOCK_MONOTONIC (NTP) do not accumulate as an error. The map is monotone: it keeps order and nesting. */
typedef struct prof_timeline {
	uint64_t epoch_ns; /* time 0 on CLOCK_MONOTONIC. Times of devices, which are on that clock, only subtract it */
	const char *clock;
	double hz;            /* ticks a second */
	double resolution_ns; /* the shortest difference seen between two reads */
	uint32_t count;       /* valid entries of lines */
	uint32_t cursor;      /* the line that was used last: the next time is probably on it */
	struct {
		uint64_t ticks, ns; /* the beginning of the line */
		uint64_t scale;     /* ns per tick, times 2^56 */
	} lines[PROF_FRAMES_MAX + 2];
} prof_timeline;

bool prof_clock_is_tsc(void);
uint64_t prof_clock_now(void);

/* Reads both clocks at about the same moment: the best of up to three tries (see prof_anchor_take). [any-thread] */
prof_anchor prof_clock_anchor(void);

/* Makes the timeline from known anchors, ascending. An anchor less than 50 ms after the one before is skipped: the
 * longer a line, the more exact its slope. A call within 10 ms of the profiler's first call sleeps until then.
 * [any-thread] */
void prof_clock_timeline(prof_timeline *timeline, const prof_anchor *anchors, uint32_t count);
/* Converts ticks to nanoseconds since the profiler's first call. Fastest if the ticks of successive calls ascend or
 * descend. */
uint64_t prof_timeline_ns(prof_timeline *timeline, uint64_t ticks);

/* By how much a zone reads too short, and the cost of recording one, in nanoseconds. Measured at the first call, which
 * takes less than a millisecond. [any-thread] */
double prof_clock_bias_ns(void);
double prof_clock_zone_cost_ns(void);

/* For tests, before the clock is first read (asserted): pretends that the TSC cannot be used. */
void prof_clock_force_monotonic(void);

/* ---- shared/prof_image.c: other images that record in this profiler, when it is libstilb.so's -------------------- */

/* What events hold for a site, and the site for that. Where all sites are this image's it is the distance from the
 * start of their array. */
#ifdef PROF_IMAGES
uint64_t stilb_prof_site_offset_of(const stilb_prof_site *site);
const uint32_t *stilb_prof_image_join(stilb_prof_image *image);
const stilb_prof_site *prof_site_at(int64_t offset);
#else
static inline uint64_t stilb_prof_site_offset_of(const stilb_prof_site *site)
{
	return stilb_prof_site_offset(site);
}
static inline const stilb_prof_site *prof_site_at(int64_t offset)
{
	return (const stilb_prof_site *)((uintptr_t)__start_stilb_prof_section + (uintptr_t)offset);
}
#endif

/* Walks the arrays of sites of all other images: NULL gives the first, each site the next, the last one NULL. True: the
 * site is in one of them. */
#ifdef PROF_IMAGES
const stilb_prof_site *prof_image_site_next(const stilb_prof_site *previous);
bool prof_image_has_site(const stilb_prof_site *site);
#else
static inline const stilb_prof_site *prof_image_site_next(const stilb_prof_site *previous)
{
	(void)previous;
	return NULL;
}
static inline bool prof_image_has_site(const stilb_prof_site *site)
{
	(void)site;
	return false;
}
#endif

/* Stands for what has no site of its own. */
extern const stilb_prof_site prof_site_more;

/* ---- prof_ring.c: events ----------------------------------------------------------------------------------------- */

/* An unpacked event. Members that the kind of its site does not have are 0. */
typedef struct prof_record {
	const stilb_prof_site *site;
	uint64_t begin, end; /* ticks of the lane's clock; equal unless the event is a zone */
	uint64_t flow;
	double value;   /* of a counter */
	uint32_t depth; /* of a zone; for a flow: number of zones that were open */
} prof_record;

static inline bool prof_kind_is_zone(uint32_t kind)
{
	return kind == STILB_PROF_KIND_ZONE || kind == STILB_PROF_KIND_PRECISE;
}

/* Unpacks an event. The event holds only the low 52 bits of its time, in ticks of its lane's clock; the time is taken
 * to be the latest one up to `limit`, in the same ticks, that has these bits, which is right for events up to ten days
 * older than limit (at 5 GHz). */
static inline prof_record prof_event_unpack(const stilb_prof_event *event, uint64_t limit)
{
	uint64_t offset = (event->end & 0x3ffff) << 12 | (event->begin & 0xfc0);
	int64_t distance = (int64_t)(offset << 34) >> 34; /* 30 bits, signed */
	uint64_t time = limit - ((limit - (event->begin >> 12)) & ((UINT64_C(1) << 52) - 1));
	uint64_t low = event->begin & 0x3f, payload = event->end >> 18;
	prof_record record = {
		.site = prof_site_at(distance),
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
	uint64_t begun_ns;              /* CLOCK_MONOTONIC: when the last owner of the ring took it */
	uint64_t ended_ns;              /* when that owner gave it up; 0: it still has it */
	uint64_t now;                   /* when its open zones were read: in the snapshot they end there */
	uint64_t limit;                 /* the argument of prof_event_unpack */
	const stilb_prof_event *events; /* in the order of their ends: children before parents */
	size_t event_count;
	uint32_t open_count; /* valid entries of open; they are the parents of zones whose parent is not in events */
	stilb_prof_open_zone open[STILB_PROF_DEPTH_MAX]; /* open[d] is at depth d */
	const struct prof_switch_event *switches;        /* ascending by time; the first may lie before the window */
	uint32_t switch_count;
	const char *no_switches;    /* the reason why switches are not known; NULL if they are */
	size_t first, first_switch; /* indices of the lane's first event and switch in the arrays of prof_copy */
} prof_lane_copy;

/* A raw copy of what the rings hold. {0} is empty; prof_copy_take reuses its memory. */
typedef struct prof_copy {
	prof_lane_copy *lanes; /* in their order in a snapshot */
	uint32_t lane_count;
	size_t lane_capacity;
	stilb_prof_event *events;
	struct prof_switch_event *switches;
	size_t event_count, event_capacity, switch_count, switch_capacity;
	uint64_t events_recorded, events_held, too_deep, without_ring; /* as in stilb_prof_snapshot */
	prof_anchor frames[PROF_FRAMES_MAX];                           /* begins of frames; the last one has not ended */
	uint64_t first_frame;                                          /* number of frames[0], counted from 0 */
	uint32_t frame_count;                                          /* valid entries of frames */
	uint32_t window_first, window_count;                           /* whole frames in the window: indices into frames */
	prof_anchor begin, end; /* the window: {0} and {UINT64_MAX} where it is open */
} prof_copy;

/* Copies the events that end at or after the begin of the window and begin before its end, the open zones, and all
 * frames, while threads go on recording. Returns 0, or -ENOMEM, and then the copy is empty. [any-thread] */
int prof_copy_take(prof_copy *copy, const stilb_prof_window *window);
void prof_copy_free(prof_copy *copy);

/* The id of a flow, 46 bits: frame % 2^16 << 30 | lane % 2^10 << 20 | sequence 1 .. 2^20 - 1. Never 0. */
static inline uint64_t prof_flow_id(uint64_t frame, uint32_t lane, uint32_t sequence)
{
	return (frame & 0xffff) << 30 | (uint64_t)(lane & 0x3ff) << 20 | (sequence % 0xfffff + 1);
}

/* The number of the frame in which a flow was begun, of which the id holds 16 bits: the latest number with these bits
 * that is not above newest, the number of the last frame begun. */
static inline uint64_t prof_flow_frame(uint64_t id, uint64_t newest)
{
	return newest - ((newest - (id >> 30)) & 0xffff);
}

/* Copies the open zones of a ring, outermost first, to zones[0..STILB_PROF_DEPTH_MAX). Returns how many.
 * [any-thread] */
uint32_t prof_copy_open(const stilb_prof_ring *ring, stilb_prof_open_zone *zones);

/* Returns the number of rings, and in *ended how many of them belong to ended threads and lanes. [any-thread] */
uint32_t prof_ring_count(uint32_t *ended);

/* ---- prof_switch.c ----------------------------------------------------------------------------------------------- */

#define PROF_SWITCHES_MAX 4096

/* The record that the kernel keeps of one thread's context switches. {0} is valid: nothing is recorded. */
typedef struct prof_switches {
	const void *page;    /* the kernel's ring; NULL: nothing is recorded */
	size_t size;         /* bytes of the mapping */
	int process;         /* the process that mapped it: its children by fork do not have the mapping */
	const char *refused; /* the reason why page is NULL; NULL if it is not */
	uint32_t schedstat;  /* handle of prof_schedstat_open, used instead; 0: none */
} prof_switches;

typedef struct prof_switch_event {
	uint64_t ns;    /* CLOCK_MONOTONIC */
	bool in;        /* true: the thread came back to a CPU; false: it left */
	bool preempted; /* it left although it could have gone on running */
} prof_switch_event;

/* Starts recording the calling thread's switches if stilb_prof_switches_set asked for it. Keeps no file descriptor.
 * Call it without prof.lock: it opens files. */
prof_switches prof_switches_open(const char *name);
void prof_switches_close(prof_switches *switches);

/* Copies the switches that the kernel's ring holds, ascending, from the last one at or before since_ns on. Returns how
 * many, at most PROF_SWITCHES_MAX. The thread may be running, waiting or ended. */
uint32_t prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);

/* ---- prof_schedstat.c -------------------------------------------------------------------------------------------- */

/* From now on the time that the calling thread runs and waits is recorded once a frame, by counters with its name.
 * Returns a handle for prof_schedstat_close, which also accepts 0; 0: not possible. [any-thread] */
uint32_t prof_schedstat_open(const char *name);
void prof_schedstat_close(uint32_t handle);

extern uint32_t prof_schedstat_count; /* open handles */
void prof_schedstat_sample(void);

/* Called once a frame, by the thread that marks frames. */
static inline void prof_schedstat_mark(void)
{
	if (__builtin_expect(__atomic_load_n(&prof_schedstat_count, __ATOMIC_RELAXED) > 0, 0)) /* no data depends on it */
		prof_schedstat_sample();
}

/* ---- prof_capture.c calls, prof_ring.c provides ------------------------------------------------------------------ */

/* stilb_prof_frame_mark calls the hook after it has stored the mark, with the number of the frame that has just ended
 * and its length on CLOCK_MONOTONIC; not for the first mark. NULL: no hook. One at a time (asserted). */
typedef void prof_frame_hook(uint64_t number, uint64_t duration_ns);
void prof_frame_hook_set(prof_frame_hook *hook);

/* The number of frames begun so far. Safe in signal handlers. [any-thread] */
uint64_t prof_frames_begun(void);

/* Copies the last frame marks, at most max, in nanoseconds of CLOCK_MONOTONIC, oldest first. Returns how many; *first
 * is the number of the frame that begins at begin_ns[0]. [any-thread] */
uint32_t prof_frames_last(uint64_t *begin_ns, uint32_t max, uint64_t *first);

/* ---- write/prof_trace.c ------------------------------------------------------------------------------------------ */

/* stilb_prof_trace_save that never replaces an existing file: -EEXIST. [any-thread] */
int prof_trace_save_fresh(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);

/* ---- prof_background.c ------------------------------------------------------------------------------------------- */

extern __thread bool prof_background; /* true after prof_background_begin */

/* Gives the calling thread the lowest priority: it gets the CPU time that other threads leave. */
void prof_background_begin(void);
void prof_background_yield(void);

/* Call it in each iteration of loops over all events or zones; round is the loop's counter. Even a thread of the lowest
 * priority sometimes takes the CPU from a thread that never sleeps, and keeps it for some milliseconds until the next
 * timer tick. Therefore a thread that has called prof_background_begin yields every 50 us. Others do nothing here. */
static inline void prof_give_way(size_t round)
{
	if (__builtin_expect((round & 255) == 0, 0) && prof_background)
		prof_background_yield();
}

/* ---- read/prof_snapshot_sound.c ---------------------------------------------------------------------------------- */

/* True if all promises of prof_snapshot.h hold: order, nesting, indices. Linear in the size of the snapshot. */
bool prof_snapshot_is_sound(const stilb_prof_snapshot *snapshot);

/* ---- memory of snapshots ----------------------------------------------------------------------------------------- */

/* stilb_prof_snapshot.memory points to a structure that begins with this, so that stilb_prof_snapshot_finish can free
 * both snapshots that were taken and those that were read. */
typedef struct prof_memory {
	void (*destroy)(void *memory);
} prof_memory;

#endif
