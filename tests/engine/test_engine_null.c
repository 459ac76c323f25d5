/* The engine on the null device: frames are the same for any number of workers, and a failed creation frees everything.
 * The linker redirects allocations to the functions here (--wrap). */
#include "engine_internal.h"
#include "scene/scene_build.h"
#include "support/render_reference.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

#define MODELS 3000u
#define FRAMES 6

/* ---- memory that runs out ---------------------------------------------------------------------------------------- */

/* Allocations until one fails. Relaxed: only a count; no other data depends on it. */
static _Atomic int64_t allocations_left = INT64_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

static bool allocation_granted(void)
{
	return atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) > 0;
}

static void allocations_allow(int64_t count)
{
	atomic_store_explicit(&allocations_left, count, memory_order_relaxed);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_granted() ? __real_stilb_memory_alloc(count, size) : NULL;
}

void *__wrap_calloc(size_t count, size_t size)
{
	return allocation_granted() ? __real_calloc(count, size) : NULL;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* What make_engine shows; null_desc sets it. */
static stress_engine stress;

static stilb_engine_desc null_desc(uint32_t workers)
{
	stress = (stress_engine){.models = MODELS, .seed = 1, .view = STILB_SCENE_VIEW_HALF, .animate = true};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = workers;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.width = 320;
	desc.height = 200;
	return desc;
}

static stilb_engine *make_engine(const stilb_engine_desc *desc)
{
	stilb_engine *engine;
	assert_int_equal(stress_engine_create(desc, &stress, &engine), STILB_OK);
	return engine;
}

/* True if the model's sphere is visible by the definition in cull.h. */
static bool model_visible(const stilb_scene *scene, uint32_t model, const stilb_frustum *frustum)
{
	for (int p = 0; p < 6; p++) {
		const stilb_plane *plane = &frustum->planes[p];
		float sum = ((scene->bounds.x[model] * plane->x + scene->bounds.y[model] * plane->y) +
		             scene->bounds.z[model] * plane->z) +
		            plane->distance;
		if (!(sum >= -scene->bounds.radius[model]))
			return false;
	}
	return true;
}

/* The stream hash (the renderer's hash of a frame's draws) of the models that the scene's camera sees, computed by this
 * test and continued from hash; *visible is their number. */
static uint64_t scene_hash(uint64_t hash, const stilb_scene *scene, const stilb_mat4 *matrix, uint32_t *visible)
{
	stilb_frustum frustum = stilb_frustum_from_matrix(matrix);
	*visible = 0;
	for (uint32_t m = 0; m < scene->model_count; m++)
		if (model_visible(scene, m, &frustum)) {
			hash = reference_hash_models(hash, scene, &m, 1);
			(*visible)++;
		}
	return hash;
}

static void assert_frame(stilb_engine *engine)
{
	stilb_engine_report report;
	uint32_t width, height, visible;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	stilb_engine_size(engine, &width, &height);
	const stilb_scene *scene = stilb_engine_scene(engine);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, (float)width / (float)height);
	stilb_render_view view = {.shading = stilb_engine_shading(engine),
	                          .lights = scene->lights,
	                          .light_count = scene->light_count,
	                          .surroundings = scene->surroundings};
	uint64_t hash = scene_hash(reference_hash_pass(REFERENCE_HASH_START, &view), scene, &matrix, &visible);
	assert_int_equal(report.visible, visible);
	assert_true((report.render.draws > 2 * visible) == engine_overlay_is_open(&engine->overlay));
	assert_true(report.render.draws >= 2 * visible);
	assert_true(stilb_engine_stream_hash(engine) == hash);
	assert_true(report.drawn && !report.close);
}

static void run(const stilb_engine_desc *desc, uint64_t hashes[FRAMES])
{
	stilb_engine *engine = make_engine(desc);
	for (int f = 0; f < FRAMES; f++) {
		assert_frame(engine);
		hashes[f] = stilb_engine_stream_hash(engine);
	}
	stress_engine_destroy(engine);
}

static void frames_do_not_depend_on_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {3, 8, 0, 1, 2};
	uint64_t expected[FRAMES], got[FRAMES];
	stilb_engine_desc desc = null_desc(0);
	run(&desc, expected);
	for (int f = 1; f < FRAMES; f++)
		assert_true(expected[f] != expected[f - 1]); /* the models move */
	for (size_t w = 0; w < (TEST_TSAN ? 2 : 5); w++)
		for (int kind = 0; kind < 6; kind++) {
			desc = null_desc(workers[w]);
			desc.cull = (stilb_cull_method)(kind / 2);
			desc.replay = kind & 1 ? STILB_RENDER_REPLAY_DIRECT : STILB_RENDER_REPLAY_INDIRECT;
			run(&desc, got);
			assert_memory_equal(got, expected, sizeof expected);
		}
}

/* The bottom plane of the view is horizontal, at a height that some of the moving spheres cross in both directions. */
static void moving_models_come_and_go(void **state)
{
	(void)state;
	for (int method = STILB_CULL_AUTO; method <= STILB_CULL_FLAT; method++) {
		stilb_engine_desc desc = null_desc(2);
		desc.cull = (stilb_cull_method)method;
		stilb_engine *engine = make_engine(&desc);
		stilb_scene_camera *camera = &stilb_engine_scene(engine)->camera;
		camera->position[1] = 1.9f;
		camera->pitch = 0.5f * camera->fov_y;
		uint32_t changes = 0;
		for (uint32_t f = 0, before = 0; f < 40; f++) {
			assert_frame(engine);
			changes += engine->report.visible != before;
			before = engine->report.visible;
			engine->frame += 13; /* advances the time by 13 frames: the scene's time follows from the frame's number */
			engine->seconds = (double)engine->frame / 60.0;
		}
		assert_true(changes > 30);
		stress_engine_destroy(engine);
	}
}

static void workers_change_between_frames(void **state)
{
	(void)state;
	static const uint32_t workers[FRAMES] = {3, 0, 8, 1, 40, 2};
	uint64_t expected[FRAMES];
	stilb_engine_desc desc = null_desc(0);
	run(&desc, expected);
	stilb_engine *engine = make_engine(&desc);
	for (int f = 0; f < FRAMES; f++) {
		assert_int_equal(stilb_engine_set_workers(engine, workers[f]), STILB_OK);
		assert_int_equal(stilb_engine_workers(engine), workers[f]);
		assert_frame(engine);
		assert_true(stilb_engine_stream_hash(engine) == expected[f]);
	}
	stress_engine_destroy(engine);
}

static void reports_say_what_happened(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	stilb_engine *engine = make_engine(&desc);
	stilb_engine_report report;
	double gpu_ms = -1.0;
	for (uint64_t f = 1; f <= 4; f++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_true(report.frame == f);
		const stilb_engine_times *t = &report.times;
		assert_true(t->cull > 0.0 && t->record > 0.0 && t->replay > 0.0 && t->update >= 0.0 && t->gpu == 0.0);
		assert_true(t->frame >= (t->cull + t->record + t->replay + t->update + t->present) * 0.999999);
	}
	assert_int_equal(stilb_engine_wait(engine, &gpu_ms), STILB_OK);
	assert_true(gpu_ms == 0.0);
	assert_string_equal(stilb_engine_device_name(engine), "null");
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	assert_int_equal(stilb_engine_screenshot(engine, "picture.png"), STILB_ERROR_DEVICE);
	stress_engine_destroy(engine);
	desc.present = false;
	engine = make_engine(&desc);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(report.times.present == 0.0);
	stress_engine_destroy(engine);
}

static void another_size_is_another_view(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(1);
	stress.animate = false;
	stress.view = STILB_SCENE_VIEW_FEW;
	stilb_engine *engine = make_engine(&desc);
	assert_frame(engine);
	uint64_t before = stilb_engine_stream_hash(engine);
	assert_int_equal(stilb_engine_resize(engine, 900, 300), STILB_OK);
	assert_frame(engine);
	assert_true(stilb_engine_stream_hash(engine) != before); /* a wider picture shows more models */
	assert_int_equal(stilb_engine_resize(engine, 320, 200), STILB_OK);
	assert_frame(engine);
	assert_true(stilb_engine_stream_hash(engine) == before);
	stress_engine_destroy(engine);
}

/* The chosen shading models are part of the stream hash; the open inspector draws without changing them. */
static void formulas_are_part_of_the_stream(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	stress.animate = false;
	desc.inspector = true;
	stilb_engine *engine = make_engine(&desc);
	assert_frame(engine);
	uint64_t before = stilb_engine_stream_hash(engine);
	stilb_render_shading at_first = stilb_engine_shading(engine);
	assert_memory_equal(&at_first, &desc.shading, sizeof at_first);
	stilb_render_shading shading = at_first;
	shading.g++;
	shading.roughness = 0.25f;
	stilb_engine_set_shading(engine, &shading);
	for (int f = 0; f < 3; f++)
		assert_frame(engine);
	assert_true(stilb_engine_stream_hash(engine) != before);
	stilb_engine_set_shading(engine, &at_first);
	assert_frame(engine);
	assert_true(stilb_engine_stream_hash(engine) == before);
	stress_engine_destroy(engine);
}

/* ---- the tables -------------------------------------------------------------------------------------------------- */

/* A frame draws the scene's own view, then those of the cameras beside it, each with what it sees. */
static void each_camera_has_a_pass(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	stilb_engine *engine = make_engine(&desc);
	const stilb_scene *scene = stilb_engine_scene(engine);
	stilb_engine_camera cameras[2] = {{.name = "elsewhere", .width = 64, .height = 64},
	                                  {.name = "again", .place = {0.5f, 0.5f, 1.0f, 1.0f}}};
	cameras[0].camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_FEW, 1.0f);
	cameras[1].camera = scene->camera;
	stilb_engine_set_cameras(engine, cameras, 2);
	for (int f = 0; f < 3; f++) {
		stilb_engine_report report;
		uint32_t visible[3];
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		uint64_t hash = STILB_FNV1A64_START;
		for (int v = 0; v < 3; v++)
			hash = scene_hash(reference_hash_pass(hash, &engine->views[v]), scene, &engine->views[v].view_projection,
			                  &visible[v]);
		assert_true(visible[0] != visible[1] && visible[1] > 0);
		assert_int_equal(visible[0], report.visible);
		assert_true(report.render.draws == 2 * (visible[0] + visible[1] + visible[2]));
		assert_true(report.render.indirect_commands >= 3);
		assert_true(stilb_engine_stream_hash(engine) == hash);
	}
	stress_engine_destroy(engine);
}

/* ---- ends -------------------------------------------------------------------------------------------------------- */

static void destroy_at_any_time(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(3);
	for (int frames = 0; frames < 3; frames++) {
		stilb_engine *engine = make_engine(&desc);
		for (int f = 0; f < frames; f++)
			assert_frame(engine);
		if (frames == 1)
			assert_int_equal(stilb_engine_set_workers(engine, 5), STILB_OK);
		stress_engine_destroy(engine);
	}
	stress_engine_destroy(NULL);
}

static void what_cannot_start_says_why(void **state)
{
	(void)state;
	stilb_engine *engine = (stilb_engine *)&engine;
	stilb_engine_desc desc = null_desc(STILB_JOB_MAX_WORKERS + 1);
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_THREAD);
	assert_null(engine);
	assert_non_null(strstr(stilb_error_message(), "257 threads"));
	desc = null_desc(1);
	desc.window = true;
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_WINDOW);
	assert_null(engine);
	desc = null_desc(1);
	desc.device = STILB_RENDER_DEVICE_VULKAN;
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_DEVICE);
	assert_null(engine);
	assert_string_equal(stilb_error_message(), "no Vulkan in this test");
	/* The program's keys are checked against the engine's own, of which only those are there that have an effect. */
	stilb_input_action own = {.name = "print", .keys = {STILB_WINDOW_KEY_F12}, .help = "print"};
	desc = null_desc(1);
	desc.actions = &own;
	desc.action_count = 1;
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_OK);
	stress_engine_destroy(engine);
	desc.saves = true;
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_ARGUMENT);
	assert_null(engine);
	assert_string_equal(stilb_error_message(), "actions 'picture' and 'print' both have 'F12'; give one another key");
}

enum { TURNS = 60 };

/* Scenes take turns in one engine; in between there is none. */
static void take_turns(stilb_scene *const scenes[2], uint32_t workers, uint64_t hashes[TURNS])
{
	stilb_engine_desc desc = null_desc(workers);
	stilb_engine *engine;
	stilb_engine_report report;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	for (int turn = 0; turn < TURNS; turn++) {
		stilb_scene *scene = turn % 3 < 2 ? scenes[turn % 3] : NULL;
		assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
		assert_true(stilb_engine_scene(engine) == scene);
		for (int f = 0; f < turn % 4; f++) {
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
			assert_int_equal(report.visible, scene ? scene->model_count : 0);
			assert_int_equal(report.render.draws, scene ? 2 * scene->model_count : 0);
		}
		hashes[turn] = stilb_engine_stream_hash(engine);
	}
	stilb_engine_destroy(engine);
}

static void scenes_take_turns(void **state)
{
	(void)state;
	static uint64_t expected[TURNS], got[TURNS];
	stilb_scene *scenes[2];
	for (int i = 0; i < 2; i++) {
		assert_int_equal(stilb_scene_create_stress(i ? 300 : 700, 1, &scenes[i]), STILB_OK);
		scenes[i]->camera = stilb_scene_stress_camera(scenes[i], STILB_SCENE_VIEW_ALL, 320.0f / 200.0f);
	}
	take_turns(scenes, 0, expected);
	assert_true(expected[13] != expected[15]); /* each with one frame at least */
	take_turns(scenes, 3, got);
	assert_memory_equal(got, expected, sizeof expected);
	for (int i = 0; i < 2; i++)
		stilb_scene_destroy(scenes[i]);
}

/* The frame and its dump have the lights of the scene; a scene that was just set has no frame to dump. */
static void lights_are_the_scenes(void **state)
{
	(void)state;
	stilb_scene_mesh plane;
	stilb_mat4 here = stilb_mat4_identity();
	stilb_scene_light light = {.intensity = {1, 2, 3}, .position = {0, 4, 0}};
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &plane),
	                               stilb_scene_build_material(build, &(stilb_scene_material){.roughness = 1.0f})};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	stilb_scene_build_light(build, &light);
	stilb_scene_mesh_finish(&plane);
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_engine_desc desc = null_desc(1);
	stilb_engine *engine;
	stilb_engine_report report;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_int_equal(stilb_engine_dump(engine, "test_engine_null.dump"), STILB_ERROR_ARGUMENT);
	for (int f = 0; f < 3; f++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.visible, 1);
		assert_int_equal(engine->views[0].light_count, 1);
		assert_memory_equal(engine->views[0].lights, &light, sizeof light);
	}
	for (uint32_t flags = STILB_SCENE_MODEL_FLAGS + 1; flags-- > 0;) { /* an unseen model is not recorded */
		assert_int_equal(stilb_scene_set_model_flags(scene, 0, flags), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.visible, flags & STILB_SCENE_MODEL_UNSEEN ? 0 : 1);
		assert_int_equal(report.render.draws, report.visible);
	}
	assert_int_equal(stilb_engine_dump(engine, "test_engine_null.dump"), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_int_equal(stilb_engine_dump(engine, "test_engine_null.dump"), STILB_ERROR_ARGUMENT);
	remove("test_engine_null.dump");
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* The cameras' views draw models that are seen, the views of shadow maps those that cast shadows. */
static void views_draw_by_flags(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(1);
	stilb_engine_report report;
	stress.models = 1;
	stress.animate = false;
	stress.view = STILB_SCENE_VIEW_ALL;
	desc.shadows.kind = STILB_ENGINE_SHADOWS_MAP;
	stilb_engine *engine = make_engine(&desc);
	stilb_scene *scene = stilb_engine_scene(engine);
	for (uint32_t flags = STILB_SCENE_MODEL_FLAGS + 1; flags-- > 0;) {
		assert_int_equal(stilb_scene_set_model_flags(scene, 0, flags), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		uint32_t seen = 0, casts = 0; /* summed over the views of each kind; not every map holds the model */
		for (uint32_t v = 0; v < engine->view_count; v++)
			*(engine->views[v].shadow ? &casts : &seen) += engine->visible[v].count;
		assert_true(engine->view_count > 1 && engine->views[engine->view_count - 1].shadow);
		assert_int_equal(seen > 0, !(flags & STILB_SCENE_MODEL_UNSEEN));
		assert_int_equal(casts > 0, !(flags & STILB_SCENE_MODEL_CASTS_NO_SHADOW));
	}
	stress_engine_destroy(engine);
}

/* Lets each allocation of the engine's creation and of its first frames fail once. Memory that is then not freed is
 * found by the leak check. */
static void no_memory(const stilb_engine_desc *desc)
{
	bool created = false, drawn = false;
	int64_t granted = 0, needed = 0;
	for (; !drawn; granted++) {
		stilb_engine *engine;
		stilb_engine_report report;
		allocations_allow(granted);
		stilb_result result = stress_engine_create(desc, &stress, &engine);
		created = result == STILB_OK;
		needed += !created;
		if (created)
			result = stilb_engine_frame(engine, &report);
		drawn = result == STILB_OK;
		allocations_allow(INT64_MAX);
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY || result == STILB_ERROR_THREAD);
		assert_true(!engine == !created);
		if (created && !drawn)
			assert_frame(engine); /* the next frame succeeds again */
		stress_engine_destroy(engine);
	}
	assert_true(needed > 15 && granted > needed + 5);
}

static void no_memory_anywhere(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	stress.models = 500;
	no_memory(&desc);
	if (TEST_TSAN) /* the windows are made by one thread */
		return;
	desc.overlay = desc.inspector = true;
	no_memory(&desc);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(frames_do_not_depend_on_workers),
		cmocka_unit_test(moving_models_come_and_go),
		cmocka_unit_test(workers_change_between_frames),
		cmocka_unit_test(reports_say_what_happened),
		cmocka_unit_test(another_size_is_another_view),
		cmocka_unit_test(formulas_are_part_of_the_stream),
		cmocka_unit_test(each_camera_has_a_pass),
		cmocka_unit_test(destroy_at_any_time),
		cmocka_unit_test(what_cannot_start_says_why),
		cmocka_unit_test(no_memory_anywhere),
		cmocka_unit_test(scenes_take_turns),
		cmocka_unit_test(lights_are_the_scenes),
		cmocka_unit_test(views_draw_by_flags),
		cmocka_unit_test(reference_no_third_party),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
