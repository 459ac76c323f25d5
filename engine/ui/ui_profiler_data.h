/*
 * ui_profiler_data: what the profiler's window says about a frame, worked out from a snapshot alone, without drawing,
 * clock or state: sums, the verdict and the longest wait in words; zones merged for a scale.
 *
 *   ui_profiler_data_build(&data, &snapshot, frame)   -> data.report, data.lanes, data.counters
 *   ui_profiler_spans_build(&spans, lane, ...)        -> spans.spans, the rectangles of one lane
 *
 * Times are nanoseconds as in the snapshot (prof_snapshot.h). Every function is [any-thread], one thread at a time for
 * each structure.
 */
#ifndef STILB_UI_PROFILER_DATA_H
#define STILB_UI_PROFILER_DATA_H

#include "profiler/prof_capture.h"
#include "profiler/prof_snapshot.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- kinds of zones ---------------------------------------------------------------------------------------------- */

/* What a thread does in a zone, by its name: "wait ..." is a WAIT for something, in "parked" and "idle" there is
 * nothing to do, everything else is WORK. */
typedef enum ui_profiler_kind { UI_PROFILER_WORK, UI_PROFILER_WAIT, UI_PROFILER_IDLE } ui_profiler_kind;

ui_profiler_kind ui_profiler_kind_of(const char *name);

/* "acquire" and "queue present", where Vulkan waits for the display, or for a GPU that has no picture for it yet: a
 * WAIT. */
bool ui_profiler_presents(const char *name);

/* ---- walking a lane ---------------------------------------------------------------------------------------------- */

/* A stretch of time and the innermost zone in it, or STILB_PROF_NONE. */
typedef struct ui_profiler_stretch {
	uint64_t begin_ns, end_ns;
	uint32_t zone;
} ui_profiler_stretch;

/* From begin_ns to end_ns over a lane, stretch by stretch and without gaps. */
typedef struct ui_profiler_walk {
	const stilb_prof_lane *lane;
	uint64_t at_ns, end_ns;
	uint32_t next, innermost;
} ui_profiler_walk;

ui_profiler_walk ui_profiler_walk_begin(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns);
bool ui_profiler_walk_next(ui_profiler_walk *walk, ui_profiler_stretch *stretch);

/* The innermost zone at that time, or STILB_PROF_NONE. */
uint32_t ui_profiler_zone_at(const stilb_prof_lane *lane, uint64_t ns);

/* The first switch that has not ended at that time; switch_count: there is none. */
uint32_t ui_profiler_switch_after(const stilb_prof_lane *lane, uint64_t ns);

/* How much of begin_ns..end_ns the lane's thread did not run; *preempted: of that, with work left to do. */
uint64_t ui_profiler_off_cpu(const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns, uint64_t *preempted);

/* ---- merging ----------------------------------------------------------------------------------------------------- */

/* What is drawn as one rectangle: a zone, or neighbours too narrow to be told apart with all that lies in them. */
typedef struct ui_profiler_span {
	uint64_t begin_ns, end_ns;
	uint32_t zone;  /* the longest of its level */
	uint32_t count; /* zones in it */
	uint32_t label; /* of all zones of its level, or STILB_PROF_NONE: they differ */
	uint16_t level;
} ui_profiler_span;

typedef struct ui_profiler_spans {
	ui_profiler_span *spans; /* of one level in ascending order */
	uint32_t count, capacity;
} ui_profiler_spans;

/* The lane's zones that touch begin_ns..end_ns; zones shorter than narrow_ns and less than that apart are merged.
 * False: no memory. */
bool ui_profiler_spans_build(ui_profiler_spans *spans, const stilb_prof_lane *lane, uint64_t begin_ns, uint64_t end_ns,
                             double narrow_ns);
void ui_profiler_spans_finish(ui_profiler_spans *spans);

/* ---- a frame in numbers and words -------------------------------------------------------------------------------- */

typedef enum ui_profiler_limit {
	UI_PROFILER_LIMIT_UNKNOWN, /* nothing was recorded */
	UI_PROFILER_LIMIT_CPU,
	UI_PROFILER_LIMIT_GPU,
	UI_PROFILER_LIMIT_DISPLAY, /* frames are held back until they can be shown */
} ui_profiler_limit;

/* Where a lane's time went in the frame: each moment counts once, so that together they are the frame's length. A
 * thread that waits or has nothing to do may be off the CPU as well; asleep and lost count only where it had work, or
 * was in no zone. */
typedef struct ui_profiler_lane_sum {
	uint64_t work_ns;    /* in zones of work, on a CPU as far as is known */
	uint64_t wait_ns;    /* in zones of waiting */
	uint64_t idle_ns;    /* in zones in which there is nothing to do */
	uint64_t asleep_ns;  /* off the CPU in work or in no zone, because it slept */
	uint64_t lost_ns;    /* likewise, because another thread had the CPU */
	uint64_t outside_ns; /* in no zone, on a CPU as far as is known */
} ui_profiler_lane_sum;

#define UI_PROFILER_PARTS 6

/* A part of a lane's time by its name. */
typedef struct ui_profiler_part {
	const char *name;
	uint64_t ns;
	bool lost; /* the CPU, to another thread */
} ui_profiler_part;

/* The parts of a sum in their order: work first, then those that are longer than least_ns. A device is busy or idle.
 * Returns how many. */
uint32_t ui_profiler_parts(stilb_prof_lane_kind kind, const ui_profiler_lane_sum *sum, uint64_t least_ns,
                           ui_profiler_part parts[UI_PROFILER_PARTS]);

/* Waits for the same thing in the same place, taken together; times without the CPU wherever they were. */
typedef struct ui_profiler_wait {
	uint32_t lane;             /* who waited, or STILB_PROF_NONE: nobody worth a word */
	uint32_t label;            /* the wait zone's; STILB_PROF_NONE: it was off the CPU in the middle of work */
	uint32_t in_label;         /* the work that it was part of (the longest of them), or STILB_PROF_NONE */
	uint32_t count;            /* how many */
	uint64_t total_ns;         /* together */
	uint64_t begin_ns, end_ns; /* the longest of them */
	bool preempted;            /* label is STILB_PROF_NONE: another thread had the CPU; else it slept */
	uint32_t for_lane;         /* for whom, or STILB_PROF_NONE: not known */
	uint32_t for_label;        /* what that one did meanwhile, or STILB_PROF_NONE */
	uint64_t for_off_ns;       /* how long that one was off the CPU in its work, */
	uint64_t for_preempted_ns; /* and how much of that because another thread had it */
	uint64_t for_late_ns;      /* how long that one had not begun */
	uint64_t after_ns;         /* how long after that one was done it went on, */
	uint64_t after_lost_ns;    /* and how much of that because another thread had its CPU */
} ui_profiler_wait;

typedef struct ui_profiler_report {
	uint32_t frame; /* index into the snapshot's */
	uint32_t lane;  /* of the thread that runs frames, or STILB_PROF_NONE */
	ui_profiler_limit limit;
	uint32_t stage_label; /* the longest part of the frame, or the GPU's pass; STILB_PROF_NONE: outside all zones */
	uint64_t stage_ns;
	uint64_t gpu_ns; /* the GPU was busy */
	ui_profiler_wait wait;
	uint32_t events;  /* recorded in the frame, all lanes */
	uint64_t cost_ns; /* what recording them cost, all threads together */
	char verdict[192];
	char wait_text[320];
} ui_profiler_report;

/* The curve of a counter: of all points of that name, whichever thread and place in the source recorded them. */
typedef struct ui_profiler_counter {
	uint32_t label;          /* the first of that name */
	uint32_t first, count;   /* its points: data->points[first] .. are indices of the snapshot's, ascending by time */
	double minimum, maximum; /* of them */
} ui_profiler_counter;

typedef struct ui_profiler_data {
	ui_profiler_report report;
	ui_profiler_lane_sum *lanes;   /* of each lane of the snapshot */
	uint8_t *kinds;                /* ui_profiler_kind of each label */
	uint64_t *lane_ns, *label_ns;  /* of each lane and label, for counting */
	ui_profiler_counter *counters; /* of the whole snapshot, in the order of their first points */
	uint32_t counter_count;
	uint32_t *counter_of; /* of each label: index into counters, or STILB_PROF_NONE */
	uint32_t *points;
	uint32_t capacity[7]; /* of these arrays */
} ui_profiler_data;

/* Fills data for the snapshot's frame of that index. False: no memory. */
bool ui_profiler_data_build(ui_profiler_data *data, const stilb_prof_snapshot *snapshot, uint32_t frame);
void ui_profiler_data_finish(ui_profiler_data *data);

/* The last point of the counter at that time or before, an index into data->points; STILB_PROF_NONE: there is none. */
uint32_t ui_profiler_counter_at(const ui_profiler_data *data, const stilb_prof_snapshot *snapshot,
                                const ui_profiler_counter *counter, uint64_t ns);

/* The snapshot's frame of that number: its index, or STILB_PROF_NONE. */
uint32_t ui_profiler_frame_find(const stilb_prof_snapshot *snapshot, uint64_t number);

/* "340 ns", "12.3 µs", "3.10 ms", "1.25 s". Returns text. */
const char *ui_profiler_time_text(char *text, size_t size, uint64_t ns);

/* ---- frame times ------------------------------------------------------------------------------------------------- */

#define UI_PROFILER_AVERAGE 10u /* frames in a moving average */

/* average_ms[i] of each frame and up to UI_PROFILER_AVERAGE - 1 before it. */
void ui_profiler_average(const stilb_prof_frame_stats *history, float average_ms[STILB_PROF_STATS_FRAMES]);

/* Index of the slowest frame, of equal ones the latest; there is one at least. */
uint32_t ui_profiler_slowest(const stilb_prof_frame_stats *history);

/* The number of the frame with that index. */
static inline uint64_t ui_profiler_frame_number(const stilb_prof_frame_stats *history, uint32_t index)
{
	return history->last - (history->count - 1 - index);
}

#endif
