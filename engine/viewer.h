/*
 * engine viewer: a window that shows a picture while it is being made, pixel for pixel.
 *
 * At first the picture fits the window; if that enlarges it, then by a whole number, so that its pixels stay equal
 * squares. stilb_engine_viewer_table has what keys and mouse do, and H shows it. A line of text is below the picture.
 *
 * Life cycle.  stilb_engine_viewer_create -> stilb_engine_viewer_picture whenever the picture has changed, and
 *              stilb_engine_viewer_frame until *close -> stilb_engine_viewer_destroy.
 * Threads.     [main-thread]: the thread that creates it makes all other calls.
 * Example.     Twenty looks a second at a picture that others make:
 *
 *   stilb_engine_viewer_desc desc = {.title = "cornell", .width = 640, .height = 480, .window = true};
 *   stilb_engine_viewer *viewer;
 *   stilb_result result = stilb_engine_viewer_create(&desc, &viewer);
 *   for (bool close = false; result == STILB_OK && !close;) {
 *       stilb_engine_viewer_picture(viewer, srgb);
 *       result = stilb_engine_viewer_frame(viewer, "40 %", 0.05, &close);
 *   }
 *   stilb_engine_viewer_destroy(viewer);
 */
#ifndef STILB_ENGINE_VIEWER_H
#define STILB_ENGINE_VIEWER_H

#include "base/base.h"
#include "image/image.h"
#include "input/input_actions.h"

typedef struct stilb_engine_viewer stilb_engine_viewer;

typedef struct stilb_engine_viewer_desc {
	const char *title;      /* of the window, UTF-8 */
	uint32_t width, height; /* of the picture, pixels, >= 1; the window is as large, but within 384 and 1280 x 800 */
	bool window;            /* false: the content of the window is drawn to memory instead */
	bool validate;          /* with Vulkan's validation layer */
	const char *gpu;        /* a number or a part of a name as `stilb info` prints them; NULL: the best */
} stilb_engine_viewer_desc;

/* What keys and mouse do in the window; no row is the program's to act on. [any-thread] */
stilb_input_table stilb_engine_viewer_table(void);

/* Opens the device and, if asked for, the window; the picture is black. On failure *viewer is NULL. STILB_ERROR_WINDOW,
 * STILB_ERROR_DEVICE: nothing can be shown here. STILB_ERROR_MEMORY. */
stilb_result stilb_engine_viewer_create(const stilb_engine_viewer_desc *desc, stilb_engine_viewer **viewer);

/* Closes the window and frees everything. NULL is accepted. */
void stilb_engine_viewer_destroy(stilb_engine_viewer *viewer);

/* Copies the picture: sRGB codes of red, green and blue for each pixel, rows from the top, of the size given at
 * create. It is shown by the next frame. */
void stilb_engine_viewer_picture(stilb_engine_viewer *viewer, const uint8_t *srgb);

/* Waits for input, at most `seconds` (>= 0), and draws with `words` below the picture. *close: the user closed the
 * window. STILB_ERROR_WINDOW: the window's display has gone, and only destroy may follow. STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_viewer_frame(stilb_engine_viewer *viewer, const char *words, double seconds, bool *close);

#endif
