/* Inside the profiler's window: its state, and what ui_profiler.c (what is shown), ui_profiler_panel.c (words, bars,
 * the table) and ui_profiler_timeline.c (the lanes) share. */
#ifndef UI_PROFILER_INTERNAL_H
#define UI_PROFILER_INTERNAL_H

#include "profiler/prof_stats.h"
#include "ui/ui_profiler.h"
#include "ui/ui_profiler_data.h"

typedef enum ui_profiler_mode {
	UI_PROFILER_SLOWEST, /* of the history */
	UI_PROFILER_LATEST,
	UI_PROFILER_PICKED, /* by the user */
} ui_profiler_mode;

typedef struct ui_profiler_colors {
	uint32_t *rgb; /* of each of the snapshot's labels */
	uint32_t capacity;
} ui_profiler_colors;

/* One lane on the screen. */
typedef struct ui_profiler_row {
	uint32_t lane;  /* index into the snapshot's */
	uint32_t depth; /* levels */
	uint32_t lines; /* of words below its name */
	float top;      /* of its first level, pixels; of this frame */
	float height;   /* with the gap behind it */
} ui_profiler_row;

struct stilb_ui_profiler {
	stilb_ui_profiler_desc desc;

	stilb_prof_frame_stats history;
	ui_profiler_mode mode;
	uint64_t picked;      /* frame number */
	bool frozen;          /* the history stands still */
	bool freeze_on_spike; /* freeze by itself at a spike */
	uint32_t settle;      /* draws until what comes late (the GPU's zones) is there too */

	stilb_prof_snapshot live, held;
	const stilb_prof_snapshot *snapshot; /* the one of them that is shown; NULL: none */
	uint64_t number;                     /* of the frame shown */
	uint64_t taken_at;                   /* the history's last when held was taken */
	uint64_t held_number;                /* the frame it was taken for */
	bool held_all;                       /* it is the frozen history's */
	bool out_of_memory;

	ui_profiler_data data;  /* the frame's */
	stilb_prof_stats stats; /* without what only idled */
	stilb_ui_sort sort;
	stilb_ui_list_state table;
	ui_profiler_colors colors;

	double view_begin_ns, view_ns; /* from the frame's begin */
	float scroll;                  /* of the lanes, pixels */
	uint32_t hot_label;            /* pointed at in the table, or STILB_PROF_NONE */
	ui_profiler_row *rows;
	uint32_t row_count, row_capacity, lane_count;
	ui_profiler_spans spans;
};

/* The frame that is shown; NULL: none. */
static inline const stilb_prof_frame *ui_profiler_frame(const stilb_ui_profiler *profiler)
{
	return profiler->snapshot ? &profiler->snapshot->frames[profiler->data.report.frame] : NULL;
}

/* ---- ui_profiler.c ----------------------------------------------------------------------------------------------- */

/* What has the keys gets the space key, too: it freezes all the same. */
void ui_profiler_freeze_key(stilb_ui_profiler *profiler, const stilb_ui *ui, const stilb_ui_action *action);

/* The lanes show that time, with a little room at both ends. */
void ui_profiler_fit_frame(stilb_ui_profiler *profiler);
void ui_profiler_fit(stilb_ui_profiler *profiler, uint64_t begin_ns, uint64_t end_ns);

/* ---- ui_profiler_panel.c ----------------------------------------------------------------------------------------- */

/* What the picture's parts have in common. */
#define UI_PROFILER_ATTENTION 0xffb224u /* the longest wait */
#define UI_PROFILER_BAD 0xff5c5cu       /* spikes, a lost CPU */
#define UI_PROFILER_RUNNING 0x3fa98au
#define UI_PROFILER_WAITING 0x566175u
#define UI_PROFILER_PARKED 0x343c49u
#define UI_PROFILER_FLOW 0x9fd0ffu
#define UI_PROFILER_AVERAGE_LINE 0xf2f5fau

/* Columns of the table. */
enum {
	UI_PROFILER_NAME,
	UI_PROFILER_CALLS,
	UI_PROFILER_INCLUSIVE,
	UI_PROFILER_SELF,
	UI_PROFILER_OFF_CPU,
	UI_PROFILER_COLUMNS
};

/* Sorts profiler->stats by the table's column. */
void ui_profiler_sort_table(stilb_ui_profiler *profiler);

float ui_profiler_top_height(const stilb_ui_profiler *profiler, const stilb_ui *ui);
void ui_profiler_draw_top(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);
float ui_profiler_legend_height(const stilb_ui *ui);
void ui_profiler_draw_legend(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);

/* ---- ui_profiler_timeline.c -------------------------------------------------------------------------------------- */

/* False: no memory. After a new snapshot. */
bool ui_profiler_layout_lanes(stilb_ui_profiler *profiler);
/* Of all lanes; sets the height of each. */
float ui_profiler_timeline_height(stilb_ui_profiler *profiler, const stilb_ui *ui);
void ui_profiler_draw_timeline(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);

/* ---- ui_profiler_counters.c -------------------------------------------------------------------------------------- */

/* Where the lanes stand, and what time they show. */
typedef struct ui_profiler_view {
	stilb_ui_rect names, area;
	double begin_ns, pixels_per_ns; /* begin_ns: at the area's left edge */
	float level;                    /* height of a line */
	stilb_ui_action action;         /* of the area */
} ui_profiler_view;

/* The nearest time that there is. */
static inline uint64_t ui_profiler_whole_ns(double ns)
{
	return ns > 0.0 ? ns < 0x1p63 ? (uint64_t)ns : UINT64_MAX : 0;
}

float ui_profiler_counters_height(const stilb_ui_profiler *profiler, float level);

/* The curves, from top on downwards; the value under the mouse is told. */
void ui_profiler_draw_counters(stilb_ui_profiler *profiler, stilb_ui *ui, const ui_profiler_view *view, float top);

#endif
