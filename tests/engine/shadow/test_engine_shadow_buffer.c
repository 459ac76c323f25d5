/* The buffer of shadows: pictures are those of maps in every way of lighting, for one light and for more than a layer
 * holds; lights beyond its room read maps. The mask that takes over where cascades end. What frames show of shadows in
 * the place of light. */
#include "engine_internal.h"
#include "render/device/render_images.h"
#include "scene/edit/scene_edit.h"
#include "shading/shade_srgb.h"
#include "support/shadow/shadow_stage.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 96u
#define HEIGHT 64u
#define PIXELS (WIDTH * HEIGHT)

static stilb_engine *engine_open(stilb_scene *scene, const stilb_engine_shadows *shadows, stilb_render_lighting way)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.profile = false;
	desc.output = STILB_RENDER_OUTPUT_LINEAR;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.samples = 1;
	desc.shadows = *shadows;
	desc.lighting = way;
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

static void radiance(stilb_engine *engine, float (*out)[3])
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK ||
	    stilb_render_read_radiance(engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const uint16_t *pixels = image.pixels;
	for (uint32_t i = 0; i < PIXELS; i++)
		for (int c = 0; c < 3; c++)
			out[i][c] = stilb_image_half_to_float(pixels[i * image.channels + (uint32_t)c]);
	stilb_image_finish(&image);
}

/* Layers of the frame's buffer; 0: it has none. */
static uint32_t buffer_layers(const stilb_engine *engine)
{
	const stilb_gpu_plan *plan = stilb_render_plan(engine->render);
	uint16_t image = stilb_gpu_plan_find(plan, STILB_RENDER_IMAGE_SHADOW_BUFFER);
	return image != 0 ? stilb_gpu_plan_extent(plan, image)->layers : 0;
}

/* ---- the same picture -------------------------------------------------------------------------------------------- */

#define LIGHTS 7u

static stilb_scene *lit_scene(uint32_t count)
{
	static const stilb_scene_light_kind kinds[LIGHTS] = {
		STILB_SCENE_LIGHT_SPOT, STILB_SCENE_LIGHT_DIRECTIONAL, STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_SPHERE,
		STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_RECTANGLE,   STILB_SCENE_LIGHT_POINT};
	stilb_scene_light lights[LIGHTS];
	uint64_t random = 12;
	for (uint32_t l = 0; l < LIGHTS; l++) {
		lights[l] = shadow_stage_light(&random, kinds[l], 0.2f);
		bool lamp = kinds[l] != STILB_SCENE_LIGHT_DIRECTIONAL;
		for (int c = 0; c < 3; c++) /* each has a colour of its own */
			lights[l].intensity[c] = (lamp ? 2.0f : 0.4f) * ((uint32_t)c == l % 3 ? 1.0f : 0.3f);
		if (l % 2 == 0 && lamp) {
			lights[l].falloff = STILB_SCENE_LIGHT_WINDOWED;
			lights[l].reach = 9.0f;
		}
	}
	stilb_scene *scene = shadow_stage_scene(SHADOW_STAGE_CLUTTER, 5, &lights[0]);
	assert_int_equal(stilb_scene_set_lights(scene, lights, count), STILB_OK);
	scene->camera = (stilb_scene_camera){
		.position = {0.5f, 4.0f, 5.5f}, .pitch = -0.65f, .fov_y = 0.9f, .near_z = 0.05f, .far_z = 100.0f};
	return scene;
}

static float code_of(float light)
{
	return 255.0f * shade_srgb_from_linear(fminf(fmaxf(light, 0.0f), 1.0f));
}

/* The picture with a buffer is that with maps, to a code of the display, and much of it is in shadow. lit: without. */
static void compare(stilb_scene *scene, stilb_render_lighting way, uint32_t layers, float (*lit)[3])
{
	static float maps[PIXELS][3], buffer[PIXELS][3];
	static const stilb_engine_shadows kinds[2] = {{.kind = STILB_ENGINE_SHADOWS_MAP, .size = 512},
	                                              {.kind = STILB_ENGINE_SHADOWS_BUFFER, .size = 512}};
	float(*pictures[2])[3] = {maps, buffer};
	for (int k = 0; k < 2; k++) {
		stilb_engine *engine = engine_open(scene, &kinds[k], way);
		radiance(engine, pictures[k]);
		assert_int_equal(buffer_layers(engine), k == 1 ? layers : 0);
		engine_close(engine);
	}
	float worst = 0.0f;
	uint32_t shadowed = 0, apart = 0;
	for (uint32_t i = 0; i < PIXELS; i++)
		for (int c = 0; c < 3; c++) {
			float off_by = fabsf(code_of(maps[i][c]) - code_of(buffer[i][c]));
			worst = fmaxf(worst, off_by);
			apart += off_by > 0.0f;
			shadowed += maps[i][c] < 0.7f * lit[i][c];
		}
	print_message("%s: %u layers, off by %.2f codes at most, %u of %u values differ, %u in shadow\n",
	              stilb_render_lighting_names[way], layers, (double)worst, apart, 3 * PIXELS, shadowed);
	assert_true(shadowed > PIXELS / 4);
	assert_true(worst <= 1.25f); /* each light's share is off by half a code */
}

static void pictures_are_those_of_maps(void **state)
{
	(void)state;
	static const stilb_render_lighting ways[] = {
		STILB_RENDER_LIGHTING_FORWARD,        STILB_RENDER_LIGHTING_CLUSTERED, STILB_RENDER_LIGHTING_COMBINED,
		STILB_RENDER_LIGHTING_TILED_FORWARD,  STILB_RENDER_LIGHTING_INDEXED,   STILB_RENDER_LIGHTING_DEFERRED,
		STILB_RENDER_LIGHTING_TILED_DEFERRED, STILB_RENDER_LIGHTING_PRELIGHT,  STILB_RENDER_LIGHTING_PREPASS};
	static const stilb_engine_shadows none = {.kind = STILB_ENGINE_SHADOWS_OFF};
	static float lit[PIXELS][3];
	stilb_scene *scene = lit_scene(LIGHTS);
	stilb_engine *engine = engine_open(scene, &none, STILB_RENDER_LIGHTING_FORWARD);
	radiance(engine, lit);
	engine_close(engine);
	for (size_t w = 0; w < sizeof ways / sizeof *ways; w++)
		compare(scene, ways[w], 2, lit);
	stilb_scene_destroy(scene);
	scene = lit_scene(1);
	compare(scene, STILB_RENDER_LIGHTING_FORWARD, 1, lit);
	compare(scene, STILB_RENDER_LIGHTING_DEFERRED, 1, lit);
	stilb_scene_destroy(scene);
}

/* More lights than it holds read maps, all of them: the same bits. */
static void too_many_read_maps(void **state)
{
	(void)state;
	static float pictures[2][PIXELS][3];
	static stilb_scene_light lights[STILB_RENDER_SHADOW_BUFFER_LIGHTS + 1];
	uint64_t random = 4;
	for (uint32_t l = 0; l < STILB_RENDER_SHADOW_BUFFER_LIGHTS + 1; l++)
		lights[l] = shadow_stage_light(&random, STILB_SCENE_LIGHT_SPOT, 0.1f);
	stilb_scene *scene = lit_scene(1);
	assert_int_equal(stilb_scene_set_lights(scene, lights, STILB_RENDER_SHADOW_BUFFER_LIGHTS + 1), STILB_OK);
	for (int k = 0; k < 2; k++) {
		stilb_engine_shadows shadows = {.kind = k ? STILB_ENGINE_SHADOWS_BUFFER : STILB_ENGINE_SHADOWS_MAP,
		                                .size = 256};
		stilb_engine *engine = engine_open(scene, &shadows, STILB_RENDER_LIGHTING_FORWARD);
		radiance(engine, pictures[k]);
		assert_int_equal(buffer_layers(engine), 0);
		engine_close(engine);
	}
	assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
	stilb_scene_destroy(scene);
}

/* ---- the mask ---------------------------------------------------------------------------------------------------- */

typedef struct hand_made {
	stilb_render *render;
	float share; /* in all of it */
	uint16_t layers;
} hand_made;

/* stilb_render_feature.add: the mask, cleared to a share. */
static stilb_result add_mask(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	const hand_made *mask = user;
	stilb_gpu_draws none = {0};
	uint32_t list;
	(void)image;
	stilb_result result = stilb_render_add_draws(mask->render, &none, &list);
	if (result != STILB_OK)
		return result;
	uint16_t made = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = STILB_RENDER_IMAGE_MASK,
	                                                                       .format = STILB_GPU_R8_U,
	                                                                       .width = WIDTH,
	                                                                       .height = HEIGHT,
	                                                                       .layers = mask->layers});
	for (uint16_t l = 0; l < mask->layers; l++)
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "mask",
		                                            .kind = STILB_GPU_PASS_DRAWS,
		                                            .draws = list,
		                                            .color = {{.image = made,
		                                                       .layer = l,
		                                                       .load = STILB_GPU_LOAD_CLEAR,
		                                                       .clear = {mask->share, 0.0f, 0.0f, 1.0f}}},
		                                            .color_count = 1});
	return STILB_OK;
}

/* The mean share of the sun on what is seen of the far end of a hall. share < 0: there is no mask. */
static double far_share(float distance, float share, uint16_t layers)
{
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.48f, -0.8f, 0.36f}};
	stilb_engine_shadows shadows = {.kind = STILB_ENGINE_SHADOWS_BUFFER, .size = 512, .distance = distance};
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_HALL, 5, &sun, shadows, WIDTH, HEIGHT);
	hand_made mask = {stage.engine->render, share, layers};
	if (share >= 0.0f)
		assert_int_equal(
			stilb_engine_add_feature(stage.engine, &(stilb_render_feature){STILB_RENDER_STAGE_FIRST, add_mask, &mask}),
			STILB_OK);
	stage.scene->camera = (stilb_scene_camera){
		.position = {6.0f, 2.0f, 7.0f}, .pitch = -0.1f, .fov_y = 0.5f, .near_z = 0.05f, .far_z = 100.0f};
	const float *live = shadow_stage_share(&stage);
	double sum = 0.0;
	uint32_t count = 0;
	for (uint32_t i = PIXELS / 4; i < PIXELS; i++) /* below: the wall, the floor */
		if (!isnan(live[i])) {
			sum += (double)live[i];
			count++;
		}
	assert_true(count > PIXELS / 20);
	shadow_stage_close(&stage);
	return sum / count;
}

/* A house beyond the last cascade: with the last one that holds all it is as dark as it is; with cascades that end
 * before it, it would be bright; the mask keeps it as its maker says, where it has a layer for the light. */
static void houses_far_away_stay_dark(void **state)
{
	(void)state;
	double whole = far_share(0.0f, -1.0f, 0), bright = far_share(1.0f, -1.0f, 0), dark = far_share(1.0f, 0.0f, 1);
	double half = far_share(1.0f, 0.5f, 2);
	print_message(
		"share of the sun in a hall: %.3f; 6 m beyond the last cascade %.3f, by masks of 0 and 0.5: %.3f, %.3f\n",
		whole, bright, dark, half);
	assert_true(whole < 0.3);
	assert_true(bright > 0.99);
	assert_true(dark < 0.01);
	assert_true(fabs(half - 0.5) < 0.02);
}

/* The share of the sun on balls over a floor, whose one map has the balls alone. share < 0: there is no mask. */
static void share_of_things(float share, stilb_render_lighting way, float *out)
{
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.48f, -0.8f, 0.36f}};
	stilb_engine_shadows shadows = {
		.kind = STILB_ENGINE_SHADOWS_BUFFER, .size = 512, .objects = true, .distance = 20.0f};
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BALLS, 5, &sun, shadows, WIDTH, HEIGHT);
	stilb_engine_set_lighting(stage.engine, way);
	hand_made mask = {stage.engine->render, share, 1};
	if (share >= 0.0f)
		assert_int_equal(
			stilb_engine_add_feature(stage.engine, &(stilb_render_feature){STILB_RENDER_STAGE_FIRST, add_mask, &mask}),
			STILB_OK);
	stage.scene->camera = (stilb_scene_camera){
		.position = {0.5f, 4.0f, 5.5f}, .pitch = -0.65f, .fov_y = 0.9f, .near_z = 0.05f, .far_z = 100.0f};
	memcpy(out, shadow_stage_share(&stage), PIXELS * sizeof *out);
	shadow_stage_close(&stage);
}

/* Things that cast on light that others made darken no more than what of it there is: the less of the mask's share and
 * the map's arrives. In the open that is the mask's, in their shadow nothing, and at its edges not the product. */
static void things_darken_what_is_lit(void **state)
{
	(void)state;
	static float open[PIXELS], half[PIXELS], none[PIXELS];
	static const stilb_render_lighting ways[] = {STILB_RENDER_LIGHTING_FORWARD, STILB_RENDER_LIGHTING_DEFERRED};
	share_of_things(-1.0f, ways[0], open);
	share_of_things(0.0f, ways[1], none);
	for (int w = 0; w < 2; w++) {
		share_of_things(0.5f, ways[w], half);
		uint32_t dark = 0, lit = 0, edge = 0;
		for (uint32_t i = 0; i < PIXELS; i++) {
			if (isnan(open[i]))
				continue;
			assert_true(fabsf(half[i] - fminf(open[i], 0.5f)) < 0.02f);
			assert_true(none[i] < 0.01f);
			dark += open[i] < 0.01f;
			lit += open[i] > 0.99f;
			edge += open[i] > 0.2f && open[i] < 0.8f;
		}
		print_message("%s: %u pixels dark, %u lit, %u at edges\n", stilb_render_lighting_names[ways[w]], dark, lit,
		              edge);
		assert_true(dark > 50 && lit > 500 && edge > 20);
	}
}

/* ---- what is shown ----------------------------------------------------------------------------------------------- */

/* Pixels of which one channel is more than so many times each of the others, and not dark. */
static uint32_t colored(float (*picture)[3], int channel, float times)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < PIXELS; i++) {
		float other = fmaxf(picture[i][(channel + 1) % 3], picture[i][(channel + 2) % 3]);
		count += picture[i][channel] > 0.05f && picture[i][channel] > times * other;
	}
	return count;
}

/* ACNE is red where surfaces shade themselves: without bias, and hardly anywhere with it. CASCADES has the colours of
 * two cascades, a near and a far one. */
static void shadows_are_shown(void **state)
{
	(void)state;
	static float picture[PIXELS][3];
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.6f, -0.8f, 0.0f}};
	stilb_scene *scene = lit_scene(1);
	assert_int_equal(stilb_scene_set_lights(scene, &sun, 1), STILB_OK);
	scene->camera.position[1] = 2.0f;
	scene->camera.position[2] = 8.0f;
	scene->camera.pitch = -0.25f;
	uint32_t red[2];
	for (int k = 0; k < 2; k++) {
		stilb_engine_shadows shadows = {.kind = STILB_ENGINE_SHADOWS_BUFFER,
		                                .size = 512,
		                                .bias = k ? STILB_ENGINE_SHADOW_BIAS_NONE : STILB_ENGINE_SHADOW_BIAS_ALL};
		stilb_engine *engine = engine_open(scene, &shadows, STILB_RENDER_LIGHTING_FORWARD);
		stilb_engine_set_shows(engine, STILB_RENDER_SHOW_ACNE);
		radiance(engine, picture);
		red[k] = colored(picture, 0, 1.25f);
		assert_int_equal(buffer_layers(engine), 0); /* it is drawn from maps */
		if (k == 0) {
			stilb_engine_set_shows(engine, STILB_RENDER_SHOW_CASCADES);
			radiance(engine, picture);
			uint32_t near = colored(picture, 0, 2.5f), far = colored(picture, 1, 2.5f);
			print_message("cascades: %u pixels of the first, %u of the second\n", near, far);
			assert_true(near > PIXELS / 20 && far > PIXELS / 50);
			stilb_engine_set_shows(engine, STILB_RENDER_SHOW_ATLAS);
			radiance(engine, picture);
			stilb_engine_report report;
			stilb_image atlas = {0};
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
			assert_int_equal(stilb_render_read_image(engine->render, &atlas), STILB_OK);
			const uint16_t *pixels = atlas.pixels;
			uint32_t grey = 0;
			for (uint32_t i = 0; i < PIXELS; i++) {
				const uint16_t *pixel = pixels + i * atlas.channels;
				float value = stilb_image_half_to_float(pixel[0]);
				grey += value > 0.3f && value < 1.01f && pixel[0] == pixel[2];
			}
			print_message("atlas: %u pixels of %ux%u are grey\n", grey, atlas.width, atlas.height);
			assert_true(grey > PIXELS / 20);
			stilb_image_finish(&atlas);
		}
		engine_close(engine);
	}
	print_message("acne: %u pixels are red, without bias %u\n", red[0], red[1]);
	assert_true(red[0] <= PIXELS / 500 && red[1] > PIXELS / 20);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_those_of_maps), cmocka_unit_test(too_many_read_maps),
		cmocka_unit_test(houses_far_away_stay_dark),  cmocka_unit_test(things_darken_what_is_lit),
		cmocka_unit_test(shadows_are_shown),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
