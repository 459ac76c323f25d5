/* What frames with shadows must bear, under the validation layer: any number of workers and way of replaying gives the
 * same picture; from no light to a thousand; lamps within a wall, of almost no size, along every axis; scenes of one
 * triangle and of 10 km; a far plane at infinity; another size of the picture, of maps and of their number in each
 * frame; memory that is short. */
#include "engine_internal.h"
#include "gpu/gpu_internal.h"
#include "render/render_internal.h"
#include "scene/edit/scene_edit.h"
#include "support/shadow/shadow_stage.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 96u
#define HEIGHT 64u

static const stilb_engine_shadows maps = {.kind = STILB_ENGINE_SHADOWS_MAP, .size = 512};

static stilb_engine *engine_open(stilb_scene *scene, uint32_t workers, stilb_render_replay_mode replay)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = workers;
	desc.replay = replay;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.shadows = maps;
	desc.validate = true;
	if (stilb_engine_create(&desc, &engine) != STILB_OK || stilb_engine_set_scene(engine, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static void engine_close(stilb_engine *engine)
{
	double ms;
	assert_int_equal(stilb_engine_wait(engine, &ms), STILB_OK);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stilb_engine_destroy(engine);
}

/* A frame, every number of which is finite. */
static stilb_image picture(stilb_engine *engine, stilb_engine_report *report)
{
	stilb_image image = {0};
	if (stilb_engine_frame(engine, report) != STILB_OK ||
	    stilb_render_read_radiance(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const uint16_t *pixels = image.pixels;
	for (uint32_t i = 0; i < image.width * image.height * image.channels; i++)
		assert_true(isfinite(stilb_image_half_to_float(pixels[i])));
	return image;
}

static stilb_scene_camera look_down(float height)
{
	return (stilb_scene_camera){
		.position = {0.5f, height, height}, .pitch = -0.78f, .fov_y = 0.9f, .near_z = 0.05f, .far_z = 20.0f * height};
}

/* The same bits by any number of workers, and each way of replaying. A sun, a spot, a point, a sphere. */
static void workers_and_replays_show_the_same(void **state)
{
	(void)state;
	static const struct {
		uint32_t workers;
		stilb_render_replay_mode replay;
	} ways[] = {
		{0, STILB_RENDER_REPLAY_INDIRECT}, {1, STILB_RENDER_REPLAY_INDIRECT},  {2, STILB_RENDER_REPLAY_INDIRECT},
		{3, STILB_RENDER_REPLAY_INDIRECT}, {8, STILB_RENDER_REPLAY_INDIRECT},  {0, STILB_RENDER_REPLAY_DIRECT},
		{3, STILB_RENDER_REPLAY_DIRECT},   {0, STILB_RENDER_REPLAY_SECONDARY}, {3, STILB_RENDER_REPLAY_SECONDARY}};
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_SPOT,
	                                               STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_SPHERE};
	uint64_t random = 3;
	stilb_scene_light lights[4];
	for (int l = 0; l < 4; l++)
		lights[l] = shadow_stage_light(&random, kinds[l], 0.2f);
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_CLUTTER, 5, &lights[0]);
	assert_int_equal(stilb_scene_set_lights(scene, lights, 4), STILB_OK);
	scene->camera = look_down(5.0f);
	stilb_image first = {0};
	for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
		stilb_engine_report report;
		stilb_engine *engine = engine_open(scene, ways[w].workers, ways[w].replay);
		stilb_image image = picture(engine, &report);
		assert_true(report.shadow_maps >= 2 + 1 + 6 + 6);
		if (w == 0)
			first = image;
		else
			assert_memory_equal(image.pixels, first.pixels, (size_t)WIDTH * HEIGHT * image.channels * sizeof(uint16_t));
		if (w > 0)
			stilb_image_finish(&image);
		engine_close(engine);
	}
	stilb_image_finish(&first);
	stilb_scene_destroy(scene);
}

/* 0, 1, 64 and 1,000 lights: as many maps as there is room for, and pictures of numbers. */
static void any_number_of_lights(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 64, 1000};
	static stilb_scene_light lights[1000];
	uint64_t random = 9;
	stilb_scene_light light = shadow_stage_light(&random, STILB_SCENE_LIGHT_SPOT, 0.1f);
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_BALLS, 5, &light);
	scene->camera = look_down(5.0f);
	for (int l = 0; l < 1000; l++) {
		lights[l] = shadow_stage_light(&random, STILB_SCENE_LIGHT_SPOT, 0.1f);
		lights[l].falloff = STILB_SCENE_LIGHT_WINDOWED;
		lights[l].reach = 4.0f;
	}
	stilb_engine *engine = engine_open(scene, 1, STILB_RENDER_REPLAY_INDIRECT);
	for (int c = 0; c < 4; c++) {
		assert_int_equal(stilb_scene_set_lights(scene, lights, counts[c]), STILB_OK);
		stilb_engine_report report;
		stilb_image image = picture(engine, &report);
		assert_int_equal(report.shadow_maps, counts[c] < ENGINE_MAX_SHADOWS ? counts[c] : ENGINE_MAX_SHADOWS);
		stilb_image_finish(&image);
	}
	engine_close(engine);
	stilb_scene_destroy(scene);
}

/* A lamp within a box lights nothing outside. Of almost no size, it is a point. A light along each axis has its shadow:
 * less light arrives than without. */
static void lights_in_odd_places(void **state)
{
	(void)state;
	uint64_t random = 9;
	stilb_scene_light light = shadow_stage_light(&random, STILB_SCENE_LIGHT_POINT, 0.1f);
	memcpy(light.position, (float[3]){2.5f, 2.0f, 1.5f}, sizeof light.position); /* in a pillar of the hall */
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_HALL, 5, &light, maps, WIDTH, HEIGHT);
	stage.scene->camera = look_down(3.0f);
	const float *share = shadow_stage_share(&stage);
	uint32_t lit = 0, leaks = 0;
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
		lit += !isnan(share[i]);
		leaks += share[i] > 1e-3f; /* where the wall meets the floor */
	}
	assert_true(lit > 1000 && leaks <= lit / 100);
	shadow_stage_close(&stage);

	static const float axes[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}};
	static float small[WIDTH * HEIGHT];
	for (int a = 0; a < 3; a++)
		for (int k = 0; k < 4; k++) {
			static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_SPOT,
			                                               STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_SPHERE};
			light = shadow_stage_light(&random, kinds[k], 1e-6f);
			memcpy(light.direction, axes[a], sizeof light.direction);
			for (int i = 0; i < 3; i++)
				light.position[i] = (i == 1 ? 1.5f : 0.0f) - 2.0f * axes[a][i];
			light.position[1] = fmaxf(light.position[1], 0.2f);
			light.cos_outer = 0.55f;
			stage = shadow_stage_open(SHADOW_STAGE_CLUTTER, 5, &light, maps, WIDTH, HEIGHT);
			stage.scene->camera = look_down(5.0f);
			share = shadow_stage_share(&stage);
			uint32_t dark = 0, known = 0, differ = 0;
			for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
				assert_false(isinf(share[i]));
				known += !isnan(share[i]);
				dark += share[i] < 0.5f;
				differ += kinds[k] == STILB_SCENE_LIGHT_SPHERE && fabsf(share[i] - small[i]) > 0.3f;
			}
			if (kinds[k] == STILB_SCENE_LIGHT_POINT)
				memcpy(small, share, sizeof small);
			if (!(known == 0 || (dark > 0 && dark < known)))
				fail_msg("axis %d, kind %d: %u of %u pixels are in shadow", a, k, dark, known);
			assert_true(differ < 100);
			shadow_stage_close(&stage);
		}
}

/* Scenes of one triangle, of 10 km and more, and seen to infinity. */
static void scenes_of_any_size(void **state)
{
	(void)state;
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0}, sizes[] = {1e-3f, 1.0f, 1e4f, 1e6f};
	stilb_scene_vertex corners[3] = {{.position = {-1, 0, -1}, .normal = {0, 1, 0}},
	                                 {.position = {0, 0, 1}, .normal = {0, 1, 0}},
	                                 {.position = {1, 0, -1}, .normal = {0, 1, 0}}};
	uint32_t indices[3] = {0, 1, 2};
	stilb_scene_mesh mesh = {.vertices = corners, .indices = indices, .vertex_count = 3, .index_count = 3};
	for (int s = 0; s < 4; s++)
		for (int k = 0; k < 3; k++) {
			static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_SPOT,
			                                               STILB_SCENE_LIGHT_POINT};
			stilb_scene_light light = {.kind = kinds[k],
			                           .direction = {0, -1, 0},
			                           .position = {0, 2.0f * sizes[s], 0},
			                           .intensity = {1, 1, 1},
			                           .cos_inner = 0.8f,
			                           .cos_outer = 0.6f};
			for (int i = 0; i < 3; i++)
				light.intensity[i] = kinds[k] == STILB_SCENE_LIGHT_DIRECTIONAL ? 3.0f : 30.0f * sizes[s] * sizes[s];
			stilb_scene_material matt = stilb_scene_material_make(grey, none, 1.0f);
			stilb_scene_build *build = stilb_scene_build_begin();
			stilb_mat4 size = stilb_mat4_scale_translate(sizes[s], 0.0f, 0.0f, 0.0f);
			stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh),
			                               stilb_scene_build_material(build, &matt)};
			stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &size), &part, 1);
			stilb_scene_build_light(build, &light);
			stilb_scene_surroundings dark = {0};
			stilb_scene_build_surroundings(build, &dark);
			stilb_scene *scene;
			assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
			scene->camera = (stilb_scene_camera){.position = {0.0f, 2.0f * sizes[s], 0.0f},
			                                     .pitch = -1.57079633f,
			                                     .fov_y = 0.9f,
			                                     .near_z = 0.01f * sizes[s],
			                                     .far_z = s == 1 ? 1e30f : 10.0f * sizes[s]};
			stilb_engine_report report;
			stilb_engine *engine = engine_open(scene, 1, STILB_RENDER_REPLAY_INDIRECT);
			stilb_image image = picture(engine, &report);
			const uint16_t *middle = (const uint16_t *)image.pixels + (HEIGHT / 2 * WIDTH + WIDTH / 2) * image.channels;
			assert_true(report.shadow_maps > 0);
			assert_true(stilb_image_half_to_float(*middle) > 0.1f); /* it does not shade itself */
			stilb_image_finish(&image);
			engine_close(engine);
			stilb_scene_destroy(scene);
		}
}

/* A spot that swings, a point that shakes, and a lamp that lights a single frame: each frame shows what an engine shows
 * that has drawn nothing else, and the flash has a shadow at once, which is gone in the next frame. */
static void lamps_swing_shake_and_flash(void **state)
{
	(void)state;
	uint64_t random = 9;
	stilb_scene_light lights[3] = {shadow_stage_light(&random, STILB_SCENE_LIGHT_SPOT, 0.1f),
	                               shadow_stage_light(&random, STILB_SCENE_LIGHT_POINT, 0.1f),
	                               shadow_stage_light(&random, STILB_SCENE_LIGHT_POINT, 0.1f)};
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_BALLS, 5, &lights[0]);
	scene->camera = look_down(5.0f);
	stilb_engine *engine = engine_open(scene, 1, STILB_RENDER_REPLAY_INDIRECT);
	for (uint32_t f = 0; f < 4; f++) {
		stilb_scene_light now[3] = {lights[0], lights[1], lights[2]};
		float angle = 0.2f * (float)f;
		memcpy(now[0].direction, (float[3]){sinf(angle), -cosf(angle), 0.0f}, sizeof now[0].direction);
		now[1].position[0] += f % 2 == 0 ? 0.005f : -0.005f;
		for (int c = 0; c < 3; c++)
			now[2].intensity[c] *= f == 2 ? 1.0f : 0.0f;
		assert_int_equal(stilb_scene_set_lights(scene, now, 3), STILB_OK);
		stilb_engine_report report;
		stilb_image image = picture(engine, &report);
		assert_int_equal(report.shadow_maps, f == 2 ? 1 + 6 + 6 : 1 + 6);
		assert_int_equal(report.shadow_maps_drawn, report.shadow_maps);
		stilb_engine *anew = engine_open(scene, 0, STILB_RENDER_REPLAY_INDIRECT);
		stilb_image same = picture(anew, &report);
		assert_memory_equal(image.pixels, same.pixels, (size_t)WIDTH * HEIGHT * image.channels * sizeof(uint16_t));
		stilb_image_finish(&image);
		stilb_image_finish(&same);
		engine_close(anew);
	}
	engine_close(engine);
	stilb_scene_destroy(scene);
}

/* Where the device has no memory for maps they are half as large, and the picture is the one of such maps. */
static void short_memory_makes_small_maps(void **state)
{
	(void)state;
	uint64_t random = 9;
	stilb_scene_light light = shadow_stage_light(&random, STILB_SCENE_LIGHT_DIRECTIONAL, 0.1f);
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_BALLS, 5, &light);
	scene->camera = look_down(5.0f);
	stilb_image images[2];
	for (int k = 0; k < 2; k++) {
		stilb_engine_report report;
		stilb_engine *engine = engine_open(scene, 0, STILB_RENDER_REPLAY_INDIRECT);
		engine->desc.shadows.size = 256;
		for (int f = 0; f < 3; f++) { /* after which all else is allocated */
			images[k] = picture(engine, &report);
			stilb_image_finish(&images[k]);
		}
		stilb_gpu *gpu = engine->render->device->gpu;
		engine->desc.shadows.size = k == 0 ? 512 : 1024;
		gpu->faults.allocation = k == 0 ? 0 : gpu->allocations + 1;
		images[k] = picture(engine, &report);
		assert_int_equal(stilb_engine_shadows_used(engine).size, 512);
		assert_true(report.shadow_maps > 0);
		if (k == 1) { /* and again, though nothing is the matter any more: maps stay */
			stilb_image again = picture(engine, &report);
			assert_int_equal(report.shadow_maps_drawn, 0);
			stilb_image_finish(&again);
		}
		engine_close(engine);
	}
	assert_memory_equal(images[0].pixels, images[1].pixels,
	                    (size_t)WIDTH * HEIGHT * images[0].channels * sizeof(uint16_t));
	stilb_image_finish(&images[0]);
	stilb_image_finish(&images[1]);
	stilb_scene_destroy(scene);
}

/* Each frame has another size, other maps, and more or less room for them, and shows what an engine shows that has
 * drawn nothing else. */
static void everything_changes_every_frame(void **state)
{
	(void)state;
	uint64_t random = 9;
	stilb_scene_light light = shadow_stage_light(&random, STILB_SCENE_LIGHT_DIRECTIONAL, 0.1f);
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_BALLS, 5, &light);
	stilb_scene_light lights[13] = {light};
	for (int l = 1; l < 13; l++)
		lights[l] = shadow_stage_light(&random, STILB_SCENE_LIGHT_POINT, 0.1f);
	assert_int_equal(stilb_scene_set_lights(scene, lights, 13), STILB_OK);
	scene->camera = look_down(5.0f);
	stilb_engine *engine = engine_open(scene, 1, STILB_RENDER_REPLAY_INDIRECT);
	for (uint32_t f = 0; f < 12; f++) {
		static const uint32_t sides[] = {64, 1024, 128, 512};
		stilb_engine_report report;
		stilb_engine_shadows now = {.kind = STILB_ENGINE_SHADOWS_MAP, .size = sides[f % 4], .cascades = 1 + f % 3};
		engine->desc.shadows = now;
		assert_int_equal(stilb_engine_resize(engine, 40 + 16 * (f % 5), 30 + 8 * (f % 3)), STILB_OK);
		stilb_image image = picture(engine, &report);
		stilb_engine *anew = engine_open(scene, 0, STILB_RENDER_REPLAY_INDIRECT);
		anew->desc.shadows = now;
		assert_int_equal(stilb_engine_resize(anew, image.width, image.height), STILB_OK);
		stilb_image same = picture(anew, &report);
		assert_memory_equal(image.pixels, same.pixels,
		                    (size_t)image.width * image.height * image.channels * sizeof(uint16_t));
		stilb_image_finish(&image);
		stilb_image_finish(&same);
		engine_close(anew);
	}
	engine_close(engine);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(workers_and_replays_show_the_same),
		cmocka_unit_test(any_number_of_lights),
		cmocka_unit_test(lights_in_odd_places),
		cmocka_unit_test(scenes_of_any_size),
		cmocka_unit_test(lamps_swing_shake_and_flash),
		cmocka_unit_test(short_memory_makes_small_maps),
		cmocka_unit_test(everything_changes_every_frame),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
