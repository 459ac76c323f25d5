/*
 * ui_profiler: the frame profiler's window: which thread did what in a frame, and what it waited for.
 *
 *   headline          the frame in words: how long, what limits it, who waited for whom
 *   history           the last 100 frames as bars; a click on a bar shows that frame
 *   table             the frame's zones: calls, inclusive, self, off the CPU
 *   timeline          a lane for each thread and the GPU; wheel zooms, drag pans, double click fits a zone
 *
 * It shows the slowest of the last 100 frames unless told otherwise: that picture stands still until a slower one comes
 * or it is 100 frames old. Frozen, the history stands still as well; recording goes on behind it.
 *
 * Life cycle.  stilb_ui_profiler_create -> stilb_ui_profiler_draw once a frame -> stilb_ui_profiler_destroy.
 * Threads.     [main-thread]; everything it shows comes from snapshots (prof_snapshot.h), so nothing else is held up.
 * Memory.      Grows with the largest frame shown, then stays.
 */
#ifndef STILB_UI_PROFILER_H
#define STILB_UI_PROFILER_H

#include "base/base.h"
#include "profiler/prof_capture.h"
#include "profiler/prof_snapshot.h"
#include "ui/ui.h"

typedef struct stilb_ui_profiler stilb_ui_profiler;

typedef struct stilb_ui_profiler_desc {
	/* Where it looks; NULL: at what this process records (stilb_prof_snapshot_take, stilb_prof_frame_stats_take). take
	 * may give more than it was asked for; what it gives is finished by stilb_prof_snapshot_finish. */
	int (*take)(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window);
	void (*frames)(void *user, stilb_prof_frame_stats *stats, double budget_ms);
	void *user;
	double budget_ms; /* a frame below it is never called a spike; 0: none */
	bool whole;       /* a recording that is over: it fills the picture, and there is nothing to freeze */
} stilb_ui_profiler_desc;

/* desc may be NULL for {0}. STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_ui_profiler_create(const stilb_ui_profiler_desc *desc, stilb_ui_profiler **profiler);
void stilb_ui_profiler_destroy(stilb_ui_profiler *profiler);

/* Between stilb_ui_begin and stilb_ui_end. [main-thread] */
void stilb_ui_profiler_draw(stilb_ui_profiler *profiler, stilb_ui *ui);

/* The space key. Frozen at the frame that is shown. [main-thread] */
void stilb_ui_profiler_freeze(stilb_ui_profiler *profiler, bool frozen);
bool stilb_ui_profiler_frozen(const stilb_ui_profiler *profiler);

/* Shows the frame of that number and freezes, as a click on its bar does. [main-thread] */
void stilb_ui_profiler_show(stilb_ui_profiler *profiler, uint64_t frame_number);

#endif
