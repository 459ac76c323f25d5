/*
 * engine trace_view: the profiler's window (ui/ui_profiler.h) over a trace file instead of over this process. It fills
 * the picture. stilb_engine_trace_view_table has what keys and mouse do, and H shows it.
 *
 * Life cycle.  stilb_engine_trace_view_create -> stilb_engine_trace_view_frame until *close ->
 *              stilb_engine_trace_view_destroy.
 * Threads.     [main-thread]: the thread that creates it makes all other calls.
 * Example.     In a window, from the first frame on:
 *
 *   stilb_engine_trace_view_desc desc = {.trace = &snapshot, .width = 1280, .height = 720, .window = true};
 *   stilb_engine_trace_view *view;
 *   stilb_result result = stilb_engine_trace_view_create(&desc, &view);
 *   for (bool close = false; result == STILB_OK && !close;)
 *       result = stilb_engine_trace_view_frame(view, &close);
 *   stilb_engine_trace_view_destroy(view);
 */
#ifndef STILB_ENGINE_TRACE_VIEW_H
#define STILB_ENGINE_TRACE_VIEW_H

#include "base/base.h"
#include "input/input_actions.h"
#include "profiler/prof_snapshot.h"
#include "ui/ui_draw.h"

typedef struct stilb_engine_trace_view stilb_engine_trace_view;

typedef struct stilb_engine_trace_view_desc {
	const stilb_prof_snapshot *trace; /* the caller keeps it until destroy */
	uint32_t frame;                   /* index of the frame shown at first; the history has the 100 frames around it */
	uint32_t width, height;           /* of the picture, pixels, 1..16384 */
	bool window;                      /* true: in a window; false: the picture is drawn to memory */
	stilb_ui_aa aa;                   /* how edges are smoothed */
	const char *gpu;                  /* a number or a part of a name as `stilb info` prints them; NULL: the best */
} stilb_engine_trace_view_desc;

/* What keys and mouse do in the window; no row is the program's to act on. [any-thread] */
stilb_input_table stilb_engine_trace_view_table(void);

/* Opens the device and, if asked for, the window. On failure *view is NULL. STILB_ERROR_ARGUMENT: the trace has no such
 * frame. STILB_ERROR_WINDOW: no window can be opened here; without one it works. STILB_ERROR_DEVICE,
 * STILB_ERROR_MEMORY. */
stilb_result stilb_engine_trace_view_create(const stilb_engine_trace_view_desc *desc, stilb_engine_trace_view **view);

/* Closes the window and frees everything. NULL is accepted. */
void stilb_engine_trace_view_destroy(stilb_engine_trace_view *view);

/* Waits for input, a tenth of a second at most, and draws the window anew. *close: the user closed the window.
 * STILB_ERROR_WINDOW: the window's display has gone, and only destroy may follow. STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_trace_view_frame(stilb_engine_trace_view *view, bool *close);

/* Writes the last picture as .png, .exr or .hdr. Fails as stilb_render_read_image and stilb_image_save do. */
stilb_result stilb_engine_trace_view_screenshot(stilb_engine_trace_view *view, const char *path);

#endif
