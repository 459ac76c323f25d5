/* --show error: how far a frame's light is from that of forward lighting. Nothing where the way of lighting is exact,
 * with shadows, too; what two frames are apart, pixel by pixel, where it is not; within --light-tolerance where weak
 * lights are left out; in the legend's colours. Under the validation layer. */
#include "engine_internal.h"
#include "shading/shade_srgb.h"
#include "support/picture_reference.h"
#include "tests/engine/stress_engine.h"

#include <math.h>

enum { WIDTH = 200, HEIGHT = 140, LEGEND = 90, LAMPS = 100 }; /* LEGEND: rows below that it may cover */

#define EXPOSURE 1.5f
#define TOLERANCE (16.0f / 255.0f)

static stilb_engine *make_engine(stilb_render_lighting way, uint32_t samples, uint32_t lamps)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = samples;
	desc.lighting = way;
	desc.validate = true;
	desc.profile = false;
	if (stress_engine_create(&desc, &(stress_engine){.models = 400, .seed = 5, .view = STILB_SCENE_VIEW_FEW},
	                         &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene *scene = stilb_engine_scene(engine);
	assert_int_equal(stilb_scene_stress_add_lamps(scene, lamps), STILB_OK);
	scene->camera.exposure = EXPOSURE;
	return engine;
}

static stilb_engine_report frame(stilb_engine *engine, stilb_render_show show)
{
	stilb_engine_report report;
	stilb_engine_set_shows(engine, show);
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return report;
}

/* What EXR files have: of frames that show an error that, else radiance. */
static stilb_image radiance(stilb_engine *engine)
{
	stilb_image image = {0};
	if (stilb_render_read_radiance(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static stilb_image radiance_by(stilb_engine *engine, stilb_render_lighting way)
{
	stilb_engine_set_lighting(engine, way);
	frame(engine, STILB_RENDER_SHOW_SHADED);
	return radiance(engine);
}

static void close_engine(stilb_engine *engine)
{
	assert_int_equal(stilb_render_validation_messages(engine->render), 0);
	stress_engine_destroy(engine);
}

/* Ways that show the same bits, with one sample and with four, with shadows: black. */
static void exact_ways_have_none(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stilb_engine *engine = make_engine(STILB_RENDER_LIGHTING_CLUSTERED, samples, 12);
		engine->desc.shadows = (stilb_engine_shadows){.kind = STILB_ENGINE_SHADOWS_MAP, .cascades = 1, .size = 128};
		for (int i = 0; i < 2; i++) {
			stilb_engine_report report = frame(engine, STILB_RENDER_SHOW_ERROR);
			assert_true(report.light_error.pixels == WIDTH * HEIGHT && report.shadow_maps > 0);
			if (report.light_error.most != 0.0 || report.light_error.rms != 0.0)
				fail_msg("off by %g with %u samples", report.light_error.most, samples);
		}
		stilb_image picture = {0};
		assert_int_equal(stilb_render_read_image(engine->render, &picture), STILB_OK);
		const uint8_t *codes = picture.pixels;
		for (size_t i = 0; i < 3u * WIDTH * (HEIGHT - LEGEND); i++)
			assert_int_equal(codes[i], 0);
		stilb_image_finish(&picture);
		assert_true(frame(engine, STILB_RENDER_SHOW_SHADED).light_error.pixels == 0);
		assert_int_equal(stilb_gpu_plan_find(stilb_engine_plan(engine), STILB_RENDER_IMAGE_REFERENCE), 0);
		close_engine(engine);
	}
}

/* The colour of a share of white, between those of the legend. */
static void legend_color(double error, double color[3])
{
	static const double colors[9][3] = {{0, 0, 0},       {.01, .02, .15}, {.02, .08, .5},
	                                    {.02, .35, .25}, {.1, .5, .03},   {.55, .55, .02},
	                                    {.8, .25, .02},  {.8, .03, .02},  {1, 1, 1}};
	double sixteenths = error * 255.0 * 16.0, at = sixteenths < 1.0 ? sixteenths : 1.0 + log2(sixteenths);
	at = fmin(at, 8.0);
	int below = at < 7.0 ? (int)at : 7;
	for (int c = 0; c < 3; c++)
		color[c] = colors[below][c] + (at - below) * (colors[below + 1][c] - colors[below][c]);
}

/* A way with highlights of its own is off by what two frames are apart. */
static void it_is_what_frames_are_apart(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_LIGHTING_PREPASS, 1, LAMPS);
	stilb_image forward = radiance_by(engine, STILB_RENDER_LIGHTING_FORWARD);
	stilb_image own = radiance_by(engine, STILB_RENDER_LIGHTING_PREPASS), picture = {0};
	stilb_engine_report report = frame(engine, STILB_RENDER_SHOW_ERROR);
	stilb_image error = radiance(engine);
	assert_int_equal(stilb_render_read_image(engine->render, &picture), STILB_OK);
	double bright = exp2((double)EXPOSURE), most = 0.0, sum = 0.0;
	uint32_t above = 0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			double worst = 0.0, color[3];
			for (int c = 0; c < 3; c++) {
				double want = fabs(picture_value(&own, x, y, c) - picture_value(&forward, x, y, c));
				double got = picture_value(&error, x, y, c);
				if (!(fabs(got - want) <= want * 0x1p-10 + 1e-7))
					fail_msg("pixel %u, %u is off by %g and shows %g", x, y, want, got);
				worst = fmax(worst, got * bright);
				sum += got * bright * got * bright;
			}
			most = fmax(most, worst);
			above += worst > 1.0 / 255.0;
			legend_color(worst, color);
			for (int c = 0; c < 3 && y < HEIGHT - LEGEND; c++) {
				double code = 255.0 * (double)shade_srgb_from_linear((float)color[c]);
				uint8_t got = ((const uint8_t *)picture.pixels)[3 * (y * WIDTH + x) + (uint32_t)c];
				if (!(fabs(code - got) <= 1.0))
					fail_msg("pixel %u, %u has the colour %u, not %g", x, y, got, code);
			}
		}
	assert_true(most > 4.0 / 255.0 && above > 0);
	assert_true(fabs(report.light_error.most - most) <= 1e-9 * most);
	assert_true(fabs(report.light_error.rms - sqrt(sum / (3.0 * WIDTH * HEIGHT))) <= 1e-9 * most);
	assert_true(fabs(report.light_error.share - above / (double)(WIDTH * HEIGHT)) <= 1e-9);
	stilb_image *images[] = {&forward, &own, &error, &picture};
	for (int i = 0; i < 4; i++)
		stilb_image_finish(images[i]);
	close_engine(engine);
}

/* Weak lights that are left out: some light is missing, and no more than the tolerance allows. */
static void weak_lights_are_within_their_tolerance(void **state)
{
	(void)state;
	stilb_engine *engine = make_engine(STILB_RENDER_LIGHTING_CLUSTERED, 1, LAMPS);
	stilb_engine_set_light_tolerance(engine, TOLERANCE);
	stilb_engine_report report = frame(engine, STILB_RENDER_SHOW_ERROR);
	assert_true(report.render.light_left_out > 0);
	/* Half floats round the light of both frames. */
	double most = report.light_error.most;
	if (!(most > 0.05 / 255.0 && most <= (double)TOLERANCE + 0x1p-10))
		fail_msg("off by %g of %g", most, (double)TOLERANCE);
	close_engine(engine);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(exact_ways_have_none),
		cmocka_unit_test(it_is_what_frames_are_apart),
		cmocka_unit_test(weak_lights_are_within_their_tolerance),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
