/*
 * How frames draw the program's picture (engine_show.c) in place of the scene, or to the right of the divider that the
 * user drags, and the caption.
 *
 * The picture is a texture of radiance, drawn by a 2D pass of its own between the scene and the windows over it. While
 * the program says that the scene is still, the scene is not drawn again: where part of it is shown, a frame without
 * windows is drawn once, read back, and shown from then on as a texture, too.
 */
#include "engine_internal.h"
#include "shading/shade_tonemap.h"

#include <math.h>

#define DIVIDER_REACH 8.0f  /* pixels to each side of the divider within which it can be dragged */
#define DIVIDER_GRIP 40.0f  /* height of its grip, pixels */
#define CAPTION_BESIDE 8.0f /* pixels from the picture's edges to the caption */

void engine_picture_forget_scene(stilb_engine *engine)
{
	stilb_render_texture_destroy(engine->render, engine->picture.scene);
	engine->picture.scene = (stilb_render_texture){0};
}

static void picture_forget_texture(stilb_engine *engine)
{
	stilb_render_texture_destroy(engine->render, engine->picture.texture);
	engine->picture.texture = (stilb_render_texture){0};
}

void engine_picture_finish(stilb_engine *engine)
{
	if (!engine->render)
		return;
	engine_picture_forget_scene(engine);
	picture_forget_texture(engine);
	stilb_image_finish(&engine->picture.radiance);
	engine->picture = (engine_shown){0};
	engine->overlay.divider_open = false;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* The first column that shows the picture; left of it is the scene. */
static float picture_edge(const engine_shown *picture, uint32_t width)
{
	float share = *picture->from;
	return share > 0.0f ? roundf(fminf(share, 1.0f) * (float)width) : 0.0f;
}

bool engine_picture_covers(const stilb_engine *engine, double x)
{
	uint32_t width, height;
	stilb_render_size(engine->render, &width, &height);
	return engine->picture.shown && x >= (double)picture_edge(&engine->picture, width);
}

static bool picture_size_is(const stilb_engine *engine, const uint32_t size[2])
{
	uint32_t width, height;
	stilb_render_size(engine->render, &width, &height);
	return size[0] == width && size[1] == height;
}

static bool picture_scene_fits(const stilb_engine *engine)
{
	return engine->picture.scene.id != 0 && picture_size_is(engine, engine->picture.scene_size);
}

bool engine_picture_wants_scene(const stilb_engine *engine)
{
	const engine_shown *picture = &engine->picture;
	return picture->shown && picture->still && *picture->from > 0.0f && picture_size_is(engine, engine->culled_size) &&
	       !picture_scene_fits(engine);
}

void engine_picture_decide(stilb_engine *engine)
{
	engine_shown *picture = &engine->picture;
	picture->hides_scene = picture->shown && picture->still && (!(*picture->from > 0.0f) || picture_scene_fits(engine));
}

stilb_result engine_picture_keep_scene(stilb_engine *engine, const stilb_image *image)
{
	engine_shown *picture = &engine->picture;
	engine_picture_forget_scene(engine);
	picture->scene_size[0] = image->width;
	picture->scene_size[1] = image->height;
	return stilb_render_texture_create(engine->render, image, &picture->scene);
}

static stilb_result picture_upload(stilb_engine *engine)
{
	engine_shown *picture = &engine->picture;
	if (!picture->stale)
		return STILB_OK;
	picture_forget_texture(engine);
	stilb_result result = stilb_render_texture_create(engine->render, &picture->radiance, &picture->texture);
	picture->stale = result != STILB_OK;
	return result;
}

stilb_result engine_picture_record(stilb_engine *engine, uint32_t pass, uint32_t worker)
{
	const engine_shown *picture = &engine->picture;
	uint32_t width, height;
	STILB_ASSERT(picture->shown);
	stilb_result result = picture_upload(engine);
	if (result == STILB_OK)
		result = stilb_render_pass_begin(engine->render, pass, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_size(engine->render, &width, &height);
	float edge = picture_edge(picture, width), right = (float)width, bottom = (float)height;
	if (picture->hides_scene && picture->scene.id == 0)
		edge = 0.0f; /* the divider has just left the edge: the next frame knows what the scene looks like */
	const float place[4] = {0.0f, 0.0f, right, bottom};
	stilb_render_context *context = stilb_render_context_get(engine->render, worker);
	stilb_render_segment_begin(context, pass, 0);
	if (edge > 0.0f && picture->hides_scene)
		stilb_render_draw_picture(context, place, (float[4]){0.0f, 0.0f, edge, bottom}, picture->scene, 0.0f,
		                          SHADE_TONE_KNEE);
	if (edge < right)
		stilb_render_draw_picture(context, place, (float[4]){edge, 0.0f, right, bottom}, picture->texture,
		                          exp2f(engine->views[0].exposure), engine->views[0].tone);
	stilb_render_segment_end(context);
	return stilb_render_pass_end(engine->render, pass);
}

/* ---- over the picture -------------------------------------------------------------------------------------------- */

void engine_picture_divider(stilb_engine *engine, stilb_ui *ui)
{
	engine_shown *picture = &engine->picture;
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	STILB_ASSERT(picture->shown);
	float at = fminf(fmaxf(*picture->from, 0.0f), 1.0f) * input->width, middle = 0.5f * input->height;
	stilb_ui_rect reach = {at - DIVIDER_REACH, 0.0f, at + DIVIDER_REACH, input->height};
	stilb_ui_action action = stilb_ui_area(ui, "divider", reach, 0);
	if (action.held) {
		at = fminf(fmaxf(action.mouse_x, 0.0f), input->width);
		*picture->from = at / input->width;
	}
	bool bright = action.hovered || action.held;
	float x = roundf(at);
	stilb_ui_draw_rect(list, (stilb_ui_rect){x - 1.0f, 0.0f, x + 1.0f, input->height},
	                   stilb_ui_fade(style->text_strong, bright ? 1.0f : 0.7f));
	stilb_ui_rect grip = {x - 5.0f, middle - 0.5f * DIVIDER_GRIP, x + 5.0f, middle + 0.5f * DIVIDER_GRIP};
	stilb_ui_draw_rounded(list, grip, 5.0f, bright ? style->text_strong : style->panel);
	stilb_ui_draw_rounded_outline(list, grip, 5.0f, 1.0f, style->text_strong);
}

stilb_ui_rect engine_picture_caption(const stilb_engine *engine, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	float room = stilb_ui_input_get(ui)->width;
	float width = fminf(ceilf(stilb_ui_text_width(font, engine->caption)) + 2.0f * style->margin, room);
	float right = fmaxf(room - CAPTION_BESIDE, width);
	stilb_ui_rect place = {right - width, CAPTION_BESIDE, right, CAPTION_BESIDE + style->control_height}, all = place;
	stilb_ui_draw_rounded(list, place, style->radius, style->panel);
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, style->panel_border);
	stilb_ui_cut_left(&place, style->margin);
	stilb_ui_draw_text(list, font, place, STILB_UI_ALIGN_LEFT, style->text_strong, engine->caption);
	return all;
}
