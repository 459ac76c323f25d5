/*
 * prof_snapshot: what was recorded, as plain data. The timeline in a window, the tables and the files are all made from
 * it, and a trace file is read back into it.
 *
 *   rings (prof.h) --take--> snapshot --write--> Chrome JSON, folded stacks, CSV      (prof_trace.h)
 *   trace file     --read--> snapshot --------->  tables, comparison                  (prof_stats.h)
 *
 * Life cycle.  stilb_prof_snapshot snapshot = {0}; stilb_prof_snapshot_take any number of times (memory is reused: one
 *              a frame soon allocates nothing more); stilb_prof_snapshot_finish.
 * Example.     Prints the zones of all threads, indented by their nesting:
 *                  stilb_prof_snapshot s = {0};
 *                  if (stilb_prof_snapshot_take(&s, NULL) == 0)
 *                      for (uint32_t l = 0; l < s.lane_count; l++)
 *                          for (uint32_t i = 0; i < s.lanes[l].zone_count; i++) {
 *                              const stilb_prof_zone *zone = &s.lanes[l].zones[i];
 *                              printf("%*s%s\n", zone->level, "", s.labels[zone->label].name);
 *                          }
 *                  stilb_prof_snapshot_finish(&s);
 *
 * Threads.     [any-thread], one thread at a time per snapshot. Threads that record are not held up; threads that begin
 *              or end wait until the rings are copied.
 * Times.       Nanoseconds since the profiler's first call; epoch_ns is that moment on CLOCK_MONOTONIC.
 * Indices.     Labels, lanes, zones and frames refer to each other by index; STILB_PROF_NONE stands for none.
 * Asserts.     Builds without NDEBUG check after each take and read that the promises below hold.
 */
#ifndef STILB_PROF_SNAPSHOT_H
#define STILB_PROF_SNAPSHOT_H

#include "prof.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STILB_PROF_NONE UINT32_MAX

/* One name of zones, counters, instants or flows. The strings live as long as the snapshot. */
typedef struct stilb_prof_label {
	const char *name;
	const char *function, *file; /* place in the source; "" if not known */
	uint32_t line;
	uint32_t color; /* 0xRRGGBB; 0: the viewer chooses */
} stilb_prof_label;

/* One zone: an interval of a lane. */
typedef struct stilb_prof_zone {
	uint64_t begin_ns, end_ns; /* a zone that is still open ends when the snapshot was taken */
	uint64_t self_ns;          /* duration without its children */
	uint64_t off_cpu_ns;       /* for how much of it the thread was not running, as far as known (switches_ns) */
	uint32_t label;            /* index into labels */
	uint32_t parent;           /* index into the lane's zones, or STILB_PROF_NONE */
	uint32_t size;             /* zones in its subtree, itself included: zone i + size is the next one outside */
	uint32_t frame; /* index into frames, or STILB_PROF_NONE: the frame it is charged to. Inside a job that is the
	                   frame that submitted the job, else the frame in which the zone began */
	uint16_t level; /* number of ancestors; stays at UINT16_MAX beyond that */
	bool open;      /* had not ended */
} stilb_prof_zone;

/* The thread was not running in [out_ns, in_ns). The time before it began and after it ended counts as such. */
typedef struct stilb_prof_switch {
	uint64_t out_ns, in_ns; /* in_ns of the last one may be the end of the window */
	bool preempted;         /* true: it could have run, but another thread had the CPU; false: it slept */
} stilb_prof_switch;

typedef enum stilb_prof_lane_kind {
	STILB_PROF_LANE_THREAD,
	STILB_PROF_LANE_DEVICE, /* zones that were timed elsewhere, for example on a GPU */
} stilb_prof_lane_kind;

/* The zones of one thread or device. Lanes are in the order in which they were made, with two exceptions: a main thread
 * that has not called stilb_prof_thread_begin is the first, and lanes whose names differ only in the number at the end
 * are in the order of that number. */
typedef struct stilb_prof_lane {
	const char *name;
	stilb_prof_lane_kind kind;
	uint32_t tid;                 /* thread id of the kernel; 0 for a device */
	const stilb_prof_zone *zones; /* parents before children, ascending by begin_ns; siblings do not overlap */
	uint32_t zone_count;
	const stilb_prof_switch *switches; /* ascending, disjoint */
	uint32_t switch_count;
	uint64_t switches_ns;    /* switches are known from then on: off_cpu_ns of a zone that began earlier is a part */
	const char *no_switches; /* the reason why switches are not known; NULL if they are */
} stilb_prof_lane;

/* The value of a counter, or an instant. */
typedef struct stilb_prof_point {
	uint64_t ns;
	double value;   /* of a counter; 0 for an instant */
	uint32_t label; /* index into labels */
	uint32_t lane;  /* index into lanes; STILB_PROF_NONE only in files of other programs */
	bool counter;   /* false: an instant */
} stilb_prof_point;

/* An arrow from where a job was submitted to where it ran. An end that is not in the snapshot (overwritten, outside the
 * window, or the job has not run yet) has the lane STILB_PROF_NONE and the time of the other end. */
typedef struct stilb_prof_flow {
	uint64_t id;
	uint64_t from_ns, to_ns; /* to_ns - from_ns, never negative, is the time that the job was queued */
	uint32_t from_lane, to_lane;
	uint32_t label; /* index into labels */
	uint32_t frame; /* index into frames: the frame that submitted the job; or STILB_PROF_NONE */
} stilb_prof_flow;

/* A whole frame: from one mark to the next. */
typedef struct stilb_prof_frame {
	uint64_t number; /* counted from 0; ascending */
	uint64_t begin_ns, end_ns;
} stilb_prof_frame;

typedef struct stilb_prof_snapshot {
	const stilb_prof_label *labels;
	const stilb_prof_lane *lanes;
	const stilb_prof_point *points; /* ascending by ns */
	const stilb_prof_flow *flows;   /* ascending by to_ns */
	const stilb_prof_frame *frames; /* ascending, disjoint */
	uint32_t label_count, lane_count, point_count, flow_count, frame_count;
	uint64_t begin_ns, end_ns; /* the window: what ended before it or began after it is left out */
	uint64_t epoch_ns;         /* time 0 on CLOCK_MONOTONIC */
	const char *clock;         /* "rdtsc" or "CLOCK_MONOTONIC"; "" for files of other programs */
	double hz;                 /* ticks of that clock per second */
	double resolution_ns;      /* the smallest difference between two reads that differ; a median */
	double bias_ns;            /* by how much a zone reads too short, because rdtsc does not wait */
	double zone_cost_ns;       /* cost of recording one zone */
	/* events_recorded = events_lost (overwritten) + events_held, over all lanes, whatever the window. Not among them
	 * are zones nested too deep (too_deep), and events of threads without memory for a ring (without_ring). */
	uint64_t events_recorded, events_lost, events_held, too_deep, without_ring;
	void *memory; /* of the library */
} stilb_prof_snapshot;

/* Which frames to take: {0}: all that the rings hold. */
typedef struct stilb_prof_window {
	uint32_t last_frames; /* the last so many whole frames, and everything since; 0: by number */
	uint64_t first_frame; /* by number: frames first_frame .. first_frame + frame_count - 1 and nothing after them */
	uint32_t frame_count; /* 0: all that the rings hold */
} stilb_prof_window;

/* Takes a snapshot of the window; NULL stands for {0}. snapshot is {0} or an earlier one, whose contents are replaced;
 * it is not NULL (asserted). Taken again, a snapshot keeps the indices of its labels. If the window's frames are no
 * longer remembered, it has no frames and no zones. Returns 0 or -ENOMEM; after an error the snapshot is {0}.
 * [any-thread] */
int stilb_prof_snapshot_take(stilb_prof_snapshot *snapshot, const stilb_prof_window *window);

/* Frees a snapshot that was taken or read, and leaves {0}. Safe on {0}. [any-thread] */
void stilb_prof_snapshot_finish(stilb_prof_snapshot *snapshot);

#ifdef __cplusplus
}
#endif
#endif
