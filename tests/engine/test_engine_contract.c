/* The asserts of the engine, its viewers and its windows, each made to fail on purpose in a forked child process. On
 * the null device, without workers and without the profiler, because a fork does not copy their threads. */
#include "engine_internal.h"
#include "replay.h"
#include "support/contract.h"
#include "support/test.h"
#include "tests/engine/stress_engine.h"
#include "trace_view.h"
#include "viewer.h"

#include <math.h>
#include <pthread.h>

static stilb_engine_desc null_desc(void)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.width = 320;
	desc.height = 200;
	desc.profile = false;
	return desc;
}

static stilb_engine *make(void)
{
	stilb_engine_desc desc = null_desc();
	stilb_engine *engine;
	assert_int_equal(stress_engine_create(&desc, &(stress_engine){.models = 20, .seed = 1}, &engine), STILB_OK);
	return engine;
}

static void create_with_two_windows(void)
{
	stilb_engine_desc desc = null_desc();
	stilb_gpu_surface surface = {0};
	stilb_engine *engine;
	desc.window = true;
	desc.surface = &surface;
	stilb_engine_create(&desc, &engine);
}

static stilb_result frame(stilb_engine *engine)
{
	stilb_engine_report report;
	return stilb_engine_frame(engine, &report);
}

static void *frame_of(void *engine)
{
	frame(engine);
	return NULL;
}

static void *capture_of(void *engine)
{
	stilb_engine_capture(engine);
	return NULL;
}

static void *destroy_of(void *engine)
{
	stress_engine_destroy(engine);
	return NULL;
}

/* Runs a call of the engine on a thread that is not the main one. */
static void call_on_another_thread(void *(*call)(void *engine), stilb_engine *engine)
{
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, call, engine), 0);
	pthread_join(thread, NULL);
}

static void create_with_shadows(stilb_engine_shadows shadows)
{
	stilb_engine_desc desc = null_desc();
	stilb_engine *engine;
	desc.shadows = shadows;
	stilb_engine_create(&desc, &engine);
}

static void create_with_replay_of_nothing(void)
{
	stilb_engine_desc desc = null_desc();
	desc.gamepad = STILB_ENGINE_GAMEPAD_REPLAY;
	stilb_engine *engine;
	stilb_engine_create(&desc, &engine);
}

static void engines(void **state)
{
	(void)state;
	contract_breaks("desc && out", stilb_engine_create(NULL, NULL));
	contract_breaks("desc->gamepad_recording", create_with_replay_of_nothing());
	contract_breaks("one window", create_with_two_windows());
	contract_breaks("shadows->kind < STILB_ENGINE_SHADOWS_COUNT",
	                create_with_shadows((stilb_engine_shadows){.kind = STILB_ENGINE_SHADOWS_COUNT}));
	contract_breaks("shadows->cascades <=", create_with_shadows((stilb_engine_shadows){.cascades = 9}));
	contract_breaks("size <= 8192", create_with_shadows((stilb_engine_shadows){.size = 1000}));
	contract_breaks("shadows->distance >= 0.0f", create_with_shadows((stilb_engine_shadows){.distance = -1.0f}));
	contract_breaks("isfinite", create_with_shadows((stilb_engine_shadows){.distance = INFINITY}));
	contract_breaks("samples == 36", create_with_shadows((stilb_engine_shadows){.samples = 9}));
	stilb_engine *engine = make();
	contract_breaks("called on the owner's thread", call_on_another_thread(frame_of, engine));
	contract_breaks("called on the owner's thread", call_on_another_thread(capture_of, engine));
	contract_breaks("called on the owner's thread", call_on_another_thread(destroy_of, engine));
	contract_breaks("report", stilb_engine_frame(engine, NULL));
	contract_breaks("gpu_ms", stilb_engine_wait(engine, NULL));
	contract_breaks("path", stilb_engine_screenshot(engine, NULL));
	contract_breaks("path", stilb_engine_picture(engine, NULL, false));
	contract_breaks("width && height", stilb_engine_size(engine, NULL, NULL));
	contract_breaks("shading", stilb_engine_set_shading(engine, NULL));
	contract_breaks("title", stilb_engine_set_title(engine, NULL));
	contract_breaks("text", stilb_engine_tell(engine, NULL));
	contract_breaks("hit", stilb_engine_pick(engine, 0.0, 0.0, NULL));
	assert_int_equal(frame(engine), STILB_OK);
	stress_engine_destroy(engine);
}

/* Shows a picture of a width, through a share that may be NULL. */
static void show(stilb_engine *engine, const float *radiance, uint32_t width, float *from)
{
	stilb_engine_show(engine, &(stilb_engine_shown){.radiance = radiance, .width = width, .height = 1, .from = from});
}

static void input_in_a_window(stilb_engine *engine)
{
	engine->window = (stilb_window *)engine; /* only its presence is looked at */
	stilb_engine_input(engine, &(stilb_window_state){0});
}

static void resize_a_window(stilb_engine *engine)
{
	engine->window = (stilb_window *)engine;
	stilb_engine_resize(engine, 64, 64);
}

static void change_the_surface_of_a_window(stilb_engine *engine)
{
	engine->window = (stilb_window *)engine;
	stilb_engine_set_surface(engine, NULL);
}

static void table_without_rows(void)
{
	stilb_input_table table;
	stilb_engine_desc desc = null_desc();
	desc.action_count = 1;
	stilb_engine_table(&desc, &table);
}

static void *show_of(void *engine)
{
	stilb_engine_show(engine, NULL);
	return NULL;
}

static void what_programs_give(void **state)
{
	(void)state;
	static const float radiance[3] = {1.0f, 1.0f, 1.0f};
	float from = 0.0f;
	stilb_engine *engine = make();
	contract_breaks("picture->from", show(engine, radiance, 1, NULL));
	contract_breaks("picture->radiance || engine->picture.shown", show(engine, NULL, 1, &from));
	contract_breaks("picture->width >= 1", show(engine, radiance, 0, &from));
	contract_breaks("picture->width <= 16384", show(engine, radiance, 16385, &from));
	contract_breaks("called on the owner's thread", call_on_another_thread(show_of, engine));
	contract_breaks("`state'", stilb_engine_input(engine, NULL));
	contract_breaks("the engine reads its own window", input_in_a_window(engine));
	contract_breaks("the picture follows the window", resize_a_window(engine));
	contract_breaks("1..16384 pixels a side", stilb_engine_resize(engine, 16385, 1));
	contract_breaks("scene != engine->scene", stilb_engine_prepare(engine, stilb_engine_scene(engine)));
	contract_breaks("surface->create", stilb_engine_set_surface(engine, &(stilb_gpu_surface){0}));
	contract_breaks("a window of its own", change_the_surface_of_a_window(engine));
	contract_breaks("speed >= 0.0f", stilb_engine_set_speed(engine, -1.0f));
	contract_breaks("(speed)", stilb_engine_set_speed(engine, INFINITY));
	contract_breaks("desc && table", stilb_engine_table(NULL, NULL));
	contract_breaks("desc->actions || ", table_without_rows());
	contract_breaks("path", stilb_engine_dump(engine, NULL));
	contract_breaks("path", stilb_engine_trace(engine, NULL, 0));
	contract_breaks("`pads'", stilb_engine_gamepads(engine, NULL));
	stress_engine_destroy(engine);
}

static void break_moved(stilb_engine *engine)
{
	engine->scene->model_count = 0;
	frame(engine);
}

static void one_camera(stilb_engine *engine, stilb_engine_camera camera)
{
	stilb_engine_set_cameras(engine, &camera, 1);
}

static void stages(void **state)
{
	(void)state;
	stilb_engine *engine = make();
	contract_breaks("models are removed by their bounds", break_moved(engine));
	static const stilb_engine_camera cameras[STILB_ENGINE_MAX_CAMERAS + 1];
	contract_breaks("count <= 15", stilb_engine_set_cameras(engine, cameras, STILB_ENGINE_MAX_CAMERAS + 1));
	contract_breaks("cameras || count == 0", stilb_engine_set_cameras(engine, NULL, 1));
	contract_breaks("length > 0", one_camera(engine, (stilb_engine_camera){.width = 8, .height = 8}));
	contract_breaks("cameras[c].width > 0", one_camera(engine, (stilb_engine_camera){.name = "a"}));
	contract_breaks("camera_place_is_sound",
	                one_camera(engine, (stilb_engine_camera){.name = "a", .place = {0.5f, 0.0f, 1.1f, 1.0f}}));
	contract_breaks("camera_place_is_sound", stilb_engine_set_place(engine, (const float[4]){0.5f, 0.5f, 0.4f, 1.0f}));
	contract_breaks("place[2] > 0.0f", stilb_engine_set_place(engine, (const float[4]){0.0f, 0.0f, 0.0f, 0.0f}));
	contract_breaks("scale >= 0.1f", stilb_engine_set_scale(engine, 0.05f));
	contract_breaks("scale <= 4.0f", stilb_engine_set_scale(engine, 4.1f));
	contract_breaks("engine_overlay_is_open", engine_overlay_record(engine, 1, 0));
	stress_engine_destroy(engine);
}

static void choose_an_unknown_model(void)
{
	stilb_render_shading before = stilb_render_shading_default(), now = before;
	now.brdf = UINT32_MAX;
	stilb_engine_shading_chosen(&before, &now);
}

static void notice_too_many(void)
{
	engine_notice notice = {.pad_count = ENGINE_NOTICE_PADS + 1};
	engine_notice_remove(&notice, 1);
}

static void parts(void **state)
{
	(void)state;
	engine_notice notice = {0};
	contract_breaks("shading->brdf < ", choose_an_unknown_model());
	contract_breaks("notice->pad_count <= ", notice_too_many());
	contract_breaks("info", engine_notice_add(&notice, 1, NULL));
	stilb_engine_replay *replay;
	contract_breaks("desc->path", stilb_engine_replay_create(&(stilb_engine_replay_desc){0}, &replay));
	stilb_engine_viewer *viewer;
	contract_breaks("desc->width >= 1", stilb_engine_viewer_create(&(stilb_engine_viewer_desc){0}, &viewer));
	stilb_engine_trace_view *view;
	contract_breaks("desc->trace", stilb_engine_trace_view_create(&(stilb_engine_trace_view_desc){0}, &view));
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(engines),
		cmocka_unit_test(what_programs_give),
		cmocka_unit_test(stages),
		cmocka_unit_test(parts),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
