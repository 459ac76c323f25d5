/*
 * engine viewer: a window that shows a picture while it is being made, every pixel of it as it is.
 *
 * The picture fits the window at first; the wheel zooms about the pointer, the left button drags, space fits it again.
 * A line of words stands below it.
 * Life cycle.  stilb_engine_viewer_create -> stilb_engine_viewer_picture whenever there is a newer one, ..._frame until
 * *close
 *              -> ..._destroy.
 * Threads.     All [main-thread].
 */
#ifndef STILB_ENGINE_VIEWER_H
#define STILB_ENGINE_VIEWER_H

#include "base/base.h"
#include "image/image.h"

typedef struct stilb_engine_viewer stilb_engine_viewer;

typedef struct stilb_engine_viewer_desc {
	const char *title;
	uint32_t width, height; /* of the picture; the window is as large, within reason */
	bool window;            /* else there is only what it would show, in memory */
	bool validate;
	const char *gpu; /* NULL: the best */
} stilb_engine_viewer_desc;

/* STILB_ERROR_WINDOW, STILB_ERROR_DEVICE: nothing can be shown here. */
stilb_result stilb_engine_viewer_create(const stilb_engine_viewer_desc *desc, stilb_engine_viewer **viewer);
void stilb_engine_viewer_destroy(stilb_engine_viewer *viewer);

/* Copies srgb: 3 bytes a pixel, row 0 on top, of the size given at create. */
void stilb_engine_viewer_picture(stilb_engine_viewer *viewer, const uint8_t *srgb);

/* Waits for the user to do something, at most `seconds`, and draws. *close: the user wants out. STILB_ERROR_WINDOW: the
 * window's display has gone, and only destroy may follow. */
stilb_result stilb_engine_viewer_frame(stilb_engine_viewer *viewer, const char *words, double seconds, bool *close);

#endif
