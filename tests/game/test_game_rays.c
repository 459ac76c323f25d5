/* view_trace: pictures on the workers of a pool, beside the loops of the thread that owns it: the bits of a render of
 * its own, whatever was asked for before, and an end at any time. No other library (Embree) takes part. */
#include "game/view/view_trace.h"
#include "support/test.h"

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

static void render_alone(const stilb_gi_settings *settings, float rgb[NUMBERS])
{
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &pool), 0);
	stilb_gi_scene_desc desc = {.pool = pool, .intersector = &stilb_gi_brute};
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
	render_alone(&first, want[0]);
	render_alone(&second, want[1]);
	assert_memory_not_equal(want[0], want[1], sizeof got);
	for (uint32_t workers = 0; workers <= 3; workers++) {
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
		cmocka_unit_test(same_bits_as_a_render),
		cmocka_unit_test(ends_at_once),
		cmocka_unit_test(fails_with_a_reason),
	};
	return cmocka_run_group_tests(tests, open_scene, close_scene);
}
