/* view_trace: pictures on the workers of a pool, beside the loops of the thread that owns it: the bits of a render of
 * its own, whatever was asked for before, also after edits, and an end at any time, also while the tree is built. And
 * view_seen: what rays need not begin anew for. No other library (Embree) takes part. */
#include "game/view/view_seen.h"
#include "game/view/view_trace.h"
#include "gi/gi_scene_internal.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "support/test.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 24, HEIGHT = 16, NUMBERS = WIDTH * HEIGHT * 3 };

static stilb_scene *scene;

static int open_scene(void **state)
{
	(void)state;
	return stilb_scene_open("cornell", &scene) == STILB_OK ? 0 : -1;
}

static int close_scene(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	return 0;
}

static stilb_gi_settings settings_for(uint32_t samples, float yaw)
{
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.width = WIDTH;
	settings.height = HEIGHT;
	settings.samples = samples;
	settings.progressive = true;
	settings.camera.yaw += yaw;
	return settings;
}

static void render_alone(const stilb_gi_settings *settings, bool movable, float rgb[NUMBERS])
{
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &pool), 0);
	stilb_gi_scene_desc desc = {.pool = pool, .intersector = &stilb_gi_brute, .movable = movable};
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	assert_int_equal(stilb_gi_render_create(gi, settings, pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	memcpy(rgb, stilb_gi_render_film(render).radiance, NUMBERS * sizeof *rgb);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
}

/* stilb_job_range_fn */
static void nothing(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	((uint32_t *)context)[begin] = end;
}

/* Runs loops on the pool, as frames do, until the trace is at this stage, or beyond. */
static stilb_gi_progress await(view_trace *trace, stilb_job_pool *pool, view_trace_stage stage)
{
	stilb_gi_progress progress;
	uint32_t ends[64];
	while (view_trace_state(trace, &progress) < stage) {
		if (pool)
			stilb_job_parallel_for(pool, 64, 1, nothing, ends, 0);
		stilb_scene_revisions_read(scene); /* as each frame does */
		nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
	}
	return progress;
}

static void same_bits_as_a_render(void **state)
{
	(void)state;
	static float want[2][NUMBERS], got[NUMBERS];
	stilb_gi_settings first = settings_for(5, 0.0f), second = settings_for(3, 0.2f),
					  endless = settings_for(65536, 0.1f);
	render_alone(&first, false, want[0]);
	render_alone(&second, false, want[1]);
	assert_memory_not_equal(want[0], want[1], sizeof got);
	for (uint32_t workers = TEST_TSAN ? 2 : 0; workers <= 3; workers++) {
		stilb_job_pool *pool = NULL;
		view_trace *trace;
		if (workers < 3) /* then a pool of the trace's own */
			assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &pool), 0);
		assert_int_equal(view_trace_start(scene, pool, 2, &stilb_gi_brute, &trace), STILB_OK);
		view_trace_look(trace, &first); /* while the tree is built */
		assert_int_equal(await(trace, pool, VIEW_TRACE_FINISHED).samples, 5);
		assert_true(view_trace_preview(trace, got));
		assert_memory_equal(got, want[0], sizeof got);
		endless.seconds = 1e9; /* as a window asks for */
		view_trace_look(trace, &endless);
		view_trace_rest(trace);
		view_trace_look(trace, &endless);
		view_trace_look(trace, &second);
		assert_int_equal(await(trace, pool, VIEW_TRACE_FINISHED).samples, 3);
		assert_true(view_trace_preview(trace, got));
		assert_memory_equal(got, want[1], sizeof got);
		view_trace_look(trace, &endless);
		if (workers != 2)
			while (await(trace, pool, VIEW_TRACE_RENDERING).samples == 0) {
			}
		view_trace_end(trace);
		stilb_job_pool_destroy(pool);
	}
}

/* True once the picture does not change any more. */
static bool comes_to_rest(view_trace *trace)
{
	stilb_gi_progress before = {0}, now;
	for (int i = 0; i < 500; i++, before = now) {
		view_trace_state(trace, &now);
		if (i > 0 && now.rays == before.rays)
			return true;
		nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
	}
	return false;
}

/* A picture that is stopped again and again, before it has begun, in the middle and when it is finished. */
static void what_rests_goes_on(void **state)
{
	(void)state;
	static float want[NUMBERS], got[NUMBERS];
	stilb_job_pool *pool;
	view_trace *trace;
	stilb_gi_settings settings = settings_for(5, 0.0f);
	render_alone(&settings, false, want);
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &pool), 0);
	assert_int_equal(view_trace_start(scene, pool, 2, &stilb_gi_brute, &trace), STILB_OK);
	assert_false(view_trace_go_on(trace)); /* there is nothing yet */
	await(trace, pool, VIEW_TRACE_WAITING);
	assert_false(view_trace_go_on(trace));
	view_trace_look(trace, &settings);
	while (!view_trace_preview(trace, got)) {
	}
	for (int i = 0; i < 12; i++) {
		view_trace_rest(trace);
		nanosleep(&(struct timespec){.tv_nsec = i % 3 * 600000}, NULL);
		view_trace_rest(trace); /* perhaps when it does not run any more */
		assert_true(view_trace_go_on(trace));
		assert_false(view_trace_go_on(trace)); /* it does already */
		if (i == 6 || i == 11)
			await(trace, pool, VIEW_TRACE_FINISHED);
	}
	assert_true(view_trace_preview(trace, got));
	assert_memory_equal(got, want, sizeof got);
	settings.samples = 65536;
	view_trace_look(trace, &settings);
	while (await(trace, pool, VIEW_TRACE_RENDERING).samples == 0) {
	}
	view_trace_rest(trace);
	assert_true(comes_to_rest(trace));
	view_trace_hold(trace);
	assert_false(view_trace_go_on(trace));
	view_trace_follow(trace);
	assert_false(view_trace_go_on(trace));
	view_trace_end(trace);
	stilb_job_pool_destroy(pool);
}

static void ends_at_once(void **state)
{
	(void)state;
	for (int i = 0; i < 5; i++) {
		view_trace *trace;
		stilb_gi_settings endless = settings_for(65536, 0.0f);
		assert_int_equal(view_trace_start(scene, NULL, 1, &stilb_gi_brute, &trace), STILB_OK);
		if (i > 0)
			view_trace_look(trace, &endless);
		if (i > 1)
			await(trace, NULL, i > 2 ? VIEW_TRACE_RENDERING : VIEW_TRACE_WAITING);
		if (i > 3)
			view_trace_rest(trace);
		view_trace_end(trace);
	}
	view_trace_end(NULL);
}

/* A lamp on a node, then the node moves. */
static void edit_lamp(bool move)
{
	static uint32_t node;
	stilb_scene_pose pose = stilb_scene_pose_identity();
	stilb_scene_light lights[2] = {scene->lights[0],
	                               {.kind = STILB_SCENE_LIGHT_POINT, .intensity = {0.3f, 0.2f, 0.1f}}};
	for (int i = 0; i < 3; i++) /* in the middle of the box, or nearer to a wall */
		pose.translation[i] =
			0.5f * (scene->bounds.x[0] * (i == 0) + scene->bounds.y[0] * (i == 1)) + 0.1f * (float)move;
	if (move) {
		assert_int_equal(stilb_scene_set_node_pose(scene, node, &pose), STILB_OK);
		return;
	}
	assert_int_equal(stilb_scene_add_node(scene, STILB_SCENE_NONE, &pose, &node), STILB_OK);
	assert_int_equal(stilb_scene_set_lights(scene, lights, 2), STILB_OK);
	assert_int_equal(stilb_scene_attach_light(scene, 1, node), STILB_OK);
}

/* Edits of the scene: other paint, parts that move, and a lamp that does. */
static void edit(int step)
{
	if (step > 4) {
		edit_lamp(step > 5);
		return;
	}
	stilb_scene_material paint = scene->materials[0];
	stilb_mat4 places[4]; /* of the white walls with the blocks, a red one, a green one, the lamp */
	paint.diffuse[1] = step == 0 ? 0.1f : 0.7f;
	memcpy(places, scene->part_transform, sizeof places);
	places[step % 4].m[12] += step % 2 > 0 ? 0.125f : -0.125f;
	if (step == 0 || step == 4)
		assert_int_equal(stilb_scene_set_material(scene, 0, &paint), STILB_OK);
	else
		assert_int_equal(stilb_scene_set_part_transforms(scene, 0, places), STILB_OK);
}

static void edits_are_followed(void **state)
{
	(void)state;
	static float want[NUMBERS], got[NUMBERS], last[NUMBERS];
	stilb_job_pool *pool;
	view_trace *trace;
	stilb_gi_progress progress;
	stilb_gi_settings settings = settings_for(2, 0.0f), endless = settings_for(65536, 0.1f);
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &pool), 0);
	assert_int_equal(view_trace_start(scene, pool, 2, &stilb_gi_brute, &trace), STILB_OK);
	for (int step = 0; step < 7; step++) {
		view_trace_look(trace, &endless);
		if (step % 2 > 0)
			await(trace, pool, VIEW_TRACE_RENDERING);
		view_trace_hold(trace);
		view_trace_hold(trace); /* twice is once */
		edit(step);
		stilb_scene_revisions_read(scene); /* nodes take their places, as a frame sees to before it lets rays follow */
		view_trace_follow(trace);
		assert_in_range(view_trace_state(trace, &progress), VIEW_TRACE_BUILDING, VIEW_TRACE_WAITING);
		if (step == 3) {
			await(trace, pool, VIEW_TRACE_WAITING);
			assert_false(view_trace_preview(trace, got)); /* what was there is of the scene as it was */
		}
		view_trace_look(trace, &settings);
		assert_int_equal(await(trace, pool, VIEW_TRACE_FINISHED).samples, 2);
		assert_true(view_trace_preview(trace, got));
		render_alone(&settings, step > 0, want); /* from the first move on, more are expected */
		assert_memory_equal(got, want, sizeof got);
		assert_true(step == 0 || memcmp(got, last, sizeof got) != 0);
		memcpy(last, got, sizeof got);
	}
	view_trace_hold(trace);
	view_trace_end(trace); /* also while it is held */
	stilb_job_pool_destroy(pool);
}

/* ---- a tree that takes long -------------------------------------------------------------------------------------- */

static _Atomic int slow_begun, slow_given_up, slow_done; /* builds; counted by the tracer's thread, read after waits */

/* Builds for five seconds, unless it is given up. */
static stilb_result slow_create(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                                stilb_gi_scene_info *info)
{
	atomic_fetch_add(&slow_begun, 1);
	for (int i = 0; i < 5000; i++) {
		if (desc->give_up(desc->user)) {
			atomic_fetch_add(&slow_given_up, 1);
			return stilb_fail(STILB_ERROR_GIVEN_UP, "given up");
		}
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	}
	atomic_fetch_add(&slow_done, 1);
	return stilb_gi_brute.create(gi, desc, tracer, info);
}

static void slow_destroy(gi_tracer *tracer)
{
	stilb_gi_brute.destroy(tracer);
}

static const stilb_gi_intersector slow = {.name = "slow", .create = slow_create, .destroy = slow_destroy};

static void await_builds(int count)
{
	while (atomic_load(&slow_begun) < count)
		nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
}

static void a_tree_is_given_up(void **state)
{
	(void)state;
	view_trace *trace;
	stilb_gi_progress progress;
	stilb_gi_settings settings = settings_for(2, 0.0f);
	assert_int_equal(view_trace_start(scene, NULL, 1, &slow, &trace), STILB_OK);
	view_trace_look(trace, &settings);
	await_builds(1);
	view_trace_rest(trace); /* the camera moves: that goes on */
	view_trace_hold(trace); /* the user edits: that does not */
	assert_int_equal(atomic_load(&slow_given_up), 1);
	assert_int_equal(view_trace_state(trace, &progress), VIEW_TRACE_BUILDING);
	view_trace_follow(trace);
	await_builds(2);
	view_trace_hold(trace);
	assert_int_equal(atomic_load(&slow_given_up), 2);
	view_trace_follow(trace);
	await_builds(3);
	view_trace_end(trace); /* another scene */
	assert_int_equal(atomic_load(&slow_given_up), 3);
	assert_int_equal(atomic_load(&slow_done), 0);
}

/* ---- what is seen ------------------------------------------------------------------------------------------------ */

static void rays_stay_for_what_only_shows_them(void **state)
{
	(void)state;
	stilb_render_shading shading = {.brdf = 1, .ndf = 2, .g = 1, .f = 1};
	view_seen seen = view_seen_read(scene, &shading, STILB_RENDER_SHOW_SHADED, 640, 480), other = seen;
	assert_true(view_seen_same_rays(&seen, &other) && view_seen_same_frame(&seen, &other));
	const struct {
		float *number;
		bool rays; /* must begin anew */
	} floats[] = {
		{&other.camera.exposure, false},    {&other.camera.near_z, true},      {&other.camera.far_z, true},
		{&other.shading.roughness, false},  {&other.shading.wrap, false},      {&other.shading.specular, false},
		{&other.shading.anisotropy, false}, {&other.camera.position[2], true}, {&other.camera.yaw, true},
		{&other.camera.pitch, true},        {&other.camera.roll, true},        {&other.camera.fov_y, true},
	};
	for (size_t i = 0; i < sizeof floats / sizeof *floats; i++) {
		*floats[i].number += 0.25f;
		assert_int_equal(!view_seen_same_rays(&seen, &other), floats[i].rays);
		assert_false(view_seen_same_frame(&seen, &other));
		other = seen;
	}
	uint32_t *const words[] = {&other.width,       &other.height,    &other.shading.brdf,
	                           &other.shading.ndf, &other.shading.g, &other.shading.f};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		(*words[i])++;
		assert_false(view_seen_same_rays(&seen, &other) || view_seen_same_frame(&seen, &other));
		other = seen;
	}
	other.show = STILB_RENDER_SHOW_NORMAL;
	assert_false(view_seen_same_rays(&seen, &other) || view_seen_same_frame(&seen, &other));
	float before = scene->camera.exposure;
	scene->camera.exposure += 1.0f;
	other = view_seen_read(scene, &shading, STILB_RENDER_SHOW_SHADED, 640, 480);
	assert_true(view_seen_same_scene(&seen, &other) && view_seen_same_rays(&seen, &other));
	scene->camera.exposure = before;
	scene->surroundings.sky[0] += 1.0f;
	other = view_seen_read(scene, &shading, STILB_RENDER_SHOW_SHADED, 640, 480);
	assert_false(view_seen_same_scene(&seen, &other) || view_seen_same_rays(&seen, &other));
	scene->surroundings.sky[0] -= 1.0f;
	stilb_scene_revisions_read(scene);
}

static void fails_with_a_reason(void **state)
{
	(void)state;
	view_trace *trace;
	const char *message;
	float rgb[3];
	stilb_gi_settings wrong = settings_for(0, 0.0f);
	assert_int_equal(view_trace_start(scene, NULL, 1, &stilb_gi_brute, &trace), STILB_OK);
	view_trace_look(trace, &wrong);
	await(trace, NULL, VIEW_TRACE_FAILED);
	assert_int_equal(view_trace_error(trace, &message), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(message, "samples"));
	assert_false(view_trace_preview(trace, rgb));
	view_trace_end(trace);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(same_bits_as_a_render), cmocka_unit_test(what_rests_goes_on),
		cmocka_unit_test(ends_at_once),          cmocka_unit_test(edits_are_followed),
		cmocka_unit_test(a_tree_is_given_up),    cmocka_unit_test(rays_stay_for_what_only_shows_them),
		cmocka_unit_test(fails_with_a_reason),
	};
	return cmocka_run_group_tests(tests, open_scene, close_scene);
}
