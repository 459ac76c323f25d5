/* What effects make of distance: motion blur of what is far away alone, beside the mean of 64 frames; and a pane that
 * blends, in focus before what is not, keeps its edge. */
#include "post_scenes.h"

#define TRUTH 64u /* frames */
#define SHUTTER 0.5f

static const stilb_scene_camera front = {.fov_y = 0.55f, .near_z = 0.1f, .far_z = 200.0f};
static float sharp[3 * SCENE_PIXELS], blurred[3 * SCENE_PIXELS], truth[3 * SCENE_PIXELS], frame[3 * SCENE_PIXELS];

/* Boxes side by side from 30 to 50 m away, and one near by in the middle. */
static uint32_t fill(scene_thing *things)
{
	uint32_t count = 0;
	for (int x = -3; x <= 3; x++)
		for (int y = -1; y <= 1; y++, count++)
			things[count] = (scene_thing){0,
			                              {stilb_random_float(3, 4 * count), stilb_random_float(3, 4 * count + 1),
			                               stilb_random_float(3, 4 * count + 2)},
			                              {.scale = {3.0f, 2.5f, 1.0f},
			                               .translation = {7.0f * (float)x, 6.0f * (float)y,
			                                               -30.0f - 20.0f * stilb_random_float(3, 4 * count + 3)},
			                               .rotation = {0, 0, 0, 1}}};
	things[count++] = (scene_thing){
		0, {0.9f, 0.5f, 0.1f}, {.scale = {0.2f, 0.2f, 0.1f}, .translation = {0, 0, -3}, .rotation = {0, 0, 0, 1}}};
	return count;
}

/* Pixels of the near box without, or all but it with those around it. */
static bool is_near(uint32_t p, float beside)
{
	float x = fabsf((float)(p % SCENE_WIDTH) + 0.5f - 0.5f * SCENE_WIDTH);
	float y = fabsf((float)(p / SCENE_WIDTH) + 0.5f - 0.5f * SCENE_HEIGHT);
	float half = 0.2f / 2.9f * 0.5f * SCENE_HEIGHT / tanf(0.275f) + beside;
	return x < half && y < half;
}

static double error_of(const float *picture)
{
	double sum = 0.0;
	uint32_t count = 0;
	for (uint32_t p = 0; p < SCENE_PIXELS; p++) {
		if (is_near(p, 16.0f)) /* what moves in front of the rest */
			continue;
		for (uint32_t c = 0; c < 3; c++, count++)
			sum += pow((double)(picture[3 * p + c] - truth[3 * p + c]), 2.0);
	}
	return sqrt(sum / count);
}

/* Draws the frame of a time, in frames, at which the camera looks elsewhere. */
static void turned(stilb_engine *engine, stilb_scene *scene, float time, float *rgb)
{
	scene->camera.yaw = 0.12f * time;
	scene->camera.pitch = 0.03f * time;
	scene_frame(engine, rgb, NULL);
}

static void far_things_blur(void **state)
{
	(void)state;
	scene_thing things[SCENE_MOST];
	stilb_scene *scene = scene_of(things, fill(things), &front);
	memcpy(scene->surroundings.ground, scene->surroundings.sky, sizeof scene->surroundings.sky);
	stilb_post_settings off = {0}, far = {.motion_blur = SHUTTER,
	                                      .motion_blur_most = 0.5f,
	                                      .motion = STILB_POST_MOTION_FAR,
	                                      .motion_blur_far = 6.0f};
	stilb_engine *engine = scene_engine(scene, 1, &off);
	memset(truth, 0, sizeof truth);
	for (uint32_t f = 0; f < TRUTH; f++) {
		turned(engine, scene, (((float)f + 0.5f) / TRUTH - 0.5f) * SHUTTER, frame);
		for (uint32_t i = 0; i < 3 * SCENE_PIXELS; i++)
			truth[i] += frame[i] / TRUTH;
	}
	turned(engine, scene, 0.0f, sharp);
	stilb_engine_set_post(engine, &far);
	turned(engine, scene, -1.0f, frame);
	turned(engine, scene, 0.0f, blurred);
	double with = error_of(blurred), without = error_of(sharp);
	printf("far: off by %.4f of white, without by %.4f\n", with, without);
	assert_true(without > 0.03 && with <= 0.4 * without);
	for (uint32_t p = 0; p < SCENE_PIXELS; p++)
		for (uint32_t c = 0; c < 3 && is_near(p, -1.0f); c++)
			assert_true(blurred[3 * p + c] == sharp[3 * p + c]);
	/* Nothing is seen of the near box around it. */
	for (uint32_t p = 0; p < SCENE_PIXELS; p++)
		if (!is_near(p, 2.0f) && is_near(p, 5.0f))
			assert_true(blurred[3 * p] <= 0.8f || blurred[3 * p + 2] > 0.15f);
	far.motion_blur_far = 100.0f; /* all is near but the sky, which is the same everywhere */
	stilb_engine_set_post(engine, &far);
	turned(engine, scene, -1.0f, frame);
	turned(engine, scene, 0.0f, blurred);
	for (uint32_t i = 0; i < 3 * SCENE_PIXELS; i++)
		assert_true(fabsf(blurred[i] - sharp[i]) <= 2e-3f);
	scene_close(engine);
	stilb_scene_destroy(scene);
}

/* ---- a pane ------------------------------------------------------------------------------------------------------ */

/* Stripes far away, and a pane 2 m away whose alpha is 0.9. */
static stilb_scene *pane_scene(void)
{
	static const float none[3] = {0};
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh box = post_box();
	uint32_t mesh = stilb_scene_build_mesh(build, &box);
	for (int i = -20; i <= 20; i++) {
		stilb_scene_material paint = stilb_scene_material_make(none, none, 1.0f);
		for (int c = 0; c < 3; c++)
			paint.emission[c] = i % 2 ? 0.1f : 0.8f;
		stilb_scene_pose pose = {
			.scale = {0.5f, 20, 0.1f}, .translation = {(float)i, 0, -20}, .rotation = {0, 0, 0, 1}};
		stilb_mat4 place = stilb_scene_pose_matrix(&pose);
		stilb_scene_build_part part = {.mesh = mesh, .material = stilb_scene_build_material(build, &paint)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_surface pane = stilb_scene_surface_make();
	pane.alpha = STILB_SCENE_BLEND;
	pane.unlit = true;
	memcpy(pane.color, (float[4]){0.1f, 0.7f, 0.2f, 0.9f}, sizeof pane.color);
	stilb_scene_material paint = stilb_scene_material_make(none, none, 1.0f);
	paint.surface = 1 + stilb_scene_build_surface(build, &pane);
	stilb_scene_pose pose = {.scale = {0.3f, 0.3f, 0.001f}, .translation = {0, 0, -2}, .rotation = {0, 0, 0, 1}};
	stilb_mat4 place = stilb_scene_pose_matrix(&pose);
	stilb_scene_build_part part = {.mesh = mesh, .material = stilb_scene_build_material(build, &paint)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	stilb_scene_build_camera(build, &front);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static void panes_keep_their_edges(void **state)
{
	(void)state;
	stilb_scene *scene = pane_scene();
	stilb_post_settings off = {0}, lens = {.dof = STILB_POST_DOF_BOKEH, .aperture = 0.1f, .focus = 2.0f};
	stilb_engine *engine = scene_engine(scene, 1, &off);
	scene_frame(engine, sharp, NULL);
	stilb_engine_set_post(engine, &lens);
	scene_frame(engine, blurred, NULL);
	float half = 0.3f / 2.0f * 0.5f * SCENE_HEIGHT / tanf(0.275f), worst = 0.0f, left[2] = {1.0f, 0.0f};
	for (uint32_t p = 0; p < SCENE_PIXELS; p++) {
		float x = fabsf((float)(p % SCENE_WIDTH) + 0.5f - 0.5f * SCENE_WIDTH);
		float y = fabsf((float)(p / SCENE_WIDTH) + 0.5f - 0.5f * SCENE_HEIGHT);
		const float *a = &sharp[3 * p], *b = &blurred[3 * p];
		if (x < half - 1.0f && y < half - 1.0f)
			for (int c = 0; c < 3; c++)
				worst = fmaxf(worst, fabsf(a[c] - b[c]));
		else if (x > half + 12.0f && x < half + 24.0f) {
			left[0] = fminf(left[0], b[0]);
			left[1] = fmaxf(left[1], b[0]);
		}
		if (x > half + 1.0f && x < half + 4.0f && y < half) /* nothing of the pane's green */
			assert_true(b[1] <= b[0] + 0.02f);
	}
	printf("pane: off by %.3f in it; stripes of .1 to .8 behind it from %.2f to %.2f\n", (double)worst, (double)left[0],
	       (double)left[1]);
	assert_true(worst <= 0.02f);
	assert_true(left[0] > 0.3f && left[1] < 0.6f);
	scene_close(engine);
	stilb_scene_destroy(scene);
}

/* Both, with light in 8 bits, in pictures of odd and extreme sizes, one after the other. */
static void any_size(void **state)
{
	static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {16384, 1}, {17, 33}};
	(void)state;
	stilb_scene *scene = pane_scene();
	stilb_post_settings all = {.dof = STILB_POST_DOF_BOKEH,
	                           .aperture = 0.1f,
	                           .focus = 2.0f,
	                           .motion_blur = SHUTTER,
	                           .motion = STILB_POST_MOTION_FAR,
	                           .motion_blur_far = 6.0f,
	                           .aa = STILB_POST_AA_POST};
	stilb_engine *engine = scene_engine(scene, 1, &all);
	engine->desc.hdr = STILB_RENDER_HDR_RGBM;
	for (uint32_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		stilb_engine_report report;
		stilb_image image = {0};
		assert_int_equal(stilb_render_resize(engine->render, sizes[i][0], sizes[i][1]), STILB_OK);
		for (uint32_t f = 0; f < 2; f++)
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_OK);
		assert_true(image.width == sizes[i][0] && image.height == sizes[i][1]);
		for (uint32_t p = 0; p < image.width * image.height * image.channels; p++) {
			float value = scene_value(&image, p);
			assert_true(value >= 0.0f && value <= 2.0f);
		}
		stilb_image_finish(&image);
	}
	scene_close(engine);
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(far_things_blur),
		cmocka_unit_test(panes_keep_their_edges),
		cmocka_unit_test(any_size),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
