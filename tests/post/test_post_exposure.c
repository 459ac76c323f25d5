/* Exposure that adapts: its pace beside the closed form, what the device counts beside the CPU, and when it counts. */
#include "engine_internal.h"
#include "post/post_internal.h"
#include "post_stage.h"

#include <float.h>

/* ---- pace -------------------------------------------------------------------------------------------------------- */

static stilb_post_settings settings_of(float speed, float rate)
{
	stilb_post_settings settings = {.exposure_adapts = true, .exposure_speed = speed, .exposure_rate = rate};
	post_exposure_defaults(&settings);
	return settings;
}

/* The distance after some seconds: linear to where the exponential is as slow, then that. */
static double distance_after(double distance, double seconds, double speed, double rate)
{
	double linear = fmax(distance - rate / speed, 0.0) / rate;
	if (seconds <= linear)
		return distance - rate * seconds;
	return fmin(distance, rate / speed) * exp(-speed * (seconds - linear));
}

static void pace_is_the_same_in_any_steps(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 2000; i++) {
		float speed = 0.1f + 5.0f * stilb_random_float(1, i), rate = 0.2f + 8.0f * stilb_random_float(2, i);
		float from = 20.0f * stilb_random_float(3, i) - 10.0f, to = 20.0f * stilb_random_float(4, i) - 10.0f;
		stilb_post_settings settings = settings_of(speed, rate);
		float at = from;
		double seconds = 0.0;
		for (uint64_t s = 0; s < 1 + i % 40; s++) { /* frames of 0 to 0.1 s */
			float step = s % 7 == 0 ? 0.0f : 0.1f * stilb_random_float(5 + i, s), before = at;
			at = post_exposure_step(at, to, step, &settings);
			seconds += (double)step;
			assert_true(fabsf(at - before) <= rate * step + 2e-6f);
			assert_true(fabsf(to - at) <= fabsf(to - before));
		}
		double away = distance_after(fabs((double)to - (double)from), seconds, (double)speed, (double)rate);
		assert_true(fabs(fabs((double)to - (double)at) - away) < 4e-5);
	}
	/* Near by it is 1 - exp(-a t). */
	stilb_post_settings settings = settings_of(3.0f, 6.0f);
	assert_true(fabs((double)post_exposure_step(1.0f, 2.0f, 0.25f, &settings) - (2.0 - exp(-0.75))) < 1e-6);
	assert_true(post_exposure_step(1.0f, 1.0f, 1.0f, &settings) == 1.0f);
	assert_true(fabsf(post_exposure_step(0.0f, -9.0f, 0.5f, &settings) - -3.0f) < 1e-6f);
	assert_true(post_exposure_step(0.0f, 5.0f, 1e9f, &settings) == 5.0f);
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

static int by_value(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* The exposure of a light by its definition, in double: the mean of log2 luminance between the percentiles. */
static bool exposure_defined(const float *rgb, uint32_t pixels, const stilb_post_settings *settings, double *stops)
{
	double *logs = calloc(pixels, sizeof *logs), sum = 0.0;
	uint32_t count = 0;
	assert_non_null(logs);
	for (uint32_t p = 0; p < pixels; p++) {
		double l = 0.2126 * (double)rgb[3 * p] + 0.7152 * (double)rgb[3 * p + 1] + 0.0722 * (double)rgb[3 * p + 2];
		if (isfinite(l) && l >= exp2(-16.0))
			logs[count++] = log2(l);
	}
	qsort(logs, count, sizeof *logs, by_value);
	double low = (double)settings->exposure_low * count, high = (double)settings->exposure_high * count;
	for (uint32_t i = 0; i < count; i++)
		sum += fmax(fmin(i + 1.0, high) - fmax(i, low), 0.0) * logs[i];
	free(logs);
	*stops = fmin(fmax(log2(0.18) - sum / (high - low), (double)settings->exposure_darkest),
	              (double)settings->exposure_brightest);
	return count > 0;
}

/* Light over 20 stops, with some that is black, negative, NaN and infinite. */
static void light_fill(const post_stage *s, uint64_t seed, float *rgb)
{
	static const float odd[] = {0.0f, -1.0f, NAN, INFINITY, 1e-6f};
	for (uint32_t p = 0; p < s->width * s->height; p++) {
		float height = exp2f(20.0f * stilb_random_float(seed, 4ull * p) - 10.0f);
		bool rare = p > 0 && stilb_random_float(seed, 4ull * p + 1) < 0.1f;
		for (uint32_t c = 0; c < 3; c++)
			rgb[3 * p + c] = height * (0.3f + 0.7f * stilb_random_float(seed + 1 + c, p));
		if (rare)
			rgb[3 * p] = rgb[3 * p + 1] = rgb[3 * p + 2] = odd[p % (sizeof odd / sizeof *odd)];
		for (uint32_t c = 0; c < 3; c++)
			rgb[3 * p + c] = stilb_image_half_to_float(stilb_image_half_from_float(rgb[3 * p + c]));
	}
}

static float *light_make(const post_stage *s)
{
	float *rgb = calloc((size_t)s->width * s->height, 3 * sizeof *rgb);
	assert_non_null(rgb);
	return rgb;
}

#define CLASS 0.046 /* stops: half of the widest class */

static void counts_are_as_defined(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {67, 41}, {640, 360}, {16384, 1}};
	static const stilb_post_settings cases[] = {
		{.exposure_adapts = true},
		{.exposure_adapts = true, .exposure_low = 0.0f, .exposure_high = 1.0f},
		{.exposure_adapts = true, .exposure_low = 0.8f, .exposure_high = 0.83f},
		{.exposure_adapts = true, .exposure_darkest = -2.0f, .exposure_brightest = -1.5f},
	};
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		post_stage s;
		stage_open(&s, STILB_RENDER_DEVICE_VULKAN, sizes[i][0], sizes[i][1]);
		float *rgb = light_make(&s);
		light_fill(&s, 7 + i, rgb);
		stage_light(&s, rgb);
		for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
			stilb_post_settings settings = cases[c];
			double want;
			stilb_post_set(s.post, &settings);
			stilb_post_forget(s.post);
			assert_true(stilb_post_is_blind(s.post));
			stage_draw(&s);
			assert_int_equal(stilb_post_look(s.post), STILB_OK);
			assert_false(stilb_post_is_blind(s.post));
			post_exposure_defaults(&settings);
			assert_true(exposure_defined(rgb, s.width * s.height, &settings, &want));
			double got = (double)stilb_post_exposure(s.post);
			print_message("%u x %u, case %zu: %.3f EV, defined %.3f\n", s.width, s.height, c, got, want);
			assert_true(fabs(got - want) < CLASS);
		}
		free(rgb);
		stage_close(&s);
	}
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void light_even(const post_stage *s, float value)
{
	float *rgb = light_make(s);
	for (uint32_t i = 0; i < 3 * s->width * s->height; i++)
		rgb[i] = value;
	stage_light((post_stage *)s, rgb);
	free(rgb);
}

/* Light that jumps by four stops: the exposure of each frame is the closed form's, counted from the second frame after
 * the jump on. */
static void frames_follow(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 32, 32);
	stilb_post_settings settings = {.exposure_adapts = true, .exposure_speed = 2.0f, .exposure_rate = 3.0f};
	stilb_post_set(s.post, &settings);
	light_even(&s, 0.25f);
	assert_int_equal(stilb_post_adapt(s.post, 0.1f), STILB_OK);
	assert_true(stilb_post_exposure(s.post) == 0.0f);
	stage_draw(&s);
	assert_int_equal(stilb_post_look(s.post), STILB_OK);
	double first = (double)stilb_post_exposure(s.post), seconds = 0.0;
	assert_true(fabs(first - log2(0.18 / 0.25)) < 2 * CLASS);
	for (int f = 0; f < 5; f++) { /* nothing moves: nothing changes */
		assert_int_equal(stilb_post_adapt(s.post, 0.5f), STILB_OK);
		assert_true((double)stilb_post_exposure(s.post) == first);
		stage_draw(&s);
	}
	light_even(&s, 4.0f);
	for (uint32_t f = 0; f < 60; f++) {
		float step = f % 5 == 3 ? 0.0f : 0.12f * stilb_random_float(9, f);
		assert_int_equal(stilb_post_adapt(s.post, step), STILB_OK);
		seconds += f >= 2 ? (double)step : 0.0;
		double want = first - 4.0 + distance_after(4.0, seconds, 2.0, 3.0);
		assert_true(fabs((double)stilb_post_exposure(s.post) - want) < 1e-4);
		stage_draw(&s);
	}
	assert_true((double)stilb_post_exposure(s.post) < first - 3.5);
	stilb_post_forget(s.post); /* another scene */
	assert_true(stilb_post_is_blind(s.post));
	light_even(&s, 1.0f);
	for (int f = 0; f < 3; f++) { /* without a look its first two frames are as the ones before */
		assert_int_equal(stilb_post_adapt(s.post, 0.01f), STILB_OK);
		stage_draw(&s);
	}
	assert_true(fabs((double)stilb_post_exposure(s.post) - log2(0.18)) < 2 * CLASS);
	stage_close(&s);
}

static void black_light_and_other_sizes_keep_it(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 40, 30);
	stilb_post_set(s.post, &(stilb_post_settings){.exposure_adapts = true});
	light_even(&s, 0.5f);
	stage_draw(&s);
	assert_int_equal(stilb_post_look(s.post), STILB_OK);
	float known = stilb_post_exposure(s.post);
	light_even(&s, 0.0f);
	for (int f = 0; f < 4; f++) {
		assert_int_equal(stilb_post_adapt(s.post, 1.0f), STILB_OK);
		assert_true(stilb_post_exposure(s.post) == known);
		stage_draw(&s);
	}
	light_even(&s, NAN);
	for (int f = 0; f < 4; f++) {
		assert_int_equal(stilb_post_adapt(s.post, 1.0f), STILB_OK);
		assert_true(stilb_post_exposure(s.post) == known);
		stage_draw(&s);
	}
	stage_resize(&s, 200, 100);
	light_even(&s, 0.5f);
	for (int f = 0; f < 4; f++) {
		assert_int_equal(stilb_post_adapt(s.post, 1.0f), STILB_OK);
		assert_true(stilb_post_exposure(s.post) == known);
		stage_draw(&s);
	}
	stage_close(&s);
}

static void without_it_there_is_no_row(void **state)
{
	(void)state;
	post_stage s;
	stage_open(&s, STILB_RENDER_DEVICE_VULKAN, 40, 30);
	light_even(&s, 0.5f);
	stage_draw(&s);
	uint32_t plain = stilb_gpu_plan_passes(stilb_render_plan(s.render));
	stilb_post_set(s.post,
	               &(stilb_post_settings){.exposure_adapts = true, .bloom = 0.1f, .place = STILB_POST_PLACE_GPU});
	stage_draw(&s);
	const stilb_gpu_plan *plan = stilb_render_plan(s.render);
	uint32_t exposure = UINT32_MAX, bloom = 0;
	for (uint32_t p = stilb_gpu_plan_passes(plan); p-- > 0;) {
		const char *name = stilb_gpu_plan_row(plan, p)->name;
		exposure = strcmp(name, "exposure") == 0 ? p : exposure;
		bloom = strcmp(name, "bloom halved") == 0 ? p : bloom;
	}
	assert_true(exposure < bloom); /* of the light before the lens scatters it */
	stilb_post_set(s.post, &(stilb_post_settings){.exposure_speed = 3.0f});
	stage_draw(&s);
	assert_int_equal(stilb_gpu_plan_passes(stilb_render_plan(s.render)), plain);
	assert_true(stilb_post_exposure(s.post) == 0.0f && !stilb_post_is_blind(s.post));
	stage_close(&s);
}

/* ---- the engine -------------------------------------------------------------------------------------------------- */

/* The exposure of what the engine drew last, by its definition. */
static double engine_defined(stilb_engine *engine, const stilb_post_settings *settings)
{
	stilb_image image = {0};
	double stops;
	assert_int_equal(stilb_render_read_radiance(engine->render, &image), STILB_OK);
	uint32_t pixels = image.width * image.height;
	float *rgb = calloc(pixels, 3 * sizeof *rgb);
	assert_non_null(rgb);
	for (uint32_t i = 0; i < 3 * pixels; i++)
		rgb[i] = stilb_image_half_to_float(((const uint16_t *)image.pixels)[(size_t)image.channels * (i / 3) + i % 3]);
	assert_true(exposure_defined(rgb, pixels, settings, &stops));
	free(rgb);
	stilb_image_finish(&image);
	return stops;
}

static stilb_scene *engine_scene(uint64_t seed, stilb_scene_stress_light light)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(60, seed, &scene), STILB_OK);
	scene->camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 1.5f);
	stilb_scene_stress_set_light(scene, light);
	return scene;
}

/* The first frame of each scene is shown as it suits it, with what the camera says on top, and what comes later goes
 * there by steps of the engine's time. */
static void engines_look_first(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_post_settings settings = {.exposure_adapts = true};
	desc.workers = 1;
	desc.width = 90;
	desc.height = 60;
	desc.samples = 1;
	desc.profile = false;
	desc.validate = true;
	desc.post = settings;
	post_exposure_defaults(&settings);
	stilb_engine *engine;
	stilb_engine_report report;
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene *scenes[2] = {engine_scene(1, STILB_SCENE_STRESS_LIGHT_SUN),
	                          engine_scene(2, STILB_SCENE_STRESS_LIGHT_NIGHT)};
	scenes[1]->camera.exposure = 1.5f;
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_engine_set_scene(engine, scenes[i]), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.frame, i + 1);
		double want = engine_defined(engine, &settings) + (double)scenes[i]->camera.exposure;
		print_message("scene %d: %.3f EV, defined %.3f\n", i, (double)report.exposure, want);
		assert_true(fabs((double)report.exposure - want) < CLASS);
		assert_true(report.exposure == engine->views[0].exposure);
	}
	/* The sun rises: two frames later the exposure begins to fall, by at most the rate. */
	double before = (double)report.exposure;
	stilb_scene_stress_set_light(scenes[1], STILB_SCENE_STRESS_LIGHT_SUN);
	for (int f = 0; f < 12; f++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		if (f < 2)
			assert_true(fabs((double)report.exposure - before) < 1e-3);
	}
	double fallen = before - (double)report.exposure;
	assert_true(fallen > 0.1 && fallen < 4.0 * 10.0 / 60.0 + 1e-4);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scenes[0]);
	stilb_scene_destroy(scenes[1]);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(pace_is_the_same_in_any_steps),
		cmocka_unit_test(counts_are_as_defined),
		cmocka_unit_test(frames_follow),
		cmocka_unit_test(black_light_and_other_sizes_keep_it),
		cmocka_unit_test(without_it_there_is_no_row),
		cmocka_unit_test(engines_look_first),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
