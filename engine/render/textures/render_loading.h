/*
 * Loading: textures of the scene that is shown, made ready while frames are drawn. Inside render/, part of
 * render_internal.h.
 *
 * Stand-in.  Until a texture is there its materials show its mean color: a picture of 2 x 2 texels, or 3 where a side
 *            is no power of two, in the format that the texture will have.
 * Order.     By id, one after the other: its pixels are made, a few rows at a time (render_pixels_step); then its
 *            upload waits for its turn, a part a frame, while the next one's pixels are made; when the device has all
 *            of it, it takes the stand-in's place.
 * Pixels.    They are read from the scene's picture, which belongs to the program: only during an update, after what
 *            has changed was brought up to date. So a picture that is edited, removed or destroyed is not read any
 *            more.
 * Threads.   [main-thread], but for render_loading_begin and _finish of tables that are not shown yet.
 */
#ifndef STILB_RENDER_LOADING_H
#define STILB_RENDER_LOADING_H

#include "render/textures/render_textures.h"

typedef struct render_scene render_scene;

typedef enum render_loading_state {
	RENDER_LOADING_DONE,   /* or it never was one that is loaded */
	RENDER_LOADING_WAITS,  /* for its turn */
	RENDER_LOADING_MADE,   /* its pixels are being made */
	RENDER_LOADING_COPIED, /* it has an upload */
} render_loading_state;

typedef struct render_loading {
	render_pixels_work work; /* of texture `made`, if some texture is MADE */
	uint32_t made;
	uint32_t left; /* textures that are not DONE */
	uint32_t next; /* no texture below waits */
} render_loading;

/* Texels that a frame makes by the number of bytes alone (STILB_RENDER_TEXTURES_EVEN). */
#define RENDER_LOADING_TEXELS ((uint64_t)4 << 20)
/* Time that a frame spends on it else (STILB_RENDER_TEXTURES_SPARE), and texels between two looks at the clock. */
#define RENDER_LOADING_NS 4000000u
#define RENDER_LOADING_SLICE ((uint64_t)128 << 10)

/* Begins a texture with this picture: a stand-in takes the place of what it has; materials that name it must be
 * written again. On failure all is as before: STILB_ERROR_ARGUMENT: the device does not take the picture;
 * STILB_ERROR_MEMORY. */
stilb_result render_loading_begin(stilb_render *render, render_scene *tables, const stilb_image *image, uint32_t id);
/* Gives up what was made of a texture; its stand-in stays. */
void render_loading_cancel(stilb_render *render, render_scene *tables, uint32_t id);
/* Frees all of it. Accepts tables without loading. */
void render_loading_finish(stilb_render *render, render_scene *tables);
/* The same without the device: textures, and their uploads, go with it. */
void render_loading_drop(render_scene *tables);
/* A frame's part, as stilb_render_set_textures says. *arrived: textures that have taken their stand-in's place now;
 * each has render_scene_texture.arrived, and materials that name it must be written again. After an error the texture
 * keeps its stand-in. Errors as stilb_render_texture_create. */
stilb_result render_loading_advance(stilb_render *render, render_scene *tables, uint32_t *arrived);

#endif
