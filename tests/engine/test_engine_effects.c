/* The effects' window: F6 opens it, each effect is switched on and off and keeps its numbers, all of them at once give
 * way to frames without, and the program's own changes are shown. */
#include "engine.h"
#include "engine_internal.h"
#include "support/test.h"

#include <string.h>

#define WIDTH 400u
#define HEIGHT 600u

typedef struct stage {
	stilb_engine *engine;
	stilb_scene *scene;
} stage;

static stage stage_open(void)
{
	stage s;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.samples = 1;
	desc.profile = false;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	assert_int_equal(stilb_scene_create_stress(4, 7, &s.scene), STILB_OK);
	assert_int_equal(stilb_engine_create(&desc, &s.engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	return s;
}

static void stage_close(stage *s)
{
	stilb_engine_destroy(s->engine);
	stilb_scene_destroy(s->scene);
}

static void stage_frame_with(const stage *s, stilb_window_state state)
{
	stilb_engine_report report;
	state.width = WIDTH;
	state.height = HEIGHT;
	state.focused = true;
	assert_int_equal(stilb_engine_input(s->engine, &state), STILB_OK);
	assert_int_equal(stilb_engine_frame(s->engine, &report), STILB_OK);
}

static void stage_press(const stage *s, stilb_window_key key)
{
	stilb_window_state state = {0};
	state.pressed[key] = 1;
	state.held[key] = true;
	stage_frame_with(s, state);
	stage_frame_with(s, (stilb_window_state){0});
}

/* Presses the button at (x, y), drags to the right by `drag` pixels and lets go. */
static void stage_drag(const stage *s, float x, float y, float drag)
{
	stilb_window_state state = {.pointer = true, .pointer_x = x, .pointer_y = y};
	stage_frame_with(s, state);
	state.button = true;
	state.clicks = 1;
	stage_frame_with(s, state);
	state.clicks = 0;
	state.pointer_x += drag;
	stage_frame_with(s, state);
	state.button = false;
	stage_frame_with(s, state);
	stage_frame_with(s, state);
}

/* Where lines of the window are: its left side, and the middle of line `line`, from 0. */
static float line_y(const stage *s, uint32_t line)
{
	const engine_overlay *overlay = &s->engine->overlay;
	const stilb_ui_style *style = stilb_ui_style_get(overlay->ui);
	return overlay->effects.place.y0 + style->title_height + style->margin +
	       (style->control_height + style->gap) * (float)line + 0.5f * style->control_height;
}

static float line_x(const stage *s, float share)
{
	stilb_ui_rect place = s->engine->overlay.effects.place;
	return place.x0 + 16.0f + share * (place.x1 - place.x0 - 32.0f);
}

enum {
	WITHOUT,
	EXPOSURE,
	OCCLUSION,
	RADIUS,
	MOTION,
	LONGEST,
	MOTION_OF,
	MOTION_FAR,
	BLOOM,
	BLOOM_WIDTH,
	IMAGES,
	PLACE,
	DITHER,
	AA,
	MIRROR,
	LENS
};

static void effects_are_switched(void **state)
{
	(void)state;
	stage s = stage_open();
	stage_frame_with(&s, (stilb_window_state){0});
	stage_press(&s, STILB_WINDOW_KEY_F6);
	assert_true(s.engine->overlay.effects.open);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, BLOOM), 0.0f);
	assert_true(stilb_engine_post(s.engine).bloom == 0.05f);
	stage_drag(&s, line_x(&s, 0.6f), line_y(&s, BLOOM), 30.0f);
	stilb_post_settings bright = stilb_engine_post(s.engine);
	assert_true(bright.bloom > 0.05f && bright.bloom <= 1.0f && bright.occlusion == 0.0f);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, BLOOM), 0.0f); /* off, and on as it was */
	assert_true(stilb_engine_post(s.engine).bloom == 0.0f);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, BLOOM), 0.0f);
	assert_true(stilb_engine_post(s.engine).bloom == bright.bloom);
	stage_drag(&s, line_x(&s, 0.4f), line_y(&s, BLOOM_WIDTH), 9.0f);
	assert_true(stilb_engine_post(s.engine).bloom_width > 0.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, IMAGES), 0.0f);
	assert_int_equal(stilb_engine_post(s.engine).bloom_format, STILB_POST_BLOOM_FIXED);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, IMAGES), 0.0f);
	assert_int_equal(stilb_engine_post(s.engine).bloom_format, STILB_POST_BLOOM_HALF);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, PLACE), 0.0f);
	assert_int_equal(stilb_engine_post(s.engine).place, STILB_POST_PLACE_GPU);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, OCCLUSION), 0.0f);
	stage_drag(&s, line_x(&s, 0.4f), line_y(&s, RADIUS), 9.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, DITHER), 0.0f);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, MOTION), 0.0f);
	stage_drag(&s, line_x(&s, 0.4f), line_y(&s, LONGEST), 9.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, MOTION_OF), 0.0f);
	stage_drag(&s, line_x(&s, 0.4f), line_y(&s, MOTION_FAR), 9.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, AA), 0.0f);
	stilb_post_settings moving = stilb_engine_post(s.engine);
	assert_true(moving.motion_blur == 0.5f && moving.motion_blur_most > 0.0f &&
	            moving.motion == STILB_POST_MOTION_FAR && moving.motion_blur_far > 0.0f &&
	            moving.aa == STILB_POST_AA_POST);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, MOTION), 0.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, MIRROR), 0.0f);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, LENS), 0.0f);
	stilb_post_settings all = stilb_engine_post(s.engine);
	assert_true(all.reflections == 1 && all.dof == 1 && all.aperture > 0.0f && all.focus > 0.0f);
	assert_true(all.dither == 1);
	assert_true(all.occlusion == 1.0f && all.occlusion_radius > 0.0f && all.bloom == bright.bloom);
	stage_close(&s);
}

static void frames_without_them(void **state)
{
	(void)state;
	stage s = stage_open();
	stilb_post_settings chosen = {.bloom = 0.25f, .bloom_width = 0.5f}, none = {0};
	stilb_engine_set_post(s.engine, &chosen);
	stage_press(&s, STILB_WINDOW_KEY_F6);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, WITHOUT), 0.0f);
	stilb_post_settings now = stilb_engine_post(s.engine);
	assert_memory_equal(&now, &none, sizeof none);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, WITHOUT), 0.0f);
	now = stilb_engine_post(s.engine);
	assert_memory_equal(&now, &chosen, sizeof chosen);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, WITHOUT), 0.0f);
	chosen.bloom = 0.125f; /* by the program */
	stilb_engine_set_post(s.engine, &chosen);
	stage_frame_with(&s, (stilb_window_state){0});
	assert_false(s.engine->overlay.effects.without);
	now = stilb_engine_post(s.engine);
	assert_memory_equal(&now, &chosen, sizeof chosen);
	stage_press(&s, STILB_WINDOW_KEY_F6); /* closed, a click reaches nothing */
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, BLOOM), 0.0f);
	now = stilb_engine_post(s.engine);
	assert_memory_equal(&now, &chosen, sizeof chosen);
	stage_close(&s);
}

/* What a scene's camera was metered to and what adapts are never added up; and a scene that comes has its own. */
static void exposure_counts_once(void **state)
{
	(void)state;
	stage s = stage_open();
	s.scene->camera.exposure = 3.0f;
	stage_press(&s, STILB_WINDOW_KEY_F6);
	assert_true(s.engine->views[0].exposure == 3.0f);
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, EXPOSURE), 0.0f);
	assert_true(stilb_engine_post(s.engine).exposure_adapts);
	assert_true(s.engine->views[0].exposure == stilb_post_exposure(s.engine->post));
	s.scene->camera.exposure = 4.0f; /* by the user, on top of it */
	stage_frame_with(&s, (stilb_window_state){0});
	assert_true(s.engine->views[0].exposure == stilb_post_exposure(s.engine->post) + 1.0f);
	stilb_scene *next;
	assert_int_equal(stilb_scene_create_stress(4, 9, &next), STILB_OK);
	next->camera.exposure = -2.0f;
	assert_int_equal(stilb_engine_set_scene(s.engine, next), STILB_OK);
	stage_frame_with(&s, (stilb_window_state){0});
	assert_true(s.engine->views[0].exposure == stilb_post_exposure(s.engine->post));
	stage_drag(&s, line_x(&s, 0.0f), line_y(&s, EXPOSURE), 0.0f);
	stage_frame_with(&s, (stilb_window_state){0});
	assert_false(stilb_engine_post(s.engine).exposure_adapts);
	assert_true(s.engine->views[0].exposure == -2.0f);
	assert_int_equal(stilb_engine_set_scene(s.engine, s.scene), STILB_OK);
	stilb_scene_destroy(next);
	stage_close(&s);
}

/* The button that saves them is there where the program does so, and tells it once. */
static void looks_are_saved(void **state)
{
	(void)state;
	stage s = stage_open();
	stilb_engine_report report;
	stage_press(&s, STILB_WINDOW_KEY_F6);
	stage_drag(&s, line_x(&s, 0.5f), line_y(&s, 1), 0.0f); /* another line */
	s.engine->desc.saves = true;
	stage_frame_with(&s, (stilb_window_state){0});
	stilb_window_state state_of = {
		.pointer = true, .pointer_x = line_x(&s, 0.5f), .pointer_y = line_y(&s, 1), .width = WIDTH, .height = HEIGHT};
	uint32_t told = 0;
	for (uint32_t frame = 0; frame < 6; frame++) {
		state_of.button = frame == 1 || frame == 2;
		state_of.clicks = frame == 1;
		assert_int_equal(stilb_engine_input(s.engine, &state_of), STILB_OK);
		assert_int_equal(stilb_engine_frame(s.engine, &report), STILB_OK);
		told += report.saves_look;
	}
	assert_int_equal(told, 1);
	stage_close(&s);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(effects_are_switched),
		cmocka_unit_test(frames_without_them),
		cmocka_unit_test(exposure_counts_once),
		cmocka_unit_test(looks_are_saved),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
