/* Grading on the device beside the same on the CPU: cubes and curves after each tone map, what stays as it is, and
 * areas that blend at doorways. */
#include "engine_internal.h"
#include "post/post_internal.h"
#include "post_stage.h"

#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static void stage_codes(post_stage *s, stilb_render_view view, uint8_t *codes)
{
	stilb_image image = {0};
	stage_draw_view(s, view);
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.channels, 4); /* there is no backdrop */
	for (uint32_t p = 0; p < s->width * s->height; p++)
		memcpy(codes + 3 * p, (const uint8_t *)image.pixels + 4 * (size_t)p, 3);
	stilb_image_finish(&image);
}

enum { SIDE = 64, PIXELS = SIDE * SIDE };
static float light[3 * PIXELS];
static uint8_t codes[3 * PIXELS], plain[3 * PIXELS];

/* Greys and colours from dark to ten times white, as halves. */
static void light_fill(uint64_t seed)
{
	for (uint64_t p = 0; p < PIXELS; p++) {
		float height = exp2f(10.0f * stilb_random_float(seed, 4 * p) - 7.0f);
		for (uint64_t c = 0; c < 3; c++) {
			float value = height * (p % 4 == 0 ? 1.0f : stilb_random_float(seed, 4 * p + 1 + c));
			light[3 * p + c] = stilb_image_half_to_float(stilb_image_half_from_float(value));
		}
	}
}

static stilb_post_table *table_make(uint64_t seed, uint32_t size, bool curves)
{
	stilb_post_table *t;
	uint32_t count = curves ? size : size * size * size;
	assert_int_equal(stilb_post_table_identity(curves ? 2 : size, &t), STILB_OK);
	free(t->values);
	t->values = malloc((size_t)count * 3 * sizeof *t->values);
	assert_non_null(t->values);
	t->size = size;
	t->curves = curves;
	for (uint32_t i = 0; i < 3 * count; i++)
		t->values[i] = 1.2f * stilb_random_float(seed, i) - 0.1f;
	for (uint32_t c = 0; c < 3; c++) {
		t->low[c] = -0.2f * (float)c;
		t->high[c] = 0.8f + 0.3f * (float)c;
	}
	return t;
}

/* The codes of a pixel, not rounded. */
static void code_of(const float rgb[3], uint32_t tone, float stops, const stilb_post_table *table, float out[3])
{
	float code[3];
	stilb_vec3 shown = shade_tone((int)tone, stilb_vec3_make(rgb[0], rgb[1], rgb[2]) * exp2f(stops));
	for (int c = 0; c < 3; c++)
		out[c] = code[c] = shade_srgb_from_linear(shown[c]);
	if (table)
		stilb_post_table_at(table, code, out);
	for (int c = 0; c < 3; c++)
		out[c] = 255.0f * fminf(fmaxf(out[c], 0.0f), 1.0f);
}

static void pictures_are_those_of_the_table(void **state)
{
	(void)state;
	static const struct {
		uint32_t size;
		bool curves;
	} tables[] = {{2, false}, {3, false}, {17, false}, {64, false}, {2, true}, {255, true}, {256, true}, {5000, true}};
	static const float origin[3] = {0};
	post_stage s;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	light_fill(3);
	stage_light(&s, light);
	for (uint32_t i = 0; i < sizeof tables / sizeof *tables; i++) {
		/* Among random entries a step of a float at the place of a colour is `size` steps of what stands there. */
		stilb_post_table *table = table_make(i, tables[i].size, tables[i].curves);
		double most = 0.0;
		stilb_render_view view = stage_view();
		assert_int_equal(stilb_post_set_grade(s.post, table, NULL, 0), STILB_OK);
		assert_int_equal(stilb_post_stand(s.post, origin), STILB_OK);
		view.grade = stilb_post_grade(s.post);
		assert_non_null(view.grade);
		view.tone = i % SHADE_TONE_COUNT;
		view.exposure = 0.5f * (float)(i % 3);
		stage_codes(&s, view, codes);
		for (uint32_t p = 0; p < PIXELS; p++) {
			float want[3];
			code_of(&light[3 * p], view.tone, view.exposure, table, want);
			for (uint32_t c = 0; c < 3; c++)
				most = fmax(most, fabs((double)codes[3 * p + c] - (double)want[c]));
		}
		print_message("%u entries%s: off by %.2f codes at most\n", table->size, table->curves ? ", curves" : "", most);
		assert_true(most < 0.7 + 2e-4 * table->size);
		stilb_post_table_destroy(table);
	}
	stage_close(&s);
}

/* A table that changes nothing is no row; and one on the device would change no code. */
static void identities_change_nothing(void **state)
{
	(void)state;
	static const float origin[3] = {0};
	post_stage s;
	stilb_post_table *table;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	light_fill(4);
	stage_light(&s, light);
	stilb_render_view view = stage_view();
	view.tone = SHADE_TONE_NEUTRAL;
	stage_codes(&s, view, plain);
	for (uint32_t size = 2; size <= 33; size += 31) {
		assert_int_equal(stilb_post_table_identity(size, &table), STILB_OK);
		assert_int_equal(stilb_post_set_grade(s.post, table, NULL, 0), STILB_OK);
		assert_int_equal(stilb_post_stand(s.post, origin), STILB_OK);
		assert_null(stilb_post_grade(s.post));
		table->values[3] += 1e-5f; /* no identity any more, though none that codes could tell */
		assert_int_equal(stilb_post_set_grade(s.post, table, NULL, 0), STILB_OK);
		assert_int_equal(stilb_post_stand(s.post, origin), STILB_OK);
		view.grade = stilb_post_grade(s.post);
		assert_non_null(view.grade);
		stage_codes(&s, view, codes);
		assert_memory_equal(codes, plain, sizeof codes);
		stilb_post_table_destroy(table);
	}
	/* Radiance is not graded. */
	stage_close(&s);
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, SIDE, SIDE);
	table = table_make(1, 5, false);
	stage_light(&s, light);
	assert_int_equal(stilb_post_set_grade(s.post, table, NULL, 0), STILB_OK);
	assert_int_equal(stilb_post_stand(s.post, origin), STILB_OK);
	view.grade = stilb_post_grade(s.post);
	stage_draw_view(&s, view);
	assert_int_equal(stilb_gpu_plan_find(stilb_render_plan(s.render), "grade"), 0);
	stilb_post_table_destroy(table);
	stage_close(&s);
}

/* ---- areas ------------------------------------------------------------------------------------------------------- */

/* Two rooms that share the wall x = 0, and a corner of the second that belongs to a third. */
static const stilb_post_area rooms[3] = {
	{.low = {-4, 0, -3}, .high = {0, 3, 3}, .blend = 1.0f, .exposure = 2.0f},
	{.low = {0, 0, -3}, .high = {4, 3, 3}, .blend = 1.0f, .exposure = -1.0f},
	{.low = {3, 0, -3}, .high = {4, 3, 0}, .blend = 0.0f},
};

static void doorways_blend(void **state)
{
	(void)state;
	float weights[3];
	for (float x = -3.0f; x <= 3.0f; x += 0.01f) { /* through the doorway: together they are always one */
		float left = post_grade_weights(rooms, 2, (const float[3]){x, 1.5f, 0.0f}, weights);
		double t = fmin(fmax(0.5 + (double)x, 0.0), 1.0), second = t * t * (3.0 - 2.0 * t);
		assert_true(fabs((double)weights[1] - second) < 1e-5 && fabs((double)weights[0] - (1.0 - second)) < 1e-5);
		assert_true(left < 1e-5f);
	}
	/* Out through a wall: down to nothing half a metre outside, a half at the wall. */
	assert_true(fabsf(post_grade_weights(rooms, 2, (const float[3]){-2.0f, 1.5f, 3.0f}, weights) - 0.5f) < 1e-6f);
	assert_true(fabsf(weights[0] - 0.5f) < 1e-6f);
	assert_true(post_grade_weights(rooms, 2, (const float[3]){-2.0f, 1.5f, 3.51f}, weights) == 1.0f);
	assert_true(post_grade_weights(rooms, 2, (const float[3]){-2.0f, 1.5f, 2.49f}, weights) == 0.0f &&
	            weights[0] == 1.0f);
	/* Around a corner it goes by distance. */
	post_grade_weights(rooms, 1, (const float[3]){-4.15f, 1.5f, 3.2f}, weights);
	double t = 0.5 - 0.25, corner = t * t * (3.0 - 2.0 * t);
	assert_true(fabs((double)weights[0] - corner) < 1e-5);
	/* Where boxes overlap each has its share of one. */
	float left = post_grade_weights(rooms, 3, (const float[3]){3.4f, 1.5f, -1.5f}, weights);
	assert_true(left == 0.0f && weights[1] == 0.5f && weights[2] == 0.5f);
	post_grade_weights(rooms, 3, (const float[3]){2.99f, 1.5f, -1.5f}, weights);
	assert_true(weights[2] == 0.0f && weights[1] == 1.0f);
}

/* What is seen on the way from room to room is the mean of what their tables show, and so is the exposure. */
static void tables_blend(void **state)
{
	(void)state;
	post_stage s;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	light_fill(5);
	stage_light(&s, light);
	stilb_post_table *tables[2] = {table_make(1, 9, false), table_make(2, 9, false)};
	for (int t = 0; t < 2; t++)
		for (int c = 0; c < 3; c++) { /* so that their mean is a table of as many entries */
			tables[t]->low[c] = 0.0f;
			tables[t]->high[c] = 1.0f;
		}
	stilb_post_area areas[2] = {rooms[0], rooms[1]};
	areas[0].table = tables[0];
	areas[1].table = tables[1];
	assert_int_equal(stilb_post_set_grade(s.post, NULL, areas, 2), STILB_OK);
	static const float places[] = {-2.0f, -0.3f, 0.0f, 0.2f, 0.9f};
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		float weights[2];
		double most = 0.0;
		const float place[3] = {places[i], 1.0f, 0.5f};
		post_grade_weights(areas, 2, place, weights);
		assert_int_equal(stilb_post_stand(s.post, place), STILB_OK);
		assert_true(fabsf(stilb_post_exposure(s.post) - (2.0f * weights[0] - weights[1])) < 1e-6f);
		stilb_render_view view = stage_view();
		view.grade = stilb_post_grade(s.post);
		stage_codes(&s, view, codes);
		for (uint32_t p = 0; p < PIXELS; p++) {
			float shown[2][3], code[3];
			code_of(&light[3 * p], view.tone, 0.0f, NULL, code);
			for (int c = 0; c < 3; c++)
				code[c] /= 255.0f;
			for (int t = 0; t < 2; t++)
				stilb_post_table_at(tables[t], code, shown[t]);
			for (uint32_t c = 0; c < 3; c++) {
				float mean = weights[0] * shown[0][c] + weights[1] * shown[1][c];
				most = fmax(most, fabs((double)codes[3 * p + c] - 255.0 * fmin(fmax((double)mean, 0.0), 1.0)));
			}
		}
		assert_true(most < 0.71);
	}
	/* Outside there is no table, and no row. */
	assert_int_equal(stilb_post_stand(s.post, (const float[3]){0.0f, 1.0f, 9.0f}), STILB_OK);
	assert_null(stilb_post_grade(s.post));
	assert_true(stilb_post_exposure(s.post) == 0.0f);
	stilb_post_table_destroy(tables[0]);
	stilb_post_table_destroy(tables[1]);
	stage_close(&s);
}

/* The engine's camera walks from room to room: no step of it changes a pixel's code by more than a few. */
static void cameras_walk_through_doorways(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	stilb_engine_report report;
	stilb_scene *scene;
	stilb_image before = {0}, now = {0};
	desc.workers = 0;
	desc.width = desc.height = SIDE;
	desc.samples = 1;
	desc.profile = false;
	desc.validate = true;
	assert_int_equal(stilb_scene_create_stress(4, 1, &scene), STILB_OK);
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	stilb_post_table *tables[2];
	for (int t = 0; t < 2; t++) { /* one is dark, one without blue */
		assert_int_equal(stilb_post_table_identity(5, &tables[t]), STILB_OK);
		for (uint32_t i = 0; i < 125; i++)
			for (uint32_t c = 0; c < 3; c++)
				tables[t]->values[3 * i + c] *= t == 0 ? 0.5f : c == 2 ? 0.0f : 1.0f;
	}
	stilb_post_area areas[2] = {rooms[0], rooms[1]};
	areas[0].table = tables[0];
	areas[1].table = tables[1];
	areas[0].exposure = areas[1].exposure = 0.0f;
	assert_int_equal(stilb_engine_set_grade(engine, NULL, areas, 2), STILB_OK);
	scene->camera.pitch = 1.5f; /* up: the sky fills the picture */
	int first = 0, last = 0;
	for (int step = 0; step <= 60; step++) {
		scene->camera.position[0] = -0.6f + 0.02f * (float)step;
		scene->camera.position[1] = 2.0f;
		scene->camera.position[2] = 0.0f;
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(stilb_render_read_image(engine->render, &now), STILB_OK);
		const uint8_t *codes_now = now.pixels, *codes_before = before.pixels;
		for (uint32_t i = 0; before.pixels && i < 3 * PIXELS; i++)
			assert_in_range(codes_now[i] - codes_before[i] + 8, 0, 16);
		first = step == 0 ? codes_now[2] : first;
		last = codes_now[2];
		stilb_image_finish(&before);
		before = now;
		now = (stilb_image){0};
	}
	stilb_image_finish(&before);
	print_message("blue goes from %d to %d\n", first, last);
	assert_true(first > 30 && last <= 1);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	stilb_post_table_destroy(tables[0]);
	stilb_post_table_destroy(tables[1]);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_those_of_the_table),
		cmocka_unit_test(identities_change_nothing),
		cmocka_unit_test(doorways_blend),
		cmocka_unit_test(tables_blend),
		cmocka_unit_test(cameras_walk_through_doorways),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
