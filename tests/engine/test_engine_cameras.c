/* Cameras beside the scene's own: each shows in its part of the picture what an engine of its own would show in a
 * picture of that size; the scene drawn larger or smaller; what lies under a point. */
#include "engine.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WIDTH 97u
#define HEIGHT 61u

static stilb_scene *scene;

static stilb_engine *open_engine(uint32_t width, uint32_t height, uint32_t workers)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = width;
	desc.height = height;
	desc.samples = 1;
	desc.validate = true;
	desc.workers = workers;
	desc.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 1.0f};
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	return engine;
}

static void close_engine(stilb_engine *engine)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
}

static stilb_engine_report frame(stilb_engine *engine)
{
	stilb_engine_report report;
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return report;
}

static stilb_image picture(stilb_engine *engine)
{
	stilb_image image;
	assert_int_equal(stilb_engine_screenshot(engine, "cameras.png"), STILB_OK);
	assert_int_equal(stilb_image_load("cameras.png", &image), STILB_OK);
	remove("cameras.png");
	return image;
}

static stilb_scene_camera camera_of(uint32_t which)
{
	stilb_scene_camera camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 1.5f);
	float angle = 1.3f * (float)which;
	float x = camera.position[0], z = camera.position[2];
	camera.position[0] = x * cosf(angle) + z * sinf(angle);
	camera.position[2] = z * cosf(angle) - x * sinf(angle);
	camera.yaw += angle;
	camera.exposure = 0.5f * (float)which;
	return camera;
}

/* The picture of a camera alone. Dithering goes by the pixel's place in the picture, so codes may be off by one. */
static stilb_image picture_alone(uint32_t which, uint32_t width, uint32_t height)
{
	stilb_engine *engine = open_engine(width, height, 0);
	scene->camera = camera_of(which);
	frame(engine);
	stilb_image image = picture(engine);
	close_engine(engine);
	return image;
}

static void assert_shows(const stilb_image *image, uint32_t left, uint32_t top, const stilb_image *alone)
{
	for (uint32_t y = 0; y < alone->height; y++)
		for (uint32_t x = 0; x < alone->width * 3; x++) {
			int got = ((uint8_t *)image->pixels)[3 * ((size_t)(top + y) * image->width + left) + x];
			int want = ((uint8_t *)alone->pixels)[3 * (size_t)y * alone->width + x];
			assert_in_range(got - want + 1, 0, 2);
		}
}

static void cameras_have_pictures_of_their_own(void **state)
{
	(void)state;
	stilb_image alone[3] = {picture_alone(0, WIDTH, HEIGHT), picture_alone(1, 29, 31), picture_alone(2, 48, 30)};
	for (uint32_t workers = 0; workers < 3; workers += 2) {
		stilb_engine *engine = open_engine(WIDTH, HEIGHT, workers);
		char name[8] = "first"; /* copied */
		stilb_engine_camera cameras[2] = {
			{.name = name, .camera = camera_of(1), .place = {0.1f, 0.0f, 0.4f, 0.5f}},
			{.name = "second", .camera = camera_of(2), .place = {0.5f, 0.5f, 1.0f, 1.0f}, .border = 0}};
		scene->camera = camera_of(0);
		stilb_engine_set_cameras(engine, cameras, 2);
		memset(name, 'x', sizeof name - 1);
		for (uint32_t f = 0; f < 2; f++) {
			frame(engine);
			stilb_image image = picture(engine);
			assert_shows(&image, 10, 0, &alone[1]);
			assert_shows(&image, 49, 31, &alone[2]);
			stilb_image_finish(&image);
		}
		stilb_engine_set_cameras(engine, NULL, 0);
		frame(engine);
		stilb_image image = picture(engine);
		assert_shows(&image, 0, 0, &alone[0]);
		stilb_image_finish(&image);
		close_engine(engine);
	}
	for (uint32_t i = 0; i < 3; i++)
		stilb_image_finish(&alone[i]);
}

/* A place of the scene's own camera, and the scene in twice the size, of which the picture is the mean of four. */
static void the_scene_in_another_size(void **state)
{
	(void)state;
	stilb_image alone = picture_alone(0, 48, 61), large;
	stilb_engine *engine = open_engine(WIDTH, HEIGHT, 0);
	scene->camera = camera_of(0);
	stilb_engine_set_place(engine, (const float[4]){0.0f, 0.0f, 0.49f, 1.0f});
	frame(engine);
	stilb_image image = picture(engine);
	assert_shows(&image, 0, 0, &alone);
	assert_int_equal(((uint8_t *)image.pixels)[3 * 60], 0);
	stilb_image_finish(&image);
	stilb_image_finish(&alone);
	stilb_engine_set_place(engine, (const float[4]){0.0f, 0.0f, 1.0f, 1.0f});
	stilb_engine_set_scale(engine, 2.0f);
	frame(engine);
	assert_int_equal(stilb_engine_screenshot(engine, "cameras.exr"), STILB_OK); /* the radiance that was drawn */
	assert_int_equal(stilb_image_load("cameras.exr", &large), STILB_OK);
	remove("cameras.exr");
	assert_int_equal(large.width, 2 * WIDTH);
	assert_int_equal(large.height, 2 * HEIGHT);
	stilb_image_finish(&large);
	close_engine(engine);
}

/* A click into an inset meets what its camera sees. */
static void points_of_the_picture(void **state)
{
	(void)state;
	stilb_engine *engine = open_engine(WIDTH, HEIGHT, 0), *other = open_engine(29, 31, 0);
	stilb_engine_camera camera = {.name = "inset", .camera = camera_of(1), .place = {0.1f, 0.0f, 0.4f, 0.5f}};
	stilb_engine_hit here, there;
	uint32_t hits = 0;
	scene->camera = camera_of(1);
	frame(other);
	for (uint32_t i = 0; i < 31 * 29; i += 7) {
		double x = i % 29 + 0.5, y = i / 29 + 0.5;
		scene->camera = camera_of(1);
		bool wanted = stilb_engine_pick(other, x, y, &there);
		scene->camera = camera_of(0);
		stilb_engine_set_cameras(engine, &camera, 1);
		assert_int_equal(stilb_engine_pick(engine, 10 + x, y, &here), wanted);
		if (wanted)
			assert_int_equal(here.model, there.model);
		hits += wanted;
	}
	assert_in_range(hits, 20, 120);
	stilb_engine_set_cameras(engine, NULL, 0);
	stilb_engine_set_place(engine, (const float[4]){0.5f, 0.0f, 1.0f, 1.0f});
	assert_false(stilb_engine_pick(engine, 20.0, 40.0, &here)); /* no camera is shown there */
	close_engine(engine);
	close_engine(other);
}

static int make_scene(void **state)
{
	(void)state;
	return stilb_scene_create_stress(300, 3, &scene) != STILB_OK;
}

static int drop_scene(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	return 0;
}

int main(void)
{
	static const struct CMUnitTest tests[] = {cmocka_unit_test(cameras_have_pictures_of_their_own),
	                                          cmocka_unit_test(the_scene_in_another_size),
	                                          cmocka_unit_test(points_of_the_picture)};
	return cmocka_run_group_tests(tests, make_scene, drop_scene);
}
