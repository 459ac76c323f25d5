/*
 * prof_snapshot: what was recorded, as plain data: the one form that the timeline in a window, the tables and the files
 * are all made from, and that a trace file is read back into.
 *
 *   rings (prof.h) --take--> snapshot --write--> Chrome JSON, folded stacks, CSV      (prof_trace.h)
 *   trace file     --read--> snapshot --------->  tables, comparison                  (prof_stats.h)
 *
 * Life cycle.  stilb_prof_snapshot s = {0}; stilb_prof_snapshot_take, any number of times (memory is used again);
 *              stilb_prof_snapshot_finish.
 * Threads.     [any-thread], one thread at a time per snapshot. Threads that record are not held up; threads that begin
 *              or end wait for the copy.
 * Times.       Nanoseconds since the profiler's first call; epoch_ns says when that was on CLOCK_MONOTONIC.
 */
#ifndef STILB_PROF_SNAPSHOT_H
#define STILB_PROF_SNAPSHOT_H

#include "prof.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STILB_PROF_NONE UINT32_MAX

/* One name of zones, counters, instants or flows. Strings live as long as the snapshot. */
typedef struct stilb_prof_label {
	const char *name;
	const char *function, *file; /* "" when not known */
	uint32_t line;
	uint32_t color; /* 0xRRGGBB; 0: the viewer chooses */
} stilb_prof_label;

typedef struct stilb_prof_zone {
	uint64_t begin_ns, end_ns; /* end of an open zone: when the snapshot was taken */
	uint64_t self_ns;          /* without its children */
	uint64_t off_cpu_ns;       /* how much of it the thread did not run, as far as is known (the lane's switches_ns) */
	uint32_t label;            /* index into labels */
	uint32_t parent;           /* index into the lane's zones, or STILB_PROF_NONE */
	uint32_t size;             /* zones in its subtree, itself included: zone i + size is the next that is not inside */
	uint32_t frame; /* index into frames of the frame that it is charged to, or STILB_PROF_NONE: where its job was
	                              submitted; without a job where it began */
	uint16_t level; /* ancestors */
	bool open;      /* had not ended */
} stilb_prof_zone;

/* The thread did not run in [out_ns, in_ns). Before it began and after it ended counts as such a time. */
typedef struct stilb_prof_switch {
	uint64_t out_ns, in_ns; /* in_ns of the last may be the end of the window */
	bool preempted;         /* it could have run: another took the CPU; else it slept */
} stilb_prof_switch;

typedef enum stilb_prof_lane_kind {
	STILB_PROF_LANE_THREAD,
	STILB_PROF_LANE_DEVICE, /* zones timed elsewhere: a GPU */
} stilb_prof_lane_kind;

/* What one thread or device did. Lanes stand in the order in which they were made, but the main thread's is the first
 * unless it called stilb_prof_thread_begin, and those whose names differ in the number at their end stand by that
 * number. */
typedef struct stilb_prof_lane {
	const char *name;
	stilb_prof_lane_kind kind;
	uint32_t tid;                 /* the kernel's number of the thread; 0 for a device */
	const stilb_prof_zone *zones; /* parents before children, ascending by begin_ns; siblings do not overlap */
	uint32_t zone_count;
	const stilb_prof_switch *switches; /* ascending, disjoint */
	uint32_t switch_count;
	uint64_t switches_ns;    /* they are known from then on: of a zone that began before, off_cpu_ns is a part */
	const char *no_switches; /* why switches are not known; NULL when they are */
} stilb_prof_lane;

/* A counter's value or an instant, ascending by ns. */
typedef struct stilb_prof_point {
	uint64_t ns;
	double value; /* of a counter */
	uint32_t label;
	uint32_t lane;
	bool counter; /* else an instant */
} stilb_prof_point;

/* An arrow from where a job was submitted to where it ran. An end that is not held (overwritten, outside the window, or
 * it has not run yet) has the lane STILB_PROF_NONE and the time of the other. */
typedef struct stilb_prof_flow {
	uint64_t id;
	uint64_t from_ns, to_ns; /* to_ns - from_ns is the queue delay */
	uint32_t from_lane, to_lane;
	uint32_t label;
	uint32_t frame; /* index into frames: where it was submitted, or STILB_PROF_NONE */
} stilb_prof_flow;

typedef struct stilb_prof_frame {
	uint64_t number;           /* counted from 0 */
	uint64_t begin_ns, end_ns; /* whole frames only */
} stilb_prof_frame;

typedef struct stilb_prof_snapshot {
	const stilb_prof_label *labels;
	const stilb_prof_lane *lanes;
	const stilb_prof_point *points;
	const stilb_prof_flow *flows; /* ascending by to_ns */
	const stilb_prof_frame *frames;
	uint32_t label_count, lane_count, point_count, flow_count, frame_count;
	uint64_t begin_ns, end_ns; /* the window: what ended before or began after is left out */
	uint64_t epoch_ns;
	const char *clock;    /* "rdtsc" or "CLOCK_MONOTONIC" */
	double hz;            /* of that clock */
	double resolution_ns; /* the shortest difference between two reads */
	double bias_ns;       /* how much shorter than it was a zone reads, because rdtsc does not wait */
	double zone_cost_ns;  /* what recording one zone costs */
	/* events_recorded = events_lost (overwritten) + events_held, over all lanes. Never recorded were too_deep zones,
	 * and without_ring zones, counters, instants and flows of threads for whose ring there was no memory. */
	uint64_t events_recorded, events_lost, events_held, too_deep, without_ring;
	void *memory; /* its own */
} stilb_prof_snapshot;

/* Which frames. Frames are counted back from the last whole one, or by number. */
typedef struct stilb_prof_window {
	uint32_t last_frames; /* that many whole frames back, and what has happened since; 0: see below */
	uint64_t
		first_frame; /* with frame_count > 0: frames first_frame .. first_frame + frame_count - 1, and nothing after */
	uint32_t frame_count; /* 0 and last_frames 0: all that is held */
} stilb_prof_window;

/* snapshot is {0} or one of before, whose contents are replaced; window may be NULL for {0}. The same snapshot taken
 * again keeps its labels' places. Returns 0 or -ENOMEM; after an error the snapshot is empty. */
int stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window);

/* Safe on {0}. */
void stilb_prof_snapshot_finish(stilb_prof_snapshot *snapshot);

#ifdef __cplusplus
}
#endif
#endif
