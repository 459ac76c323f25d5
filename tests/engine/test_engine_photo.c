/* Photos: by tiles they are what one piece is, with what reaches over tiles, at every place of the picture; afterwards
 * frames are as before; and what cannot be is refused by name. */
#include "engine_internal.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 230, HEIGHT = 150, SMALL = 48 };

static const char *const whole_path = "photo-whole.png", *const tiles_path = "photo-tiles.png";

/* Balls near and far, some of them lamps, in the light of a sun that casts shadows. */
static stilb_scene *scene_made(void)
{
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh ball = {0};
	assert_int_equal(stilb_scene_mesh_sphere(4, &ball), STILB_OK);
	uint32_t mesh = stilb_scene_build_mesh(build, &ball);
	for (uint32_t i = 0; i < 40; i++) {
		const float none[3] = {0};
		float color[3];
		for (uint32_t c = 0; c < 3; c++)
			color[c] = stilb_random_float(i, c);
		stilb_scene_material paint = stilb_scene_material_make(color, none, 0.5f);
		for (uint32_t c = 0; c < 3 && i % 7 == 0; c++)
			paint.emission[c] = 8.0f * color[c];
		float size = 0.2f + 0.4f * stilb_random_float(i, 3);
		stilb_scene_pose pose = {.scale = {size, size, size},
		                         .rotation = {0, 0, 0, 1},
		                         .translation = {8.0f * stilb_random_float(i, 4) - 4.0f,
		                                         5.0f * stilb_random_float(i, 5) - 2.5f,
		                                         -2.0f - 8.0f * stilb_random_float(i, 6)}};
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_build_part part = {.mesh = mesh, .material = stilb_scene_build_material(build, &paint)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_camera camera = {.fov_y = 1.0f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	for (int c = 0; c < 3; c++)
		scene->surroundings.sky[c] = scene->surroundings.ground[c] = 0.1f * (float)(c + 1);
	stilb_scene_mesh_finish(&ball);
	return scene;
}

static stilb_engine *opened(stilb_scene *scene, uint32_t width, uint32_t height)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.workers = 0;
	desc.width = width;
	desc.height = height;
	desc.samples = 1;
	desc.profile = false;
	desc.validate = true;
	desc.shadows.kind = STILB_ENGINE_SHADOWS_MAP;
	desc.detail = (stilb_render_detail){STILB_RENDER_DETAIL_MORPH, 0.5f};
	desc.post.dither = STILB_POST_DITHER_ORDERED;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static void drawn(stilb_engine *engine)
{
	stilb_engine_report report;
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* The largest difference of two pictures, codes; and the share of values that differ. */
static int apart(const stilb_image *a, const stilb_image *b, double *share)
{
	size_t size = stilb_image_size(a), differ = 0;
	const uint8_t *x = a->pixels, *y = b->pixels;
	int most = 0;
	assert_true(a->width == b->width && a->height == b->height && a->channels == b->channels);
	for (size_t i = 0; i < size; i++) {
		int off = abs((int)x[i] - (int)y[i]);
		most = off > most ? off : most;
		differ += off > 0;
	}
	*share = (double)differ / (double)size;
	return most;
}

/* Compares a photo by tiles with one in one tile, under these effects. */
static void compare(stilb_engine *engine, const stilb_post_settings *post, const char *what, double some)
{
	stilb_image images[2] = {0};
	stilb_engine_set_post(engine, post);
	drawn(engine);
	for (uint32_t i = 0; i < 2; i++) {
		stilb_engine_photo photo = {
			.path = i ? tiles_path : whole_path, .width = WIDTH, .height = HEIGHT, .tile = i ? 64 : 0};
		if (stilb_engine_photo_take(engine, &photo) != STILB_OK)
			fail_msg("%s: %s", what, stilb_error_message());
		assert_int_equal(stilb_image_load(photo.path, &images[i]), STILB_OK);
	}
	double share;
	int most = apart(&images[0], &images[1], &share);
	printf("%s: %.4f %% of the values differ, by %d at most\n", what, 100.0 * share, most);
	if (most > 1 || share > some)
		fail_msg("%s: %.4f %% of the values differ, by %d at most", what, 100.0 * share, most);
	for (uint32_t i = 0; i < 2; i++)
		stilb_image_finish(&images[i]);
}

static void tiles_are_one_piece(void **state)
{
	(void)state;
	stilb_scene *scene = scene_made();
	stilb_engine *engine = opened(scene, SMALL, SMALL);
	stilb_post_settings none = {0}, edges = {.aa = STILB_POST_AA_POST},
						lens = {.dof = STILB_POST_DOF_BOKEH, .aperture = 0.1f, .focus = 4.0f, .blades = 5};
	compare(engine, &none, "none", 1e-3);
	compare(engine, &edges, "edges", 1e-3);
	compare(engine, &lens, "lens", 1e-3);
	/* A photo is what frames of its size show. */
	stilb_image images[2] = {0};
	double share;
	stilb_engine *large = opened(scene, WIDTH, HEIGHT);
	stilb_engine_set_post(large, &lens);
	drawn(large);
	assert_int_equal(stilb_engine_screenshot(large, whole_path), STILB_OK);
	assert_int_equal(stilb_image_load(whole_path, &images[0]), STILB_OK);
	assert_int_equal(stilb_image_load(tiles_path, &images[1]), STILB_OK);
	assert_true(apart(&images[0], &images[1], &share) <= 1 && share <= 1e-3);
	stilb_image_finish(&images[0]);
	stilb_image_finish(&images[1]);
	assert_int_equal(stilb_engine_validation_messages(large), 0);
	stilb_engine_destroy(large);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* The frame after a photo is the frame before it, and has its size; what looks at all of a picture is in one piece. */
static void frames_go_on(void **state)
{
	(void)state;
	stilb_scene *scene = scene_made();
	stilb_engine *engine = opened(scene, SMALL, SMALL);
	stilb_engine_photo photo = {.path = whole_path, .width = 100, .height = 70, .tile = 64};
	assert_int_equal(stilb_engine_photo_take(engine, &photo), STILB_ERROR_ARGUMENT); /* of which frame? */
	stilb_image before = {0}, after = {0};
	double share;
	drawn(engine);
	assert_int_equal(stilb_render_read_image(engine->render, &before), STILB_OK);
	assert_null(stilb_engine_photo_whole(engine));
	assert_int_equal(stilb_engine_photo_take(engine, &photo), STILB_OK);
	drawn(engine);
	assert_int_equal(stilb_render_read_image(engine->render, &after), STILB_OK);
	assert_int_equal(apart(&before, &after, &share), 0);
	stilb_image_finish(&before);
	stilb_image_finish(&after);
	stilb_post_settings bloom = {.bloom = 0.2f};
	stilb_engine_set_post(engine, &bloom);
	drawn(engine);
	assert_non_null(strstr(stilb_engine_photo_whole(engine), "bloom"));
	assert_int_equal(stilb_engine_photo_take(engine, &photo), STILB_OK);
	photo.width = 16385;
	assert_int_equal(stilb_engine_photo_take(engine, &photo), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "bloom scatters"));
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(tiles_are_one_piece),
		cmocka_unit_test(frames_go_on),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
