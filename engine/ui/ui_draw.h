/*
 * ui_draw: shapes and text as triangles in one draw list. Everything drawn over the picture is made of these.
 *
 * Coordinates  are pixels from the picture's top left corner, y down; the first pixel's centre is at (0.5, 0.5).
 *              Colours are sRGB with straight alpha and are blended in linear light.
 * Edges        are feathered: a shape's full inside ends half a pixel before its edge, and a ring of vertices without
 *              alpha lies half a pixel beyond it. Across the edge alpha is then a ramp one pixel wide, which is how
 *              much of a pixel square at that distance the shape covers. Edges along pixel boundaries stay sharp,
 *              a line thinner than a pixel gets less alpha instead of less width, and no multisampling is needed.
 *              docs/ui.md derives this and gives its errors.
 * Order        of the calls is the order of drawing: later shapes lie over earlier ones.
 * Values.      A shape with a NaN coordinate, or a size <= 0, draws nothing. Positions of text are finite.
 * Life cycle.  A stilb_ui owns a list (stilb_ui_list), begins it and records it. A list of one's own: zero-initialise
 *              it -> stilb_ui_list_begin once a frame, then shapes -> stilb_ui_list_finish.
 * Threads.     [one-writer] per list: any thread, but one at a time. Functions without a list are [any-thread].
 * Memory.      A list grows and keeps what it has, so a steady frame allocates nothing. Without memory shapes are left
 *              out, out_of_memory is set, and recording the list fails.
 * Example.     A button-like shape with a word in it:
 *
 *   stilb_ui_draw_list *list = stilb_ui_list(ui);
 *   stilb_ui_rect rect = {20, 20, 120, 44};
 *   stilb_ui_draw_rounded(list, rect, 4.0f, stilb_ui_rgb(0x2d343e));
 *   stilb_ui_draw_text(list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), rect, STILB_UI_ALIGN_CENTER,
 *                      stilb_ui_rgb(0xffffff), "Open");
 */
#ifndef STILB_UI_DRAW_H
#define STILB_UI_DRAW_H

#include "base/base.h"
#include "render/render.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_ui_point {
	float x, y;
} stilb_ui_point;

typedef struct stilb_ui_rect {
	float x0, y0, x1, y1; /* left, top, right, bottom; empty if x1 <= x0 or y1 <= y0 */
} stilb_ui_rect;

typedef struct stilb_ui_color {
	uint8_t r, g, b, a; /* sRGB codes; a: straight alpha, 255 is opaque */
} stilb_ui_color;

/* 0xRRGGBB, opaque. [any-thread] */
static inline stilb_ui_color stilb_ui_rgb(uint32_t rgb)
{
	return (stilb_ui_color){(uint8_t)(rgb >> 16), (uint8_t)(rgb >> 8), (uint8_t)rgb, 255};
}

/* The color with its alpha multiplied by opacity, which is clamped to 0..1. [any-thread] */
stilb_ui_color stilb_ui_fade(stilb_ui_color color, float opacity);

/* Linear interpolation of the four sRGB codes: from at t = 0, to at t = 1; t is clamped to 0..1. [any-thread] */
stilb_ui_color stilb_ui_mix(stilb_ui_color from, stilb_ui_color to, float t);

/* Black or white, whichever has the higher contrast to the background, whose alpha is ignored. Source: WCAG 2.1,
 * "contrast ratio". [any-thread] */
stilb_ui_color stilb_ui_text_color_on(stilb_ui_color background);

/* ---- rectangles --------------------------------------------------------------------------------------------------
 * Layout is done by cutting: a strip is cut off one side of *area and returned; *area becomes the rest. A strip is
 * never larger than the area was. All [any-thread]. A title, a gap, and two columns of which `area` is the right one:
 *
 *     stilb_ui_rect title = stilb_ui_cut_top(&area, 24.0f);
 *     stilb_ui_cut_top(&area, 6.0f);
 *     stilb_ui_rect left = stilb_ui_cut_left(&area, 200.0f); */

/* Cuts off a strip `width` pixels wide (as far as the area is) at the left. */
static inline stilb_ui_rect stilb_ui_cut_left(stilb_ui_rect *area, float width)
{
	float x = area->x0;
	area->x0 = x + width < area->x1 ? x + width : area->x1;
	return (stilb_ui_rect){x, area->y0, area->x0, area->y1};
}

/* Cuts off a strip `width` pixels wide at the right. */
static inline stilb_ui_rect stilb_ui_cut_right(stilb_ui_rect *area, float width)
{
	float x = area->x1;
	area->x1 = x - width > area->x0 ? x - width : area->x0;
	return (stilb_ui_rect){area->x1, area->y0, x, area->y1};
}

/* Cuts off a strip `height` pixels high at the top. */
static inline stilb_ui_rect stilb_ui_cut_top(stilb_ui_rect *area, float height)
{
	float y = area->y0;
	area->y0 = y + height < area->y1 ? y + height : area->y1;
	return (stilb_ui_rect){area->x0, y, area->x1, area->y0};
}

/* Cuts off a strip `height` pixels high at the bottom. */
static inline stilb_ui_rect stilb_ui_cut_bottom(stilb_ui_rect *area, float height)
{
	float y = area->y1;
	area->y1 = y - height > area->y0 ? y - height : area->y0;
	return (stilb_ui_rect){area->x0, area->y1, area->x1, y};
}

/* The rectangle with each side moved inwards by margin pixels, outwards if margin is negative. */
static inline stilb_ui_rect stilb_ui_inset(stilb_ui_rect rect, float margin)
{
	return (stilb_ui_rect){rect.x0 + margin, rect.y0 + margin, rect.x1 - margin, rect.y1 - margin};
}

/* True if the point is inside, or on the left or top edge. */
static inline bool stilb_ui_contains(stilb_ui_rect rect, float x, float y)
{
	return x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
}

/* True if the rectangle has no area, and also if one of its sides is NaN. */
static inline bool stilb_ui_is_empty(stilb_ui_rect rect)
{
	return !(rect.x1 > rect.x0 && rect.y1 > rect.y0);
}

/* The part that a and b share; empty if they do not overlap. */
stilb_ui_rect stilb_ui_intersection(stilb_ui_rect a, stilb_ui_rect b);

/* ---- the list ---------------------------------------------------------------------------------------------------- */

/* How edges are smoothed. */
typedef enum stilb_ui_aa {
	STILB_UI_AA_FEATHER, /* a ramp from half a pixel inside the edge to half a pixel outside */
	STILB_UI_AA_ARTICLE, /* for comparison: a ring outside the edge only, with corners moved by half the sum of the
	                        normals. Shapes grow by half a pixel, and sharp corners become thin */
	STILB_UI_AA_OFF,     /* hard edges */
} stilb_ui_aa;

/* Triangles that are drawn within one clip rectangle: indices[first_index .. first_index + index_count - 1]. */
typedef struct stilb_ui_draw_command {
	float clip[4];                     /* left, top, right, bottom, whole pixels */
	uint32_t first_index, index_count; /* into the list's indices; multiples of 3 */
} stilb_ui_draw_command;

#define STILB_UI_CLIP_DEPTH 32

/* Triangles with one texture, that of the glyphs (stilb_ui_glyphs), which is white at uv (0, 0), for shapes without
 * texture. To be read by whoever draws the list; only the functions below write it, but aa may be set at any time.
 * Drawing it without stilb_ui_record:
 *
 *     for each command, in order: set the scissor rectangle to its clip, and draw its triangles without culling.
 *     A vertex's colour is its sRGB code made linear and premultiplied by its alpha; interpolate that, and multiply it
 *     by the texture's coverage at uv, filtered linearly. Blend over the picture in linear light. */
typedef struct stilb_ui_draw_list {
	stilb_ui_aa aa;                   /* how the shapes added from now on are smoothed */
	stilb_render_vertex_2d *vertices; /* [vertex_count] */
	uint32_t *indices;                /* [index_count] into vertices, three for each triangle */
	stilb_ui_draw_command *commands;  /* [command_count] in drawing order, which together hold all indices; no two in a
	                                     row have the same clip */
	uint32_t vertex_count, index_count, command_count;
	uint32_t vertex_capacity, index_capacity, command_capacity;
	stilb_ui_rect clips[STILB_UI_CLIP_DEPTH]; /* [clip_count], each within the one before; the first is the picture */
	uint32_t clip_count;                      /* 0: the list has not begun */
	bool out_of_memory;                       /* memory was short since begin: shapes are missing */
} stilb_ui_draw_list;

/* Empties the list and its clips for a picture of this size, pixels, >= 0. [one-writer] */
void stilb_ui_list_begin(stilb_ui_draw_list *list, float width, float height);

/* Frees and zeroes the list; accepts NULL and {0}. [one-writer] */
void stilb_ui_list_finish(stilb_ui_draw_list *list);

/* Until the matching pop, drawing is clipped to rect, rounded outwards to whole pixels, and to the clips pushed before.
 * At most STILB_UI_CLIP_DEPTH - 1 deep. [one-writer] */
void stilb_ui_clip_push(stilb_ui_draw_list *list, stilb_ui_rect rect);
void stilb_ui_clip_pop(stilb_ui_draw_list *list);

/* The current clip: the intersection of all pushed ones with the picture; may be empty. [one-writer] */
stilb_ui_rect stilb_ui_clip(const stilb_ui_draw_list *list);

/* ---- shapes ------------------------------------------------------------------------------------------------------
 * Lengths are pixels. A shape outside the clip adds no triangles. All [one-writer], between stilb_ui_list_begin and the
 * use of the list. */

/* Feathered exactly: every pixel gets the share of it that the rectangle covers, at any place and size. */
void stilb_ui_draw_rect(stilb_ui_draw_list *list, stilb_ui_rect rect, stilb_ui_color color);

/* The border of rect, `width` thick towards the inside. */
void stilb_ui_draw_rect_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float width, stilb_ui_color color);

/* A rectangle with corners of this radius, which is reduced to half the shorter side if it is larger; the outline's
 * thickness lies inside rect. Arcs deviate from a circle by 0.02 pixels at most, up to radii of some 65 pixels. */
void stilb_ui_draw_rounded(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, stilb_ui_color color);
void stilb_ui_draw_rounded_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float width,
                                   stilb_ui_color color);

/* A shadow around a rounded rectangle: color at its edge, falling to nothing `reach` pixels outside of it. Nothing is
 * drawn inside: draw the shadow first, then the rectangle. */
void stilb_ui_draw_shadow(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float reach,
                          stilb_ui_color color);

/* A filled disk. */
void stilb_ui_draw_circle(stilb_ui_draw_list *list, stilb_ui_point center, float radius, stilb_ui_color color);

/* A triangle, either way around. */
void stilb_ui_draw_triangle(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, stilb_ui_point c,
                            stilb_ui_color color);

/* A convex polygon, either way around: corners[0 .. count - 1], count 3..STILB_UI_MAX_POLYGON, no two consecutive ones
 * equal. */
#define STILB_UI_MAX_POLYGON 64
void stilb_ui_draw_convex(stilb_ui_draw_list *list, const stilb_ui_point *corners, uint32_t count,
                          stilb_ui_color color);

/* A line from a to b that ends there squarely, without round caps. */
void stilb_ui_draw_line(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width,
                        stilb_ui_color color);

/* One line through points[0 .. count - 1], of any count, with mitred corners that reach at most four half widths; if
 * closed, also from the last point back to the first. A point equal to the one before it is skipped. */
void stilb_ui_draw_polyline(stilb_ui_draw_list *list, const stilb_ui_point *points, uint32_t count, bool closed,
                            float width, stilb_ui_color color);

/* A line from a to b with an arrowhead at b, `head` pixels long and wide, or as long as the line if that is shorter. */
void stilb_ui_draw_arrow(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width, float head,
                         stilb_ui_color color);

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* A typeface at one size with its glyphs in the texture, from stilb_ui_font_get; lives as long as its stilb_ui. It has
 * ASCII, Latin-1 and some symbols; other characters and bytes that are not UTF-8 show as a box. */
typedef struct stilb_ui_font stilb_ui_font;

typedef enum stilb_ui_align {
	STILB_UI_ALIGN_LEFT,
	STILB_UI_ALIGN_CENTER,
	STILB_UI_ALIGN_RIGHT,
} stilb_ui_align;

/* The distance from one line to the next, whole pixels; letters with accents and descenders fit in it. [any-thread] */
float stilb_ui_font_line(const stilb_ui_font *font);

/* The distance from the top of a line to its baseline, whole pixels. [any-thread] */
float stilb_ui_font_ascent(const stilb_ui_font *font);

/* Width of UTF-8 text in one line, pixels. All digits are equally wide. [any-thread] */
float stilb_ui_text_width(const stilb_ui_font *font, const char *text);

/* Draws UTF-8 text from x on, its baseline at the y `baseline`, rounded to whole pixels. Returns the x at which the
 * text ends, also if it is clipped. [one-writer] */
float stilb_ui_draw_text_at(stilb_ui_draw_list *list, const stilb_ui_font *font, float x, float baseline,
                            stilb_ui_color color, const char *text);

/* Draws UTF-8 text within rect: horizontally as `align` says, vertically in the middle. A text that is too long is cut
 * short with an ellipsis; if not even one letter and the ellipsis fit, nothing is drawn. [one-writer] */
void stilb_ui_draw_text(stilb_ui_draw_list *list, const stilb_ui_font *font, stilb_ui_rect rect, stilb_ui_align align,
                        stilb_ui_color color, const char *text);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
