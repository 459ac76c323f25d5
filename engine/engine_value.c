/*
 * The value of the pixel under the pointer, as a line beside it: of the scene's image before exposure and tone map, or
 * of the program's picture where that covers it. The image is copied by the device after a frame, and read when the
 * copy is there: no frame waits for it, and the value is that of a frame or two before. And what frames that show
 * STILB_RENDER_SHOW_LIGHTS have counted, of the same image, or how far those that show _ERROR are off, of "error", with
 * what the colours mean in a corner of the picture.
 */
#include "engine_internal.h"
#include "render/device/render_images.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define VALUE_BESIDE 16.0f /* pixels from the pointer to the line */
#define COUNTS_EDGE 8.0f   /* pixels from the picture's edges */
#define COUNTS_BOX 33.0f   /* width of a colour */
#define COUNTS_COLORS 9u

bool engine_value_wanted(const stilb_engine *engine)
{
	const engine_overlay *overlay = &engine->overlay;
	stilb_scene_surface_channel channel;
	bool shows = stilb_render_show_channel(engine->desc.show, &channel) || engine->value.open;
	return shows && overlay->input.mouse_present && engine->scene && engine->image[0] == '\0' &&
	       !(overlay->ui && stilb_ui_wants_mouse(overlay->ui));
}

/* The texel that x, y of a picture of `size` lie in, of an image of width x height. */
static size_t value_texel(double x, double y, const uint32_t size[2], uint32_t width, uint32_t height)
{
	double column = fmin(fmax(x / size[0], 0.0), 1.0) * width, row = fmin(fmax(y / size[1], 0.0), 1.0) * height;
	uint32_t across = column < width ? (uint32_t)column : width - 1;
	return (size_t)(row < height ? (uint32_t)row : height - 1) * width + across;
}

/* Takes the value from the program's picture, of which those of data are light that is shown as them. */
static void value_of_picture(stilb_engine *engine)
{
	const stilb_image *image = &engine->picture.radiance;
	stilb_scene_surface_channel channel;
	bool data = stilb_render_show_channel(engine->desc.show, &channel) &&
	            stilb_scene_channel_kind_of(channel) == STILB_SCENE_CHANNEL_DATA;
	const stilb_ui_input *input = &engine->overlay.input;
	uint32_t size[2];
	stilb_render_size(engine->render, &size[0], &size[1]);
	size_t at = value_texel((double)input->mouse_x, (double)input->mouse_y, size, image->width, image->height);
	const float *texel = (const float *)image->pixels + 4 * at;
	for (int c = 0; c < 3; c++)
		engine->value.value[c] = data ? shade_srgb_from_linear(texel[c]) : texel[c];
	engine->value.known = true;
}

void engine_value_forget(stilb_engine *engine)
{
	engine_value *value = &engine->value;
	if (value->ticket != 0)
		stilb_gpu_read_end(stilb_render_gpu(engine->render), value->ticket);
	value->ticket = 0;
	value->known = false;
}

/* Asks for a copy of the scene's image; a frame without one has no value. */
static void value_ask(stilb_engine *engine)
{
	engine_value *value = &engine->value;
	const stilb_gpu_plan *plan = stilb_render_plan(engine->render);
	uint16_t image = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_COLOR);
	if (image == 0)
		return;
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, image);
	if (extent.format != STILB_GPU_RGBA16_F ||
	    stilb_gpu_read_begin(stilb_render_gpu(engine->render), plan, image, 0, 0, &value->ticket) != STILB_OK) {
		value->ticket = 0;
		return;
	}
	value->size[0] = extent.width;
	value->size[1] = extent.height;
}

void engine_value_frame(stilb_engine *engine)
{
	engine_value *value = &engine->value;
	const void *bytes = NULL;
	uint64_t frame;
	if (!engine_value_wanted(engine)) {
		engine_value_forget(engine);
		return;
	}
	if (engine_picture_covers(engine, (double)engine->overlay.input.mouse_x)) {
		engine_value_forget(engine);
		value_of_picture(engine);
		return;
	}
	double x = (double)engine->overlay.input.mouse_x, y = (double)engine->overlay.input.mouse_y;
	uint32_t size[2];
	/* Where the scene's picture is known, its image is not drawn; and insets have images of their own. */
	if (engine->picture.hides_scene || !engine_cameras_own(engine, &x, &y, size)) {
		engine_value_forget(engine);
		return;
	}
	stilb_gpu *gpu = stilb_render_gpu(engine->render);
	if (value->ticket != 0 && stilb_gpu_read_get(gpu, value->ticket, false, &bytes, &frame) != STILB_OK)
		engine_value_forget(engine);
	if (bytes) {
		uint16_t halves[3];
		memcpy(halves, (const uint16_t *)bytes + 4 * value_texel(x, y, size, value->size[0], value->size[1]),
		       sizeof halves);
		for (int c = 0; c < 3; c++)
			value->value[c] = stilb_image_half_to_float(halves[c]);
		stilb_gpu_read_end(gpu, value->ticket);
		value->ticket = 0;
		value->known = true;
	}
	if (value->ticket == 0)
		value_ask(engine);
}

void engine_value_draw(const stilb_engine *engine, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const float *v = engine->value.value;
	char text[96];
	if (v[0] == v[1] && v[1] == v[2])
		snprintf(text, sizeof text, "%.4g", (double)v[0]);
	else
		snprintf(text, sizeof text, "%.4g  %.4g  %.4g", (double)v[0], (double)v[1], (double)v[2]);
	float width = ceilf(stilb_ui_text_width(font, text)) + 2.0f * style->margin, height = style->control_height;
	float left = input->mouse_x + VALUE_BESIDE, top = input->mouse_y + VALUE_BESIDE;
	if (left + width > input->width)
		left = fmaxf(input->mouse_x - VALUE_BESIDE - width, 0.0f);
	if (top + height > input->height)
		top = fmaxf(input->mouse_y - VALUE_BESIDE - height, 0.0f);
	stilb_ui_rect place = {floorf(left), floorf(top), floorf(left) + width, floorf(top) + height};
	stilb_ui_draw_rounded(stilb_ui_list(ui), place, style->radius, style->panel);
	stilb_ui_draw_rounded_outline(stilb_ui_list(ui), place, style->radius, 1.0f, style->panel_border);
	stilb_ui_cut_left(&place, style->margin);
	stilb_ui_draw_text(stilb_ui_list(ui), font, place, STILB_UI_ALIGN_LEFT, style->text_strong, text);
}

/* ---- counted lights ---------------------------------------------------------------------------------------------- */

void engine_counts_forget(stilb_engine *engine)
{
	engine_counts *counts = &engine->counts;
	if (counts->ticket != 0)
		stilb_gpu_read_end(stilb_render_gpu(engine->render), counts->ticket);
	*counts = (engine_counts){0};
}

/* Asks for a copy of the scene's image; a frame without one has no counts. */
static void counts_ask(stilb_engine *engine)
{
	engine_counts *counts = &engine->counts;
	const stilb_gpu_plan *plan = stilb_render_plan(engine->render);
	bool error = engine->views[0].show == STILB_RENDER_SHOW_ERROR;
	uint16_t image = stilb_gpu_plan_find(plan, error ? STILB_RENDER_IMAGE_ERROR : STILB_RENDER_IMAGE_COLOR);
	if (image == 0)
		return;
	stilb_gpu_extent extent = *stilb_gpu_plan_extent(plan, image);
	counts->show = engine->views[0].show;
	counts->exposure = engine->views[0].exposure;
	counts->pixels = (uint64_t)extent.width * extent.height;
	if (extent.format != STILB_GPU_RGBA16_F ||
	    stilb_gpu_read_begin(stilb_render_gpu(engine->render), plan, image, 0, 0, &counts->ticket) != STILB_OK)
		counts->ticket = 0;
}

/* Sums the copy if it is there. */
static void counts_take(stilb_engine *engine, bool wait)
{
	engine_counts *counts = &engine->counts;
	stilb_gpu *gpu = stilb_render_gpu(engine->render);
	const void *bytes = NULL;
	uint64_t frame;
	if (stilb_gpu_read_get(gpu, counts->ticket, wait, &bytes, &frame) == STILB_OK && !bytes)
		return;
	if (bytes && counts->show == STILB_RENDER_SHOW_ERROR)
		counts->error = stilb_render_measure_error(bytes, counts->pixels, counts->exposure);
	else if (bytes)
		counts->last = stilb_render_count_lights(bytes, counts->pixels);
	stilb_gpu_read_end(gpu, counts->ticket);
	counts->ticket = 0;
}

void engine_counts_frame(stilb_engine *engine)
{
	engine_counts *counts = &engine->counts;
	bool watched = engine->window || engine->desc.surface;
	stilb_render_show show = engine->views[0].show;
	bool counts_some = show == STILB_RENDER_SHOW_LIGHTS || show == STILB_RENDER_SHOW_ERROR;
	if (!counts_some || !engine->scene || engine->picture.hides_scene ||
	    engine->desc.device == STILB_RENDER_DEVICE_NULL) {
		engine_counts_forget(engine);
		return;
	}
	if (counts->ticket != 0 && counts->show != show)
		engine_counts_forget(engine);
	if (counts->ticket == 0)
		counts_ask(engine);
	if (counts->ticket != 0)
		counts_take(engine, !watched);
	if (show == STILB_RENDER_SHOW_LIGHTS)
		engine->report.light_counts = counts->last;
	else
		engine->report.light_error = counts->error;
}

/* What the legend says in numbers, above the colours. */
static void counts_words(const stilb_engine *engine, char text[96])
{
	const stilb_render_light_counts *lights = &engine->counts.last;
	const stilb_render_error *error = &engine->counts.error;
	bool shows_error = engine->desc.show == STILB_RENDER_SHOW_ERROR;
	snprintf(text, 96, shows_error ? "off from forward, 1/255 of white" : "lights that pixels asked");
	if (shows_error && error->pixels > 0)
		snprintf(text, 96, "off by %.3g, at most %.3g / 255 of white", 255.0 * error->rms, 255.0 * error->most);
	else if (!shows_error && lights->shown > 0)
		snprintf(text, 96, "%.1f lights a pixel, lit %.2f times", lights->lights / (double)lights->shown,
		         lights->shadings / (double)lights->shown);
}

void engine_counts_draw(const stilb_engine *engine, stilb_ui *ui)
{
	/* As light_of_count of shaders/tone.frag has them, in sRGB. */
	static const uint32_t colors[COUNTS_COLORS] = {0x000000, 0x19276c, 0x2750bc, 0x27a089, 0x59bc30,
	                                               0xc4c427, 0xe78927, 0xe73027, 0xffffff};
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	static const char *const numbers[2][COUNTS_COLORS] = {{"0", "1", "2", "4", "8", "16", "32", "64", "128"},
	                                                      {"0", "1/16", "1/8", "1/4", "1/2", "1", "2", "4", "8"}};
	const char *const *number = numbers[engine->desc.show == STILB_RENDER_SHOW_ERROR];
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	char text[96];
	counts_words(engine, text);
	float boxes = COUNTS_BOX * COUNTS_COLORS, inner = fmaxf(boxes, ceilf(stilb_ui_text_width(font, text)));
	float width = inner + 2.0f * style->margin, height = 3.0f * style->row_height + 2.0f * style->margin;
	float top = fmaxf(input->height - COUNTS_EDGE - height, 0.0f);
	stilb_ui_rect place = {COUNTS_EDGE, top, COUNTS_EDGE + width, top + height};
	stilb_ui_draw_rounded(list, place, style->radius, style->panel);
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, style->panel_border);
	stilb_ui_rect rest = stilb_ui_inset(place, style->margin);
	stilb_ui_draw_text(list, font, stilb_ui_cut_top(&rest, style->row_height), STILB_UI_ALIGN_LEFT, style->text_strong,
	                   text);
	for (uint32_t i = 0; i < COUNTS_COLORS; i++) {
		stilb_ui_rect box = stilb_ui_cut_left(&rest, COUNTS_BOX), color = stilb_ui_cut_top(&box, style->row_height);
		stilb_ui_draw_rect(list, color, stilb_ui_rgb(colors[i]));
		stilb_ui_draw_text(list, font, box, STILB_UI_ALIGN_CENTER, style->text, number[i]);
	}
}
