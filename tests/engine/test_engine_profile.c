/* The engine and its profiler together, on the null device: the overlay, captures and traces while workers record. */
#include "engine.h"
#include "support/stilb_program.h"
#include "tests/engine/stress_engine.h"

static const stress_engine stress = {.models = 3000, .seed = 1, .animate = true};

static stilb_engine_desc null_desc(uint32_t workers)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = workers;
	desc.profile_ring_mib = 1;
	return desc;
}

static stilb_engine *make_engine(const stilb_engine_desc *desc)
{
	stilb_engine *engine;
	stilb_result result = stress_engine_create(desc, &stress, &engine);
	if (result != STILB_OK)
		print_error("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
	return engine;
}

static stilb_engine_report run_frames(stilb_engine *engine, int count)
{
	stilb_engine_report report = {0};
	for (int i = 0; i < count; i++)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	return report;
}

static void test_overlay_draws_and_leaves_the_stream_alone(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	stilb_engine *engine = make_engine(&desc);
	stilb_engine_report plain = run_frames(engine, 5);
	uint64_t hash = stilb_engine_stream_hash(engine);
	stress_engine_destroy(engine);
	desc.overlay = true;
	engine = make_engine(&desc);
	stilb_engine_report over = run_frames(engine, 5);
	assert_true(stilb_engine_stream_hash(engine) == hash);
	assert_true(over.render.draws > plain.render.draws);
	assert_int_equal(over.visible, plain.visible);
	assert_true(over.times.ui > 0.0);
	stress_engine_destroy(engine);
}

/* Frames, the overlay's snapshots of the profiler, the thread that writes captures and a trace at the same time. */
static void test_all_at_once(void **state)
{
	(void)state;
	for (uint32_t workers = TEST_TSAN ? 2 : 0; workers <= 3; workers++) {
		stilb_engine_desc desc = null_desc(workers);
		desc.overlay = true;
		desc.capture.path = "c.json";
		desc.capture.spike = STILB_PROF_SPIKE_AUTO;
		desc.capture.frames_before = desc.capture.frames_after = 5;
		stilb_engine *engine = make_engine(&desc);
		for (int i = 0; i < 5; i++) {
			run_frames(engine, 10);
			assert_int_equal(stilb_engine_capture(engine), STILB_OK);
			assert_int_equal(stilb_engine_trace(engine, "t.json", 4), STILB_OK);
			if (i == 2)
				assert_int_equal(stilb_engine_set_workers(engine, workers + 1), STILB_OK);
		}
		stress_engine_destroy(engine);
		trace_check_report report;
		const char *const files[] = {"c.json", "t.json"};
		for (int i = 0; i < 2; i++) {
			trace_check_file(files[i], &report);
			assert_string_equal(report.error, "");
			assert_true(report.frames > 0);
			assert_true(trace_check_zones(&report, "main", "ui build") > 0);
			trace_check_finish(&report);
		}
		folder_fresh(state);
	}
}

/* What the program's part of each frame was told. */
typedef struct updates {
	uint64_t frames;
	double seconds;
} updates;

static void update_slowly(void *user, const stilb_engine_update *update)
{
	updates *seen = user;
	PROFILE("the program's own");
	assert_int_equal(update->frame, ++seen->frames);
	assert_true(seen->frames == 1 ? update->seconds == 0.0 : update->seconds > seen->seconds);
	assert_non_null(update->input);
	seen->seconds = update->seconds;
	if (update->frame == 3)
		usleep(100000);
}

static void the_program_has_a_part_in_each_frame(void **state)
{
	(void)state;
	updates seen = {0};
	stilb_engine_desc desc = null_desc(1);
	desc.update = update_slowly;
	desc.user = &seen;
	stilb_engine *engine;
	assert_int_equal(stress_engine_create(&desc, &(stress_engine){.models = 100, .seed = 1}, &engine), STILB_OK);
	for (int i = 1; i <= 4; i++) {
		stilb_engine_report report = run_frames(engine, 1);
		assert_int_equal(seen.frames, i);
		if (i == 3)
			assert_true(report.times.update >= 100.0);
	}
	assert_true(seen.seconds == 3.0 / 60.0);
	assert_int_equal(stilb_engine_trace(engine, "t.json", 0), STILB_OK);
	stress_engine_destroy(engine);
	trace_check_report report;
	trace_check_file("t.json", &report);
	assert_string_equal(report.error, "");
	assert_int_equal(trace_check_zones(&report, "main", "the program's own"), 4);
	trace_check_finish(&report);
}

static void test_nothing_is_recorded(void **state)
{
	(void)state;
	stilb_engine_desc desc = null_desc(2);
	desc.profile = false;
	desc.overlay = true; /* the window says that nothing is recorded */
	desc.capture.path = "c.json";
	stilb_engine *engine = make_engine(&desc);
	run_frames(engine, 5);
	assert_int_equal(stilb_engine_capture(engine), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_engine_trace(engine, "t.json", 0), STILB_OK);
	stress_engine_destroy(engine);
	trace_check_report report;
	trace_check_file("t.json", &report);
	assert_string_equal(report.error, "");
	assert_int_equal(report.zones, 0);
	trace_check_finish(&report);
	assert_int_equal(folder_entries(), 1);
	desc = null_desc(1);
	engine = make_engine(&desc); /* the next engine records again */
	run_frames(engine, 2);
	assert_int_equal(stilb_engine_trace(engine, "t.json", 0), STILB_OK);
	stress_engine_destroy(engine);
	trace_check_file("t.json", &report);
	assert_int_equal(trace_check_zones(&report, "main", "frame"), 2);
	trace_check_finish(&report);
}

static void test_what_cannot_be(void **state)
{
	(void)state;
	static const uint32_t rings[] = {0, 3, 2048, 65536, 131073, UINT32_MAX};
	stilb_engine *engine;
	stilb_engine_desc desc;
	for (size_t i = 0; i < sizeof rings / sizeof *rings; i++) {
		desc = null_desc(1);
		desc.profile_ring_mib = rings[i];
		assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_ARGUMENT);
		assert_null(engine);
		assert_said(stilb_error_message(), "power of two");
	}
	desc = null_desc(1);
	desc.capture.path = "c.json";
	desc.capture.signal = 9999;
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_FILE);
	assert_said(stilb_error_message(), "'c.json'");
	desc = null_desc(1);
	engine = make_engine(&desc);
	assert_int_equal(stilb_engine_capture(engine), STILB_ERROR_ARGUMENT); /* captures have no path */
	assert_int_equal(stilb_engine_trace(engine, "missing/t.json", 0), STILB_ERROR_FILE);
	assert_said(stilb_error_message(), "'missing/t.json'");
	stress_engine_destroy(engine);
	assert_int_equal(folder_entries(), 0);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_overlay_draws_and_leaves_the_stream_alone),
		FRESH_TEST(test_all_at_once),
		FRESH_TEST(the_program_has_a_part_in_each_frame),
		FRESH_TEST(test_nothing_is_recorded),
		FRESH_TEST(test_what_cannot_be),
	};
	if (argc < 1 || !folder_enter(argv[0], "test_engine_profile"))
		return 1;
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
