/* The choice of levels of detail and their transitions, on the null device: against a plain statement of the rule in
 * double, frame by frame, for any number of workers. */
#include "render/render_detail.h"
#include "render/render_dump.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 640u
#define HEIGHT 360u
#define MODELS 900u
#define COARSEST 3u     /* level of the spheres */
#define FAR_AWAY 700.0f /* height from which all spheres are drawn in it */

static stilb_scene *scene;
static uint32_t ids[MODELS];

static int scene_make(void **state)
{
	(void)state;
	assert_int_equal(stilb_scene_create_stress(MODELS, 3, &scene), STILB_OK);
	for (uint32_t i = 0; i < MODELS; i++)
		ids[i] = i;
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
	                          .morph = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	return render;
}

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

/* A camera at a height over the middle of the grid, looking ahead and down. */
static stilb_render_view view_at(float height, stilb_render_detail_mode mode)
{
	stilb_scene_camera camera = {
		.position = {1.0f, height, 12.0f}, .pitch = -0.8f, .fov_y = 0.85f, .near_z = 0.1f, .far_z = 1000.0f};
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

/* A draw of the last frame. */
typedef struct drawn {
	const render_command *command;
	const render_row *row;
	uint32_t kind;
} drawn;

/* The last frame's draws in replay order; all must fit. */
static uint32_t drawn_list(const stilb_render *render, drawn *out, uint32_t most)
{
	const render_pass_lists *lists = &render->passes[0];
	uint32_t count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = lists->runs[r].first; c < lists->runs[r].first + lists->runs[r].count; c++) {
			const render_command *command = &render_commands(render)[c];
			assert_true(count < most);
			out[count++] = (drawn){command, render_row_of(render, command), render_state_detail(lists->runs[r].state)};
		}
	return count;
}

/* The model of a sphere's draw: the one at its place. */
static uint32_t model_of(const render_row *row)
{
	for (uint32_t m = 0; m < MODELS; m++)
		if (scene->part_transform[2 * m].m[12] == row->transform[3] &&
		    scene->part_transform[2 * m].m[14] == row->transform[11])
			return m;
	fail_msg("a sphere at a place where no model is");
	return 0;
}

/* The error of each level of a model's sphere in pixels, as docs/detail.md states it. */
static double pixels_of(uint32_t model, uint32_t level, const stilb_render_view *view)
{
	double d = 0.0, radius = (double)scene->part_transform[2 * model].m[0];
	const double center[3] = {(double)scene->bounds.x[model], (double)scene->bounds.y[model],
	                          (double)scene->bounds.z[model]};
	for (int i = 0; i < 3; i++)
		d += pow(center[i] - (double)view->camera_position[i], 2.0);
	d = fmax(sqrt(d) - (double)scene->bounds.radius[model], 0.1);
	double pixels = 0.5 * HEIGHT / tan(0.5 * 0.85);
	return level == 0 ? 0.0 : (double)scene->meshes[0].levels[level - 1].error * radius * pixels / d;
}

static uint32_t triangles_of(uint32_t level)
{
	return level == 0 ? scene->meshes[0].index_count / 3 : scene->meshes[0].levels[level - 1].index_count / 3;
}

static uint32_t level_of(const render_command *command)
{
	for (uint32_t l = 0; l <= scene->meshes[0].level_count; l++)
		if (triangles_of(l) * 3 == command->index_count)
			return l;
	fail_msg("%u indices are no level", command->index_count);
	return 0;
}

static bool is_sphere(const drawn *d)
{
	return d->command->index_count > 6;
}

/* ---- the choice -------------------------------------------------------------------------------------------------- */

static void the_coarsest_level_within_the_error_is_drawn(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(0);
	static drawn list[2 * MODELS];
	for (float height = 1.0f; height < 500.0f; height *= 1.5f) {
		stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
		stilb_render_view view = view_at(height, STILB_RENDER_DETAIL_POP);
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list, 2 * MODELS), spheres = 0;
		assert_int_equal(count, 2 * MODELS);
		uint64_t triangles = 0;
		for (uint32_t i = 0; i < count; i++) {
			triangles += list[i].command->index_count / 3;
			if (!is_sphere(&list[i]))
				continue;
			uint32_t model = model_of(list[i].row), level = level_of(list[i].command);
			assert_true(pixels_of(model, level, &view) <= 0.5 * (1.0 + 1e-5));
			assert_true(level == COARSEST || pixels_of(model, level + 1, &view) > 0.5 * (1.0 - 1e-5));
			assert_int_equal(render_command_detail(list[i].command), 0);
			spheres++;
		}
		assert_int_equal(spheres, MODELS);
		assert_true(triangles == stilb_render_triangles(render));
		stilb_render_destroy(render);
	}
	stilb_job_pool_destroy(pool);
}

/* A view without perspective has the same error everywhere; without levels of detail the stream is what it is. */
static void other_views(void **state)
{
	(void)state;
	static drawn list[2 * MODELS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_render_view view = {.detail = {STILB_RENDER_DETAIL_POP, 0.5f}, .shading = stilb_render_shading_default()};
	static const float halves[COARSEST + 1] = {10.0f, 50.0f, 150.0f, 500.0f}; /* of the picture's height, metres */
	for (uint32_t level = 0; level <= COARSEST; level++) {
		float half = halves[level];
		view.view_projection =
			(stilb_mat4){{HEIGHT / (WIDTH * half), 0, 0, 0, 0, 1.0f / half, 0, 0, 0, 0, 0.001f, 0, 0, 0, 0.5f, 1}};
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list, 2 * MODELS), found[COARSEST + 1] = {0};
		for (uint32_t i = 0; i < count; i++)
			if (is_sphere(&list[i])) {
				double error = 0.5 * HEIGHT / (double)half * (double)list[i].row->transform[0];
				uint32_t l = level_of(list[i].command);
				found[l]++;
				assert_true(l == 0 || error * (double)scene->meshes[0].levels[l - 1].error <= 0.5001);
				assert_true(l == COARSEST || error * (double)scene->meshes[0].levels[l].error >= 0.4499);
			}
		assert_true(found[level] > 0);
	}
	view = view_at(20.0f, STILB_RENDER_DETAIL_OFF);
	draw(render, &view, pool);
	uint64_t hash = stilb_render_stream_hash(render);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, MODELS, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &(stilb_render_pass){.name = "scene"}, 1, &view, 1, pool, 0),
	                 STILB_OK);
	assert_true(stilb_render_stream_hash(render) == hash);
	assert_true(stilb_render_triangles(render) == MODELS * (320u + 2u));
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static void rooms_are_the_same_four_at_a_time(void **state)
{
	(void)state;
	uint32_t some[64];
	float one[64], four[64];
	stilb_render_view view = view_at(5.0f, STILB_RENDER_DETAIL_POP);
	render_detail_view detail = render_detail_view_make(&view, WIDTH, HEIGHT);
	assert_true(fabsf(detail.near - 0.1f) < 1e-3f);
	for (uint32_t round = 0; round < 400; round++) {
		uint32_t count = round % 64, at = round * 7 % 500;
		for (uint32_t i = 0; i < count; i++)
			some[i] = at += round % 3 == 0 ? 1 : 1 + (i * round) % 5;
		render_detail_rooms_scalar(&detail, &scene->bounds, some, count, one);
		render_detail_rooms(&detail, &scene->bounds, some, count, four);
		assert_memory_equal(one, four, count * sizeof *one);
	}
	/* Inside of a model's sphere it is as near as the near plane. */
	memcpy(detail.position, (float[3]){scene->bounds.x[5], 0.5f, scene->bounds.z[5]}, sizeof detail.position);
	render_detail_rooms(&detail, &scene->bounds, (uint32_t[]){5, 6, 7, 8}, 4, four);
	assert_true(four[0] == detail.near * detail.near * detail.scale && four[3] > four[0]);
}

/* ---- transitions ------------------------------------------------------------------------------------------------- */

/* A camera that trembles about the distance at which levels change switches none back and forth. */
static void trembling_switches_nothing(void **state)
{
	(void)state;
	static drawn list[2 * MODELS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t level[MODELS] = {0}, finer = 0, coarser = 0;
	for (uint32_t frame = 0; frame < 20; frame++) {
		stilb_render_view view = view_at(30.0f * (frame % 2 ? 1.02f : 1.0f), STILB_RENDER_DETAIL_POP);
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list, 2 * MODELS);
		for (uint32_t i = 0; i < count; i++)
			if (is_sphere(&list[i])) {
				uint32_t model = model_of(list[i].row), now = level_of(list[i].command);
				assert_true(pixels_of(model, now, &view) <= 0.5001);
				finer += frame > 1 && now < level[model];
				coarser += frame > 1 && now > level[model];
				level[model] = now;
			}
	}
	/* The first two frames may differ: the first had no history. */
	assert_int_equal(finer, 0);
	assert_int_equal(coarser, 0);
	/* Far enough away each goes over. */
	stilb_render_view far = view_at(FAR_AWAY, STILB_RENDER_DETAIL_POP);
	draw(render, &far, pool);
	assert_true(stilb_render_triangles(render) == MODELS * (8u + 2u));
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* The map of a light has the levels that it asks for, whatever was drawn before. */
static void maps_remember_nothing(void **state)
{
	(void)state;
	static const stilb_render_target target = {
		.name = "map", .kind = STILB_RENDER_TARGET_DEPTH, .width = WIDTH, .height = HEIGHT};
	stilb_job_pool *pool = make_pool(0);
	stilb_render *used = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t others = 0;
	for (uint32_t frame = 0; frame < 12; frame++) {
		stilb_render *fresh = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
		stilb_render_view view = view_at(20.0f + 2.0f * (float)(frame * 5 % 12), STILB_RENDER_DETAIL_POP);
		draw(used, &view, pool);
		uint64_t remembered = stilb_render_triangles(used);
		view.target = &target;
		view.shadow = true;
		draw(used, &view, pool);
		draw(fresh, &view, pool);
		assert_true(stilb_render_triangles(used) == stilb_render_triangles(fresh));
		others += remembered != stilb_render_triangles(used);
		stilb_render_destroy(fresh);
	}
	assert_true(others > 0); /* a camera's view remembers */
	stilb_render_destroy(used);
	stilb_job_pool_destroy(pool);
}

/* From near to far: in each of 15 frames both levels are drawn, with complementary shares that grow by a sixteenth. */
static void fades_take_sixteen_frames(void **state)
{
	(void)state;
	static drawn list[3 * MODELS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_render_view near = view_at(200.0f, STILB_RENDER_DETAIL_FADE);
	stilb_render_view far = view_at(FAR_AWAY, STILB_RENDER_DETAIL_FADE);
	draw(render, &near, pool);
	uint32_t fading = 0, plain = drawn_list(render, list, 3 * MODELS);
	assert_int_equal(plain, 2 * MODELS); /* nothing fades in the first frame */
	for (uint32_t i = 0; i < plain; i++)
		fading += is_sphere(&list[i]) && level_of(list[i].command) < COARSEST;
	assert_true(fading > 10 && fading < MODELS);
	for (uint32_t frame = 1; frame <= 17; frame++) {
		draw(render, &far, pool);
		uint32_t count = drawn_list(render, list, 3 * MODELS), pairs = 0;
		assert_int_equal(count, 2 * MODELS + (frame < 16 ? fading : 0));
		for (uint32_t i = 0; i < count; i++) {
			if (list[i].kind == 0) {
				assert_int_equal(render_command_detail(list[i].command), 0);
				assert_true(!is_sphere(&list[i]) || level_of(list[i].command) == COARSEST);
				continue;
			}
			assert_int_equal(list[i].kind, 1);
			const drawn *other = &list[i + 1];
			assert_true(level_of(list[i].command) == COARSEST && level_of(other->command) < COARSEST);
			assert_int_equal(render_command_detail(list[i].command), 2 * frame);
			assert_int_equal(render_command_detail(other->command), 32 + 2 * frame);
			assert_memory_equal(list[i].row, other->row, sizeof *other->row);
			pairs++;
			i++;
		}
		assert_int_equal(pairs, frame < 16 ? fading : 0);
		/* One run of each kind for each segment of 256 models. */
		assert_true(render->passes[0].run_count <= 2 * (MODELS / 256 + 1) + 1);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* Levels of errors 1 m, growth, growth^2, ... for calls of render_detail_step. */
static render_levels *make_levels_of(uint32_t count, float growth)
{
	stilb_scene_level levels[STILB_SCENE_MAX_LEVELS];
	uint32_t indices[3 * (STILB_SCENE_MAX_LEVELS + 2)] = {0};
	stilb_scene_vertex vertex = {{0}, {0, 0, 1}, {0}};
	for (uint32_t l = 0; l < count; l++)
		levels[l] = (stilb_scene_level){0, 3 * (count - l), 1, powf(growth, (float)l)};
	stilb_scene_mesh mesh = {.vertices = &vertex,
	                         .indices = indices,
	                         .vertex_count = 1,
	                         .index_count = 3 * (count + 1),
	                         .level_count = count,
	                         .level_index_count = 3 * count,
	                         .levels = levels,
	                         .level_indices = indices};
	render_levels_data data;
	assert_true(render_levels_make(&mesh, false, &data));
	render_levels *made = data.levels;
	render_levels_finish(&data, &mesh);
	return made;
}

static render_levels *make_levels(uint32_t count)
{
	return make_levels_of(count, 2.0f);
}

static uint16_t step(uint16_t history, stilb_render_detail_mode mode, const render_levels *levels, float meters)
{
	float room = meters * meters;
	return render_detail_step(history, mode, levels, render_detail_allowed(levels, 1.0f, room), 1.0f, room);
}

static void allowed_levels_of_long_chains(void **state)
{
	(void)state;
	for (uint32_t count = 1; count <= 9; count++) {
		render_levels *levels = make_levels(count);
		assert_int_equal(render_detail_allowed(levels, 1.0f, 0.0f), 0);
		for (uint32_t l = 0; l < count; l++) {
			float error = (float)(1u << l);
			assert_int_equal(render_detail_allowed(levels, 1.0f, error * error * 0.999f), l);
			assert_int_equal(render_detail_allowed(levels, 1.0f, error * error), l + 1);
			assert_int_equal(render_detail_allowed(levels, 4.0f, error * error * 4.0f), l + 1);
		}
		assert_int_equal(render_detail_allowed(levels, 1.0f, 1e30f), count);
		free(levels);
	}
}

static void steps(void **state)
{
	(void)state;
	render_levels *levels = make_levels(5);
	stilb_render_detail_mode pop = STILB_RENDER_DETAIL_POP, fade = STILB_RENDER_DETAIL_FADE;
	/* The first time, and of another mesh with more levels: at once. */
	assert_int_equal(step(0, fade, levels, 4.0f), render_detail_rest(3));
	assert_int_equal(step(render_detail_rest(9), fade, levels, 4.0f), render_detail_rest(3));
	assert_int_equal(step((uint16_t)(3 | 9 << 6 | 3 << 12), fade, levels, 4.0f), render_detail_rest(3));
	/* Coarser only at nine tenths; finer at once. */
	assert_int_equal(step(render_detail_rest(2), pop, levels, 4.0f), render_detail_rest(2));
	assert_int_equal(step(render_detail_rest(2), pop, levels, 4.4f), render_detail_rest(2));
	assert_int_equal(step(render_detail_rest(2), pop, levels, 4.46f), render_detail_rest(3));
	assert_int_equal(step(render_detail_rest(3), pop, levels, 4.0f), render_detail_rest(3));
	assert_int_equal(step(render_detail_rest(3), pop, levels, 3.99f), render_detail_rest(2));
	/* A fade to 2 that is wanted back at 3 turns around, and ends there. */
	uint16_t history = step(render_detail_rest(3), fade, levels, 3.9f);
	assert_int_equal(history, 3 | 4 << 6 | 1 << 12);
	for (int i = 0; i < 4; i++)
		history = step(history, fade, levels, 3.9f);
	assert_int_equal(history, 3 | 4 << 6 | 5 << 12);
	history = step(history, fade, levels, 4.5f);
	assert_int_equal(history, 4 | 3 << 6 | 12 << 12); /* 11 sixteenths were of level 3 */
	for (int i = 0; i < 3; i++)
		history = step(history, fade, levels, 4.5f);
	assert_int_equal(history, 4 | 3 << 6 | 15 << 12);
	assert_int_equal(step(history, fade, levels, 4.5f), render_detail_rest(3));
	/* What another level wants waits for the end. */
	assert_int_equal(step(history, fade, levels, 17.8f), render_detail_rest(3));
	assert_int_equal(step(render_detail_rest(3), fade, levels, 17.8f), 6 | 4 << 6 | 1 << 12);
	/* A cut to a place from which the level is off by more than four times the error: at once. */
	assert_int_equal(step(render_detail_rest(5), fade, levels, 4.1f), 4 | 6 << 6 | 1 << 12);
	assert_int_equal(step(render_detail_rest(5), fade, levels, 3.9f), render_detail_rest(2));
	free(levels);
}

static uint32_t morph(const render_levels *levels, uint32_t level, float meters)
{
	return render_detail_morph(levels, level, 1.0f, 1.0f / (meters * meters));
}

/* As the distance grows, what is drawn only goes one way, from level to level without a step back: a level begins where
 * the finer one has morphed to it. growth: of the error from level to level. */
static void morphs_end_where_the_next_level_begins_of(float growth)
{
	render_levels *levels = make_levels_of(5, growth);
	uint32_t last = 0;
	for (float meters = 0.2f; meters < 1.1f * powf(growth, 4.0f); meters *= 1.001f) {
		uint32_t level = render_detail_allowed(levels, 1.0f, meters * meters);
		uint32_t gone = morph(levels, level, meters), now = 64 * level + gone;
		/* The step for a thousandth more of distance, in 64ths: a level has at most the way to the next one. */
		float way = fminf(2.0f, 2.0f * log2f(growth));
		assert_true(now >= last && now - last <= 1 + (uint32_t)(64.0f * 2.0f * 0.00289f / way));
		assert_true(level < 5 || gone == 0);
		/* The error of what is drawn: the finer level's, and the share of the next one's. */
		float next = level < 5 ? powf(growth, (float)level) : 0.0f;
		assert_true(next * (float)gone / 64.0f <= meters * 1.0001f);
		last = now;
	}
	assert_int_equal(last, 64 * 5);
	free(levels);
}

static void morphs_end_where_the_next_level_begins(void **state)
{
	(void)state;
	morphs_end_where_the_next_level_begins_of(2.0f);
	morphs_end_where_the_next_level_begins_of(1.3f); /* a level begins after the next one's error is less than twice */
	morphs_end_where_the_next_level_begins_of(5.0f);
	/* It begins where the next level's error, 5 m here, is twice what is allowed. */
	render_levels *levels = make_levels_of(5, 5.0f);
	assert_int_equal(morph(levels, 1, 5.0f / 2.01f), 0);
	assert_int_equal(morph(levels, 1, 5.0f / 1.95f), 3);
	assert_int_equal(morph(levels, 1, 5.0f / 1.5f), 28); /* the square of 1.5 is an eighth of the way from 2 to 4 */
	assert_int_equal(morph(levels, 1, 5.0f / 1.02f), 62);
	free(levels);
}

/* However fast the camera goes, a morph takes sixteen frames for a level at least; but a place that is a level away is
 * another view's. */
static void morphs_take_sixteen_frames(void **state)
{
	(void)state;
	uint16_t history = 0;
	assert_int_equal(render_detail_follow(&history, 5 * 64, 70), 70); /* the first time at once */
	assert_int_equal(history, RENDER_DETAIL_PLACE + 70);
	assert_false(render_detail_fades(history));
	assert_int_equal(render_detail_follow(&history, 5 * 64, 71), 71);
	for (uint32_t frame = 1; frame < 16; frame++)
		assert_int_equal(render_detail_follow(&history, 5 * 64, 71 + 63), 71 + (frame < 16 ? 4 * frame : 63));
	assert_int_equal(render_detail_follow(&history, 5 * 64, 71 + 63), 71 + 63);
	assert_int_equal(render_detail_follow(&history, 5 * 64, 80), 130);
	assert_int_equal(render_detail_follow(&history, 5 * 64, 66), 66);
	assert_int_equal(render_detail_follow(&history, 5 * 64, 130), 130);
	/* Of another mesh, which has fewer levels; at rest or fading in another mode: at once. */
	history = RENDER_DETAIL_PLACE + 100;
	assert_int_equal(render_detail_follow(&history, 64, 64), 64);
	for (uint32_t other = 0; other < 1u << 16; other++) {
		history = (uint16_t)other;
		bool morphs = other > RENDER_DETAIL_PLACE && other < RENDER_DETAIL_PLACE + 128;
		uint32_t place = render_detail_follow(&history, 64, 64);
		assert_true(morphs ? place <= 64 : place == 64);
	}
	/* What morphed and is now to pop or to fade rests in its level. */
	render_levels *levels = make_levels(5);
	assert_int_equal(step(RENDER_DETAIL_PLACE + 64 + 9, STILB_RENDER_DETAIL_FADE, levels, 1.5f), render_detail_rest(1));
	free(levels);
}

/* ---- the same for any number of workers -------------------------------------------------------------------------- */

#define FRAMES 24u

/* A flight that goes away and comes back. */
static void hashes_of(stilb_render_detail_mode mode, stilb_render_show show, uint32_t workers,
                      stilb_render_replay_mode replay, uint64_t out[FRAMES])
{
	stilb_job_pool *pool = make_pool(workers);
	stilb_render *render = make_render(replay, workers);
	for (uint32_t f = 0; f < FRAMES; f++) {
		stilb_render_view view = view_at(15.0f + 6.0f * (float)(f < 12 ? f : 23 - f), mode);
		view.show = show;
		draw(render, &view, pool);
		out[f] = stilb_render_stream_hash(render);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static void streams_do_not_depend_on_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	uint64_t first[4][FRAMES], again[FRAMES];
	for (int mode = 0; mode < 4; mode++) {
		hashes_of((stilb_render_detail_mode)mode, STILB_RENDER_SHOW_SHADED, 0, STILB_RENDER_REPLAY_INDIRECT,
		          first[mode]);
		for (size_t w = TEST_TSAN ? 2 : 0; w < sizeof workers / sizeof *workers; w += TEST_TSAN ? 2 : 1)
			for (int replay = 0; replay < 3; replay += TEST_TSAN ? 2 : 1) {
				hashes_of((stilb_render_detail_mode)mode, STILB_RENDER_SHOW_SHADED, workers[w],
				          (stilb_render_replay_mode)replay, again);
				assert_memory_equal(first[mode], again, sizeof again);
			}
		for (int before = 0; before < mode; before++)
			for (uint32_t f = 3; f < FRAMES; f++)
				assert_true(first[mode][f] != first[before][f]);
	}
	hashes_of(STILB_RENDER_DETAIL_POP, STILB_RENDER_SHOW_LEVELS, 2, STILB_RENDER_REPLAY_DIRECT, again);
	hashes_of(STILB_RENDER_DETAIL_MORPH, STILB_RENDER_SHOW_LEVELS, 0, STILB_RENDER_REPLAY_INDIRECT, first[0]);
	assert_memory_equal(first[0], again, sizeof again); /* levels in colours know no transitions */
}

/* A scene that is set anew has no history, and a pass that another thread of frames has recorded keeps its own. */
static void histories_are_of_the_pass_and_the_scene(void **state)
{
	(void)state;
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_render_view near = view_at(20.0f, STILB_RENDER_DETAIL_FADE), far = view_at(300.0f, STILB_RENDER_DETAIL_FADE);
	draw(render, &near, pool);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	draw(render, &far, pool);
	assert_true(stilb_render_stats_get(render).draws == 2 * MODELS);
	static const stilb_render_pass passes[2] = {{.name = "one"}, {.name = "two", .view = 1}};
	const stilb_render_view views[2] = {far, near};
	for (int frame = 0; frame < 2; frame++) {
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		for (uint32_t p = 0; p < 2; p++)
			assert_int_equal(stilb_render_record_view(render, p, scene, ids, MODELS, &views[p], pool, 0), STILB_OK);
		assert_int_equal(stilb_render_replay(render, passes, 2, views, 2, pool, 0), STILB_OK);
		assert_true(stilb_render_stats_get(render).draws == 4 * MODELS);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* ---- dumps and colours ------------------------------------------------------------------------------------------- */

static void dumps_hold_levels_and_transitions(void **state)
{
	(void)state;
	char path[64];
	snprintf(path, sizeof path, "/tmp/test_render_detail_%d.dump", (int)getpid());
	stilb_job_pool *pool = make_pool(1);
	static const stilb_render_pass pass = {.name = "scene"};
	for (int mode = 0; mode < 5; mode++) {
		stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1), *played;
		stilb_render_view view = view_at(30.0f, (stilb_render_detail_mode)(mode % 4));
		view.show = mode == 4 ? STILB_RENDER_SHOW_LEVELS : STILB_RENDER_SHOW_SHADED;
		draw(render, &view, pool);
		stilb_render_view then = view_at(60.0f, (stilb_render_detail_mode)(mode % 4));
		then.show = view.show;
		draw(render, &then, pool);
		assert_int_equal(stilb_render_dump_save(render, &pass, 1, &then, 1, path), STILB_OK);
		uint64_t hash = stilb_render_stream_hash(render), triangles = stilb_render_triangles(render);
		stilb_render_destroy(render);
		stilb_render_dump *dump;
		if (stilb_render_dump_load(path, &dump) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		stilb_render_dump_info info = stilb_render_dump_info_get(dump);
		assert_true(info.stream_hash == hash && info.morph);
		stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
		                          .width = WIDTH,
		                          .height = HEIGHT,
		                          .context_count = 2,
		                          .morph = info.morph};
		assert_int_equal(stilb_render_create(&desc, &played), STILB_OK);
		assert_int_equal(stilb_render_dump_upload(dump, played), STILB_OK);
		assert_int_equal(stilb_render_frame_begin(played), STILB_OK);
		assert_int_equal(stilb_render_dump_record(dump, played, pool, 0), STILB_OK);
		assert_int_equal(stilb_render_dump_replay(dump, played, pool, 0), STILB_OK);
		assert_true(stilb_render_stream_hash(played) == hash);
		assert_true(stilb_render_triangles(played) == triangles);
		stilb_render_destroy(played);
		stilb_render_dump_destroy(dump);
	}
	remove(path);
	stilb_job_pool_destroy(pool);
}

static void colours_tell_levels(void **state)
{
	(void)state;
	static drawn list[2 * MODELS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	for (int mode = 0; mode < 4; mode++) {
		stilb_render_view view = view_at(30.0f, (stilb_render_detail_mode)mode);
		view.show = STILB_RENDER_SHOW_LEVELS;
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list, 2 * MODELS);
		assert_int_equal(count, 2 * MODELS);
		for (uint32_t i = 0; i < count; i++) {
			uint32_t wanted = is_sphere(&list[i]) ? 1 + level_of(list[i].command) : 0;
			assert_int_equal(render_command_detail(list[i].command), wanted);
			assert_int_equal(list[i].kind, 3);
			assert_true(mode != 0 || wanted < 2);
		}
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* ---- resources --------------------------------------------------------------------------------------------------- */

/* The sphere's vertices lie in pairs with where they morph to. Of each level's two lists of indices the second names
 * the second of a pair for the vertices that the next level does not use. */
static void morphs_name_the_second_of_pairs(void **state)
{
	(void)state;
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t mesh = stilb_render_scene_mesh(render, 0).id & RENDER_INDEX_MASK;
	const stilb_scene_mesh *source = &scene->meshes[0];
	const render_levels *levels = render->resources.levels[mesh];
	const render_level *level = render_levels_level(levels);
	const uint16_t *heap = (const uint16_t *)render->resources.heaps[RENDER_HEAP_INDICES_16].data;
	const render_layout *layout = &render->resources.layout;
	const uint8_t *vertices = render->resources.heaps[RENDER_HEAP_VERTICES].data;
	assert_true(levels->morphs == 1 && levels->count == COARSEST);
	for (uint32_t l = 0; l <= COARSEST; l++) {
		const uint32_t *from = l == 0 ? source->indices : source->level_indices + source->levels[l - 1].first_index;
		assert_int_equal(level[l].index_count, 3 * triangles_of(l));
		for (uint32_t i = 0; i < level[l].index_count; i++) {
			assert_int_equal(heap[level[l].first_index + i], 2 * from[i]);
			if (l == COARSEST)
				continue;
			uint32_t moves = from[i] >= source->levels[l].vertex_count;
			assert_int_equal(heap[level[COARSEST + 1 + l].first_index + i], 2 * from[i] + moves);
			const stilb_scene_vertex wanted[2] = {source->vertices[from[i]], source->morph[from[i]]};
			size_t place = (size_t)(uint32_t)level[l].vertex_offset + 2 * (size_t)from[i];
			uint8_t packed[2 * sizeof *wanted];
			render_vertices_pack(layout, wanted, 2, true, packed);
			assert_memory_equal(vertices + place * layout->size, packed, (moves ? 2 : 1) * (size_t)layout->size);
		}
	}
	stilb_render_destroy(render);
}

static void wrong_levels_are_refused(void **state)
{
	(void)state;
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_scene_mesh mesh;
	stilb_render_mesh made;
	assert_int_equal(stilb_scene_mesh_sphere(2, &mesh), STILB_OK);
	uint32_t before = mesh.level_indices[5];
	mesh.level_indices[5] = 6;
	assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "index 5 of level 2 of a mesh is vertex 6, but it has 6"));
	mesh.level_indices[5] = before;
	mesh.levels[1].error = 0.0f;
	assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "an error of 0 m after"));
	mesh.levels[1].error = 0.3f;
	mesh.levels[0].first_index = 225;
	assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_ERROR_ARGUMENT);
	mesh.levels[0].first_index = 84;
	mesh.level_count = STILB_SCENE_MAX_LEVELS + 1;
	assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_ERROR_ARGUMENT);
	mesh.level_count = COARSEST;
	/* Made and destroyed again and again, with pairs at even and odd places, the heaps do not grow. */
	uint32_t sizes[2] = {0};
	for (uint32_t frame = 0; frame < 40; frame++) {
		stilb_render_mesh meshes[3];
		stilb_scene_mesh plane;
		assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
		plane.vertex_count = 3 + frame % 2;
		plane.index_count = 3;
		assert_int_equal(stilb_render_mesh_create(render, &plane, &meshes[0]), STILB_OK);
		plane.vertex_count = 4;
		plane.index_count = 6;
		for (int i = 1; i < 3; i++) {
			assert_int_equal(stilb_render_mesh_create(render, &mesh, &meshes[i]), STILB_OK);
			const render_mesh_slot *slot = &render->resources.meshes[meshes[i].id & RENDER_INDEX_MASK];
			assert_int_equal(slot->vertex_offset % 2, 0);
		}
		for (int i = 0; i < 3; i++)
			stilb_render_mesh_destroy(render, meshes[i]);
		stilb_scene_mesh_finish(&plane);
		for (int i = 0; i < 3; i++)
			assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		for (int h = 0; h < 2; h++) {
			assert_true(frame < 4 || render->resources.heaps[h].size == sizes[h]);
			sizes[h] = render->resources.heaps[h].size;
		}
	}
	stilb_scene_mesh_finish(&mesh);
	stilb_render_destroy(render);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_coarsest_level_within_the_error_is_drawn),
		cmocka_unit_test(other_views),
		cmocka_unit_test(rooms_are_the_same_four_at_a_time),
		cmocka_unit_test(trembling_switches_nothing),
		cmocka_unit_test(maps_remember_nothing),
		cmocka_unit_test(fades_take_sixteen_frames),
		cmocka_unit_test(allowed_levels_of_long_chains),
		cmocka_unit_test(steps),
		cmocka_unit_test(morphs_end_where_the_next_level_begins),
		cmocka_unit_test(morphs_take_sixteen_frames),
		cmocka_unit_test(streams_do_not_depend_on_workers),
		cmocka_unit_test(histories_are_of_the_pass_and_the_scene),
		cmocka_unit_test(dumps_hold_levels_and_transitions),
		cmocka_unit_test(colours_tell_levels),
		cmocka_unit_test(morphs_name_the_second_of_pairs),
		cmocka_unit_test(wrong_levels_are_refused),
	};
	return cmocka_run_group_tests(tests, scene_make, scene_free);
}
