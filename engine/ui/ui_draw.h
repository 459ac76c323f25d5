/*
 * ui_draw: shapes and text as triangles, in one draw list. What stands over the picture is drawn with these alone.
 *
 * Coordinates  are pixels from the picture's top left corner, y down; the first pixel's centre is at (0.5, 0.5).
 *              Colours are sRGB with straight alpha and are blended in linear light.
 * Edges        are feathered: a shape's inside ends half a pixel before its edge, and a ring of vertices without alpha
 *              lies half a pixel behind it, so across the edge there is a ramp one pixel wide, which is what a pixel
 *              square would be covered by. What lies on pixel edges stays sharp, what is thinner than a pixel gets less
 *              alpha instead of less width, and needs no multisampling. docs/ui.md says how and how exactly.
 * Order        of the calls is the order from back to front.
 * Life cycle.  A stilb_ui owns its list (stilb_ui_list) and begins and records it. By itself: a zero-initialised list,
 *              stilb_ui_list_begin once a frame, then shapes; stilb_ui_list_finish.
 * Threads.     [one-writer] per list.
 * Memory.      A list grows and keeps what it has, so a steady frame allocates nothing. Without memory shapes are left
 *              out, and recording the list fails.
 */
#ifndef STILB_UI_DRAW_H
#define STILB_UI_DRAW_H

#include "base/base.h"
#include "render/render.h"

typedef struct stilb_ui_point {
	float x, y;
} stilb_ui_point;

typedef struct stilb_ui_rect {
	float x0, y0, x1, y1; /* left, top, right, bottom; nothing in it when x1 <= x0 or y1 <= y0 */
} stilb_ui_rect;

typedef struct stilb_ui_color {
	uint8_t r, g, b, a; /* sRGB; straight alpha */
} stilb_ui_color;

/* 0xRRGGBB, opaque. [any-thread] */
static inline stilb_ui_color stilb_ui_rgb(uint32_t rgb)
{
	return (stilb_ui_color){(uint8_t)(rgb >> 16), (uint8_t)(rgb >> 8), (uint8_t)rgb, 255};
}

/* The color with its alpha times opacity, 0..1. [any-thread] */
stilb_ui_color stilb_ui_fade(stilb_ui_color color, float opacity);

/* Between from and to: t 0..1, in sRGB. [any-thread] */
stilb_ui_color stilb_ui_mix(stilb_ui_color from, stilb_ui_color to, float t);

/* Black or white, whichever is easier to read on background (opaque): WCAG 2 contrast. [any-thread] */
stilb_ui_color stilb_ui_text_color_on(stilb_ui_color background);

/* ---- rectangles --------------------------------------------------------------------------------------------------
 * Layout is cutting: a strip is cut off an area, and the area is what is left. All [any-thread]. */

static inline stilb_ui_rect stilb_ui_cut_left(stilb_ui_rect *area, float width)
{
	float x = area->x0;
	area->x0 = x + width < area->x1 ? x + width : area->x1;
	return (stilb_ui_rect){x, area->y0, area->x0, area->y1};
}

static inline stilb_ui_rect stilb_ui_cut_right(stilb_ui_rect *area, float width)
{
	float x = area->x1;
	area->x1 = x - width > area->x0 ? x - width : area->x0;
	return (stilb_ui_rect){area->x1, area->y0, x, area->y1};
}

static inline stilb_ui_rect stilb_ui_cut_top(stilb_ui_rect *area, float height)
{
	float y = area->y0;
	area->y0 = y + height < area->y1 ? y + height : area->y1;
	return (stilb_ui_rect){area->x0, y, area->x1, area->y0};
}

static inline stilb_ui_rect stilb_ui_cut_bottom(stilb_ui_rect *area, float height)
{
	float y = area->y1;
	area->y1 = y - height > area->y0 ? y - height : area->y0;
	return (stilb_ui_rect){area->x0, area->y1, area->x1, y};
}

/* Smaller by margin on all sides (larger where it is negative). */
static inline stilb_ui_rect stilb_ui_inset(stilb_ui_rect rect, float margin)
{
	return (stilb_ui_rect){rect.x0 + margin, rect.y0 + margin, rect.x1 - margin, rect.y1 - margin};
}

static inline bool stilb_ui_contains(stilb_ui_rect rect, float x, float y)
{
	return x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
}

static inline bool stilb_ui_is_empty(stilb_ui_rect rect)
{
	return !(rect.x1 > rect.x0 && rect.y1 > rect.y0);
}

/* What both have in common. */
stilb_ui_rect stilb_ui_intersection(stilb_ui_rect a, stilb_ui_rect b);

/* ---- the list ---------------------------------------------------------------------------------------------------- */

/* How edges are smoothed. */
typedef enum stilb_ui_aa {
	STILB_UI_AA_FEATHER, /* half a pixel in, half a pixel out */
	STILB_UI_AA_ARTICLE, /* a ring outside alone, corners by half the sum of the normals: shapes grow, corners thin */
	STILB_UI_AA_OFF,     /* hard edges */
} stilb_ui_aa;

/* Triangles first_index on, drawn within the clip rectangle. */
typedef struct stilb_ui_draw_command {
	float clip[4]; /* left, top, right, bottom, whole pixels */
	uint32_t first_index, index_count;
} stilb_ui_draw_command;

#define STILB_UI_CLIP_DEPTH 32

/* Triangles with one texture, that of the glyphs, which is white at uv 0, 0. Read it; what writes it is below. */
typedef struct stilb_ui_draw_list {
	stilb_ui_aa aa;
	stilb_render_vertex_2d *vertices;
	uint32_t *indices;
	stilb_ui_draw_command *commands; /* no two in a row have the same clip */
	uint32_t vertex_count, index_count, command_count;
	uint32_t vertex_capacity, index_capacity, command_capacity;
	stilb_ui_rect clips[STILB_UI_CLIP_DEPTH]; /* [clip_count]; the first is the picture */
	uint32_t clip_count;
	bool out_of_memory; /* since begin: something is missing */
} stilb_ui_draw_list;

/* Empties the list for a picture of this size, pixels. */
void stilb_ui_list_begin(stilb_ui_draw_list *list, float width, float height);

/* Frees; accepts NULL and {0}. */
void stilb_ui_list_finish(stilb_ui_draw_list *list);

/* What is drawn until the pop stays within rect, rounded outwards to whole pixels, and within the clips around it. At
 * most STILB_UI_CLIP_DEPTH deep. */
void stilb_ui_clip_push(stilb_ui_draw_list *list, stilb_ui_rect rect);
void stilb_ui_clip_pop(stilb_ui_draw_list *list);

/* The rectangle that is drawn in now. */
stilb_ui_rect stilb_ui_clip(const stilb_ui_draw_list *list);

/* ---- shapes ------------------------------------------------------------------------------------------------------
 * Lengths are pixels. What lies outside the clip costs next to nothing. */

/* Exact at any place and size, down to hair lines. */
void stilb_ui_draw_rect(stilb_ui_draw_list *list, stilb_ui_rect rect, stilb_ui_color color);

/* A frame of this width, inside rect. */
void stilb_ui_draw_rect_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float width, stilb_ui_color color);

/* Corners of this radius, at most half the shorter side. */
void stilb_ui_draw_rounded(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, stilb_ui_color color);
void stilb_ui_draw_rounded_outline(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float width,
                                   stilb_ui_color color);

/* A shadow around a rounded rectangle: full colour at its edge, nothing `reach` pixels away. */
void stilb_ui_draw_shadow(stilb_ui_draw_list *list, stilb_ui_rect rect, float radius, float reach,
                          stilb_ui_color color);

void stilb_ui_draw_circle(stilb_ui_draw_list *list, stilb_ui_point center, float radius, stilb_ui_color color);

void stilb_ui_draw_triangle(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, stilb_ui_point c,
                            stilb_ui_color color);

/* A convex polygon, either way around; count 3..STILB_UI_MAX_POLYGON, no two corners in a row at the same place. */
#define STILB_UI_MAX_POLYGON 64
void stilb_ui_draw_convex(stilb_ui_draw_list *list, const stilb_ui_point *corners, uint32_t count,
                          stilb_ui_color color);

/* From a to b, with square ends at both. */
void stilb_ui_draw_line(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width,
                        stilb_ui_color color);

/* One line through all points, of any count, with mitred corners; closed: back to the first. Points that lie on the one
 * before are left out. */
void stilb_ui_draw_polyline(stilb_ui_draw_list *list, const stilb_ui_point *points, uint32_t count, bool closed,
                            float width, stilb_ui_color color);

/* A line from a to b with a head at b, `head` pixels long. */
void stilb_ui_draw_arrow(stilb_ui_draw_list *list, stilb_ui_point a, stilb_ui_point b, float width, float head,
                         stilb_ui_color color);

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* A typeface at one size, its glyphs ready. */
typedef struct stilb_ui_font stilb_ui_font;

typedef enum stilb_ui_align {
	STILB_UI_ALIGN_LEFT,
	STILB_UI_ALIGN_CENTER,
	STILB_UI_ALIGN_RIGHT,
} stilb_ui_align;

/* The way to the next line, whole pixels; the letters with their accents and tails fit in it. */
float stilb_ui_font_line(const stilb_ui_font *font);

/* From the top of a line to its baseline, whole pixels. */
float stilb_ui_font_ascent(const stilb_ui_font *font);

/* Length of UTF-8 text in one line, pixels. All digits are equally wide. What is no character, or not in the font
 * (which has Latin-1 and some symbols), counts and shows as a box. */
float stilb_ui_text_width(const stilb_ui_font *font, const char *text);

/* Text from x on, on a baseline. Returns where it ends. */
float stilb_ui_draw_text_at(stilb_ui_draw_list *list, const stilb_ui_font *font, float x, float baseline,
                            stilb_ui_color color, const char *text);

/* Text in rect: aligned, in the middle of its height, cut short with an ellipsis when it is too long, and nothing at
 * all when there is no room for a letter and that. */
void stilb_ui_draw_text(stilb_ui_draw_list *list, const stilb_ui_font *font, stilb_ui_rect rect, stilb_ui_align align,
                        stilb_ui_color color, const char *text);

#endif
