/* Shared by tests of effects that live over time: scenes of balls and boxes that move as a test says, their frames, and
 * the same in 64 samples a pixel. */
#ifndef POST_SCENES_H
#define POST_SCENES_H

#include "engine_internal.h"
#include "post_box.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
	SCENE_WIDTH = 160,
	SCENE_HEIGHT = 90,
	SCENE_PIXELS = SCENE_WIDTH * SCENE_HEIGHT,
	SCENE_MOST = 32,
	SCENE_FINE = 8
};

/* Of a scene: boxes (0) and balls (1), each with its colour, from 0 to 1. */
typedef struct scene_thing {
	uint32_t kind;
	float color[3];
	stilb_scene_pose pose;
} scene_thing;

/* Things below white surroundings, model m is thing m; or, joined, all are parts of one model. */
static inline stilb_scene *scene_made(const scene_thing *things, uint32_t count, const stilb_scene_camera *camera,
                                      bool joined)
{
	static const float none[3] = {0};
	stilb_scene *scene;
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh meshes[2] = {post_box()};
	assert_int_equal(stilb_scene_mesh_sphere(3, &meshes[1]), STILB_OK);
	uint32_t kinds[2];
	for (uint32_t k = 0; k < 2; k++)
		kinds[k] = stilb_scene_build_mesh(build, &meshes[k]);
	stilb_scene_build_part parts[SCENE_MOST];
	for (uint32_t t = 0; t < count; t++) {
		stilb_scene_material paint = stilb_scene_material_make(things[t].color, none, 1.0f);
		stilb_mat4 place = stilb_scene_pose_matrix(&things[t].pose);
		parts[t] = (stilb_scene_build_part){.mesh = kinds[things[t].kind],
		                                    .material = stilb_scene_build_material(build, &paint)};
		if (!joined)
			stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &parts[t], 1);
	}
	stilb_mat4 origin = stilb_mat4_identity();
	if (joined)
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &origin), parts, count);
	stilb_scene_build_camera(build, camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_mat4 places[SCENE_MOST];
	for (uint32_t t = 0; t < count; t++)
		places[t] = stilb_scene_pose_matrix(&things[t].pose);
	if (joined)
		assert_int_equal(stilb_scene_set_part_transforms(scene, 0, places), STILB_OK);
	for (int c = 0; c < 3; c++) {
		scene->surroundings.sky[c] = 1.0f;
		scene->surroundings.ground[c] = 0.5f;
	}
	stilb_scene_mesh_finish(&meshes[1]);
	return scene;
}

static inline stilb_scene *scene_of(const scene_thing *things, uint32_t count, const stilb_scene_camera *camera)
{
	return scene_made(things, count, camera, false);
}

/* Of engines that open. */
static stilb_render_output scene_output = STILB_RENDER_OUTPUT_LINEAR;
static uint32_t scene_workers = 0, scene_samples = 1;

static inline stilb_engine *scene_engine(stilb_scene *scene, uint32_t fine, const stilb_post_settings *post)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.workers = scene_workers;
	desc.width = fine * SCENE_WIDTH;
	desc.height = fine * SCENE_HEIGHT;
	desc.samples = scene_samples;
	desc.profile = false;
	desc.output = scene_output;
	desc.validate = fine == 1;
	desc.post = *post;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static inline void scene_close(stilb_engine *engine)
{
	assert_int_equal(stilb_render_validation_messages(engine->render), 0);
	stilb_engine_destroy(engine);
}

/* A channel of a pixel, as light. */
static inline float scene_value(const stilb_image *image, size_t index)
{
	if (image->format == STILB_IMAGE_F16_LINEAR)
		return stilb_image_half_to_float(((const uint16_t *)image->pixels)[index]);
	float code = ((const uint8_t *)image->pixels)[index] / 255.0f;
	return code <= 0.04045f ? code / 12.92f : powf((code + 0.055f) / 1.055f, 2.4f);
}

/* Draws a frame, and gives its RGB, or, of finer pictures, the mean of each pixel's samples,
 * weighted as post.h says, and in *varies, unless it is
 * NULL, by how much they differ at most. */
static inline void scene_frame(stilb_engine *engine, float *rgb, float *varies)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	uint32_t fine = image.width / SCENE_WIDTH;
	for (uint32_t p = 0; p < SCENE_PIXELS; p++) {
		float sum[3] = {0}, weights = 0.0f, low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f}, most = 0.0f;
		for (uint32_t s = 0; s < fine * fine; s++) {
			size_t x = p % SCENE_WIDTH * fine + s % fine, y = p / SCENE_WIDTH * fine + s / fine;
			size_t texel = (y * image.width + x) * image.channels;
			float v[3] = {scene_value(&image, texel), scene_value(&image, texel + 1), scene_value(&image, texel + 2)};
			float weight = 1.0f / (1.0f + 0.25f * v[0] + 0.5f * v[1] + 0.25f * v[2]);
			weights += weight;
			for (uint32_t c = 0; c < 3; c++) {
				sum[c] += weight * v[c];
				low[c] = fminf(low[c], v[c]);
				high[c] = fmaxf(high[c], v[c]);
			}
		}
		for (uint32_t c = 0; c < 3; c++) {
			rgb[3 * p + c] = sum[c] / weights;
			most = fmaxf(most, high[c] - low[c]);
		}
		if (varies)
			varies[p] = most;
	}
	stilb_image_finish(&image);
}

/* The root of the mean square of differences, where `varies` is at least `least` (NULL: everywhere). */
static inline double scene_error(const float *a, const float *b, const float *varies, float least)
{
	double sum = 0.0;
	uint32_t count = 0;
	for (uint32_t p = 0; p < SCENE_PIXELS; p++) {
		if (varies && varies[p] < least)
			continue;
		count++;
		for (uint32_t c = 0; c < 3; c++)
			sum += (double)(a[3 * p + c] - b[3 * p + c]) * (double)(a[3 * p + c] - b[3 * p + c]);
	}
	assert_true(count > 50);
	return sqrt(sum / (3.0 * count));
}

/* Writes a picture for people, where STILB_POST_PICTURES names a folder. */
static inline void scene_save(const float *rgb, const char *name, uint32_t number)
{
	const char *folder = getenv("STILB_POST_PICTURES");
	if (!folder)
		return;
	char path[512];
	stilb_image image = {0};
	snprintf(path, sizeof path, "%s/%s%02u.png", folder, name, number);
	assert_int_equal(stilb_image_create(&image, SCENE_WIDTH, SCENE_HEIGHT, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (uint32_t i = 0; i < 3 * SCENE_PIXELS; i++) {
		float v = fminf(fmaxf(rgb[i], 0.0f), 1.0f);
		v = v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1.0f / 2.4f) - 0.055f;
		((uint8_t *)image.pixels)[i] = (uint8_t)lrintf(255.0f * v);
	}
	assert_int_equal(stilb_image_save(&image, path), STILB_OK);
	stilb_image_finish(&image);
}

#endif
