/* The engine's camera moved by gamepads, whose hidraw nodes sockets simulate: plugged in, pulled out, without
 * permission, rumbling, and read by frames that stall. On the null device. */
#include "engine_internal.h"
#include "support/fake_hidraw.h"
#include "support/test.h"
#include "support/trace_check.h"
#include "tests/engine/stress_engine.h"

#include <math.h>
#include <stddef.h>

#define NODE 3
#define TRIES 300000 /* frames with pauses of 1 ms after which a wait fails: a limit against hangs only */

static stilb_engine *engine;
static stilb_engine_report report;
static uint8_t pad_report[64]; /* of a DualShock 4 over USB */

static const input_test_descriptor *dualshock(void)
{
	return input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
}

static stilb_engine_desc flown_desc(void)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.gamepad = STILB_ENGINE_GAMEPAD_HIDRAW;
	desc.gamepad_sys = fake.sys;
	desc.gamepad_dev = fake.dev;
	return desc;
}

static void let_go(void)
{
	memset(pad_report, 0, sizeof pad_report);
	pad_report[0] = 1;
	memset(pad_report + 1, 0x80, 4);
	pad_report[5] = 8;
}

static void create(const stilb_engine_desc *desc)
{
	assert_int_equal(stress_engine_create(desc, &(stress_engine){.models = 25, .seed = 1}, &engine), STILB_OK);
}

static int set_up(void **state)
{
	(void)state;
	fake_begin();
	let_go();
	return 0;
}

static int tear_down(void **state)
{
	(void)state;
	stress_engine_destroy(engine);
	engine = NULL;
	fake_end();
	return 0;
}

static void run_frame(void)
{
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
}

static void send_report(void)
{
	assert_true(fake_send(NODE, pad_report, sizeof pad_report));
}

static uint32_t pads(void)
{
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	return stilb_engine_gamepads(engine, now);
}

/* Runs frames until this many pads are connected. */
static void expect_pads(uint32_t count)
{
	for (int i = 0; i < TRIES && pads() != count; i++, usleep(1000))
		run_frame();
	assert_int_equal(pads(), count);
}

static void expect_reports(uint64_t count)
{
	for (int i = 0; i < TRIES && stilb_engine_gamepad_counts_get(engine).reports < count; i++, usleep(1000))
		run_frame();
	assert_int_equal(stilb_engine_gamepad_counts_get(engine).reports, count);
}

static void fly_frames(int count)
{
	for (int i = 0; i < count; i++, usleep(1000))
		run_frame();
}

static bool moved_since(const stilb_input_pose *before)
{
	stilb_input_pose now = stilb_engine_pose(engine);
	return memcmp(&now, before, sizeof now) != 0;
}

/* ---- plugged and pulled ------------------------------------------------------------------------------------------ */

static void plugged_it_flies_pulled_it_stops(void **state)
{
	(void)state;
	stilb_engine_desc desc = flown_desc();
	create(&desc);
	stilb_input_pose pose = stilb_engine_pose(engine);
	for (int round = 0; round < 2; round++) {
		fly_frames(3);
		assert_false(moved_since(&pose));
		fake_plug(NODE, dualshock());
		expect_pads(1);
		pad_report[2] = 0; /* forwards */
		send_report();
		for (int i = 0; i < TRIES && !moved_since(&pose); i++, usleep(1000))
			run_frame();
		assert_true(moved_since(&pose));
		fake_unplug(NODE);
		expect_pads(0);
		pose = stilb_engine_pose(engine);
		fly_frames(5);
		assert_false(moved_since(&pose)); /* the camera stands still at once and stays there */
	}
	assert_int_equal(stilb_engine_gamepad_counts_get(engine).reports, 2);
}

static void headless_it_must_be_asked_for(void **state)
{
	(void)state;
	stilb_engine_desc desc = flown_desc();
	fake_plug(NODE, dualshock());
	for (int i = 0; i < 2; i++) {
		desc.gamepad = i ? STILB_ENGINE_GAMEPAD_OFF : STILB_ENGINE_GAMEPAD_AUTO;
		create(&desc);
		for (int f = 0; f < 3; f++) {
			run_frame();
			assert_int_equal(report.time_us, (int64_t)f * 1000000 / 60);
		}
		assert_int_equal(pads(), 0);
		stress_engine_destroy(engine);
	}
	engine = NULL;
}

/* Half a second without a frame at 1000 reports a second: the next frame takes all these reports, and the camera moves
 * as the last one asks. */
static void a_stalled_frame_loses_nothing(void **state)
{
	(void)state;
	enum { REPORTS = 500 };
	stilb_engine_desc desc = flown_desc();
	create(&desc);
	fake_plug(NODE, dualshock());
	expect_pads(1);
	for (int i = 0; i < REPORTS; i++) {
		pad_report[3] = (uint8_t)(i % 256);
		if (i == REPORTS - 1)
			pad_report[3] = 0xff;
		send_report();
	}
	for (int i = 0; i < TRIES && stilb_input_pads_stats_get(engine->input.pads).reports < REPORTS; i++)
		usleep(1000);
	run_frame();
	stilb_engine_gamepad_counts counts = stilb_engine_gamepad_counts_get(engine);
	assert_int_equal(counts.reports, REPORTS);
	assert_int_equal(counts.lost, 0);
	assert_int_equal(counts.corrupt, 0);
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	stilb_engine_gamepads(engine, now);
	assert_true(now[0].state.axes[STILB_INPUT_RIGHT_X] == 1.0f);
	assert_true(report.times.pad > 0.0 && report.times.pad < 10000.0);
	run_frame();
	assert_true(report.times.pad == 0.0); /* no report came since the last frame */
}

/* ---- the camera's control ---------------------------------------------------------------------------------------- */

static void the_program_may_move_the_camera(void **state)
{
	(void)state;
	stilb_engine_desc desc = flown_desc();
	create(&desc);
	stilb_engine_scene(engine)->camera =
		stilb_scene_stress_camera(stilb_engine_scene(engine), STILB_SCENE_VIEW_FEW, 1.5f);
	stilb_input_pose pose = stilb_engine_pose(engine);
	fly_frames(3);
	assert_false(moved_since(&pose));
	stilb_scene_camera *camera = &stilb_engine_scene(engine)->camera;
	camera->position[1] = 33.0f;
	camera->yaw = 1.0f;
	pose = stilb_engine_pose(engine);
	fly_frames(3);
	assert_false(moved_since(&pose));
	fake_plug(NODE, dualshock());
	expect_pads(1);
	assert_false(moved_since(&pose));
	pad_report[3] = 0; /* turns left, from the pose that the program gave it */
	send_report();
	for (int i = 0; i < TRIES && !moved_since(&pose); i++, usleep(1000))
		run_frame();
	assert_true(camera->yaw > 1.0f && camera->yaw < 2.0f);
	assert_true(camera->position[1] == 33.0f);
}

/* ---- permission -------------------------------------------------------------------------------------------------- */

static void a_denied_pad_is_named_until_it_is_granted(void **state)
{
	(void)state;
	stilb_engine_desc desc = flown_desc();
	fake_plug_mode(NODE, dualshock(), 0);
	create(&desc);
	expect_pads(1);
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	stilb_engine_gamepads(engine, now);
	assert_true(now[0].denied);
	const engine_notice *notice = &engine->overlay.notice;
	assert_int_equal(notice->pad_count, 1);
	assert_non_null(strstr(notice->pads[0].who, "(054c:05c4)"));
	assert_non_null(strstr(notice->pads[0].who, "/hidraw3"));
	assert_non_null(strstr(notice->pads[0].rule, "uaccess"));
	run_frame();
	assert_true(report.render.draws > 2 * report.visible); /* the notice adds draws */
	fake_chmod(NODE, 0600);
	for (int i = 0; i < TRIES && notice->pad_count > 0; i++, usleep(1000))
		run_frame();
	assert_int_equal(notice->pad_count, 0);
	expect_pads(1);
	stilb_engine_gamepads(engine, now);
	assert_false(now[0].denied);
	send_report();
	expect_reports(1);
}

/* ---- captures ---------------------------------------------------------------------------------------------------- */

/* Runs frames until the input of one asks for a capture. */
static void expect_capture(void)
{
	for (int i = 0; i < TRIES && !report.input.actions[STILB_ENGINE_CAPTURE]; i++, usleep(1000))
		run_frame();
	assert_true(report.input.actions[STILB_ENGINE_CAPTURE]);
}

static void a_pad_that_captures_shakes(void **state)
{
	(void)state;
	char path[128];
	uint8_t output[128];
	snprintf(path, sizeof path, "%s/capture.json", fake.folder);
	stilb_engine_desc desc = flown_desc();
	desc.capture.path = path;
	desc.saves = true;
	create(&desc);
	fake_plug(NODE, dualshock());
	expect_pads(1);
	pad_report[5] = 0x18; /* square */
	send_report();
	expect_capture();
	assert_int_equal(stilb_engine_capture(engine), STILB_OK);
	assert_int_equal(fake_receive(NODE, output, sizeof output, 5000), 32);
	assert_int_equal(output[0], 5);
	assert_true(output[4] > 0 && output[5] > 0); /* both motors */
	while ((output[4] || output[5]) && fake_receive(NODE, output, sizeof output, 5000) == 32)
		;
	assert_true(output[4] == 0 && output[5] == 0); /* the rumble ends */
	run_frame();
	assert_false(report.input.actions[STILB_ENGINE_CAPTURE]);
	assert_int_equal(stilb_engine_capture(engine), STILB_OK); /* requested by the program: no rumble */
	assert_int_equal(fake_receive(NODE, output, sizeof output, 50), 0);
	stress_engine_destroy(engine);
	engine = NULL;
	assert_int_equal(unlink(path), 0);
	snprintf(path, sizeof path, "%s/capture-2.json", fake.folder);
	unlink(path);
}

/* ---- the profiler ------------------------------------------------------------------------------------------------ */

/* A report is recorded as a flow from the pad's thread to the frame, and its latencies as two counters. */
static void reports_are_seen_in_the_profile(void **state)
{
	(void)state;
	char path[128];
	stilb_engine_desc desc = flown_desc();
	create(&desc);
	fake_plug(NODE, dualshock());
	expect_pads(1);
	for (uint64_t i = 1; i <= 5; i++) {
		send_report();
		expect_reports(i);
	}
	snprintf(path, sizeof path, "%s/trace.json", fake.folder);
	assert_int_equal(stilb_engine_trace(engine, path, 0), STILB_OK);
	trace_check_report trace;
	trace_check_file(path, &trace);
	assert_string_equal(trace.error, "");
	assert_true(trace_check_zones(&trace, "main", "input") > 0);
	trace_check_finish(&trace);
	char line[4096];
	int to_camera = 0, to_submit = 0, flows = 0, readers = 0;
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	while (fgets(line, sizeof line, file)) {
		to_camera += strstr(line, "\"ph\":\"C\"") && strstr(line, "pad report to camera, ms");
		to_submit += strstr(line, "\"ph\":\"C\"") && strstr(line, "pad report to submit, ms");
		flows += strstr(line, "\"ph\":\"f\"") && strstr(line, "report");
		readers += strstr(line, "pad hidraw3") ? 1 : 0;
	}
	fclose(file);
	unlink(path);
	assert_int_equal(to_camera, 5);
	assert_int_equal(to_submit, 5);
	assert_int_equal(flows, 5);
	assert_true(readers > 0);
}

/* ---- ends -------------------------------------------------------------------------------------------------------- */

static void what_cannot_start_says_why(void **state)
{
	(void)state;
	stilb_engine_desc desc = flown_desc();
	desc.gamepad = STILB_ENGINE_GAMEPAD_REPLAY;
	desc.gamepad_recording = "/nonexistent/flight.rec";
	assert_int_equal(stilb_engine_create(&desc, &engine), STILB_ERROR_FILE);
	assert_null(engine);
	assert_non_null(strstr(stilb_error_message(), "/nonexistent/flight.rec"));
	desc.gamepad = STILB_ENGINE_GAMEPAD_HIDRAW;
	desc.gamepad_dev = "/nonexistent";
	assert_int_not_equal(stilb_engine_create(&desc, &engine), STILB_OK);
	assert_null(engine);
	assert_non_null(strstr(stilb_error_message(), "/nonexistent"));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		TEST(plugged_it_flies_pulled_it_stops),
		TEST(headless_it_must_be_asked_for),
		TEST(a_stalled_frame_loses_nothing),
		TEST(the_program_may_move_the_camera),
		TEST(a_denied_pad_is_named_until_it_is_granted),
		TEST(a_pad_that_captures_shakes),
		TEST(reports_are_seen_in_the_profile),
		TEST(what_cannot_start_says_why),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
