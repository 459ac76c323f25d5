/* Rows that are kept from frame to frame: whatever changes in a scene, in each way that the API has, every draw has the
 * row that a renderer to which the scene was given anew has; and no row changes that a frame in flight reads. With
 * "vulkan" as argument the pictures are compared, too. */
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/edit/scene_variant.h"
#include "scene/scene_internal.h"
#include "support/render_fixture.h"

#define MODELS 60u
#define MOST_MODELS 400u
#define NODES 12u
#define VARIANTS 2u
#define SIDE 96u

static bool vulkan;

/* ---- a scene that has all there is ------------------------------------------------------------------------------- */

static float roll(uint64_t *random)
{
	return stilb_random_float(5, (*random)++);
}

static uint32_t roll_below(uint64_t *random, uint32_t end)
{
	return (uint32_t)(stilb_random_u64(5, (*random)++) % end);
}

static stilb_mat4 roll_place(uint64_t *random)
{
	stilb_mat4 m = stilb_mat4_scale_translate(0.2f + roll(random), 8.0f * roll(random) - 4.0f, roll(random),
	                                          8.0f * roll(random) - 4.0f);
	m.m[4] = 0.3f * roll(random); /* shears */
	return m;
}

static stilb_scene_pose roll_pose(uint64_t *random)
{
	stilb_scene_pose pose = stilb_scene_pose_identity();
	for (int i = 0; i < 3; i++)
		pose.translation[i] = 2.0f * roll(random) - 1.0f;
	return pose;
}

/* Models of two parts, nodes that hang on one another, and variants of materials. */
static stilb_scene *make_scene(void)
{
	stilb_scene *scene = fixture_scene(MODELS);
	uint64_t random = 1;
	assert_int_equal(scene_add_variants(scene, VARIANTS), STILB_OK);
	for (uint32_t v = 0; v <= VARIANTS; v++)
		for (uint32_t p = 0; p < scene->part_count; p++)
			scene->variants->materials[v * scene->part_count + p] =
				(scene->part_material[p] + v) % scene->material_count;
	for (uint32_t n = 0; n < NODES; n++) {
		uint32_t node;
		stilb_scene_pose pose = roll_pose(&random);
		uint32_t parent = n == 0 ? STILB_SCENE_NONE : n / 2;
		assert_int_equal(stilb_scene_add_node(scene, parent, &pose, &node), STILB_OK);
	}
	return scene;
}

/* ---- edits ------------------------------------------------------------------------------------------------------- */

static void edit_add(stilb_scene *scene, uint64_t *random)
{
	uint32_t id, count = 1 + roll_below(random, 3);
	stilb_scene_build_part parts[3];
	stilb_mat4 place = roll_place(random);
	for (uint32_t p = 0; p < count; p++)
		parts[p] = (stilb_scene_build_part){roll_below(random, 2), roll_below(random, scene->material_count)};
	if (scene->model_count < MOST_MODELS)
		assert_int_equal(stilb_scene_add_model(scene, &place, parts, count, &id), STILB_OK);
}

/* A mesh of another size in place of a mesh. */
static void edit_mesh(stilb_scene *scene, uint64_t *random)
{
	stilb_scene_mesh mesh;
	bool sphere = roll_below(random, 2) == 0;
	assert_int_equal(sphere ? stilb_scene_mesh_sphere(roll_below(random, 3), &mesh) : stilb_scene_mesh_plane(&mesh),
	                 STILB_OK);
	assert_int_equal(stilb_scene_set_mesh(scene, roll_below(random, 2), &mesh), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
}

/* Who writes transforms without scene_edit.h lists the model himself. */
static void edit_directly(stilb_scene *scene, uint32_t model, uint64_t *random)
{
	for (uint32_t i = 0; i < scene->moved_count; i++)
		if (scene->moved[i] == model)
			return;
	scene->part_transform[scene->first_part[model]] = roll_place(random);
	scene->moved[scene->moved_count++] = model;
}

/* Makes one random edit. Those of a model that was removed are refused. */
static void edit(stilb_scene *scene, uint64_t *random)
{
	uint32_t model = roll_below(random, scene->model_count);
	uint32_t count = scene->first_part[model + 1] - scene->first_part[model];
	uint32_t node = roll_below(random, NODES);
	stilb_mat4 places[3] = {roll_place(random), roll_place(random), roll_place(random)};
	stilb_scene_pose pose = roll_pose(random);
	switch (roll_below(random, 15)) {
	case 0:
	case 1:
		stilb_scene_set_transform(scene, model, &places[0]);
		break;
	case 2:
		stilb_scene_set_part_transforms(scene, model, places);
		break;
	case 3:
		stilb_scene_set_part(
			scene, model, roll_below(random, count),
			(stilb_scene_build_part){roll_below(random, 2), roll_below(random, scene->material_count)});
		break;
	case 4:
	case 5:
		stilb_scene_show_model(scene, model, roll_below(random, 2) == 0);
		break;
	case 6:
		edit_add(scene, random);
		break;
	case 7:
		stilb_scene_remove_model(scene, model);
		break;
	case 8:
		edit_mesh(scene, random);
		break;
	case 9:
		stilb_scene_attach_model(scene, model, roll_below(random, 3) == 0 ? STILB_SCENE_NONE : node);
		break;
	case 10:
		assert_int_equal(stilb_scene_set_node_pose(scene, node, &pose), STILB_OK);
		break;
	case 11:
		assert_int_equal(stilb_scene_set_node_matrix(scene, node, &places[0]), STILB_OK);
		break;
	case 12:
		assert_int_equal(stilb_scene_show_variant(scene, roll_below(random, VARIANTS + 1)), STILB_OK);
		break;
	case 13:
		stilb_scene_set_model_flags(scene, model, roll_below(random, STILB_SCENE_MODEL_FLAGS + 1));
		break;
	default:
		if (!isnan(scene->bounds.radius[model]))
			edit_directly(scene, model, random);
	}
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static stilb_render *make_render(uint32_t workers)
{
	stilb_render_desc desc = {.device = vulkan ? STILB_RENDER_DEVICE_VULKAN : STILB_RENDER_DEVICE_NULL,
	                          .output = STILB_RENDER_OUTPUT_LINEAR,
	                          .width = SIDE,
	                          .height = SIDE,
	                          .context_count = workers + 1,
	                          .validate = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

static stilb_render_view make_view(const stilb_scene *scene)
{
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&scene->camera, 1.0f),
	                          .lights = scene->lights,
	                          .light_count = scene->light_count,
	                          .surroundings = scene->surroundings,
	                          .shading = stilb_render_shading_default()};
	memcpy(view.camera_position, scene->camera.position, sizeof view.camera_position);
	return view;
}

static uint32_t shown_models(const stilb_scene *scene, uint32_t ids[MOST_MODELS])
{
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++)
		if (!isnan(scene->bounds.radius[m]))
			ids[count++] = m;
	return count;
}

/* Brings the renderer up to date, and begins the lists of the next frame. */
static void take_changes(stilb_render *render, stilb_scene *scene)
{
	stilb_scene_changes changes = stilb_scene_changes_read(scene);
	assert_int_equal(stilb_render_update_scene(render, scene, &changes), STILB_OK);
	stilb_scene_changes_clear(scene);
}

/* Records and replays passes 0 .. passes - 1, each with all models that are shown. detail: with levels of meshes. */
static void draw(stilb_render *render, const stilb_scene *scene, uint32_t passes, bool detail, stilb_job_pool *pool)
{
	uint32_t ids[MOST_MODELS], count = shown_models(scene, ids);
	stilb_render_view view = make_view(scene);
	stilb_render_pass table[2] = {{.name = "first"}, {.name = "second"}};
	if (detail)
		view.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 0.25f};
	for (uint32_t p = 0; p < passes; p++)
		assert_int_equal(stilb_render_record_view(render, p, scene, ids, count, &view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, table, passes, &view, 1, pool, 0), STILB_OK);
}

/* The rows of the last frame's draws are those of the scene's parts, in scene order. */
static void check_rows(const stilb_render *render, const stilb_scene *scene)
{
	uint32_t ids[MOST_MODELS], count = shown_models(scene, ids), model = 0, part = 0;
	const render_pass_lists *lists = &render->passes[0];
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = 0; c < lists->runs[r].count; c++) {
			const render_row *row = render_row_of(render, &render_commands(render)[lists->runs[r].first + c]);
			assert_true(model < count);
			uint32_t p = scene->first_part[ids[model]] + part++;
			for (int i = 0; i < 12; i++)
				assert_true(row->transform[i] == scene->part_transform[p].m[i % 4 * 4 + i / 4]);
			assert_true(row->material == (render->scene.materials[scene->part_material[p]].id & RENDER_INDEX_MASK));
			assert_int_equal(row->model & 0xffffffu, 1 + ids[model]);
			assert_int_equal(row->model >> 24, scene->model_flags[ids[model]]);
			assert_true(row->mesh == (render->scene.meshes[scene->part_mesh[p]].id & RENDER_INDEX_MASK));
			if (p + 1 == scene->first_part[ids[model] + 1]) {
				model++;
				part = 0;
			}
		}
	assert_true(model == count && part == 0);
}

/* The hash, and on the GPU the picture, are those of a renderer that has never seen the scene before. */
static void check_anew(stilb_render *render, stilb_render *other, const stilb_scene *scene, bool detail,
                       stilb_job_pool *pool)
{
	assert_int_equal(stilb_render_set_scene(other, scene), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(other), STILB_OK);
	draw(other, scene, 1, detail, pool);
	assert_true(stilb_render_stream_hash(render) == stilb_render_stream_hash(other));
	if (!vulkan)
		return;
	stilb_image image = {0}, anew = {0};
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	assert_int_equal(stilb_render_read_image(other, &anew), STILB_OK);
	assert_memory_equal(image.pixels, anew.pixels, stilb_image_size(&image));
	stilb_image_finish(&image);
	stilb_image_finish(&anew);
	assert_int_equal(stilb_render_validation_messages(render), 0);
	assert_int_equal(stilb_render_validation_messages(other), 0);
}

/* ---- frames in flight -------------------------------------------------------------------------------------------- */

/* The rows of a submitted frame as its draws had them, and where they lie. */
typedef struct flight {
	const render_row *at[2 * MOST_MODELS];
	render_row was[2 * MOST_MODELS];
	uint32_t count;
} flight;

static void flight_take(flight *frame, const stilb_render *render)
{
	const render_pass_lists *lists = &render->passes[0];
	frame->count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = 0; c < lists->runs[r].count && frame->count < 2 * MOST_MODELS; c++) {
			frame->at[frame->count] = render_row_of(render, &render_commands(render)[lists->runs[r].first + c]);
			frame->was[frame->count] = *frame->at[frame->count];
			frame->count++;
		}
}

/* Of what shaders read nothing has changed. */
static void flight_check(const flight *frame)
{
	for (uint32_t i = 0; i < frame->count; i++)
		assert_memory_equal(frame->at[i], &frame->was[i], offsetof(render_row, mesh));
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Random edits in frames of all kinds: some without any, some that are begun and dropped, some that draw nothing of the
 * scene, and changes that are read between frames, more than once. */
static void every_edit_is_seen(void **state)
{
	(void)state;
	static flight before;
	uint32_t frames = vulkan ? 40 : TEST_TSAN || TEST_ASAN ? 300 : 1500;
	stilb_scene *scene = make_scene();
	stilb_job_pool *pool = fixture_pool(2, (stilb_job_hooks){0});
	stilb_render *render = make_render(2), *other = make_render(2);
	uint64_t random = 1000;
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	before.count = 0;
	for (uint32_t f = 0; f < frames; f++) {
		uint32_t edits = roll_below(&random, 3) == 0 ? 0 : roll_below(&random, 12), kind = roll_below(&random, 8);
		bool detail = kind < 2;
		for (uint32_t e = 0; e < edits; e++)
			edit(scene, &random);
		if (kind == 2) /* between frames */
			take_changes(render, scene);
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		take_changes(render, scene);
		if (kind == 3) { /* dropped after its recording */
			uint32_t ids[MOST_MODELS], count = shown_models(scene, ids);
			assert_int_equal(stilb_render_record(render, 0, scene, ids, count, pool, 0), STILB_OK);
		}
		if (kind == 3 || kind == 4) {
			before.count = 0; /* the next frame waits for it */
			continue;
		}
		if (render->passes[0].history) /* as in a renderer that has drawn no level yet */
			memset(render->passes[0].history, 0, render->passes[0].history_capacity * sizeof(uint16_t));
		draw(render, scene, 1, detail, pool);
		flight_check(&before);
		if (!detail)
			check_rows(render, scene);
		flight_take(&before, render);
		check_anew(render, other, scene, detail, pool);
	}
	stilb_render_destroy(render);
	stilb_render_destroy(other);
	stilb_job_pool_destroy(pool);
	stilb_scene_destroy(scene);
}

/* A scene takes the place of another one while the last frame is in flight. */
static void scenes_follow_one_another(void **state)
{
	(void)state;
	stilb_scene *scenes[2] = {make_scene(), fixture_scene(MODELS / 2)};
	stilb_job_pool *pool = fixture_pool(0, (stilb_job_hooks){0});
	stilb_render *render = make_render(0), *other = make_render(0);
	static flight before;
	before.count = 0;
	for (int f = 0; f < 12; f++) {
		stilb_scene *scene = scenes[f / 2 % 2];
		if (f % 2 == 0)
			assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
		flight_check(&before);
		if (f > 0) /* the last frame's hash can still be asked for */
			assert_true(stilb_render_stream_hash(render) == stilb_render_stream_hash(other));
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		stilb_scene_animate(scenes[1], 0.1 * f);
		take_changes(render, scene);
		draw(render, scene, 1, false, pool);
		flight_check(&before);
		flight_take(&before, render);
		check_anew(render, other, scene, false, pool);
	}
	assert_int_equal(stilb_render_set_scene(render, NULL), STILB_OK);
	stilb_render_destroy(render);
	stilb_render_destroy(other);
	stilb_job_pool_destroy(pool);
	for (int s = 0; s < 2; s++)
		stilb_scene_destroy(scenes[s]);
}

static uint64_t recorded_bytes(stilb_render *render, stilb_scene *scene, uint32_t passes, stilb_job_pool *pool)
{
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	take_changes(render, scene);
	draw(render, scene, passes, false, pool);
	return stilb_render_stats_get(render).recorded_bytes;
}

/* 32 bytes a draw, in each pass; for two frames 64 more for each part that has moved, however many passes show it. */
static void only_what_moves_writes_rows(void **state)
{
	(void)state;
	stilb_scene *scene = fixture_scene(MODELS);
	stilb_job_pool *pool = fixture_pool(2, (stilb_job_hooks){0});
	stilb_render *render = make_render(2);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	for (uint32_t passes = 1; passes <= 2; passes++) {
		uint64_t commands = 2ull * MODELS * 32 * passes, rows = 2ull * MODELS / 10 * 64;
		for (int f = 0; f < 3; f++)
			assert_true(recorded_bytes(render, scene, passes, pool) == commands);
		stilb_scene_animate(scene, 1.0);
		assert_true(recorded_bytes(render, scene, passes, pool) == commands + rows);
		check_rows(render, scene);
		assert_true(recorded_bytes(render, scene, passes, pool) == commands + rows);
		assert_true(recorded_bytes(render, scene, passes, pool) == commands);
		check_rows(render, scene);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	stilb_scene_destroy(scene);
}

/* A scene of which most moves has more rows than a new frame has room for. */
static void more_moves_than_there_is_room_for(void **state)
{
	(void)state;
	uint32_t models = RENDER_FIRST_ROWS, *ids = fixture_ids(models);
	stilb_scene *scene = fixture_scene(models);
	stilb_job_pool *pool = fixture_pool(3, (stilb_job_hooks){0});
	stilb_render *render = make_render(3), *other = make_render(3);
	stilb_render_view view = make_view(scene);
	stilb_render_pass pass = {.name = "scene"};
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	for (int f = 0; f < 4; f++) {
		for (uint32_t m = 0; m < models && f < 2; m++) {
			stilb_mat4 place = stilb_mat4_scale_translate(1.0f, (float)m, (float)f, 0.0f);
			assert_int_equal(stilb_scene_set_transform(scene, m, &place), STILB_OK);
		}
		for (int r = 0; r < 2; r++) {
			stilb_render *to = r == 0 ? render : other;
			if (r == 1)
				assert_int_equal(stilb_render_set_scene(other, scene), STILB_OK);
			assert_int_equal(stilb_render_frame_begin(to), STILB_OK);
			if (r == 0)
				take_changes(render, scene);
			assert_int_equal(stilb_render_record(to, 0, scene, ids, models, pool, 0), STILB_OK);
			assert_int_equal(stilb_render_replay(to, &pass, 1, &view, 1, pool, 0), STILB_OK);
		}
		assert_true(stilb_render_stream_hash(render) == stilb_render_stream_hash(other));
	}
	stilb_render_destroy(render);
	stilb_render_destroy(other);
	stilb_job_pool_destroy(pool);
	stilb_scene_destroy(scene);
	free(ids);
}

int main(int argc, char **argv)
{
	vulkan = argc > 1 && strcmp(argv[1], "vulkan") == 0;
	struct CMUnitTest tests[] = {
		cmocka_unit_test(every_edit_is_seen),
		cmocka_unit_test(scenes_follow_one_another),
		cmocka_unit_test(only_what_moves_writes_rows),
		cmocka_unit_test(more_moves_than_there_is_room_for),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
