/* Impostors on the null device: which models are drawn as theirs, against the rule stated in double; fades and
 * trembling cameras; what makes them stale; the same stream for any number of workers; dumps; errors. */
#include "render/render_detail.h"
#include "render/render_dump.h"
#include "scene/edit/scene_edit.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 640u
#define HEIGHT 360u
#define MODELS 900u
#define GRID 3u
#define SIDE 64u

static stilb_scene *scene;
static uint32_t ids[MODELS];

/* Blank maps: the null device draws nothing. */
static stilb_scene_impostor blank(uint32_t side)
{
	stilb_scene_impostor impostor = {.half = {1, 1, 1}, .radius = 1.0f, .grid = GRID, .side = side};
	assert_int_equal(stilb_image_create(&impostor.maps, GRID * side, 2 * GRID * side, 4, STILB_IMAGE_F16_LINEAR),
	                 STILB_OK);
	return impostor;
}

/* Models 0, 2, 4, ... have one of two impostors. */
static void give_impostors(void)
{
	uint32_t first, second;
	stilb_scene_impostor a = blank(SIDE), b = blank(SIDE / 2);
	assert_int_equal(stilb_scene_add_impostor(scene, &a, &first), STILB_OK);
	assert_int_equal(stilb_scene_add_impostor(scene, &b, &second), STILB_OK);
	assert_null(a.maps.pixels);
	for (uint32_t m = 0; m < MODELS; m += 2)
		assert_int_equal(stilb_scene_set_impostor(scene, m, 1 + (m % 4 ? second : first)), STILB_OK);
}

static int scene_make(void **state)
{
	(void)state;
	assert_int_equal(stilb_scene_create_stress(MODELS, 3, &scene), STILB_OK);
	for (uint32_t i = 0; i < MODELS; i++)
		ids[i] = i;
	give_impostors();
	return 0;
}

static int scene_free(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	return 0;
}

static stilb_render *make_render(stilb_render_replay_mode replay, uint32_t workers)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
	                          .replay = replay,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .context_count = workers + 1,
	                          .keep_textures = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	if (stilb_render_set_scene(render, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return render;
}

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static stilb_render_view view_at(float height, stilb_render_detail_mode mode)
{
	stilb_scene_camera camera = {
		.position = {1.0f, height, 12.0f}, .pitch = -1.2f, .fov_y = 0.85f, .near_z = 0.1f, .far_z = 1000.0f};
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, (float)WIDTH / HEIGHT),
	                          .shading = stilb_render_shading_default(),
	                          .detail = {mode, 0.5f}};
	memcpy(view.camera_position, camera.position, sizeof view.camera_position);
	return view;
}

static void draw(stilb_render *render, const stilb_render_view *view, stilb_job_pool *pool)
{
	static const stilb_render_pass pass = {.name = "scene"};
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record_view(render, 0, scene, ids, MODELS, view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, view, 1, pool, 0), STILB_OK);
}

/* ---- what a frame has drawn -------------------------------------------------------------------------------------- */

/* Of a model: draws of its parts and of its impostor, and how far they fade (RENDER_DETAIL_SHIFT). */
typedef struct seen {
	uint32_t parts, impostors, part_detail, impostor_detail;
} seen;

static void find_drawn(const stilb_render *render, seen out[MODELS])
{
	const render_pass_lists *lists = &render->passes[0];
	memset(out, 0, MODELS * sizeof *out);
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = lists->runs[r].first; c < lists->runs[r].first + lists->runs[r].count; c++) {
			const render_command *command = &render_commands(render)[c];
			const render_row *row = render_row_of(render, command);
			bool impostor = (lists->runs[r].state & RENDER_STATE_IMPOSTOR) != 0;
			uint32_t model = 0; /* tiles lie exactly below their spheres */
			while (model < MODELS && (scene->part_transform[2 * model].m[12] != row->transform[3] ||
			                          scene->part_transform[2 * model].m[14] != row->transform[11]))
				model++;
			assert_true(model < MODELS);
			if (impostor) {
				assert_int_equal(command->index_count, 6);
				assert_float_equal(row->transform[7], scene->part_transform[2 * model].m[13], 0.0f);
				out[model].impostors++;
				out[model].impostor_detail = render_command_detail(command);
			} else {
				out[model].parts++;
				out[model].part_detail = render_command_detail(command);
			}
		}
}

/* Pixels that four texels of the model's impostor are wide, at the point of its sphere that is nearest to the
 * camera. */
static double texels_of(uint32_t model, const stilb_render_view *view)
{
	const stilb_scene_bounds *b = &scene->bounds;
	double x = (double)b->x[model] - (double)view->camera_position[0];
	double y = (double)b->y[model] - (double)view->camera_position[1];
	double z = (double)b->z[model] - (double)view->camera_position[2];
	double near = fmax(sqrt(x * x + y * y + z * z) - (double)b->radius[model], 0.1);
	double pixels = HEIGHT / 2.0 / tan(0.85 / 2.0) / near;
	return 4.0 * 2.0 * (double)b->radius[model] / (model % 4 ? SIDE / 2 : SIDE) * pixels;
}

/* ---- the tests --------------------------------------------------------------------------------------------------- */

static void far_models_are_their_impostors(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(1);
	static seen all[MODELS];
	uint32_t drawn = 0, parts = 0;
	for (float height = 10.0f; height < 400.0f; height *= 1.7f) {
		stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1);
		stilb_render_view view = view_at(height, STILB_RENDER_DETAIL_POP);
		draw(render, &view, pool);
		find_drawn(render, all);
		for (uint32_t m = 0; m < MODELS; m++) {
			double texels = texels_of(m, &view);
			if (fabs(texels - 1.0) < 1e-4)
				continue;
			bool impostor = m % 2 == 0 && texels < 1.0;
			assert_int_equal(all[m].impostors, impostor ? 1 : 0);
			assert_int_equal(all[m].parts, impostor ? 0 : 2);
			drawn += impostor;
			parts += !impostor;
		}
		/* Drawn in full, there are none. */
		view.detail.mode = STILB_RENDER_DETAIL_OFF;
		draw(render, &view, pool);
		find_drawn(render, all);
		for (uint32_t m = 0; m < MODELS; m++)
			assert_true(all[m].impostors == 0 && all[m].parts == 2);
		stilb_render_destroy(render);
	}
	assert_true(drawn > 500 && parts > 500);
	stilb_job_pool_destroy(pool);
}

/* A camera that leaves: for 15 frames both are drawn, in pixels that add up to all; a camera that comes back in between
 * turns the fade around. */
static void fades_take_sixteen_frames(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(1);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1);
	stilb_render_view close = view_at(70.0f, STILB_RENDER_DETAIL_FADE), far = view_at(92.0f, STILB_RENDER_DETAIL_FADE);
	static seen all[MODELS];
	uint32_t model = 0;
	while (model < MODELS && !(texels_of(model, &close) > 1.0 && texels_of(model, &far) < 0.85))
		model += 2;
	assert_true(model < MODELS);
	draw(render, &close, pool);
	find_drawn(render, all);
	assert_true(all[model].impostors == 0 && all[model].parts == 2);
	for (uint32_t frame = 1; frame <= 17; frame++) {
		draw(render, &far, pool);
		find_drawn(render, all);
		assert_int_equal(all[model].impostors, 1);
		assert_int_equal(all[model].parts, frame < 16 ? 2 : 0);
		if (frame < 16) {
			assert_int_equal(all[model].impostor_detail, 2 * frame);
			assert_int_equal(all[model].part_detail, 2 * frame | RENDER_DETAIL_OUT);
		}
	}
	for (uint32_t frame = 1; frame <= 5; frame++)
		draw(render, &close, pool);
	find_drawn(render, all);
	assert_int_equal(all[model].part_detail, 10);
	assert_int_equal(all[model].impostor_detail, 10 | RENDER_DETAIL_OUT);
	draw(render, &far, pool); /* 5 of 16 were the meshes': 11 + 1 are the impostor's */
	find_drawn(render, all);
	assert_int_equal(all[model].impostor_detail, 24);
	assert_int_equal(all[model].part_detail, 24 | RENDER_DETAIL_OUT);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* Between nine tenths of the distance and the distance a model stays what it was. */
static void trembling_switches_nothing(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	static seen before[MODELS], after[MODELS];
	stilb_render_view view = view_at(75.0f, STILB_RENDER_DETAIL_POP);
	draw(render, &view, pool);
	find_drawn(render, before);
	uint32_t near_the_border = 0;
	for (int frame = 0; frame < 8; frame++) {
		stilb_render_view next = view_at(75.0f * (frame % 2 ? 1.03f : 1.0f), STILB_RENDER_DETAIL_POP);
		draw(render, &next, pool);
		find_drawn(render, after);
		for (uint32_t m = 0; m < MODELS; m += 2) {
			near_the_border += frame == 1 && texels_of(m, &view) > 1.0 && texels_of(m, &next) < 1.0;
			assert_int_equal(before[m].impostors, after[m].impostors);
		}
	}
	assert_true(near_the_border > 0);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static uint64_t hash_of(stilb_render_replay_mode replay, uint32_t workers, stilb_render_detail_mode mode)
{
	stilb_job_pool *pool = make_pool(workers);
	stilb_render *render = make_render(replay, workers);
	stilb_render_view close = view_at(70.0f, mode), far = view_at(95.0f, mode);
	draw(render, &close, pool);
	draw(render, &far, pool);
	draw(render, &far, pool);
	uint64_t hash = stilb_render_stream_hash(render);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	return hash;
}

static void streams_do_not_depend_on_workers(void **state)
{
	(void)state;
	for (int mode = 0; mode < 3; mode++) {
		uint64_t first = hash_of(STILB_RENDER_REPLAY_INDIRECT, 0, (stilb_render_detail_mode)mode);
		for (uint32_t workers = 1; workers < 4; workers++)
			assert_true(first ==
			            hash_of((stilb_render_replay_mode)(workers % 3), workers, (stilb_render_detail_mode)mode));
	}
	assert_true(hash_of(STILB_RENDER_REPLAY_INDIRECT, 0, STILB_RENDER_DETAIL_POP) !=
	            hash_of(STILB_RENDER_REPLAY_INDIRECT, 0, STILB_RENDER_DETAIL_FADE));
}

static uint32_t count_impostors(stilb_render *render, stilb_job_pool *pool)
{
	static seen all[MODELS];
	stilb_render_view view = view_at(400.0f, STILB_RENDER_DETAIL_POP);
	uint32_t count = 0;
	draw(render, &view, pool);
	find_drawn(render, all);
	for (uint32_t m = 0; m < MODELS; m++)
		count += all[m].impostors;
	return count;
}

static void update(stilb_render *render)
{
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	assert_int_equal(stilb_render_update_scene(render, scene, &changes), STILB_OK);
	stilb_scene_changes_clear(scene);
}

/* Edits of materials and meshes make impostors stale until others are baked; edits of a model's parts take its own. */
static void edits_take_them_away(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(1);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1);
	assert_int_equal(count_impostors(render, pool), MODELS / 2);
	stilb_scene_build_part part = {scene->part_mesh[0], scene->part_material[3]};
	assert_int_equal(stilb_scene_set_part(scene, 0, 0, part), STILB_OK);
	update(render);
	assert_int_equal(count_impostors(render, pool), MODELS / 2 - 1);
	assert_int_equal(stilb_scene_set_impostor(scene, 0, 1), STILB_OK);
	assert_int_equal(count_impostors(render, pool), MODELS / 2);
	stilb_scene_material material = scene->materials[5];
	material.roughness = 0.9f;
	assert_true(stilb_scene_impostors_are_current(scene));
	assert_int_equal(stilb_scene_set_material(scene, 5, &material), STILB_OK);
	assert_false(stilb_scene_impostors_are_current(scene));
	update(render);
	assert_int_equal(count_impostors(render, pool), 0);
	give_impostors(); /* the stale ones go */
	assert_int_equal(scene->impostor_count, 2);
	assert_int_equal(count_impostors(render, pool), 0); /* the renderer does not have them yet */
	update(render);
	assert_int_equal(count_impostors(render, pool), MODELS / 2);
	assert_int_equal(stilb_scene_set_impostor(scene, 2, 0), STILB_OK);
	assert_int_equal(count_impostors(render, pool), MODELS / 2 - 1);
	assert_int_equal(stilb_scene_set_impostor(scene, 2, 2), STILB_OK);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static void dumps_hold_impostors(void **state)
{
	(void)state;
	char path[64];
	snprintf(path, sizeof path, "/tmp/test_render_impostor_%d.dump", (int)getpid());
	static const stilb_render_pass pass = {.name = "scene"};
	stilb_job_pool *pool = make_pool(1);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1), *played;
	stilb_render_view close = view_at(70.0f, STILB_RENDER_DETAIL_FADE), far = view_at(95.0f, STILB_RENDER_DETAIL_FADE);
	draw(render, &close, pool);
	draw(render, &far, pool);
	assert_int_equal(stilb_render_dump_save(render, &pass, 1, &far, 1, path), STILB_OK);
	uint64_t hash = stilb_render_stream_hash(render);
	uint64_t states = render->passes[0].states;
	stilb_render_destroy(render);
	stilb_render_dump *dump;
	if (stilb_render_dump_load(path, &dump) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL, .width = WIDTH, .height = HEIGHT, .context_count = 2};
	assert_int_equal(stilb_render_create(&desc, &played), STILB_OK);
	assert_int_equal(stilb_render_dump_upload(dump, played), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(played), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, played, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, played, pool, 0), STILB_OK);
	assert_true(stilb_render_stream_hash(played) == hash);
	assert_true((states & RENDER_STATE_IMPOSTOR) && (played->passes[0].states & RENDER_STATE_IMPOSTOR));
	stilb_render_destroy(played);
	stilb_render_dump_destroy(dump);
	remove(path);
	stilb_job_pool_destroy(pool);
}

/* A sorted pass keeps what the draws are: an impostor's maps are no texture of a mesh. */
static void sorting_keeps_impostors(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	static const stilb_render_pass pass = {.name = "scene", .sort = true};
	stilb_render_view view = view_at(95.0f, STILB_RENDER_DETAIL_POP);
	static seen all[MODELS];
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record_view(render, 0, scene, ids, MODELS, &view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	find_drawn(render, all);
	uint32_t impostors = 0;
	for (uint32_t m = 0; m < MODELS; m++)
		impostors += all[m].impostors;
	assert_in_range(impostors, 10, MODELS / 2);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static void wrong_ones_are_refused(void **state)
{
	(void)state;
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_scene_impostor impostor = blank(8);
	stilb_render_impostor out;
	uint32_t id;
	impostor.radius = -1.0f;
	assert_int_equal(stilb_render_impostor_create(render, &impostor, &out), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "radius"));
	assert_true(out.mesh.id == 0 && out.material.id == 0 && out.texture.id == 0);
	assert_int_equal(stilb_scene_add_impostor(scene, &impostor, &id), STILB_ERROR_ARGUMENT);
	assert_non_null(impostor.maps.pixels);
	impostor.radius = 1.0f;
	assert_int_equal(stilb_render_impostor_create(render, &impostor, &out), STILB_OK);
	stilb_render_impostor_destroy(render, out);
	assert_int_equal(stilb_scene_set_impostor(scene, MODELS, 1), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_set_impostor(scene, 0, 99), STILB_ERROR_ARGUMENT);
	stilb_scene_impostor_finish(&impostor);
	stilb_render_destroy(render);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(far_models_are_their_impostors), cmocka_unit_test(fades_take_sixteen_frames),
		cmocka_unit_test(trembling_switches_nothing),     cmocka_unit_test(streams_do_not_depend_on_workers),
		cmocka_unit_test(dumps_hold_impostors),           cmocka_unit_test(sorting_keeps_impostors),
		cmocka_unit_test(wrong_ones_are_refused),         cmocka_unit_test(edits_take_them_away),
	};
	return cmocka_run_group_tests(tests, scene_make, scene_free);
}
