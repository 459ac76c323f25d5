/* A scene that is made ready beside the frames: it looks like one that was set at once, frames go on meanwhile, and it
 * may be given up or set at any moment. On the device given by DEVICE, Vulkan's under its validation layer. */
#include "engine_faults.h"
#include "engine_internal.h"
#include "tests/engine/edit_script.h"

#include <string.h>

#ifndef PREPARE_DEVICE
#define PREPARE_DEVICE STILB_RENDER_DEVICE_VULKAN
#define PREPARE_DEVICE_DRAWS 1
#include "tests/engine/pipeline_count.h"
#endif

#define SANITIZED (TEST_ASAN || TEST_TSAN) /* fewer rounds of the same */
#define WIDTH 96
#define HEIGHT 64
#define SIDE 2100u /* of a texture, pixels: 16.8 MiB with four channels, which take more than one frame */

static bool apart;    /* stilb_engine_desc.ambient_apart of engines that are made */
static bool shadowed; /* likewise: they have shadow maps */

static stilb_engine *make_engine_with(stilb_engine_textures textures)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.textures = textures;
	desc.ambient_apart = apart;
	desc.shadows.kind = shadowed ? STILB_ENGINE_SHADOWS_MAP : STILB_ENGINE_SHADOWS_OFF;
	desc.workers = 1;
	desc.width = WIDTH;
	desc.height = HEIGHT;
	desc.device = PREPARE_DEVICE;
	desc.validate = PREPARE_DEVICE == STILB_RENDER_DEVICE_VULKAN;
	if (stilb_engine_create(&desc, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static stilb_engine *make_engine(void)
{
	return make_engine_with(STILB_ENGINE_TEXTURES_AUTO);
}

/* The script's scene, and in it a sheet that shows a large texture of random rows. */
static stilb_scene *make_scene(uint64_t seed)
{
	edit_script script;
	stilb_scene *scene = script_begin(&script, seed);
	stilb_image image;
	uint32_t texture, material, mesh, model;
	stilb_scene_mesh sheet = script_sheet();
	assert_int_equal(stilb_image_create(&image, SIDE, SIDE, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	uint8_t *codes = image.pixels;
	for (uint32_t y = 0; y < SIDE; y++) /* bands of a few rows, each with a colour of its own */
		memset(codes + (size_t)y * SIDE * 3, (int)(stilb_random_u64(seed, 7000 + y / 16) % 256), (size_t)SIDE * 3);
	assert_int_equal(stilb_scene_add_texture(scene, &image, &texture), STILB_OK);
	stilb_image_finish(&image);
	stilb_scene_material paint = script_paint(&script, texture + 1);
	assert_int_equal(stilb_scene_add_material(scene, &paint, &material), STILB_OK);
	assert_int_equal(stilb_scene_add_mesh(scene, &sheet, &mesh), STILB_OK);
	stilb_mat4 place = stilb_mat4_scale_translate(6.0f, 0.0f, 2.0f, 0.0f);
	stilb_scene_build_part part = {mesh, material};
	assert_int_equal(stilb_scene_add_model(scene, &place, &part, 1, &model), STILB_OK);
	return scene;
}

/* The stream's hash of a frame, and its picture's. */
typedef struct seen {
	uint64_t stream, picture;
} seen;

static seen draw(stilb_engine *engine)
{
	stilb_engine_report report;
	stilb_image image = {0};
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	seen s = {.stream = stilb_engine_stream_hash(engine)};
	if (PREPARE_DEVICE == STILB_RENDER_DEVICE_VULKAN) {
		assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_OK);
		s.picture = stilb_hash_fnv1a64(STILB_FNV1A64_START, image.pixels, stilb_image_size(&image));
		stilb_image_finish(&image);
	}
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	return s;
}

static bool same(seen a, seen b)
{
	return a.stream == b.stream && a.picture == b.picture;
}

/* Two scenes, and what each looks like when it is set at once. */
typedef struct world {
	stilb_scene *scenes[2];
	seen looks[2];
} world;

static int set_up(void **state)
{
	static world w;
	stilb_engine *engine = make_engine();
	for (int i = 0; i < 2; i++) {
		w.scenes[i] = make_scene(21 + (uint64_t)i);
		assert_int_equal(stilb_engine_set_scene(engine, w.scenes[i]), STILB_OK);
		w.looks[i] = draw(engine);
	}
	assert_false(same(w.looks[0], w.looks[1]));
	stilb_engine_destroy(engine);
	*state = &w;
	return 0;
}

static int tear_down(void **state)
{
	world *w = *state;
	stilb_scene_destroy(w->scenes[0]);
	stilb_scene_destroy(w->scenes[1]);
	return 0;
}

/* Draws until the scene is ready; the frames show what they did. Returns their number. */
static int draw_until_ready(stilb_engine *engine, seen now)
{
	int frames = 0;
	float before = 0.0f;
	for (float done; (done = stilb_engine_prepared(engine)) < 1.0f; frames++) {
		assert_true(done >= before && "the share grows");
		before = done;
		assert_true(same(draw(engine), now));
	}
	return frames;
}

static void a_scene_is_made_ready(void **state)
{
	world *w = *state;
	stilb_engine *engine = make_engine();
	stilb_engine_report report;
	assert_int_equal(stilb_engine_prepare(engine, w->scenes[0]), STILB_OK);
	while (stilb_engine_prepared(engine) < 1.0f) /* nothing is shown yet */
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
	assert_true(same(draw(engine), w->looks[0]));
	for (int round = 0; round < (SANITIZED ? 1 : 4); round++) {
		int to = 1 - round % 2;
		assert_int_equal(stilb_engine_prepare(engine, w->scenes[to]), STILB_OK);
		int frames = draw_until_ready(engine, w->looks[1 - to]);
		assert_true(frames >= 2 && "one frame has no room for all of it");
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[to]), STILB_OK);
		for (int i = 0; i < 3; i++)
			assert_true(same(draw(engine), w->looks[to]));
	}
	stilb_engine_destroy(engine);
}

#if PREPARE_DEVICE_DRAWS
/* A frame that shows a scene that was made ready compiles nothing, whatever lights and background are new in it. */
static void pipelines_are_made_ahead(void **state)
{
	world *w = *state;
	stilb_engine *engine = make_engine();
	stilb_engine_report report;
	stilb_scene *scene = make_scene(9);
	stilb_scene_light lamp = {.kind = STILB_SCENE_LIGHT_POINT, .position = {0.0f, 4.0f, 0.0f}, .intensity = {9, 9, 9}};
	assert_int_equal(stilb_scene_set_lights(scene, &lamp, 1), STILB_OK);
	scene->both_sides = true;
	assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
	draw(engine);
	for (int prepared = 1; prepared >= 0; prepared--) {
		if (prepared)
			assert_int_equal(stilb_engine_prepare(engine, scene), STILB_OK);
		while (stilb_engine_prepared(engine) < 1.0f)
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		int before = pipeline_count;
		assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
		draw(engine);
		assert_int_equal(pipeline_count - before, prepared ? 0 : 2); /* without a texture and with one */
		lamp.kind = STILB_SCENE_LIGHT_SPOT;                          /* and without making it ready, the frame does */
		lamp.direction[1] = -1.0f;
		lamp.cos_inner = 0.9f;
		lamp.cos_outer = 0.8f;
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
		assert_int_equal(stilb_scene_set_lights(scene, &lamp, 1), STILB_OK);
	}
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* A frame in which the last lamp with shadow maps is no longer seen compiles nothing, nor does the one where it comes
 * back. */
static void lamps_come_and_go(void **state)
{
	(void)state;
	shadowed = true;
	stilb_engine *engine = make_engine();
	shadowed = false;
	stilb_engine_report report;
	stilb_scene *scene = make_scene(9);
	stilb_scene_light lamp = {.kind = STILB_SCENE_LIGHT_POINT,
	                          .position = {0.0f, 4.0f, 0.0f},
	                          .intensity = {9, 9, 9},
	                          .falloff = STILB_SCENE_LIGHT_WINDOWED,
	                          .reach = 6.0f};
	for (int i = 0, before = 0; i < 3; i++) {
		lamp.position[1] = i == 1 ? 1e6f : 4.0f;
		assert_int_equal(stilb_scene_set_lights(scene, &lamp, 1), STILB_OK);
		if (i == 0)
			assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.shadow_maps, i == 1 ? 0 : 6);
		if (i > 0)
			assert_int_equal(pipeline_count, before);
		before = pipeline_count;
	}
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* Likewise where the surroundings' light is drawn apart. */
static void pipelines_of_parts_are_made_ahead(void **state)
{
	world *w = *state;
	apart = true;
	stilb_engine *engine = make_engine();
	apart = false;
	stilb_engine_report report;
	stilb_scene *scene = make_scene(9);
	scene->both_sides = true;
	assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_engine_prepare(engine, scene), STILB_OK);
	while (stilb_engine_prepared(engine) < 1.0f)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	int before = pipeline_count;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(pipeline_count, before);
	assert_int_not_equal(stilb_gpu_plan_find(stilb_engine_plan(engine), "ambient"), 0);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}
#endif

/* After some frames, which copied a part of it: set all the same, given up, another one instead, the engine's end. */
static void at_any_moment(void **state)
{
	world *w = *state;
	for (int frames = SANITIZED; frames < (SANITIZED ? 2 : 4); frames++) {
		stilb_engine *engine = make_engine();
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
		assert_int_equal(stilb_engine_prepare(engine, w->scenes[1]), STILB_OK);
		for (int i = 0; i < frames; i++)
			assert_true(same(draw(engine), w->looks[0]));
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[1]), STILB_OK);
		assert_true(same(draw(engine), w->looks[1]));

		assert_int_equal(stilb_engine_prepare(engine, w->scenes[0]), STILB_OK);
		for (int i = 0; i < frames; i++)
			assert_true(same(draw(engine), w->looks[1]));
		assert_int_equal(stilb_engine_prepare(engine, NULL), STILB_OK);
		assert_true(stilb_engine_prepared(engine) == 1.0f);
		for (int i = 0; i < 3; i++)
			assert_true(same(draw(engine), w->looks[1]));
		assert_int_equal(stilb_engine_prepare(engine, w->scenes[0]), STILB_OK);
		assert_int_equal(stilb_engine_prepare(engine, w->scenes[0]), STILB_OK); /* anew */
		for (int i = 0; i < frames; i++)
			draw(engine);
		stilb_engine_destroy(engine);
	}
}

/* What the device does not take is set_scene's error; the scene before stays. */
static void an_error_is_told(void **state)
{
	world *w = *state;
	stilb_engine_set_faults(&(stilb_render_faults){.texture_side = SIDE - 1});
	stilb_engine *engine = make_engine();
	stilb_engine_set_faults(NULL);
	stilb_engine_report report;
	edit_script script;
	stilb_scene *small = script_begin(&script, 5);
	assert_int_equal(stilb_engine_set_scene(engine, small), STILB_OK);
	seen look = draw(engine);
	assert_int_equal(stilb_engine_prepare(engine, w->scenes[0]), STILB_OK);
	while (stilb_engine_prepared(engine) < 1.0f)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "2100x2100"));
	assert_true(stilb_engine_scene(engine) == small);
	assert_true(same(draw(engine), look));
	stilb_engine_destroy(engine);
	stilb_scene_destroy(small);
}

/* Headless, textures are waited for unless they shall come later; then the frames before the last look different, and
 * the scene may be taken away meanwhile. */
static void textures_come_later(void **state)
{
	world *w = *state;
	static const stilb_engine_textures all[] = {STILB_ENGINE_TEXTURES_AUTO, STILB_ENGINE_TEXTURES_WAIT,
	                                            STILB_ENGINE_TEXTURES_LATER};
	for (int i = 0; i < 3; i++) {
		bool later = all[i] == STILB_ENGINE_TEXTURES_LATER;
		stilb_engine *engine = make_engine_with(all[i]);
		stilb_engine_report report;
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[0]), STILB_OK);
		seen first = draw(engine);
		assert_int_equal(first.stream, w->looks[0].stream);
		assert_int_equal(same(first, w->looks[0]), !later || PREPARE_DEVICE != STILB_RENDER_DEVICE_VULKAN);
		for (uint32_t frames = 0, left = 1; left > 0; frames++) {
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
			left = report.textures_left;
			assert_true(frames < 20 && (left == 0 || later) && (left > 0 || !later || frames > 0));
		}
		assert_true(same(draw(engine), w->looks[0]));
		assert_int_equal(stilb_engine_set_scene(engine, w->scenes[1]), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.textures_left > 0, later);
		stilb_engine_destroy(engine);
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(a_scene_is_made_ready),
#if PREPARE_DEVICE_DRAWS
		cmocka_unit_test(pipelines_are_made_ahead),
		cmocka_unit_test(pipelines_of_parts_are_made_ahead),
		cmocka_unit_test(lamps_come_and_go),
#endif
		cmocka_unit_test(at_any_moment),
		cmocka_unit_test(an_error_is_told),
		cmocka_unit_test(textures_come_later),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
