/*
 * bake_pack: rectangles beside one another on square pages.
 *
 * By the skyline of stb_rect_pack, tallest first. What does not fit on a page goes to the next one: nothing is left
 * out. [any-thread]
 */
#ifndef STILB_BAKE_PACK_H
#define STILB_BAKE_PACK_H

#include "base/base.h"

typedef struct stilb_bake_rect {
	uint32_t width, height; /* >= 1 and at most the side of a page */
	uint32_t page, x, y;    /* out: its page, and its corner nearest to (0, 0) */
} stilb_bake_rect;

#define STILB_BAKE_MAX_SIDE 16384u /* of a page */

/* Places the rectangles on *page_count pages of side x side, 1..STILB_BAKE_MAX_SIDE; 0 pages for no rectangles.
 * STILB_ERROR_MEMORY. */
stilb_result stilb_bake_pack(stilb_bake_rect *rects, uint32_t count, uint32_t side, uint32_t *page_count);

#endif
