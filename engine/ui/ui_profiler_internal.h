/* Inside the profiler's window (ui_profiler.h): its state, and the functions that its files share. A lane is the row of
 * one thread or of the GPU in the timeline. The files, in the order of the window's parts from the top down:
 *
 *   ui_profiler.c            which frame is shown, its snapshot, the window as a whole
 *   ui_profiler_panel.c      the upper part: words, history, table; and the legend
 *   ui_profiler_timeline.c   the lanes
 *   ui_profiler_counters.c   the curves below the lanes
 *   ui_profiler_choice.c     what the user chose: the frame, frozen or not, the time that the lanes show
 */
#ifndef UI_PROFILER_INTERNAL_H
#define UI_PROFILER_INTERNAL_H

#include "base/base_contract.h"
#include "profiler/prof_stats.h"
#include "ui/ui_profiler.h"
#include "ui/ui_profiler_data.h"

typedef enum ui_profiler_mode {
	UI_PROFILER_SLOWEST, /* the window shows the slowest frame of the history */
	UI_PROFILER_LATEST,  /* the last frame of the history */
	UI_PROFILER_PICKED,  /* the frame whose number is stilb_ui_profiler.picked */
} ui_profiler_mode;

/* The colour in which the zones of each label (name and place in the source) are drawn. */
typedef struct ui_profiler_colors {
	uint32_t *rgb; /* [snapshot->label_count] 0xRRGGBB */
	uint32_t capacity;
} ui_profiler_colors;

/* One lane on the screen. */
typedef struct ui_profiler_row {
	uint32_t lane;  /* index into the snapshot's lanes */
	uint32_t depth; /* levels of nested zones that are drawn, 1..10 */
	uint32_t lines; /* lines of text below the lane's name */
	float top;      /* y of its first level in this frame, pixels */
	float height;   /* pixels, including the gap below it */
} ui_profiler_row;

/* The GPU's zones of a frame are known once its timestamps have been read, at most this many frames after the frame has
 * ended. */
#define UI_PROFILER_LATE 4u

struct stilb_ui_profiler {
	stilb_owner owner; /* the thread that created it */
	stilb_ui_profiler_desc desc;

	stilb_prof_frame_stats history;
	ui_profiler_mode mode;
	uint64_t picked;      /* frame number, for UI_PROFILER_PICKED */
	bool frozen;          /* the history stands still */
	bool freeze_on_spike; /* a spike (a frame far longer than usual) is shown and freezes the history */
	uint32_t settle;      /* while frozen: draws until the GPU's zones of all frames have arrived */

	stilb_prof_snapshot live;            /* for mode LATEST, taken on every draw */
	stilb_prof_snapshot held;            /* for the other modes, taken when another frame is to be shown */
	const stilb_prof_snapshot *snapshot; /* the one of the two that is shown; NULL: no frame is shown */
	uint64_t number;                     /* of the frame shown */
	uint64_t taken_at;                   /* the newest frame's number (history.last) when `held` was taken */
	uint64_t held_number;                /* the frame number that `held` was taken for; UINT64_MAX: none */
	bool held_all;                       /* `held` has all frames of the frozen history */
	bool out_of_memory;

	ui_profiler_data data;  /* of the frame shown */
	stilb_prof_stats stats; /* sums of that frame's zones for the table, without zones of kind UI_PROFILER_IDLE */
	stilb_ui_sort sort;
	stilb_ui_list_state table;
	ui_profiler_colors colors;

	double view_begin_ns, view_ns; /* the lanes show view_ns from view_begin_ns on, counted from the frame's begin */
	float scroll;                  /* how far the lanes are scrolled down, pixels */
	uint32_t hot_label;            /* of the table's row under the mouse, or STILB_PROF_NONE */
	ui_profiler_row *rows;         /* lanes with zones, in the order in which they are drawn */
	uint32_t row_count, row_capacity, lane_count;
	ui_profiler_spans spans; /* of the lane that is being drawn */
};

/* The frame that is shown; only if there is a snapshot. */
static inline const stilb_prof_frame *ui_profiler_frame(const stilb_ui_profiler *profiler)
{
	STILB_ASSERT(profiler->snapshot && "a frame is shown");
	STILB_ASSERT(profiler->data.report.frame < profiler->snapshot->frame_count);
	return &profiler->snapshot->frames[profiler->data.report.frame];
}

/* ---- ui_profiler_choice.c ---------------------------------------------------------------------------------------- */

/* Called for each area of the window that takes the keys, with the user's action on it: the space key freezes and
 * unfreezes also while that area has the focus. */
void ui_profiler_freeze_key(stilb_ui_profiler *profiler, const stilb_ui *ui, const stilb_ui_action *action);

/* Makes the lanes show begin_ns..end_ns, or the frame, with a margin at both ends. To be called only while a frame is
 * shown. */
void ui_profiler_fit(stilb_ui_profiler *profiler, uint64_t begin_ns, uint64_t end_ns);
void ui_profiler_fit_frame(stilb_ui_profiler *profiler);

/* ---- ui_profiler_panel.c ----------------------------------------------------------------------------------------- */

/* Colours with a meaning, 0xRRGGBB, the same in all parts of the window and in its legend. */
#define UI_PROFILER_ATTENTION 0xffb224u /* the longest wait */
#define UI_PROFILER_BAD 0xff5c5cu       /* frames that are spikes; times in which another thread took a thread's CPU */
#define UI_PROFILER_RUNNING 0x3fa98au   /* times in which a thread ran on a CPU */
#define UI_PROFILER_WAITING 0x566175u   /* zones in which a thread waits for something (UI_PROFILER_WAIT) */
#define UI_PROFILER_PARKED 0x343c49u    /* zones in which a thread has no work (UI_PROFILER_IDLE), and threads asleep */
#define UI_PROFILER_FLOW 0x9fd0ffu      /* arrows from where a job was submitted to where it ran */
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

/* The upper part (words, history, table) and the legend of colours: their heights in pixels, and drawing them. The
 * legend is drawn only while a frame is shown. */
float ui_profiler_top_height(const stilb_ui_profiler *profiler, stilb_ui *ui);
void ui_profiler_draw_top(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);
float ui_profiler_legend_height(const stilb_ui *ui);
void ui_profiler_draw_legend(const stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);

/* ---- ui_profiler_timeline.c -------------------------------------------------------------------------------------- */

/* Fills profiler->rows from the snapshot; call it after every change of the snapshot. False: no memory. */
bool ui_profiler_layout_lanes(stilb_ui_profiler *profiler);

/* Pixels that the ruler, all lanes and the counters need; also sets the height of each row. */
float ui_profiler_timeline_height(stilb_ui_profiler *profiler, const stilb_ui *ui);

/* Draws the lanes and counters in area and handles the mouse over them. A frame is shown. */
void ui_profiler_draw_timeline(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area);

/* ---- ui_profiler_counters.c -------------------------------------------------------------------------------------- */

/* The layout of the timeline on the screen, and the time that it shows. */
typedef struct ui_profiler_view {
	stilb_ui_rect names, area;      /* the column of names at the left, and the lanes */
	double begin_ns, pixels_per_ns; /* begin_ns: the time at the area's left edge */
	float level;                    /* height of a line of text, pixels */
	stilb_ui_action action;         /* what the user does with the area */
} ui_profiler_view;

/* ns without its fraction, clamped to 0..UINT64_MAX; 0 for NaN. */
static inline uint64_t ui_profiler_whole_ns(double ns)
{
	return ns > 0.0 ? ns < 0x1p63 ? (uint64_t)ns : UINT64_MAX : 0;
}

/* Pixels that the curves need for lines of text of this height. */
float ui_profiler_counters_height(const stilb_ui_profiler *profiler, float level);

/* Draws a curve for each counter from y = top on downwards, and a tooltip with the value under the mouse. */
void ui_profiler_draw_counters(stilb_ui_profiler *profiler, stilb_ui *ui, const ui_profiler_view *view, float top);

#endif
