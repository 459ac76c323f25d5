/* The viewer: resamples the visible part of the picture to the window's pixels, as a texture, and draws that and a line
 * of text as two 2D passes. */
#include "viewer.h"

#include "engine_internal.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VIEWER_WORKER 0u    /* there is only the main thread */
#define VIEWER_STRIP 26u    /* height of the line of text, pixels */
#define VIEWER_GREY 0.02f   /* of the surroundings of the picture, linear light */
#define VIEWER_LEAST 384u   /* pixels a side: the window of a smaller picture is enlarged to it at first */
#define VIEWER_WIDEST 1280u /* largest width and height of the window at first, pixels, without the line of text */
#define VIEWER_HIGHEST 800u
#define VIEWER_MAX_SCALE 64.0f /* pixels of the window for one of the picture */

enum { VIEWER_ZOOM = STILB_INPUT_ACTIONS, VIEWER_MOVE, VIEWER_FIT, VIEWER_CLOSE, VIEWER_KEYS, VIEWER_ACTIONS };

enum { VIEWER_PASS_PICTURE, VIEWER_PASS_WORDS, VIEWER_PASSES };

struct stilb_engine_viewer {
	stilb_owner owner;    /* the main thread: the one that created it */
	stilb_window *window; /* NULL: none */
	stilb_render *render;
	engine_surface surface; /* of the window */
	stilb_ui *ui;
	stilb_input_table actions;
	engine_keys keys;             /* the key card */
	stilb_ui_input input;         /* of this frame; {0} without a window */
	stilb_image picture;          /* the picture as the program gave it, U8_SRGB */
	stilb_image shown;            /* the part in the window at the window's size, F32_LINEAR */
	stilb_render_texture texture; /* of `shown` */
	bool stale;                   /* `shown` is to be resampled before the next frame */
	float scale;                  /* pixels of the window for one of the picture; 0: fit the picture to the window */
	float center[2];              /* if scale > 0: the point in the middle of the window, pixels of the picture */
	bool dragging;                /* the left button was down in the last frame */
	float drag[2];                /* if dragging: the pointer's place in the last frame, pixels of the window */
	float light[256];             /* linear light of each sRGB code */
};

/* ---- which part of the picture ----------------------------------------------------------------------------------- */

/* The largest scale at which the picture fits the window; a whole number if that enlarges it, so that its pixels stay
 * equal squares. */
static float viewer_fit(const stilb_image *picture, uint32_t width, uint32_t height)
{
	float scale = fminf((float)width / (float)picture->width, (float)height / (float)picture->height);
	return scale >= 1.0f ? fminf(floorf(scale), VIEWER_MAX_SCALE) : scale;
}

/* Along one axis: sets span so that pixel i of the window's `count` pixels shows the pixels span[0] .. span[1] - 1 of
 * the picture's `size`; none if it lies outside the picture. */
static void viewer_span(uint32_t i, uint32_t count, float scale, float center, uint32_t size, uint32_t span[2])
{
	STILB_ASSERT(scale > 0.0f && size > 0);
	float from = center + ((float)i - 0.5f * (float)count) / scale, to = from + 1.0f / scale;
	float limit = (float)size;
	if (from + to < 0.0f || from + to >= 2.0f * limit) {
		span[0] = span[1] = 0;
	} else if (scale >= 1.0f) {
		span[0] = (uint32_t)fminf(0.5f * (from + to), limit - 1.0f);
		span[1] = span[0] + 1;
	} else {
		span[0] = (uint32_t)fmaxf(from, 0.0f);
		span[1] = (uint32_t)fminf(ceilf(to), limit);
	}
}

/* The mean colour of the picture's pixels in x[0] .. x[1] - 1 and y[0] .. y[1] - 1, linear light; VIEWER_GREY if there
 * are none. */
static void viewer_average(const stilb_engine_viewer *viewer, const uint32_t x[2], const uint32_t y[2], float out[3])
{
	STILB_ASSERT(x[1] <= viewer->picture.width && y[1] <= viewer->picture.height);
	const uint8_t *codes = viewer->picture.pixels;
	float sum[3] = {0.0f, 0.0f, 0.0f};
	for (uint32_t row = y[0]; row < y[1]; row++) {
		const uint8_t *code = codes + 3 * ((size_t)row * viewer->picture.width + x[0]);
		for (uint32_t column = x[0]; column < x[1]; column++, code += 3)
			for (int c = 0; c < 3; c++)
				sum[c] += viewer->light[code[c]];
	}
	uint32_t count = (x[1] - x[0]) * (y[1] - y[0]);
	for (int c = 0; c < 3; c++)
		out[c] = count > 0 ? sum[c] / (float)count : VIEWER_GREY;
}

/* Fills `shown`, by the nearest pixel if the picture is enlarged, by the mean if it is reduced. */
static void viewer_resample(stilb_engine_viewer *viewer)
{
	const stilb_image *picture = &viewer->picture, *shown = &viewer->shown;
	bool fits = viewer->scale <= 0.0f;
	float scale = fits ? viewer_fit(picture, shown->width, shown->height) : viewer->scale;
	float center[2] = {fits ? 0.5f * (float)picture->width : viewer->center[0],
	                   fits ? 0.5f * (float)picture->height : viewer->center[1]};
	float *out = shown->pixels;
	for (uint32_t row = 0; row < shown->height; row++) {
		uint32_t x[2], y[2];
		viewer_span(row, shown->height, scale, center[1], picture->height, y);
		for (uint32_t column = 0; column < shown->width; column++, out += 3) {
			viewer_span(column, shown->width, scale, center[0], picture->width, x);
			viewer_average(viewer, x, y, out);
		}
	}
}

/* Brings `shown` and its texture up to date, width x height pixels. */
static stilb_result viewer_texture(stilb_engine_viewer *viewer, uint32_t width, uint32_t height)
{
	if (!viewer->stale && viewer->shown.width == width && viewer->shown.height == height)
		return STILB_OK;
	stilb_result result = STILB_OK;
	if (viewer->shown.width != width || viewer->shown.height != height) {
		stilb_image_finish(&viewer->shown);
		result = stilb_image_create(&viewer->shown, width, height, 3, STILB_IMAGE_F32_LINEAR);
	}
	if (result != STILB_OK)
		return result;
	viewer_resample(viewer);
	stilb_render_texture_destroy(viewer->render, viewer->texture);
	viewer->texture = (stilb_render_texture){0};
	result = stilb_render_texture_create(viewer->render, &viewer->shown, &viewer->texture);
	viewer->stale = result != STILB_OK;
	return result;
}

/* ---- what keys and mouse do -------------------------------------------------------------------------------------- */

stilb_input_table stilb_engine_viewer_table(void)
{
#define VIEWER_ROW(row) [VIEWER_##row - STILB_INPUT_ACTIONS]
	static const stilb_input_action rows[VIEWER_ACTIONS - STILB_INPUT_ACTIONS] = {
		VIEWER_ROW(ZOOM) = {"zoom", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_WHEEL,
	                        .help = "zoom in and out at the pointer"},
		VIEWER_ROW(MOVE) = {"move", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_LEFT, .help = "move the picture"},
		VIEWER_ROW(FIT) = {"fit", .keys = {STILB_WINDOW_KEY_SPACE}, .help = "fit the picture to the window"},
		VIEWER_ROW(CLOSE) = {"close", .keys = {STILB_WINDOW_KEY_ESCAPE}, .help = "close the window"},
		VIEWER_ROW(KEYS) = {"keys", STILB_INPUT_SWITCH, .keys = {STILB_WINDOW_KEY_H}, .typed = "?",
	                        .help = "this list"},
	};
#undef VIEWER_ROW
	stilb_input_table table = stilb_input_table_plain();
	stilb_result result = stilb_input_table_add(&table, rows, sizeof rows / sizeof *rows);
	STILB_ASSERT(result == STILB_OK);
	(void)result;
	return table;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* The window's size at first: the picture's, but larger for tiny pictures and smaller for those that would not fit a
 * screen. */
static void viewer_window_size(const stilb_engine_viewer_desc *desc, uint32_t size[2])
{
	float width = (float)desc->width, height = (float)desc->height;
	float scale = fminf(1.0f, fminf((float)VIEWER_WIDEST / width, (float)VIEWER_HIGHEST / height));
	float least = ceilf((float)VIEWER_LEAST / fmaxf(width, height));
	if (least > 1.0f)
		scale = least;
	size[0] = (uint32_t)fmaxf(roundf(width * scale), (float)VIEWER_LEAST);
	size[1] = (uint32_t)fmaxf(roundf(height * scale), (float)VIEWER_STRIP) + VIEWER_STRIP;
}

static stilb_result viewer_start(stilb_engine_viewer *viewer, const stilb_engine_viewer_desc *desc)
{
	uint32_t size[2];
	viewer_window_size(desc, size);
	stilb_result result = stilb_image_create(&viewer->picture, desc->width, desc->height, 3, STILB_IMAGE_U8_SRGB);
	if (result == STILB_OK && desc->window)
		result = stilb_window_create(desc->title, size[0], size[1], &viewer->window);
	if (result != STILB_OK)
		return result;
	stilb_gpu_surface surface = viewer->window ? engine_surface_of(viewer->window) : (stilb_gpu_surface){0};
	stilb_render_desc render = {
		.gpu = desc->gpu,
		.surface = viewer->window ? &surface : NULL,
		.width = size[0],
		.height = size[1],
		.samples = 1,
		.context_count = 1,
		.validate = desc->validate,
	};
	result = stilb_render_create(&render, &viewer->render);
	if (result != STILB_OK)
		return result;
	stilb_ui_desc ui = stilb_ui_desc_default();
	ui.render = viewer->render;
	return stilb_ui_create(&ui, &viewer->ui);
}

stilb_result stilb_engine_viewer_create(const stilb_engine_viewer_desc *desc, stilb_engine_viewer **out)
{
	STILB_ASSERT(desc && out);
	STILB_ASSERT(desc->width >= 1 && desc->height >= 1);
	*out = NULL;
	stilb_engine_viewer *viewer = calloc(1, sizeof *viewer);
	if (!viewer)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a window with the picture");
	stilb_owner_take(&viewer->owner);
	for (int code = 0; code < 256; code++)
		viewer->light[code] = shade_srgb_to_linear((float)code / 255.0f);
	viewer->stale = true;
	viewer->actions = stilb_engine_viewer_table();
	viewer->keys.list.selected = STILB_UI_NO_ROW;
	stilb_result result = viewer_start(viewer, desc);
	if (result == STILB_OK)
		*out = viewer;
	else
		stilb_engine_viewer_destroy(viewer);
	return result;
}

void stilb_engine_viewer_destroy(stilb_engine_viewer *viewer)
{
	if (!viewer)
		return;
	STILB_ASSERT_OWNER(viewer->owner);
	if (viewer->render)
		stilb_render_texture_destroy(viewer->render, viewer->texture);
	stilb_ui_destroy(viewer->ui);
	stilb_render_destroy(viewer->render);
	stilb_window_destroy(viewer->window);
	stilb_image_finish(&viewer->shown);
	stilb_image_finish(&viewer->picture);
	free(viewer);
}

void stilb_engine_viewer_picture(stilb_engine_viewer *viewer, const uint8_t *srgb)
{
	STILB_ASSERT_OWNER(viewer->owner);
	STILB_ASSERT(srgb);
	memcpy(viewer->picture.pixels, srgb, stilb_image_size(&viewer->picture));
	viewer->stale = true;
}

/* ---- input ------------------------------------------------------------------------------------------------------- */

/* Called before a zoom or drag. If the picture has been fitted to the window until now, sets scale and centre to those
 * of the fit, so that the user's change starts from what is shown. */
static void viewer_take_over(stilb_engine_viewer *viewer, uint32_t width, uint32_t height)
{
	if (viewer->scale > 0.0f)
		return;
	viewer->scale = viewer_fit(&viewer->picture, width, height);
	viewer->center[0] = 0.5f * (float)viewer->picture.width;
	viewer->center[1] = 0.5f * (float)viewer->picture.height;
}

/* Zooms by a factor of sqrt(2) for each notch. The point under the pointer, from_middle pixels from the window's
 * middle, stays there. */
static void viewer_zoom(stilb_engine_viewer *viewer, float notches, const float from_middle[2])
{
	STILB_ASSERT(viewer->scale > 0.0f && "the user has taken over");
	float scale = fminf(fmaxf(viewer->scale * exp2f(0.5f * notches), 1.0f / 64.0f), VIEWER_MAX_SCALE);
	for (int k = 0; k < 2; k++)
		viewer->center[k] += from_middle[k] / viewer->scale - from_middle[k] / scale;
	viewer->scale = scale;
	viewer->stale = true;
}

/* Moves the picture with the pointer. */
static void viewer_drag(stilb_engine_viewer *viewer, const float pointer[2])
{
	STILB_ASSERT(viewer->scale > 0.0f && "the user has taken over");
	for (int k = 0; k < 2; k++)
		viewer->center[k] -= (pointer[k] - viewer->drag[k]) / viewer->scale;
	viewer->stale = true;
}

/* What the card takes of the mouse is not the picture's. */
static void viewer_act(stilb_engine_viewer *viewer, const stilb_window_state *state, const stilb_input_state *asked,
                       uint32_t width, uint32_t height)
{
	bool ours = !viewer->keys.open || !stilb_ui_wants_mouse(viewer->ui);
	float zoom = ours ? asked->zoom : 0.0f;
	float pointer[2] = {state->pointer_x, state->pointer_y};
	float from_middle[2] = {pointer[0] - 0.5f * (float)width, pointer[1] - 0.5f * (float)height};
	bool dragged =
		state->button && viewer->dragging && (pointer[0] != viewer->drag[0] || pointer[1] != viewer->drag[1]);
	if (dragged || zoom != 0.0f)
		viewer_take_over(viewer, width, height);
	if (dragged)
		viewer_drag(viewer, pointer);
	if (zoom != 0.0f)
		viewer_zoom(viewer, zoom, from_middle);
	if (asked->actions[VIEWER_FIT] > 0) {
		viewer->scale = 0.0f;
		viewer->stale = true;
	}
	viewer->keys.open ^= asked->actions[VIEWER_KEYS] > 0;
	viewer->dragging = state->button && ours;
	memcpy(viewer->drag, pointer, sizeof pointer);
}

/* Takes the window's input and follows its size. *drawn is false if the window has no area to draw to. */
static stilb_result viewer_input(stilb_engine_viewer *viewer, double seconds, bool *close, bool *drawn)
{
	stilb_window_state state;
	uint32_t width, height;
	*close = false;
	*drawn = true;
	if (!viewer->window)
		return STILB_OK;
	stilb_window_set_capturing(viewer->window, false); /* there is no camera */
	stilb_window_wait(viewer->window, seconds, &state);
	if (state.lost)
		return stilb_fail(STILB_ERROR_WINDOW, "the display has gone");
	stilb_input_state asked = stilb_input_from_window(&viewer->actions, &state);
	viewer->input = engine_ui_input(&state);
	*close = state.close || asked.actions[VIEWER_CLOSE] > 0;
	*drawn = state.width > 0 && state.height > VIEWER_STRIP;
	if (!*drawn)
		return STILB_OK;
	viewer_act(viewer, &state, &asked, state.width, state.height - VIEWER_STRIP);
	stilb_render_size(viewer->render, &width, &height);
	if (state.width == width && state.height == height)
		return STILB_OK;
	return stilb_render_resize(viewer->render, state.width, state.height);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* The line of text at the bottom, with the scale at its right end unless the picture fits the window. */
static void viewer_words(stilb_engine_viewer *viewer, const char *words, uint32_t width, uint32_t height)
{
	STILB_ASSERT(height > VIEWER_STRIP);
	const stilb_ui_style *style = stilb_ui_style_get(viewer->ui);
	const stilb_ui_font *font = stilb_ui_font_get(viewer->ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(viewer->ui);
	stilb_ui_rect area = {0.0f, (float)(height - VIEWER_STRIP), (float)width, (float)height};
	stilb_ui_draw_rect(list, area, style->panel);
	area = stilb_ui_inset(area, 6.0f);
	area.y0 -= 6.0f;
	area.y1 += 6.0f;
	if (viewer->scale > 0.0f) {
		char percent[32];
		snprintf(percent, sizeof percent, "%.0f %%", (double)(100.0f * viewer->scale));
		stilb_ui_draw_text(list, font, stilb_ui_cut_right(&area, 60.0f), STILB_UI_ALIGN_RIGHT, style->text_muted,
		                   percent);
	}
	stilb_ui_draw_text(list, font, area, STILB_UI_ALIGN_LEFT, style->text, words);
}

/* Draws the texture over the window, except for the line of text. */
static stilb_result viewer_record_picture(stilb_engine_viewer *viewer, uint32_t width, uint32_t height)
{
	float right = (float)width, bottom = (float)height, clip[4] = {0.0f, 0.0f, right, bottom};
	stilb_render_vertex_2d corners[4] = {
		{{0.0f, 0.0f}, {0.0f, 0.0f}, {255, 255, 255, 255}},
		{{right, 0.0f}, {1.0f, 0.0f}, {255, 255, 255, 255}},
		{{right, bottom}, {1.0f, 1.0f}, {255, 255, 255, 255}},
		{{0.0f, bottom}, {0.0f, 1.0f}, {255, 255, 255, 255}},
	};
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	stilb_result result = stilb_render_pass_begin(viewer->render, VIEWER_PASS_PICTURE, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_context *context = stilb_render_context_get(viewer->render, VIEWER_WORKER);
	stilb_render_segment_begin(context, VIEWER_PASS_PICTURE, 0);
	uint32_t first = stilb_render_geometry_2d(context, corners, 4, indices, 6);
	stilb_render_draw_2d(context, first, 6, clip, viewer->texture);
	stilb_render_segment_end(context);
	return stilb_render_pass_end(viewer->render, VIEWER_PASS_PICTURE);
}

static stilb_result viewer_draw(stilb_engine_viewer *viewer, const char *words)
{
	static const stilb_render_pass passes[VIEWER_PASSES] = {
		[VIEWER_PASS_PICTURE] = {.name = "picture", .kind = STILB_RENDER_PASS_2D, .order = 0},
		[VIEWER_PASS_WORDS] = {.name = "words", .kind = STILB_RENDER_PASS_2D, .order = 1},
	};
	uint32_t width, height;
	stilb_render_size(viewer->render, &width, &height);
	stilb_result result = viewer_texture(viewer, width, height - VIEWER_STRIP);
	if (result != STILB_OK)
		return result;
	viewer->input.width = (float)width;
	viewer->input.height = (float)height;
	stilb_ui_begin(viewer->ui, &viewer->input);
	viewer_words(viewer, words, width, height);
	if (viewer->keys.open)
		engine_keys_draw(&viewer->keys, &viewer->actions, viewer->ui);
	stilb_ui_end(viewer->ui);
	result = stilb_render_frame_begin(viewer->render);
	if (result == STILB_OK)
		result = viewer_record_picture(viewer, width, height - VIEWER_STRIP);
	if (result == STILB_OK)
		result = stilb_ui_record(viewer->ui, VIEWER_PASS_WORDS, VIEWER_WORKER);
	if (result == STILB_OK)
		result = stilb_render_replay(viewer->render, passes, VIEWER_PASSES, NULL, 0, NULL, VIEWER_WORKER);
	return result == STILB_OK ? engine_surface_present(&viewer->surface, viewer->render, viewer->window) : result;
}

stilb_result stilb_engine_viewer_frame(stilb_engine_viewer *viewer, const char *words, double seconds, bool *close)
{
	STILB_ASSERT_OWNER(viewer->owner);
	STILB_ASSERT(words && close);
	STILB_ASSERT(seconds >= 0.0);
	bool drawn;
	stilb_result result = viewer_input(viewer, seconds, close, &drawn);
	if (result == STILB_OK && drawn)
		result = viewer_draw(viewer, words);
	if (result == STILB_OK && engine_surface_is_gone(&viewer->surface, viewer->window))
		result = stilb_fail(STILB_ERROR_WINDOW, "the window's surface was lost, and it gives no other");
	return result;
}
