/*
 * debug_draw: lines, boxes, spheres, axes and text in the world, from any thread at any time, to see what a program
 *             thinks.
 *
 * How it works.  A call writes records of 32 bytes, one for each line or letter, to memory of the calling thread. When
 *                the frame is replayed all records are gathered, sorted, and drawn in one pass over the picture: after
 *                the tone map, so that colours are those that were asked for, and below the windows of the user
 *                interface.
 * Which frame.   A call that has returned before stilb_debug_frame is seen in that frame, one that runs at the same
 *                time in that frame or in the next; in the engine that moment is the beginning of its stage replay.
 *                Each thing is seen in one frame, or for style.seconds.
 * Edges          are smooth: each pixel gets the share that a line of this width covers, at any angle, and ends are
 *                round, so that lines that meet leave no gap. With an alpha below 1 that shows where lines of a shape
 *                overlap.
 * Hidden         is what lies behind the scene's surfaces, sample by sample with four a pixel. What lies on a surface
 *                is seen: lines are tested, along their middle, as if they were a thousandth of their distance nearer,
 *                and by what the surface rises within a pixel. A text is hidden or seen as a whole, by the pixel of its
 *                place. style.on_top: nothing hides it.
 * Order.         What can be hidden comes first, then what is on top; in each lines before texts, and far ones before
 *                near ones, by the middle of a line, as the first camera sees it. What is equally far is ordered by its
 *                content. So the picture is the same, bit for bit, whichever threads drew in whichever order, also of
 *                overlapping and transparent things.
 * Cost.          On the calling thread some 10 ns a line; it takes no lock but for each 1024th. On the frame's thread,
 *                and its pool, some 60 ns a line.
 * Limits.        Memory grows; without memory the frame fails, and nothing is left out without a word. What is drawn
 *                is no part of the stream hash, of dumps, and of stilb_render_read_radiance.
 * Life cycle.    The engine has one: stilb_engine_debug. With a renderer alone: stilb_debug_create -> frames ->
 *                stilb_debug_destroy.
 * Threads.       [any-thread]: any, at any time between create and destroy. [main-thread]: the renderer's.
 * Example.       A job that shows what it has found:
 *
 *   stilb_debug_style red = {.rgba = 0xff4040ff, .width = 2.0f};
 *   stilb_debug_line(debug, eye, target, red);
 *   stilb_debug_sphere(debug, target, 0.5f, red);
 *   stilb_debug_text(debug, target, (stilb_debug_style){.rgba = 0xffffffff, .on_top = true}, "target %u", number);
 */
#ifndef STILB_DEBUG_DRAW_H
#define STILB_DEBUG_DRAW_H

#include "base/base.h"
#include "base/base_math.h"
#include "jobs/job.h"
#include "render/render.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_debug stilb_debug;

#define STILB_DEBUG_THREADS 512u /* that draw at a time, in the process; more are an error of the frame */

/* How something is drawn. */
typedef struct stilb_debug_style {
	uint32_t rgba; /* 0xrrggbbaa: sRGB codes, straight alpha; blended in linear light */
	float width;   /* of lines, pixels, up to STILB_DEBUG_MAX_WIDTH at any distance; 0: 1. Not of text */
	float
		seconds; /* 0: in one frame; > 0: in all frames that begin within this time of the engine's from the first on */
	bool on_top; /* the scene does not hide it */
} stilb_debug_style;

#define STILB_DEBUG_MAX_WIDTH 64.0f

/* ---- drawing ------------------------------------------------------------------------------------------------------
 * Places are in world space, metres, and finite. What lies behind the camera, or nearer than its near plane, is cut
 * off. */

/* A line; from == to: a dot. [any-thread] */
void stilb_debug_line(stilb_debug *debug, const float from[3], const float to[3], stilb_debug_style style);

/* Lines from points[2 i] to points[2 i + 1], i < count: cheaper than one by one. [any-thread] */
void stilb_debug_lines(stilb_debug *debug, const float (*points)[3], uint32_t count, stilb_debug_style style);

/* The twelve edges of the box from low to high, under a transform; NULL: none. The transform may be projective: the
 * inverse of a camera's matrix with the box (-1, -1, 0) to (1, 1, 1) shows what that camera sees. [any-thread] */
void stilb_debug_box(stilb_debug *debug, const float low[3], const float high[3], const stilb_mat4 *transform,
                     stilb_debug_style style);

/* A circle of 48 lines around the axis, which need not be of unit length, but is not 0. radius >= 0. [any-thread] */
void stilb_debug_circle(stilb_debug *debug, const float center[3], const float axis[3], float radius,
                        stilb_debug_style style);

/* Three circles around the axes of the world. radius >= 0. [any-thread] */
void stilb_debug_sphere(stilb_debug *debug, const float center[3], float radius, stilb_debug_style style);

/* The axes of a transform, `length` long in its space: x red, y green, z blue. Of the colour only alpha counts.
 * [any-thread] */
void stilb_debug_axes(stilb_debug *debug, const stilb_mat4 *transform, float length, stilb_debug_style style);

/* A line of text in letters of 13 pixels, as printf has it, UTF-8, cut off after 255 bytes: its middle above the place,
 * which its baseline touches; a halo, dark or bright, makes it stand out. The font has what ui_draw.h says; the first
 * text draws its glyphs, which takes some 20 ms. [any-thread] */
void stilb_debug_text(stilb_debug *debug, const float place[3], stilb_debug_style style, const char *format, ...)
	__attribute__((format(printf, 4, 5)));

/* ---- life cycle, for programs without the engine ---------------------------------------------------------------- */

/* The renderer must live longer. On failure *debug is NULL. STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_debug_create(stilb_render *render, stilb_debug **debug);

/* No thread draws any more. Accepts NULL. [main-thread] */
void stilb_debug_destroy(stilb_debug *debug);

/* Gathers what has been drawn, for this frame: to be called between stilb_render_frame_begin and stilb_render_replay;
 * frames without this call show what the last one has gathered. views: those of the frame's scene passes, of which
 * view_projection and target are read; each shows what was drawn in its part of the picture, as far as no later one
 * lies over it. view_count: 0..STILB_RENDER_MAX_PASSES; 0: what was drawn for one frame is seen in none. seconds: the
 * program's time, which does not go back. worker: the caller's index in the pool. From the first frame on that shows
 * something the renderer has a feature more, in its stage PICTURE. STILB_ERROR_MEMORY: of the frame, or of a call
 * before; STILB_ERROR_THREAD: more than STILB_DEBUG_THREADS threads; STILB_ERROR_DEVICE; STILB_ERROR_ARGUMENT as
 * stilb_render_add_feature. [main-thread] */
stilb_result stilb_debug_frame(stilb_debug *debug, const stilb_render_view *views, uint32_t view_count, double seconds,
                               stilb_job_pool *pool, uint32_t worker);

/* What the last stilb_debug_frame has gathered: 1 a line, 2 a letter. [main-thread] */
uint32_t stilb_debug_count(const stilb_debug *debug);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
