/* A picture of the program's in place of the scene, on the device and under the validation layer: its pixels, the
 * scene's beside them, which are those of a frame without it, whether or not the scene is still. */
#include "engine_internal.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"
#include "support/picture_reference.h"
#include "tests/engine/stress_engine.h"

enum { WIDTH = 96, HEIGHT = 64 };

static float radiance[HEIGHT][WIDTH][3];

static int make_radiance(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
		(&radiance[0][0][0])[i] = (float)(stilb_random_u64(3, i) % 256) / 64.0f;
	return 0;
}

static stilb_engine *make_engine(stilb_render_output output)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.output = output;
	desc.validate = true;
	desc.profile = false;
	if (stress_engine_create(&desc, &(stress_engine){.models = 300, .seed = 5}, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_engine_scene(engine)->camera.exposure = -1.0f; /* half as bright, which radiance is not */
	return engine;
}

/* Draws a frame and reads its picture; *draws is the number of draws. */
static stilb_image draw(stilb_engine *engine, uint64_t *draws)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	*draws = report.render.draws;
	return image;
}

static bool shows_radiance(const stilb_image *image, uint32_t x, uint32_t y)
{
	const uint8_t *got = (const uint8_t *)image->pixels + 3 * (y * image->width + x);
	const float *in = radiance[y][x];
	stilb_vec3 light = shade_tonemap(stilb_vec3_make(in[0], in[1], in[2]) * 0.5f, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
	bool same = true;
	for (int c = 0; c < 3; c++)
		same = same && abs((int)got[c] - (int)(255.0f * shade_srgb_from_linear(light[c]) + 0.5f)) <= 1;
	return same;
}

/* Left of column `edge` the image has the pixels of `scene`, from there on those of the radiance. */
static void assert_divided(stilb_image image, const stilb_image *scene, uint32_t edge)
{
	assert_int_equal(image.width, WIDTH);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			size_t at = 3 * ((size_t)y * WIDTH + x);
			bool good = x < edge ? memcmp((uint8_t *)image.pixels + at, (uint8_t *)scene->pixels + at, 3) == 0
			                     : shows_radiance(&image, x, y);
			if (!good)
				fail_msg("pixel %u, %u beside column %u", x, y, edge);
		}
	stilb_image_finish(&image);
}

static void beside_the_scene(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_DISPLAY);
	uint64_t all, draws;
	float from = 0.5f;
	stilb_engine_shown picture = {
		.radiance = &radiance[0][0][0], .width = WIDTH, .height = HEIGHT, .from = &from, .divider = true};
	stilb_image scene = draw(engine, &all);
	assert_true(all > 100);
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	assert_divided(draw(engine, &draws), &scene, WIDTH / 2);
	picture.radiance = NULL;
	picture.still = true;
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	stilb_engine_caption(engine, "there is no window for it");
	/* The scene is read back in the first of these frames, and drawn in none. */
	for (int i = 0; i < 4; i++) {
		from = (float)i / 4;
		assert_divided(draw(engine, &draws), &scene, WIDTH / 4 * (uint32_t)i);
		assert_true(draws < 10);
	}
	from = 1.5f;
	assert_divided(draw(engine, &draws), &scene, WIDTH);
	assert_int_equal(stilb_engine_dump(engine, "none.dump"), STILB_ERROR_ARGUMENT);
	/* What is no longer still is drawn. */
	stilb_engine_scene(engine)->camera.yaw += 0.1f;
	picture.still = false;
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	stilb_image turned = draw(engine, &draws);
	assert_true(draws > 100 && memcmp(turned.pixels, scene.pixels, stilb_image_size(&scene)) != 0);
	stilb_image_finish(&turned);
	stilb_engine_scene(engine)->camera.yaw -= 0.1f;
	/* A frame of another size: the scene is drawn for it, the picture enlarged. */
	picture.still = true;
	from = 0.5f;
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	assert_int_equal(stilb_engine_resize(engine, 2 * WIDTH, 2 * HEIGHT), STILB_OK);
	stilb_image large = draw(engine, &draws);
	assert_true(draws > 100);
	assert_memory_equal((uint8_t *)large.pixels + 3 * (2 * WIDTH - 1), (uint8_t *)large.pixels + 3 * (2 * WIDTH - 2),
	                    3);
	stilb_image_finish(&large);
	assert_int_equal(stilb_engine_resize(engine, WIDTH, HEIGHT), STILB_OK);
	assert_int_equal(stilb_engine_show(engine, NULL), STILB_OK);
	stilb_image again = draw(engine, &draws);
	assert_int_equal(draws, all);
	assert_memory_equal(again.pixels, scene.pixels, stilb_image_size(&scene));
	stilb_image_finish(&again);
	stilb_image_finish(&scene);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

static void radiance_as_it_is(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_LINEAR);
	uint64_t draws;
	float from = 0.0f;
	stilb_engine_shown picture = {
		.radiance = &radiance[0][0][0], .width = WIDTH, .height = HEIGHT, .from = &from, .still = true};
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	stilb_image image = draw(engine, &draws);
	for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++)
		assert_true(reference_half(((const uint16_t *)image.pixels)[i]) == (double)(&radiance[0][0][0])[i]);
	stilb_image_finish(&image);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

/* Draws frames until the value under the pointer is known, or some are over. */
static bool draw_value(stilb_engine *engine, float x, float y)
{
	stilb_engine_report report;
	stilb_input_state none = {0};
	engine->overlay.input.mouse_present = true;
	engine->overlay.input.mouse_x = x;
	engine->overlay.input.mouse_y = y;
	engine_value_forget(engine);
	for (int i = 0; i < 50 && !engine->value.known; i++) {
		double gpu_ms;
		engine_overlay_act(engine, &none);
		if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_engine_wait(engine, &gpu_ms) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	return engine->value.known;
}

/* Of a channel always, of light once it is asked for; of the program's picture where that covers the pointer; of
 * nothing if there is no pointer. The line beside the pointer is drawn then. */
static void value_under_the_pointer(void **state)
{
	(void)state;
	enum { X = 20, Y = 40 };
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_DISPLAY);
	stilb_image light = {0};
	stilb_engine_report report;
	float from = 0.5f;
	assert_false(draw_value(engine, X + 0.5f, Y + 0.5f));
	for (int channel = 0; channel < 2; channel++) {
		stilb_engine_set_shows(engine, channel ? STILB_RENDER_SHOW_NORMAL : STILB_RENDER_SHOW_SHADED);
		engine->value.open = !channel;
		assert_true(draw_value(engine, X + 0.5f, Y + 0.5f));
		assert_false(engine->overlay.value_open);
		assert_int_equal(stilb_render_read_radiance(engine->render, &light), STILB_OK);
		const uint16_t *texel = (const uint16_t *)light.pixels + light.channels * (Y * WIDTH + X);
		for (int c = 0; c < 3; c++)
			assert_true(engine->value.value[c] == stilb_image_half_to_float(texel[c]));
		assert_true(engine->value.value[0] > 0.0f);
		stilb_image_finish(&light);
		engine_overlay_act(engine, &(stilb_input_state){0});
		assert_true(engine->overlay.value_open && engine_overlay_is_open(&engine->overlay));
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	}
	stilb_engine_set_shows(engine, STILB_RENDER_SHOW_SHADED);
	engine->value.open = true;
	stilb_engine_shown picture = {.radiance = &radiance[0][0][0], .width = WIDTH, .height = HEIGHT, .from = &from};
	assert_int_equal(stilb_engine_show(engine, &picture), STILB_OK);
	assert_true(draw_value(engine, WIDTH - 3.5f, 7.5f));
	for (int c = 0; c < 3; c++)
		assert_true(engine->value.value[c] == radiance[7][WIDTH - 4][c]);
	engine->overlay.input.mouse_present = false;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_false(engine->value.known || engine->value.ticket != 0);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

/* C goes through all that pictures can show and names it, back with Shift. */
static void keys_go_through_the_channels(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_DISPLAY);
	stilb_input_state next = {0}, back = {0};
	next.actions[STILB_ENGINE_SHOW] = 1;
	back.actions[STILB_ENGINE_SHOW_BACK] = 1;
	for (int i = 1; i <= STILB_RENDER_SHOWS; i++) {
		engine_images_act(engine, &next);
		assert_int_equal(stilb_engine_shows(engine), i % STILB_RENDER_SHOWS);
	}
	engine_images_act(engine, &back);
	assert_int_equal(stilb_engine_shows(engine), STILB_RENDER_SHOWS - 1);
	assert_int_equal(engine->overlay.toasts.count, ENGINE_TOASTS);
	stress_engine_destroy(engine);
}

/* L goes through the ways of lighting; the pictures of all are the same but for deferred's rounding. */
static void keys_go_through_the_ways_of_lighting(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_DISPLAY);
	stilb_input_state next = {0}, back = {0};
	next.actions[STILB_ENGINE_LIGHTING] = 1;
	back.actions[STILB_ENGINE_LIGHTING_BACK] = 1;
	for (int i = 1; i <= STILB_RENDER_LIGHTING_WAYS; i++) {
		stilb_engine_report report;
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		engine_images_act(engine, &next);
		assert_int_equal(stilb_engine_lighting(engine), i % STILB_RENDER_LIGHTING_WAYS);
	}
	engine_images_act(engine, &back);
	assert_int_equal(stilb_engine_lighting(engine), STILB_RENDER_LIGHTING_WAYS - 1);
	stilb_engine_set_lighting(engine, STILB_RENDER_LIGHTING_FORWARD);
	assert_int_equal(stilb_engine_lighting(engine), STILB_RENDER_LIGHTING_FORWARD);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

/* What lights in place of the surroundings holds from the next frame on. */
static void ambient_light_is_switched(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_OUTPUT_DISPLAY);
	uint64_t draws;
	assert_int_equal(stilb_engine_ambient(engine), STILB_RENDER_AMBIENT_ENVIRONMENT);
	stilb_image before = draw(engine, &draws);
	stilb_engine_set_ambient(engine, STILB_RENDER_AMBIENT_NONE);
	assert_int_equal(stilb_engine_ambient(engine), STILB_RENDER_AMBIENT_NONE);
	stilb_image dark = draw(engine, &draws);
	stilb_engine_set_ambient(engine, STILB_RENDER_AMBIENT_ENVIRONMENT);
	stilb_image after = draw(engine, &draws);
	assert_memory_not_equal(before.pixels, dark.pixels, stilb_image_size(&before));
	assert_memory_equal(before.pixels, after.pixels, stilb_image_size(&before));
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_image_finish(&before);
	stilb_image_finish(&dark);
	stilb_image_finish(&after);
	stress_engine_destroy(engine);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(beside_the_scene),
		cmocka_unit_test(radiance_as_it_is),
		cmocka_unit_test(value_under_the_pointer),
		cmocka_unit_test(keys_go_through_the_channels),
		cmocka_unit_test(keys_go_through_the_ways_of_lighting),
		cmocka_unit_test(ambient_light_is_switched),
	};
	return cmocka_run_group_tests(tests, make_radiance, NULL);
}
