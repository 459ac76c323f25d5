/* Surface functions in an engine: they get its time, a program edits their parameters in its update, and one that does
 * not fit is an error of one frame, after which frames go on without it. */
#include "engine_internal.h"
#include "scene/edit/scene_edit.h"
#include "support/test.h"

#include "probe.surface.h"

#include <math.h>
#include <string.h>

#define COLOR 1.0f /* of the probe: shows its second parameter; shows the time, and its fraction */
#define TIME 5.0f

/* A white ball in front of the camera, which shows its colour whatever the light. */
static stilb_scene *ball_scene(float what)
{
	static const float white[3] = {1, 1, 1}, none[3] = {0};
	stilb_scene *scene = NULL;
	stilb_scene_mesh ball = {0};
	stilb_mat4 place = stilb_mat4_identity();
	stilb_scene_camera camera = {.position = {0, 0, 3}, .fov_y = 0.3f, .near_z = 0.1f, .far_z = 10};
	assert_int_equal(stilb_scene_mesh_sphere(3, &ball), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_surface surface = stilb_scene_surface_make();
	surface.unlit = true;
	surface.function = 1 + stilb_scene_build_function(build, &probe);
	surface.parameters[0][0] = what;
	surface.parameters[1][1] = 0.25f;
	stilb_scene_material material = stilb_scene_material_make(white, none, 1.0f);
	material.surface = 1 + stilb_scene_build_surface(build, &surface);
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, &ball)};
	part.material = stilb_scene_build_material(build, &material);
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_mesh_finish(&ball);
	return scene;
}

static stilb_engine *open_engine(stilb_scene *scene, stilb_engine_update_fn *update, void *user)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = desc.height = 16;
	desc.samples = 1;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.workers = 1;
	desc.update = update;
	desc.user = user;
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	return engine;
}

static void close_engine(stilb_engine *engine, stilb_scene *scene)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* Draws a frame, in whose middle is this radiance. */
static void assert_frame(stilb_engine *engine, float r, float g)
{
	stilb_engine_report report;
	stilb_image image = {0};
	float row[16 * 4];
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_image_row_to_light(&image, 8, row);
	const float *middle = row + 8 * image.channels;
	if (!(fabsf(middle[0] - r) <= 1e-3f && fabsf(middle[1] - g) <= 1e-3f))
		fail_msg("%.5f %.5f, not %.5f %.5f", (double)middle[0], (double)middle[1], (double)r, (double)g);
	stilb_image_finish(&image);
}

static void time_is_the_engines(void **state)
{
	(void)state;
	stilb_scene *scene = ball_scene(TIME);
	stilb_engine *engine = open_engine(scene, NULL, NULL);
	for (int frame = 0; frame < 70; frame++) {
		float time = (float)frame / 60.0f;
		if (frame % 23 == 0)
			assert_frame(engine, fminf(time, 1.0f), time - floorf(time));
		else
			assert_int_equal(stilb_engine_frame(engine, &(stilb_engine_report){0}), STILB_OK);
	}
	close_engine(engine, scene);
}

/* Fades from black to red by the frame's number. */
static void fade(void *user, const stilb_engine_update *update)
{
	stilb_scene *scene = user;
	stilb_scene_surface surface = scene->surfaces[0];
	surface.parameters[1][0] = 0.125f * (float)update->frame;
	assert_int_equal(stilb_scene_set_surface(scene, 0, &surface), STILB_OK);
}

static void programs_edit_parameters(void **state)
{
	(void)state;
	stilb_scene *scene = ball_scene(COLOR);
	stilb_engine *engine = open_engine(scene, fade, scene);
	for (int frame = 1; frame <= 4; frame++)
		assert_frame(engine, 0.125f * (float)frame, 0.25f);
	close_engine(engine, scene);
}

static void one_that_does_not_fit_is_told_once(void **state)
{
	(void)state;
	stilb_engine_report report;
	stilb_scene *scene = ball_scene(COLOR);
	stilb_engine *engine = open_engine(scene, NULL, NULL);
	assert_frame(engine, 0.0f, 0.25f);
	stilb_scene_function other = probe;
	other.codes[0] = probe.codes[8]; /* of layers, which the ball has not */
	uint32_t id;
	stilb_scene_surface surface = scene->surfaces[0];
	assert_int_equal(stilb_scene_add_function(scene, &other, &id), STILB_OK);
	surface.function = 1 + id;
	assert_int_equal(stilb_scene_set_surface(scene, 0, &surface), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "surface function probe"));
	assert_frame(engine, 1.0f, 1.0f);
	surface.function = 1;
	assert_int_equal(stilb_scene_set_surface(scene, 0, &surface), STILB_OK);
	assert_frame(engine, 0.0f, 0.25f);
	close_engine(engine, scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(time_is_the_engines),
		cmocka_unit_test(programs_edit_parameters),
		cmocka_unit_test(one_that_does_not_fit_is_told_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
