/*
 * engine trace_view: the profiler's timeline over a trace file instead of over this process.
 *
 * Life cycle.  stilb_engine_trace_view_create -> stilb_engine_trace_view_frame until *close -> ..._destroy.
 * Threads.     All [main-thread].
 */
#ifndef STILB_ENGINE_TRACE_VIEW_H
#define STILB_ENGINE_TRACE_VIEW_H

#include "base/base.h"
#include "profiler/prof_snapshot.h"
#include "ui/ui_draw.h"

typedef struct stilb_engine_trace_view stilb_engine_trace_view;

typedef struct stilb_engine_trace_view_desc {
	const stilb_prof_snapshot *trace; /* with at least one frame; the caller's, who keeps it until destroy */
	uint32_t frame;                   /* index of the frame shown at first; the history holds the 100 around it */
	uint32_t width, height;           /* 1..16384 */
	bool window;                      /* else there is only the picture in memory */
	stilb_ui_aa aa;
	const char *gpu; /* NULL: the best */
} stilb_engine_trace_view_desc;

/* STILB_ERROR_WINDOW: no window can be opened here, without one it would do. */
stilb_result stilb_engine_trace_view_create(const stilb_engine_trace_view_desc *desc, stilb_engine_trace_view **view);
void stilb_engine_trace_view_destroy(stilb_engine_trace_view *view);

/* Waits for the user to do something, a tenth of a second at most, and draws. *close: the user wants out. */
stilb_result stilb_engine_trace_view_frame(stilb_engine_trace_view *view, bool *close);

/* The last picture as .png or .exr. */
stilb_result stilb_engine_trace_view_screenshot(stilb_engine_trace_view *view, const char *path);

#endif
