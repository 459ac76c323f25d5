/* A scene that is edited between frames, on the null device: what is drawn is what a plain loop over the scene finds,
 * for any number of workers, culling and replay; only what changed is uploaded; scenes that take turns leave nothing
 * behind. */
#include "engine_faults.h"
#include "engine_internal.h"
#include "render/render_internal.h"
#include "support/render_reference.h"
#include "tests/engine/edit_script.h"

#include <malloc.h>
#include <string.h>

#define FRAMES 40
#define SWAPS (TEST_TSAN ? 60 : 1000)

static stilb_engine *make_engine(uint32_t workers, stilb_render_replay_mode replay, stilb_cull_method cull)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = workers;
	desc.replay = replay;
	desc.cull = cull;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.width = 160;
	desc.height = 120;
	desc.profile = false;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	return engine;
}

/* The number of models that the scene's camera sees by the definition in cull.h, and of their parts; continues *hash
 * over the draws of these. */
static uint32_t find_visible(const stilb_scene *scene, uint32_t *parts, uint64_t *hash)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, 160.0f / 120.0f);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	const stilb_scene_bounds *b = &scene->bounds;
	uint32_t count = 0;
	*parts = 0;
	for (uint32_t m = 0; m < scene->model_count; m++) {
		bool visible = true;
		for (int p = 0; p < 6; p++) {
			const stilb_plane *plane = &frustum.planes[p];
			float sum = ((b->x[m] * plane->x + b->y[m] * plane->y) + b->z[m] * plane->z) + plane->distance;
			visible = visible && sum >= -b->radius[m];
		}
		count += visible;
		*parts += visible ? scene->first_part[m + 1] - scene->first_part[m] : 0;
		if (visible)
			*hash = reference_hash_models(*hash, scene, &m, 1);
	}
	return count;
}

/* Runs the script; hashes: of the stream in each frame. */
static void run(uint32_t workers, int replay, int cull, uint64_t hashes[FRAMES])
{
	edit_script script;
	stilb_scene *scene = script_begin(&script, 3);
	stilb_engine *engine = make_engine(workers, (stilb_render_replay_mode)replay, (stilb_cull_method)cull);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	for (uint32_t f = 0; f < FRAMES; f++) {
		stilb_engine_report report;
		uint32_t parts;
		script_step(&script, scene, f);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		uint64_t hash = reference_hash_pass(REFERENCE_HASH_START, &engine->views[0]);
		assert_int_equal(report.visible, find_visible(scene, &parts, &hash));
		assert_int_equal(report.render.draws, parts);
		assert_int_equal(scene->moved_count, 0);
		hashes[f] = stilb_engine_stream_hash(engine);
		assert_true(hashes[f] == hash); /* of the scene as it is now, whatever it was before */
	}
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

static void edits_do_not_depend_on_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {3, 0, 1, 2, 8};
	uint64_t expected[FRAMES], got[FRAMES];
	run(0, 0, 0, expected);
	for (int f = 1; f < FRAMES; f++)
		assert_true(expected[f] != expected[f - 1]);
	for (int w = 0; w < (TEST_TSAN ? 1 : 5); w++)
		for (int replay = 0; replay < 3; replay++) {
			run(workers[w], replay, (w + replay) % 3, got);
			assert_memory_equal(got, expected, sizeof got);
		}
}

/* ---- what is uploaded -------------------------------------------------------------------------------------------- */

static const gpu_functions *real;
static const render_device *counted;
static const uint32_t heap_elements[RENDER_HEAPS] = {24, sizeof(uint32_t), sizeof(uint16_t), sizeof(render_material)};
static uint64_t uploaded[RENDER_HEAPS], uploaded_textures;

static stilb_result count_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                              uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                              uint32_t upload_count)
{
	memset(uploaded, 0, sizeof uploaded);
	uploaded_textures = 0;
	for (uint32_t u = 0; u < upload_count; u++) {
		const stilb_gpu_upload *upload = &uploads[u].upload;
		uploaded_textures += upload->image.id != 0;
		for (int kind = 0; kind < RENDER_HEAPS; kind++)
			if (upload->buffer.id == counted->heaps[kind].buffer.id && upload->buffer.id != 0)
				uploaded[kind] += upload->bytes / heap_elements[kind];
	}
	return real->run(gpu, plan, lists, list_count, threads, uploads, upload_count);
}

/* The elements of each heap, and the textures, that the next frame uploads. */
static void assert_uploads(stilb_engine *engine, uint64_t vertices, uint64_t indices, uint64_t materials,
                           uint64_t textures)
{
	stilb_engine_report report;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(uploaded[RENDER_HEAP_VERTICES], vertices);
	assert_int_equal(uploaded[RENDER_HEAP_INDICES] + uploaded[RENDER_HEAP_INDICES_16], indices);
	assert_int_equal(uploaded[RENDER_HEAP_MATERIALS], materials);
	assert_int_equal(uploaded_textures, textures);
}

static void only_changes_are_uploaded(void **state)
{
	(void)state;
	edit_script script;
	stilb_scene *scene = script_begin(&script, 5);
	stilb_engine *engine = make_engine(1, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_AUTO);
	stilb_gpu *gpu = engine->render->device->gpu;
	gpu_functions counting = *gpu->functions;
	stilb_scene_vertex row[SCRIPT_GRID];
	stilb_scene_material paint = script_paint(&script, 0);
	stilb_mat4 place = script_place(&script);
	stilb_image same = script_image(&script, 8);
	uint32_t vertices = scene->meshes[0].vertex_count + scene->meshes[1].vertex_count;
	uint32_t indices = 0;
	for (uint32_t m = 0; m < 2; m++)
		indices += scene->meshes[m].index_count + scene->meshes[m].level_index_count;
	real = gpu->functions;
	counted = engine->render->device;
	counting.run = count_run;
	gpu->functions = &counting;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_uploads(engine, vertices, indices, 2, 1);
	assert_uploads(engine, 0, 0, 0, 0);
	assert_int_equal(stilb_scene_set_transform(scene, 3, &place), STILB_OK);
	assert_int_equal(stilb_scene_remove_model(scene, 4), STILB_OK);
	assert_uploads(engine, 0, 0, 0, 0);
	script_sheet_row(2, 1.0f, row);
	assert_int_equal(stilb_scene_set_vertices(scene, script.sheet, 2 * SCRIPT_GRID, SCRIPT_GRID, row), STILB_OK);
	assert_int_equal(stilb_scene_set_vertices(scene, script.sheet, 7 * SCRIPT_GRID, 4, row), STILB_OK);
	assert_uploads(engine, SCRIPT_GRID + 4, 0, 0, 0);
	assert_int_equal(stilb_scene_set_material(scene, 0, &paint), STILB_OK);
	assert_uploads(engine, 0, 0, 1, 0);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &same), STILB_OK);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &same), STILB_OK);
	uint32_t live = engine->render->resources.live, retired = engine->render->resources.retired_count;
	assert_uploads(engine, 0, 0, 0, 1);
	assert_int_equal(engine->render->resources.live, live); /* in the place of the old one */
	assert_int_equal(engine->render->resources.retired_count, retired);
	stilb_image larger = script_image(&script, 16);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &larger), STILB_OK);
	assert_uploads(engine, 0, 0, 1, 1); /* the material that names it, too */
	for (int f = 0; f < 3; f++)
		assert_uploads(engine, 0, 0, 0, 0);
	assert_int_equal(engine->render->resources.live, live); /* the old one is free again */
	gpu->functions = real;
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* ---- textures that the device does not take ---------------------------------------------------------------------- */

#define REFUSED(call, words)                                                                                           \
	do {                                                                                                               \
		assert_int_equal(call, STILB_ERROR_ARGUMENT);                                                                  \
		if (!strstr(stilb_error_message(), words))                                                                     \
			fail_msg("%s", stilb_error_message());                                                                     \
	} while (0)

/* A texture that is too large, or one too many, is an error of one frame, which keeps what was there; of
 * stilb_engine_set_scene it is one that keeps the scene. */
static void textures_beyond_the_device(void **state)
{
	(void)state;
	edit_script script, other;
	stilb_scene *scene = script_begin(&script, 11), *large = script_begin(&other, 12);
	stilb_engine_report report;
	uint32_t second, third;
	stilb_image small = script_image(&script, 8);
	stilb_engine_set_faults(&(stilb_render_faults){.texture_side = 12, .textures = 2});
	stilb_engine *engine = make_engine(1, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_AUTO);
	stilb_engine_set_faults(NULL);
	const render_resources *resources = &engine->render->resources;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	uint32_t live = resources->live, texture = engine->render->scene.textures[0].texture.id;
	stilb_image image = script_image(&script, 16);
	stilb_scene_material paint = script_paint(&script, 0);
	stilb_mat4 place = script_place(&script);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &image), STILB_OK);
	assert_int_equal(stilb_scene_set_material(scene, 1, &paint), STILB_OK);
	assert_int_equal(stilb_scene_set_transform(scene, 2, &place), STILB_OK);
	REFUSED(stilb_engine_frame(engine, &report),
	        "texture 0 of the scene: GPU 'null' has textures of up to 12x12 pixels, not 16x16; use a smaller image");
	for (int f = 0; f < 3; f++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		uint32_t parts;
		uint64_t hash = reference_hash_pass(REFERENCE_HASH_START, &engine->views[0]);
		assert_int_equal(report.visible, find_visible(scene, &parts, &hash));
		assert_true(stilb_engine_stream_hash(engine) == hash); /* with the other edits */
	}
	assert_int_equal(engine->render->scene.textures[0].texture.id, texture);
	assert_int_equal(resources->live, live);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &image), STILB_OK);
	REFUSED(stilb_engine_frame(engine, &report), "texture 0 of the scene"); /* told each time that it is set */
	assert_int_equal(stilb_scene_set_texture(scene, 0, &small), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_scene_add_texture(scene, &small, &second), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_scene_set_texture(scene, 0, &image), STILB_OK); /* likely where the refused one lay */
	assert_int_equal(stilb_scene_set_texture(scene, second, &image), STILB_OK);
	REFUSED(stilb_engine_frame(engine, &report), "has textures of up to 12x12");
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK); /* one error for both */
	assert_int_equal(stilb_scene_set_texture(scene, 0, &small), STILB_OK);
	assert_int_equal(stilb_scene_set_texture(scene, second, &small), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_scene_add_texture(scene, &small, &third), STILB_OK);
	paint.diffuse_texture = third + 1;
	assert_int_equal(stilb_scene_set_material(scene, 1, &paint), STILB_OK);
	REFUSED(stilb_engine_frame(engine, &report),
	        "texture 2 of the scene: no id for another texture: at most 2 can exist at once; remove some first");
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK); /* its material has none */
	assert_int_equal(stilb_scene_remove_texture(scene, second), STILB_OK);
	for (int f = 0; f < 4; f++) /* until the device is done with it */
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_scene_set_texture(scene, third, &small), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(engine->render->scene.textures[third].texture.id != 0);
	live = resources->live;
	assert_int_equal(stilb_scene_set_texture(large, 0, &image), STILB_OK);
	REFUSED(stilb_engine_set_scene(engine, large), "texture 0 of the scene: GPU 'null'");
	assert_ptr_equal(stilb_engine_scene(engine), scene);
	for (int f = 0; f < 4; f++)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(resources->live, live);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(large);
}

/* ---- scenes that take turns -------------------------------------------------------------------------------------- */

static void swaps_leave_nothing_behind(void **state)
{
	(void)state;
	edit_script scripts[2];
	stilb_scene *scenes[2] = {script_begin(&scripts[0], 7), script_begin(&scripts[1], 8)};
	stilb_engine *engine = make_engine(1, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_AUTO);
	const render_resources *resources = &engine->render->resources;
	stilb_engine_report report;
	size_t bytes = 0;
	uint32_t live = 0, vertices = 0;
	for (int i = 0; i < SWAPS; i++) {
		assert_int_equal(stilb_engine_set_scene(engine, scenes[i % 2]), STILB_OK);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		if (i < SWAPS * 6 / 10) /* until then the device's own lists find their size */
			bytes = mallinfo2().uordblks;
		if (i < 20) {
			live = resources->live;
			vertices = resources->heaps[RENDER_HEAP_VERTICES].size;
		}
	}
	assert_int_equal(resources->live, live);
	assert_int_equal(resources->heaps[RENDER_HEAP_VERTICES].size, vertices);
	assert_true(TEST_ASAN || TEST_TSAN || mallinfo2().uordblks <= bytes + 4096);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scenes[0]);
	stilb_scene_destroy(scenes[1]);
}

/* ---- things that come and go ------------------------------------------------------------------------------------- */

#define TURNOVER (TEST_TSAN ? 1500u : 10000u)
#define TURNS 12

static void turn_in(stilb_scene *scene, uint32_t *mesh, uint32_t *model, uint32_t i, float height)
{
	stilb_scene_vertex corners[3] = {{.position = {0, 0, 0}, .normal = {0, 1, 0}},
	                                 {.position = {0, 0, 1}, .normal = {0, 1, 0}},
	                                 {.position = {1, 0, 0}, .normal = {0, 1, 0}}};
	static uint32_t indices[3] = {0, 1, 2};
	stilb_scene_mesh triangle = {.vertices = corners, .indices = indices, .vertex_count = 3, .index_count = 3};
	stilb_mat4 place = stilb_mat4_scale_translate(0.1f, (float)(i % 100) * 0.1f, height, (float)i * -0.001f);
	corners[2].position[0] = 1.0f + height;
	assert_int_equal(stilb_scene_add_mesh(scene, &triangle, mesh), STILB_OK);
	assert_int_equal(stilb_scene_add_model(scene, &place, &(stilb_scene_build_part){*mesh, 0}, 1, model), STILB_OK);
}

/* Before each frame 10,000 models and their meshes go, and as many others come: neither handles nor memory grow. */
static void turnover_does_not_grow(void **state)
{
	(void)state;
	static uint32_t meshes[10000], models[10000];
	edit_script script;
	stilb_scene *scene = script_begin(&script, 4);
	stilb_engine *engine = make_engine(1, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_AUTO);
	const render_resources *resources = &engine->render->resources;
	const render_indices *ids = &resources->indices[RENDER_RESOURCE_MESH];
	stilb_engine_report report;
	size_t bytes = 0;
	uint32_t live = 0, vertices = 0, handles = 0;
	for (uint32_t i = 0; i < TURNOVER; i++)
		turn_in(scene, &meshes[i], &models[i], i, 0.0f);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	uint32_t mesh_count = scene->mesh_count, model_count = scene->model_count;
	for (int turn = 0; turn < TURNS; turn++) {
		for (uint32_t i = 0; turn > 0 && i < TURNOVER; i++) {
			assert_int_equal(stilb_scene_remove_model(scene, models[i]), STILB_OK);
			assert_int_equal(stilb_scene_remove_mesh(scene, meshes[i]), STILB_OK);
		}
		for (uint32_t i = 0; turn > 0 && i < TURNOVER; i++)
			turn_in(scene, &meshes[i], &models[i], i, 0.01f * (float)turn);
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		uint32_t parts;
		uint64_t hash = reference_hash_pass(REFERENCE_HASH_START, &engine->views[0]);
		assert_int_equal(report.visible, find_visible(scene, &parts, &hash));
		assert_true(stilb_engine_stream_hash(engine) == hash);
		if (turn == TURNS / 2) {
			bytes = mallinfo2().uordblks;
			live = resources->live;
			vertices = resources->heaps[RENDER_HEAP_VERTICES].size;
			handles = ids->next_unused;
		}
	}
	assert_true(scene->mesh_count == mesh_count && scene->model_count == model_count); /* ids are taken again */
	assert_int_equal(resources->live, live);
	assert_int_equal(resources->heaps[RENDER_HEAP_VERTICES].size, vertices);
	assert_int_equal(ids->next_unused, handles);
	assert_true(handles <= 5 * TURNOVER); /* those of two frames in flight wait, and not many more */
	assert_true(TEST_ASAN || TEST_TSAN || mallinfo2().uordblks <= bytes + 4096);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* After 10^4 random edits, many of which add and remove, what is drawn is what another engine draws that is given the
 * scene as it is now. */
static void many_edits_leave_a_whole_scene(void **state)
{
	(void)state;
	edit_script script;
	stilb_scene *scene = script_begin(&script, 17);
	stilb_engine *engine = make_engine(1, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_OCTREE);
	stilb_engine_report report;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	uint32_t steps = TEST_TSAN ? 60 : 400; /* of 27 edits and more */
	for (uint32_t step = 0; step < steps; step++) {
		script_step(&script, scene, step);
		if (step % 4 == 3)
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	}
	uint64_t hash = stilb_engine_stream_hash(engine);
	uint32_t live = engine->render->resources.live;
	for (int i = 0; i < 4; i++) /* until what was removed is freed */
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(engine->render->resources.live <= live);
	live = engine->render->resources.live;
	stilb_engine_destroy(engine);
	engine = make_engine(0, STILB_RENDER_REPLAY_DIRECT, STILB_CULL_FLAT);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_true(stilb_engine_stream_hash(engine) == hash);
	assert_int_equal(engine->render->resources.live, live);
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

/* Edits made while another scene is shown are there when the scene is shown again. */
static void edits_of_a_scene_not_shown(void **state)
{
	(void)state;
	edit_script script, other;
	stilb_scene *scene = script_begin(&script, 9), *beside = script_begin(&other, 10);
	stilb_engine *engine = make_engine(0, STILB_RENDER_REPLAY_INDIRECT, STILB_CULL_OCTREE);
	stilb_engine_report report;
	uint32_t parts;
	uint64_t hash = 0;
	for (uint32_t f = 0; f < 12; f++) {
		assert_int_equal(stilb_engine_set_scene(engine, f % 2 ? scene : beside), STILB_OK);
		script_step(&script, scene, f); /* after it was set, and before that */
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_int_equal(report.visible, find_visible(f % 2 ? scene : beside, &parts, &hash));
		assert_int_equal(report.render.draws, parts);
	}
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(beside);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(edits_do_not_depend_on_workers), cmocka_unit_test(only_changes_are_uploaded),
		cmocka_unit_test(textures_beyond_the_device),     cmocka_unit_test(swaps_leave_nothing_behind),
		cmocka_unit_test(edits_of_a_scene_not_shown),     cmocka_unit_test(turnover_does_not_grow),
		cmocka_unit_test(many_edits_leave_a_whole_scene),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
