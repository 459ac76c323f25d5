/*
 * ui_profiler_data: what the profiler's window says about a frame, computed from a snapshot alone, without drawing,
 * clock or state: each lane's time by kind; in words, what limits the frame and its longest wait; and zones merged
 * where they are too narrow for the scale of the timeline. A lane is one thread or the GPU with its zones.
 *
 *   ui_profiler_data_build(&data, &snapshot, frame)   -> data.report, data.lanes, data.counters
 *   ui_profiler_spans_build(&spans, lane, ...)        -> spans.spans, the rectangles of one lane
 *
 * Times are nanoseconds on the snapshot's clock (prof_snapshot.h). Every function is [any-thread], one thread at a time
 * for each structure.
 */
#ifndef STILB_UI_PROFILER_DATA_H
#define STILB_UI_PROFILER_DATA_H

#include "base/base.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_snapshot.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- kinds of zones ---------------------------------------------------------------------------------------------- */

/* The kind of a zone, told by its name: "wait ..." waits for something, "parked" and "idle" mean that there is nothing
 * to do, everything else is work. */
typedef enum ui_profiler_kind { UI_PROFILER_WORK, UI_PROFILER_WAIT, UI_PROFILER_IDLE } ui_profiler_kind;

ui_profiler_kind ui_profiler_kind_of(const char *name);

/* True for "acquire" and "queue present": in these zones Vulkan waits for the display, or for the GPU to finish the
 * picture. Their kind is UI_PROFILER_WAIT. */
bool ui_profiler_presents(const char *name);

/* ---- walking a lane ---------------------------------------------------------------------------------------------- */

/* A stretch of time, and the innermost zone of the lane during it, or STILB_PROF_NONE outside all zones. */
typedef struct ui_profiler_stretch {
	uint64_t begin_ns, end_ns;
	uint32_t zone;
} ui_profiler_stretch;

/* Goes over begin_ns..end_ns of a lane, stretch by stretch, in order and without gaps:
 *
 *   ui_profiler_walk walk = ui_profiler_walk_begin(lane, begin_ns, end_ns);
 *   for (ui_profiler_stretch stretch; ui_profiler_walk_next(&walk, &stretch);)
 *       ...
 */
typedef struct ui_profiler_walk {
	const stilb_prof_lane *lane;
	uint64_t at_ns, end_ns;
	uint32_t next;      /* the first zone that the walk has not reached */
	uint32_t innermost; /* the innermost zone at at_ns, or STILB_PROF_NONE */
} ui_profiler_walk;

ui_profiler_walk ui_profiler_walk_begin(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns);

/* Gives the next stretch. False: the walk is over, *stretch is unchanged. */
bool ui_profiler_walk_next(ui_profiler_walk *walk, ui_profiler_stretch *stretch);

/* The innermost zone at that time, or STILB_PROF_NONE. */
uint32_t ui_profiler_zone_at(const stilb_prof_lane *lane, uint64_t ns);

/* Index of the lane's first switch (time off the CPU) that ends after that time; switch_count: there is none. */
uint32_t ui_profiler_switch_after(const stilb_prof_lane *lane, uint64_t ns);

/* Nanoseconds of begin_ns..end_ns in which the lane's thread did not run; *preempted is the part of them in which
 * another thread had taken the CPU from it. */
uint64_t ui_profiler_off_cpu(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns, uint64_t *preempted);

/* ---- merging ----------------------------------------------------------------------------------------------------- */

/* One rectangle of the timeline: a zone, or several neighbours that are too narrow to be told apart, with all zones
 * nested in them. */
typedef struct ui_profiler_span {
	uint64_t begin_ns, end_ns;
	uint32_t zone;  /* index of the longest of the span's outermost zones */
	uint32_t count; /* zones in the span, nested ones included */
	uint32_t label; /* the label that all its outermost zones have, or STILB_PROF_NONE: they differ */
	uint16_t level; /* nesting depth of the outermost zones in it */
} ui_profiler_span;

typedef struct ui_profiler_spans {
	ui_profiler_span *spans; /* of one level in ascending order */
	uint32_t count, capacity;
} ui_profiler_spans;

/* Replaces spans ({0} at first) by the lane's zones that touch begin_ns..end_ns. Neighbouring zones that are each
 * shorter than narrow_ns, with gaps shorter than narrow_ns between them, are merged into one span. False: no memory. */
bool ui_profiler_spans_build(ui_profiler_spans *spans, const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns,
                             double narrow_ns);

/* Frees; accepts {0}. */
void ui_profiler_spans_finish(ui_profiler_spans *spans);

/* ---- a frame in numbers and words -------------------------------------------------------------------------------- */

typedef enum ui_profiler_limit {
	UI_PROFILER_LIMIT_UNKNOWN, /* nothing was recorded */
	UI_PROFILER_LIMIT_CPU,
	UI_PROFILER_LIMIT_GPU,
	UI_PROFILER_LIMIT_DISPLAY, /* the frame waits until the display takes the picture */
} ui_profiler_limit;

/* The parts of a lane's time in the frame. Every moment counts in exactly one of them, so their sum is the frame's
 * length. A thread is usually off the CPU while it waits or has nothing to do: such time counts as wait or idle.
 * asleep_ns and lost_ns are only the time off the CPU in zones of work or outside all zones. */
typedef struct ui_profiler_lane_sum {
	uint64_t work_ns;    /* in zones of work, on a CPU as far as is known */
	uint64_t wait_ns;    /* in zones of waiting */
	uint64_t idle_ns;    /* in zones in which there is nothing to do */
	uint64_t asleep_ns;  /* off the CPU in work or in no zone, because it slept */
	uint64_t lost_ns;    /* likewise, because another thread had the CPU */
	uint64_t outside_ns; /* in no zone, on a CPU as far as is known */
} ui_profiler_lane_sum;

#define UI_PROFILER_PARTS 6

/* A part of a lane's time, with its name for the user. */
typedef struct ui_profiler_part {
	const char *name;
	uint64_t ns;
	bool lost; /* the part "lost the CPU", which is drawn as a warning */
} ui_profiler_part;

/* The parts of a sum, always in the same order: work, then those longer than least_ns; at least one. The work of a
 * device is called "busy", and its time outside zones counts as idle. Returns how many. */
uint32_t ui_profiler_parts(stilb_prof_lane_kind kind, const ui_profiler_lane_sum *sum, uint64_t least_ns,
                           ui_profiler_part parts[UI_PROFILER_PARTS]);

/* All waits of one thread for the same reason in the same zone of work, taken together. Times in which it had lost the
 * CPU are one group, whichever zone they were in. */
typedef struct ui_profiler_wait {
	uint32_t lane;             /* of the thread that waited; STILB_PROF_NONE: no wait was long enough to be named */
	uint32_t label;            /* of the zone of waiting; STILB_PROF_NONE: off the CPU in the middle of work */
	uint32_t in_label;         /* the zone of work around the longest wait, or STILB_PROF_NONE */
	uint32_t count;            /* waits in the group */
	uint64_t total_ns;         /* their sum */
	uint64_t begin_ns, end_ns; /* of the longest wait in the group */
	bool preempted;            /* with label STILB_PROF_NONE: another thread had taken the CPU; else it slept */
	uint32_t for_lane;         /* the lane that was waited for, or STILB_PROF_NONE: not known */
	uint32_t for_label;        /* the zone in which that lane spent most of the waits, or STILB_PROF_NONE */
	uint64_t for_off_ns;       /* time in the waits in which that lane's thread was off the CPU in its work, */
	uint64_t for_preempted_ns; /* and the part of it in which another thread had taken its CPU */
	uint64_t for_late_ns;      /* time in the waits before that lane began its work */
	uint64_t after_ns;         /* time in the waits after that lane had finished its work, */
	uint64_t after_lost_ns;    /* and the part of it in which the waiting thread had lost the CPU */
} ui_profiler_wait;

typedef struct ui_profiler_report {
	uint32_t frame; /* index into the snapshot's frames */
	uint32_t lane;  /* of the thread that runs frames, or STILB_PROF_NONE */
	ui_profiler_limit limit;
	uint32_t stage_label;  /* the longest part of the frame, with LIMIT_GPU the longest pass; STILB_PROF_NONE: the time
	                          outside all zones */
	uint64_t stage_ns;     /* its length */
	uint64_t gpu_ns;       /* time in the frame in which the GPU was busy */
	ui_profiler_wait wait; /* the group of waits that took longest */
	uint32_t events;       /* events that were recorded in the frame, in all lanes */
	uint64_t cost_ns;      /* the time that recording these events took, all threads together */
	char verdict[192];     /* the limit in a sentence */
	char wait_text[320];   /* the wait in a sentence */
} ui_profiler_report;

/* A counter: all points of one name, whichever thread and place in the source recorded them. */
typedef struct ui_profiler_counter {
	uint32_t label;        /* the first label with that name */
	uint32_t first, count; /* data->points[first .. first + count - 1] index the snapshot's points, ascending by time */
	double minimum, maximum; /* over these points; all are finite */
} ui_profiler_counter;

typedef struct ui_profiler_data {
	ui_profiler_report report;
	ui_profiler_lane_sum *lanes;   /* [snapshot->lane_count] */
	uint8_t *kinds;                /* [snapshot->label_count] ui_profiler_kind */
	uint64_t *lane_ns, *label_ns;  /* scratch, [snapshot->lane_count] and [snapshot->label_count] */
	ui_profiler_counter *counters; /* [counter_count] of the whole snapshot, in the order of their first points */
	uint32_t counter_count;
	uint32_t *counter_of; /* [snapshot->label_count] index into counters, or STILB_PROF_NONE */
	uint32_t *points;     /* the counters' points, see ui_profiler_counter */
	uint32_t capacity[7]; /* elements for which each of the seven arrays above has memory */
} ui_profiler_data;

/* Fills data ({0} at first) for snapshot->frames[frame]. False: no memory. */
bool ui_profiler_data_build(ui_profiler_data *data, const stilb_prof_snapshot *snapshot, uint32_t frame);

/* Frees; accepts {0}. */
void ui_profiler_data_finish(ui_profiler_data *data);

/* Index into data->points of the counter's last point at the time ns or before; STILB_PROF_NONE: there is none. */
uint32_t ui_profiler_counter_at(const ui_profiler_data *data, const stilb_prof_snapshot *snapshot,
                                const ui_profiler_counter *counter, uint64_t ns);

/* Index of the snapshot's frame with that number, or STILB_PROF_NONE. */
uint32_t ui_profiler_frame_find(const stilb_prof_snapshot *snapshot, uint64_t number);

/* Writes the time with its unit ("340 ns", "12.3 µs", "3.10 ms", "1.25 s") into text of size bytes, of which 32 always
 * suffice. Returns text. */
const char *ui_profiler_time_text(char *text, size_t size, uint64_t ns);

/* ---- frame times ------------------------------------------------------------------------------------------------- */

#define UI_PROFILER_AVERAGE 10u /* frames in a moving average */

/* average_ms[i], i < history->count: mean time of frame i and up to UI_PROFILER_AVERAGE - 1 frames before it. */
void ui_profiler_average(const stilb_prof_frame_stats *history, float average_ms[STILB_PROF_STATS_FRAMES]);

/* Index of the slowest frame, of equal ones the latest. The history has at least one frame. */
uint32_t ui_profiler_slowest(const stilb_prof_frame_stats *history);

/* The number of the history's frame with that index, 0..history->count - 1. */
static inline uint64_t ui_profiler_frame_number(const stilb_prof_frame_stats *history, uint32_t index)
{
	STILB_ASSERT(index < history->count);
	return history->last - (history->count - 1 - index);
}

#endif
