/* The engine in somebody else's program: it changes nothing of the process, and several engines live side by side. */
#include "engine.h"
#include "profiler/prof.h"
#include "profiler/prof_snapshot.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"

#include <fenv.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const stress_engine stress = {.models = 400, .seed = 1, .animate = true};

static stilb_engine *make_engine(uint32_t workers, bool profile)
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = workers;
	desc.profile = profile;
	desc.profile_ring_mib = 1;
	if (stress_engine_create(&desc, &stress, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static uint64_t run_frame(stilb_engine *engine)
{
	stilb_engine_report report;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	return stilb_engine_stream_hash(engine);
}

/* ---- the process stays as it was --------------------------------------------------------------------------------- */

typedef struct process {
	sighandler_t handlers[NSIG];
	int flags[NSIG], blocked[NSIG];
	char locale[128], folder[PATH_MAX];
	mode_t umask;
	int rounding, traps;
} process;

static process look(void)
{
	process p;
	memset(&p, 0, sizeof p);
	sigset_t mask;
	pthread_sigmask(SIG_SETMASK, NULL, &mask);
	for (int i = 1; i < NSIG; i++) {
		struct sigaction action = {0};
		sigaction(i, NULL, &action);
		p.handlers[i] = action.sa_handler;
		p.flags[i] = action.sa_flags;
		p.blocked[i] = sigismember(&mask, i);
	}
	snprintf(p.locale, sizeof p.locale, "%s", setlocale(LC_ALL, NULL));
	assert_non_null(getcwd(p.folder, sizeof p.folder));
	p.umask = umask(0);
	umask(p.umask);
	p.rounding = fegetround();
	p.traps = fegetexcept();
	return p;
}

static void test_the_process_stays_as_it_was(void **state)
{
	(void)state;
	process before = look();
	stilb_engine *engine = make_engine(2, true);
	run_frame(engine);
	process during = look();
	stress_engine_destroy(engine);
	process after = look();
	assert_memory_equal(&before, &during, sizeof before);
	assert_memory_equal(&before, &after, sizeof before);
}

/* ---- several engines --------------------------------------------------------------------------------------------- */

#define FRAMES 6u

typedef struct run {
	uint64_t hashes[FRAMES];
	uint32_t workers;
	pthread_t thread;
} run;

static void *run_alone(void *data)
{
	run *r = data;
	stilb_engine *engine = make_engine(r->workers, true);
	for (uint32_t f = 0; f < FRAMES; f++)
		r->hashes[f] = run_frame(engine);
	stress_engine_destroy(engine);
	return NULL;
}

static void test_engines_take_turns_on_one_thread(void **state)
{
	(void)state;
	run alone = {.workers = 1};
	run_alone(&alone);
	stilb_engine *a = make_engine(0, true), *b = make_engine(2, true);
	for (uint32_t f = 0; f < FRAMES; f++) {
		assert_true(run_frame(a) == alone.hashes[f]);
		assert_true(run_frame(b) == alone.hashes[f]);
	}
	stress_engine_destroy(a);
	run_frame(b); /* goes on without the one that was there first */
	stress_engine_destroy(b);
}

static void test_engines_have_threads_of_their_own(void **state)
{
	(void)state;
	run alone = {.workers = 1}, runs[3] = {{.workers = 0}, {.workers = 1}, {.workers = 2}};
	run_alone(&alone);
	for (int i = 0; i < 3; i++)
		assert_int_equal(pthread_create(&runs[i].thread, NULL, run_alone, &runs[i]), 0);
	for (int i = 0; i < 3; i++) {
		assert_int_equal(pthread_join(runs[i].thread, NULL), 0);
		assert_memory_equal(runs[i].hashes, alone.hashes, sizeof alone.hashes);
	}
}

static uint32_t recorded_frames(void)
{
	stilb_prof_snapshot snapshot = {0};
	assert_int_equal(stilb_prof_snapshot_take(&snapshot, NULL), 0);
	uint32_t count = snapshot.frame_count;
	stilb_prof_snapshot_finish(&snapshot);
	return count;
}

/* The profiler's frames are the first engine's, then the next one's; it records while one engine wants it; and only the
 * end of the last engine empties it. */
static void test_engines_share_the_profiler(void **state)
{
	(void)state;
	stilb_engine *a = make_engine(0, true), *b = make_engine(0, false);
	for (int i = 0; i < 4; i++) {
		run_frame(a);
		run_frame(b);
	}
	assert_int_equal(recorded_frames(), 3); /* four marks, of a's frames: three whole ones */
	stress_engine_destroy(a);
	assert_int_equal(recorded_frames(), 3);
	assert_false(stilb_prof_is_recording());
	run_frame(b);
	run_frame(b);
	assert_int_equal(recorded_frames(), 5);
	a = make_engine(0, true);
	assert_true(stilb_prof_is_recording());
	run_frame(a); /* not the profiler's: b draws frames */
	assert_int_equal(recorded_frames(), 5);
	stress_engine_destroy(b);
	stress_engine_destroy(a);
	assert_int_equal(recorded_frames(), 0);
}

/* Two engines cannot write captures at once; the second says so, and the first goes on. */
static void test_one_engine_captures(void **state)
{
	(void)state;
	stilb_engine *a, *b;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	desc.capture.path = "guest.json";
	assert_int_equal(stilb_engine_create(&desc, &a), STILB_OK);
	assert_int_equal(stilb_engine_create(&desc, &b), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "guest.json"));
	run_frame(a);
	assert_int_equal(stilb_engine_capture(a), STILB_OK);
	stilb_engine_destroy(a);
	assert_int_equal(unlink("guest.json"), 0);
}

/* ---- what the program asks --------------------------------------------------------------------------------------- */

/* The stress test's middle: straight down its camera lies a model that the picture shows. */
static void test_pick(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine = make_engine(0, false), *empty;
	stilb_engine_hit hit;
	uint32_t width, height, hits = 0;
	stilb_engine_size(engine, &width, &height);
	stilb_scene *scene = stilb_engine_scene(engine);
	for (uint32_t i = 0; i < 64; i++) {
		double x = (i % 8 + 0.5) * width / 8, y = (i / 8 + 0.5) * height / 8;
		stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, width, height, x, y);
		stilb_scene_hit wanted;
		bool met = stilb_scene_pick(scene, &ray, &wanted);
		assert_int_equal(stilb_engine_pick(engine, x, y, &hit), met);
		if (!met)
			continue;
		assert_int_equal(hit.part, wanted.part);
		assert_int_equal(hit.triangle, wanted.triangle);
		hits++;
	}
	assert_in_range(hits, 16, 64);
	stress_engine_destroy(engine);
	desc.device = STILB_RENDER_DEVICE_NULL;
	assert_int_equal(stilb_engine_create(&desc, &empty), STILB_OK);
	assert_false(stilb_engine_pick(empty, 1.0, 1.0, &hit));
	assert_int_equal(stilb_engine_presentation(empty), STILB_GPU_PRESENT_FIFO);
	stilb_engine_destroy(empty);
}

/* A sphere of 5,120 triangles, seen from z 40, of which the engine keeps boxes. */
static stilb_scene *make_ball(stilb_scene_mesh *sphere)
{
	stilb_scene *scene;
	stilb_scene_camera camera = {.position = {0, 0, 40}, .fov_y = 0.25f, .near_z = 0.1f, .far_z = 100.0f};
	stilb_mat4 one = stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f);
	assert_int_equal(stilb_scene_mesh_sphere(4, sphere), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_material(build, &(stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}});
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, sphere)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &one), &part, 1);
	stilb_scene_build_camera(build, &camera);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	return scene;
}

static void scale_ball(stilb_scene *scene, const stilb_scene_mesh *sphere, float scale)
{
	for (uint32_t v = 0; v < sphere->vertex_count; v++) {
		stilb_scene_vertex vertex = sphere->vertices[v];
		for (int i = 0; i < 3; i++)
			vertex.position[i] *= scale;
		assert_int_equal(stilb_scene_set_vertices(scene, 0, v, 1, &vertex), STILB_OK);
	}
}

/* True if the ball lies under the point that is so far above its middle. */
static bool ball_reaches(stilb_engine *engine, double metres)
{
	stilb_engine_hit hit;
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	return stilb_engine_pick(engine, 0.5 * width, 0.5 * height * (1.0 - metres / (40.0 * tan(0.125))), &hit);
}

/* Picking sees what the program has changed, before and after the frame that draws it, and in another scene. */
static void test_pick_follows_edits(void **state)
{
	(void)state;
	stilb_scene_mesh sphere, same;
	stilb_scene *scene = make_ball(&sphere), *other = make_ball(&same);
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	assert_int_equal(stilb_engine_set_scene(engine, other), STILB_OK);
	/* The last pick before a change meets the ball: then there are boxes, which the change makes wrong. */
	assert_true(!ball_reaches(engine, 1.2) && ball_reaches(engine, 0.9));
	scale_ball(scene, &sphere, 2.0f);
	stilb_scene_changes_read(scene);
	stilb_scene_changes_clear(scene);
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	assert_true(!ball_reaches(engine, 2.3) && ball_reaches(engine, 1.8));
	scale_ball(scene, &sphere, 3.0f);
	assert_true(!ball_reaches(engine, 3.3) && ball_reaches(engine, 2.8));
	scale_ball(scene, &sphere, 4.0f);
	run_frame(engine);
	assert_true(ball_reaches(engine, 3.8));
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(other);
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&same);
}

/* ---- input that the program gives -------------------------------------------------------------------------------- */

static stilb_engine_report given_frame(stilb_engine *engine, const stilb_window_state *state)
{
	stilb_engine_report report;
	if (state)
		assert_int_equal(stilb_engine_input(engine, state), STILB_OK);
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	return report;
}

/* Flies, opens the profiler's window and presses the program's own key. The camera's pose at the end. */
static stilb_input_pose fly_by_given_input(void)
{
	static const stilb_input_action wave = {.name = "wave", .keys = {STILB_WINDOW_KEY_Z}, .help = "wave"};
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = 0;
	desc.actions = &wave;
	desc.action_count = 1;
	if (stress_engine_create(&desc, &stress, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_input_pose start = stilb_engine_pose(engine), still;
	given_frame(engine, NULL);
	stilb_window_state state = {.focused = true, .width = 800, .height = 500};
	state.held[STILB_WINDOW_KEY_W] = true;
	state.pressed[STILB_WINDOW_KEY_W] = state.pressed[STILB_WINDOW_KEY_Z] = 1;
	stilb_engine_report report = given_frame(engine, &state);
	assert_int_equal(report.input.actions[STILB_ENGINE_ACTIONS], 1); /* the program's first row */
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	assert_true(width == 800 && height == 500 && !report.close && !report.ui_mouse);
	report = given_frame(engine, NULL); /* the key is still down, and was not pressed again */
	assert_true(report.input.actions[STILB_ENGINE_ACTIONS] == 0 && report.input.move[2] > 0.0f);
	stilb_input_pose one = stilb_engine_pose(engine);
	given_frame(engine, NULL);
	stilb_input_pose two = stilb_engine_pose(engine);
	assert_true(memcmp(one.position, start.position, sizeof one.position) != 0);
	assert_true(memcmp(two.position, one.position, sizeof one.position) != 0);
	for (int i = 0; i < 60; i++) /* comes to rest */
		given_frame(engine, &(stilb_window_state){.focused = true});
	still = stilb_engine_pose(engine);
	state =
		(stilb_window_state){.focused = true, .pointer = true, .pointer_x = 400.0f, .pointer_y = 400.0f, .close = true};
	state.pressed[STILB_WINDOW_KEY_F1] = 1;
	report = given_frame(engine, &state);
	assert_true(report.close && !report.ui_mouse);
	given_frame(engine, NULL);
	report = given_frame(engine, NULL); /* the pointer is still over the window that opened */
	assert_true(report.ui_mouse && !report.close);
	stilb_input_pose end = stilb_engine_pose(engine);
	assert_memory_equal(&still, &end, sizeof end);
	stress_engine_destroy(engine);
	return end;
}

static void test_the_program_gives_input(void **state)
{
	(void)state;
	stilb_input_pose first = fly_by_given_input(), second = fly_by_given_input();
	assert_memory_equal(&first, &second, sizeof first);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_process_stays_as_it_was),
		cmocka_unit_test(test_engines_take_turns_on_one_thread),
		cmocka_unit_test(test_engines_have_threads_of_their_own),
		cmocka_unit_test(test_engines_share_the_profiler),
		cmocka_unit_test(test_one_engine_captures),
		cmocka_unit_test(test_pick),
		cmocka_unit_test(test_pick_follows_edits),
		cmocka_unit_test(test_the_program_gives_input),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
