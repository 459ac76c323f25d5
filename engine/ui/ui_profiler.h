/*
 * ui_profiler: the frame profiler's window: which thread did what in a frame, and what it waited for.
 *
 *   headline          the frame in words: how long, what limits it, who waited for whom
 *   history           the last 100 frames as bars; a click on a bar shows that frame
 *   table             the frame's zones: calls, inclusive, self, off the CPU
 *   timeline          a lane (row) for each thread and the GPU; wheel zooms, drag pans, double click fits a zone
 *   counters          a curve for each recorded counter, below the lanes
 *
 * Which frame.  The slowest of the last 100 unless told otherwise: the window stands still until a slower frame comes
 *               or that one is 100 frames old. The user can choose the latest instead, or one frame by its bar. Frozen,
 *               the history stands still as well; recording goes on behind it.
 * Size.         The window fills the picture's width and as much of its height as it needs, at the bottom. A picture
 *               under 480 x 270 pixels gets one line of text instead.
 * Life cycle.   stilb_ui_profiler_create -> stilb_ui_profiler_draw once a frame -> stilb_ui_profiler_destroy.
 * Threads.      [main-thread]: the thread that creates it makes all other calls. Everything it shows comes from
 *               snapshots (prof_snapshot.h), so no thread that records is held up.
 * Memory.       Grows with the largest frame shown and is kept. If there is none left, the window says so and goes on.
 * Example.      Within a frame of the user interface:
 *
 *   stilb_ui_profiler *profiler;
 *   stilb_result result = stilb_ui_profiler_create(NULL, &profiler);
 *   ...
 *   stilb_ui_begin(ui, &input);
 *   stilb_ui_profiler_draw(profiler, ui);
 *   stilb_ui_end(ui);
 *   ...
 *   stilb_ui_profiler_destroy(profiler);
 */
#ifndef STILB_UI_PROFILER_H
#define STILB_UI_PROFILER_H

#include "base/base.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_snapshot.h"
#include "ui/ui.h"

typedef struct stilb_ui_profiler stilb_ui_profiler;

typedef struct stilb_ui_profiler_desc {
	/* The source of what is shown; both NULL: what this process records (stilb_prof_snapshot_take,
	 * stilb_prof_frame_stats_take). Both are called by stilb_ui_profiler_draw, on its thread, with `user`.
	 * take:   fills the snapshot with the frames of the window, or with more; returns 0 or -ENOMEM. The snapshot is {0}
	 *         or what an earlier call filled, and is given to stilb_prof_snapshot_finish at the end.
	 * frames: fills stats with the times of the last frames. */
	int (*take)(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window);
	void (*frames)(void *user, stilb_prof_frame_stats *stats, double budget_ms);
	void *user;
	double budget_ms; /* milliseconds that a frame may take: a shorter one is never called a spike; 0: no such limit */
	bool whole;       /* what is shown is a finished recording: the window fills the picture, and nothing is frozen */
} stilb_ui_profiler_desc;

/* desc may be NULL for {0}; take and frames are both set or both NULL. On failure *profiler is NULL.
 * STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_ui_profiler_create(const stilb_ui_profiler_desc *desc, stilb_ui_profiler **profiler);

/* NULL is accepted. [main-thread] */
void stilb_ui_profiler_destroy(stilb_ui_profiler *profiler);

/* Takes what was recorded since the last call and draws the window, between stilb_ui_begin and stilb_ui_end of ui; also
 * handles its mouse and keys. [main-thread] */
void stilb_ui_profiler_draw(stilb_ui_profiler *profiler, stilb_ui *ui);

/* Freezes the history, with the frame that is shown, or lets it go on: as the space key does. [main-thread] */
void stilb_ui_profiler_freeze(stilb_ui_profiler *profiler, bool frozen);

/* True while the history stands still. [main-thread] */
bool stilb_ui_profiler_frozen(const stilb_ui_profiler *profiler);

/* Shows the frame of that number (stilb_prof_frame.number) and freezes, as a click on its bar does. If the frame is no
 * longer held, the window says so. [main-thread] */
void stilb_ui_profiler_show(stilb_ui_profiler *profiler, uint64_t frame_number);

#endif
