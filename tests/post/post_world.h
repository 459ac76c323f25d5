/* Shared by the tests of post that hold frames against rays: scenes of boxes and balls in colours, and both pictures of
 * them. With STILB_POST_PICTURES=FOLDER in the environment the pictures are written there. */
#ifndef POST_WORLD_H
#define POST_WORLD_H

#include "engine_internal.h"
#include "gi/gi_render.h"
#include "post_box.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 640, HEIGHT = 360, PIXELS = WIDTH * HEIGHT, MOST = 96 /* things */ };

typedef float world_picture[PIXELS][3];

enum { WORLD_BOX, WORLD_BALL };

typedef struct world_thing {
	uint32_t kind;
	stilb_scene_pose pose;
	stilb_scene_material paint;
} world_thing;

static inline stilb_scene_material world_paint(float red, float green, float blue, float emission)
{
	float color[3] = {red, green, blue}, none[3] = {0};
	stilb_scene_material paint = stilb_scene_material_make(color, none, 1.0f);
	for (int c = 0; c < 3; c++)
		paint.emission[c] = color[c] * emission;
	return paint;
}

static inline world_thing world_put(uint32_t kind, float x, float y, float z, float sx, float sy, float sz,
                                    stilb_scene_material paint)
{
	return (world_thing){kind, {.scale = {sx, sy, sz}, .translation = {x, y, z}, .rotation = {0, 0, 0, 1}}, paint};
}

static inline stilb_scene *world_make(const world_thing *things, uint32_t count, const stilb_scene_camera *camera,
                                      const stilb_scene_surroundings *around)
{
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh meshes[2] = {post_box()};
	uint32_t kinds[2];
	assert_true(count <= MOST);
	assert_int_equal(stilb_scene_mesh_sphere(5, &meshes[1]), STILB_OK);
	for (uint32_t k = 0; k < 2; k++)
		kinds[k] = stilb_scene_build_mesh(build, &meshes[k]);
	for (uint32_t t = 0; t < count; t++) {
		stilb_scene_build_part part = {.mesh = kinds[things[t].kind],
		                               .material = stilb_scene_build_material(build, &things[t].paint)};
		stilb_mat4 place = stilb_scene_pose_matrix(&things[t].pose);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_build_camera(build, camera);
	stilb_scene_build_surroundings(build, around);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_mesh_finish(&meshes[1]);
	return scene;
}

/* Writes a picture as FOLDER/NAME.exr and .png; without the folder nothing. */
static inline void world_keep(const world_picture picture, const char *name)
{
	const char *folder = getenv("STILB_POST_PICTURES");
	char path[300];
	stilb_image image;
	if (!folder)
		return;
	assert_int_equal(stilb_image_create(&image, WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memcpy(image.pixels, picture, sizeof(world_picture));
	for (int k = 0; k < 2; k++) {
		snprintf(path, sizeof path, "%s/%s.%s", folder, name, k ? "png" : "exr");
		if (stilb_image_save(&image, path) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	stilb_image_finish(&image);
}

/* ---- both pictures ----------------------------------------------------------------------------------------------- */

/* By rays. settings: of integrator, samples, lens and depth. */
static inline void world_trace(stilb_scene *scene, stilb_gi_settings settings, world_picture radiance)
{
	stilb_job_pool_desc desc = {.worker_count = 1};
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(pool);
	assert_int_equal(stilb_gi_scene_create(scene, &gi_desc, &gi), STILB_OK);
	settings.width = WIDTH;
	settings.height = HEIGHT;
	if (stilb_gi_render_create(gi, &settings, pool, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	memcpy(radiance, stilb_gi_render_film(render).radiance, sizeof(world_picture));
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
}

static inline stilb_engine *world_open(stilb_scene *scene, stilb_post_settings post)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.workers = 0;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.validate = true;
	desc.post = post;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

/* The radiance of the next frame. */
static inline void world_draw(stilb_engine *engine, world_picture radiance)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(image.format, STILB_IMAGE_F16_LINEAR);
	for (uint32_t i = 0; i < PIXELS; i++)
		for (uint32_t c = 0; c < 3; c++)
			radiance[i][c] =
				stilb_image_half_to_float(((const uint16_t *)image.pixels)[image.channels * (size_t)i + c]);
	stilb_image_finish(&image);
}

static inline void world_close(stilb_engine *engine)
{
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
}

/* The root of the mean square of the difference of means over 2 x 2 pixels, of all channels: frames have one sample a
 * pixel, rays many, which is not what is tested. */
static inline double world_rms(const world_picture a, const world_picture b)
{
	double sum = 0.0;
	for (uint32_t y = 0; y < HEIGHT; y += 2)
		for (uint32_t x = 0; x < WIDTH; x += 2)
			for (uint32_t c = 0; c < 3; c++) {
				double off = 0.0;
				for (uint32_t p = 0; p < 4; p++) {
					uint32_t i = (y + p / 2) * WIDTH + x + p % 2;
					off += 0.25 * ((double)a[i][c] - (double)b[i][c]);
				}
				sum += off * off;
			}
	return sqrt(sum / (PIXELS / 4 * 3));
}

static inline float world_random(uint32_t seed, uint32_t use, float low, float high)
{
	return low + (high - low) * stilb_random_float(seed, use);
}

#endif
