/*
 * The lights' window: a list of the scene's lights, of which one is picked and may be changed: on or off, intensity,
 * colour or temperature, place; shown alone; taken back to what the scene's file has; and all saved beside that file.
 */
#include "engine_internal.h"

#include "shading/shade_luminance.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LIGHTS_WIDTH 340.0f  /* pixels, at most */
#define LIGHTS_ROWS 8u       /* lights that are seen at once, at most */
#define LIGHTS_BORDER 2.0f   /* pixels: the panel's border is no thicker */
#define LIGHTS_CONTROLS 10u  /* lines below the list */
#define LIGHTS_BRIGHTER 4.0f /* of the slider at most, times what the light had when it was picked */
#define LIGHTS_DAY 6500.0f   /* kelvin, where the slider of temperature stands at first */
#define LIGHTS_RING 10.0f    /* pixels: radius of the mark around the picked light */

static float lights_brightest(const float color[3])
{
	return fmaxf(color[0], fmaxf(color[1], color[2]));
}

/* color: not black. */
static void lights_set(stilb_scene_light *light, float intensity, const float color[3])
{
	float brightest = lights_brightest(color);
	for (int c = 0; c < 3; c++)
		light->intensity[c] = intensity * (color[c] / brightest);
}

/* How far from the origin models reach, metres, at least 1. */
static float lights_reach(const stilb_scene *scene)
{
	float reach = 1.0f;
	for (uint32_t m = 0; m < scene->model_count; m++) {
		const stilb_scene_bounds *b = &scene->bounds;
		float far = fmaxf(fabsf(b->x[m]), fmaxf(fabsf(b->y[m]), fabsf(b->z[m]))) + b->radius[m];
		reach = far > reach ? far : reach; /* false for models that are hidden: NaN */
	}
	return reach;
}

/* Remembers what the picked light is like, whose intensity may become 0 and so lose its colour. */
static void lights_remember(engine_lights *lights, const stilb_scene_light *light)
{
	float brightest = lights_brightest(light->intensity);
	memcpy(lights->seen, light->intensity, sizeof lights->seen);
	lights->intensity = brightest > 0.0f ? brightest : 1.0f;
	for (int c = 0; c < 3; c++)
		lights->color[c] = brightest > 0.0f ? light->intensity[c] / brightest : 1.0f;
}

static void lights_pick(engine_lights *lights, const stilb_scene *scene)
{
	lights->picked = lights->list.selected;
	lights->kelvin = LIGHTS_DAY;
	lights->reach = lights_reach(scene);
	for (int i = 0; i < 3; i++)
		lights->reach = fmaxf(lights->reach, 2.0f * fabsf(scene->lights[lights->picked].position[i]));
	lights_remember(lights, &scene->lights[lights->picked]);
}

static stilb_ui_rect lights_line(const stilb_ui_style *style, stilb_ui_rect *area)
{
	stilb_ui_rect line = stilb_ui_cut_top(area, style->control_height);
	stilb_ui_cut_top(area, style->gap);
	return line;
}

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static void lights_draw_list(const stilb_scene *scene, stilb_ui *ui, stilb_ui_rect area, stilb_ui_list_state *state)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, area, "lights", scene->light_count, state);
	for (uint32_t i = rows.first; i < rows.end; i++) {
		const stilb_scene_light *light = &scene->lights[i];
		char text[96];
		stilb_ui_rect row = stilb_ui_row(ui, &rows, i);
		row.x0 += style->gap;
		row.x1 -= style->gap;
		float brightest = lights_brightest(light->intensity);
		snprintf(text, sizeof text, "%u %s", i, stilb_scene_light_kind_names[light->kind]);
		(brightest > 0.0f ? stilb_ui_label : stilb_ui_label_muted)(ui, row, STILB_UI_ALIGN_LEFT, text);
		snprintf(text, sizeof text, "%.4g %s", (double)brightest, stilb_scene_light_unit_name(light));
		stilb_ui_label_muted(ui, row, STILB_UI_ALIGN_RIGHT, text);
	}
	stilb_ui_rows_end(ui);
}

/* ---- the picked light -------------------------------------------------------------------------------------------- */

/* On or off, alone, intensity, colour. */
static void lights_draw_light(engine_lights *lights, stilb_scene_light *light, stilb_ui *ui, stilb_ui_rect *area)
{
	static const stilb_ui_slider_range share = {0.0f, 1.0f, 0.0f, NULL}, kelvin = {1000.0f, 15000.0f, 50.0f, "%.0f K"};
	static const char *const channels[3] = {"Red", "Green", "Blue"};
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	char format[32];
	if (memcmp(lights->seen, light->intensity, sizeof lights->seen) != 0) /* the program has changed it */
		lights_remember(lights, light);
	float intensity = lights_brightest(light->intensity);
	bool on = intensity > 0.0f, changed = false;
	stilb_ui_rect line = lights_line(style, area);
	float half = floorf(0.5f * (line.x1 - line.x0));
	if (stilb_ui_checkbox(ui, stilb_ui_cut_left(&line, half), "On", &on)) {
		intensity = on ? lights->intensity : 0.0f;
		changed = true;
	}
	stilb_ui_checkbox(ui, line, "Alone", &lights->solo);
	snprintf(format, sizeof format, "%%.4g %s", stilb_scene_light_unit_name(light));
	changed |= stilb_ui_slider(ui, lights_line(style, area), "Intensity", &intensity,
	                           &(stilb_ui_slider_range){0.0f, LIGHTS_BRIGHTER * lights->intensity, 0.0f, format});
	if (stilb_ui_slider(ui, lights_line(style, area), "Temperature", &lights->kelvin, &kelvin)) {
		stilb_vec3 color = shade_color_of_temperature(lights->kelvin);
		for (int c = 0; c < 3; c++)
			lights->color[c] = color[c];
		changed = true;
	}
	float hue[3];
	memcpy(hue, lights->color, sizeof hue);
	for (int c = 0; c < 3; c++)
		changed |= stilb_ui_slider(ui, lights_line(style, area), channels[c], &lights->color[c], &share);
	if (!(lights_brightest(lights->color) > 0.0f)) /* black is no hue: the one before stays */
		memcpy(lights->color, hue, sizeof hue);
	if (changed) {
		lights_set(light, intensity, lights->color);
		memcpy(lights->seen, light->intensity, sizeof lights->seen);
	}
}

static void lights_draw_place(stilb_scene *scene, uint32_t picked, float reach, stilb_ui *ui, stilb_ui_rect *area)
{
	static const char *const axes[3] = {"X", "Y", "Z"};
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_scene_light *light = &scene->lights[picked];
	float position[3];
	memcpy(position, light->position, sizeof position);
	bool moved = false, fixed = light->kind == STILB_SCENE_LIGHT_DIRECTIONAL;
	for (int i = 0; i < 3; i++)
		moved |=
			(fixed ? stilb_ui_slider_muted : stilb_ui_slider)(ui, lights_line(style, area), axes[i], &position[i],
		                                                      &(stilb_ui_slider_range){-reach, reach, 0.0f, "%.2f m"});
	if (moved && !fixed)
		stilb_scene_move_light(scene, picked, position);
}

static void lights_draw_buttons(stilb_engine *engine, stilb_ui *ui, stilb_ui_rect line)
{
	engine_lights *lights = &engine->overlay.lights;
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	float half = floorf(0.5f * (line.x1 - line.x0 - style->gap));
	if (stilb_ui_button(ui, stilb_ui_cut_left(&line, half), "As in the file")) {
		stilb_scene_lights_restore(engine->scene, lights->picked);
		lights_pick(lights, engine->scene);
	}
	stilb_ui_cut_left(&line, style->gap);
	if (!stilb_ui_button(ui, line, "Save all"))
		return;
	const char *path;
	char text[256];
	if (stilb_scene_lights_save(engine->scene, &path) == STILB_OK)
		snprintf(text, sizeof text, "lights saved: %s", path);
	else
		snprintf(text, sizeof text, "lights not saved: %s", stilb_error_message());
	stilb_log("%s", text);
	engine_toasts_add(&engine->overlay.toasts, text);
}

/* A ring where the picked light is seen. */
static void lights_draw_mark(const stilb_engine *engine, const stilb_scene_light *light, stilb_ui *ui)
{
	enum { CORNERS = 24 };
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const float *place = engine->place, *p = light->position;
	float width = (place[2] - place[0]) * input->width, height = (place[3] - place[1]) * input->height, clip[4];
	stilb_ui_point ring[CORNERS];
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL || !(width >= 1.0f && height >= 1.0f))
		return;
	stilb_mat4 matrix = stilb_scene_camera_matrix(&engine->scene->camera, width / height);
	for (int row = 0; row < 4; row++)
		clip[row] = matrix.m[row] * p[0] + matrix.m[4 + row] * p[1] + matrix.m[8 + row] * p[2] + matrix.m[12 + row];
	if (!(clip[3] > 0.0f) || fabsf(clip[0]) > clip[3] || fabsf(clip[1]) > clip[3])
		return;
	float x = place[0] * input->width + (0.5f + 0.5f * clip[0] / clip[3]) * width;
	float y = place[1] * input->height + (0.5f + 0.5f * clip[1] / clip[3]) * height;
	for (int i = 0; i < CORNERS; i++) {
		float angle = 6.2831853f * (float)i / CORNERS;
		ring[i] = (stilb_ui_point){x + LIGHTS_RING * cosf(angle), y + LIGHTS_RING * sinf(angle)};
	}
	stilb_ui_draw_polyline(stilb_ui_list(ui), ring, CORNERS, true, 2.0f, stilb_ui_style_get(ui)->accent);
}

/* ---- the window -------------------------------------------------------------------------------------------------- */

/* At first in the upper left corner, from then on wherever the user moved it. */
static void lights_place(engine_lights *lights, const stilb_ui_style *style, const stilb_ui_input *input,
                         uint32_t count)
{
	float around = 2.0f * style->margin, below = (float)LIGHTS_CONTROLS * (style->control_height + style->gap);
	float rows = style->row_height * (float)(count < LIGHTS_ROWS ? count : LIGHTS_ROWS);
	float height = style->title_height + around + LIGHTS_BORDER + rows + style->gap + below;
	float width = fminf(LIGHTS_WIDTH, input->width - around);
	height = fminf(height, input->height - around);
	stilb_ui_rect *place = &lights->place;
	if (stilb_ui_is_empty(*place))
		*place = (stilb_ui_rect){.x0 = style->margin, .y0 = style->margin};
	*place = (stilb_ui_rect){place->x0, place->y0, place->x0 + width, place->y0 + height};
}

bool stilb_engine_lights_shown(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->overlay.lights.open;
}

bool engine_lights_solo(const stilb_engine *engine, uint32_t *light)
{
	const engine_lights *lights = &engine->overlay.lights;
	*light = lights->picked;
	return lights->open && lights->solo && engine->scene && lights->picked < engine->scene->light_count;
}

void engine_lights_draw(stilb_engine *engine, stilb_ui *ui)
{
	engine_lights *lights = &engine->overlay.lights;
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_scene *scene = engine->scene;
	uint32_t count = scene ? scene->light_count : 0;
	if (lights->list.selected >= count)
		lights->list.selected = STILB_UI_NO_ROW;
	if (lights->list.selected == STILB_UI_NO_ROW)
		lights->picked = STILB_UI_NO_ROW;
	else if (lights->list.selected != lights->picked)
		lights_pick(lights, scene);
	if (lights->picked < count)
		lights_draw_mark(engine, &scene->lights[lights->picked], ui);
	lights_place(lights, style, stilb_ui_input_get(ui), count > 0 ? count : 1);
	stilb_ui_id_push(ui, "lights");
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Lights", &lights->place, STILB_UI_PANEL_MOVABLE, &lights->open);
	stilb_ui_rect below = stilb_ui_cut_bottom(&area, (float)LIGHTS_CONTROLS * (style->control_height + style->gap));
	if (count == 0)
		stilb_ui_label_muted(ui, lights_line(style, &area), STILB_UI_ALIGN_LEFT, "The scene has no lights.");
	else
		lights_draw_list(scene, ui, area, &lights->list);
	if (lights->picked >= count) {
		stilb_ui_label_muted(ui, lights_line(style, &below), STILB_UI_ALIGN_LEFT, "Pick a light to change it.");
	} else if (scene->lights[lights->picked].face) {
		stilb_ui_label_muted(ui, lights_line(style, &below), STILB_UI_ALIGN_LEFT,
		                     "A surface shines: see its material.");
	} else {
		lights_draw_light(lights, &scene->lights[lights->picked], ui, &below);
		lights_draw_place(scene, lights->picked, lights->reach, ui, &below);
		lights_draw_buttons(engine, ui, lights_line(style, &below));
	}
	stilb_ui_panel_end(ui);
	stilb_ui_id_pop(ui);
}
