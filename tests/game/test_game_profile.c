/* The profiles that `stilb demo` writes: traces, captures of slow frames and by signal, and their errors. */
#include "support/stilb_program.h"

#define SMALL "demo --headless --device null --models 400 --size 320x180 "

/* Frames that are long compared with the noise of the machine, so that a frame slowed on purpose stands out. */
#define LARGE "demo --headless --device null --models 10000 --size 320x180 --workers 0 --replay direct "

static trace_check_report trace;

static int fresh(void **state)
{
	trace_check_finish(&trace);
	trace = (trace_check_report){0};
	return folder_fresh(state);
}

static void read_trace(const char *path)
{
	trace_check_finish(&trace);
	trace_check_file(path, &trace);
	assert_string_equal(trace.error, "");
}

static void read_text(const char *path, char *text, size_t size)
{
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	size_t length = fread(text, 1, size - 1, file);
	fclose(file);
	text[length] = '\0';
}

static bool await_file(const char *path)
{
	for (int i = 0; i < 30000; i++, usleep(10000))
		if (access(path, F_OK) == 0)
			return true;
	return false;
}

/* ---- traces ------------------------------------------------------------------------------------------------------ */

/* A trace has the zones of every thread: the stages of frames, and the workers' jobs, each with an arrow (a flow) from
 * its submission, and sleep ("parked"). */
static void test_trace_tells_all(void **state)
{
	(void)state;
	stilb_good("demo --headless --device null --models 20000 --frames 50 --workers 2 --trace t.json");
	read_trace("t.json");
	static const char *const stages[] = {"frame begin", "scene update", "cull", "record", "ui", "replay", "present"};
	for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
		assert_int_equal(trace_check_zones(&trace, "main", stages[i]), 50);
	assert_int_equal(trace.frames, 49);
	assert_int_equal(trace.events_lost, 0);
	assert_true(trace_check_zones(&trace, "worker 1", "parked") + trace_check_zones(&trace, "worker 2", "parked") > 0);
	assert_int_equal(trace_check_zones(&trace, "main", "parked"), 0);
	uint64_t jobs = trace_check_zones(&trace, "worker 1", "job") + trace_check_zones(&trace, "worker 2", "job");
	assert_true(jobs > 0);
	assert_true(trace.flows == jobs); /* each job worked on a loop of the main thread */
	assert_int_equal(trace.flow_ends_outside, 0);
}

static void test_forms(void **state)
{
	(void)state;
	char text[1 << 16];
	stilb_good(SMALL "--frames 5 --trace t.folded");
	read_text("t.folded", text, sizeof text);
	assert_said(text, "main;frame;record");
	stilb_good(SMALL "--frames 5 --trace t.csv");
	read_text("t.csv", text, sizeof text);
	assert_memory_equal(text, "frame,begin_ms,ms,", 18);
	assert_int_equal(program_lines(text), 1 + 4); /* the last frame has no end yet */
	assert_int_equal(folder_entries(), 2);
}

static void test_small_ring_forgets(void **state)
{
	(void)state;
	stilb_good(SMALL "--frames 20000 --workers 0 --profile-ring 1 --trace t.json");
	read_trace("t.json");
	assert_true(trace.events_lost > 0);
	assert_true(trace.frames > 100);
}

static void test_no_profile(void **state)
{
	(void)state;
	stilb_good(SMALL "--frames 5 --no-profile --stats a.json");
	read_stats("a.json");
	assert_int_equal(stat_int("frames"), 5);
}

/* ---- captures ---------------------------------------------------------------------------------------------------- */

static void test_slow_frame_is_captured(void **state)
{
	(void)state;
	int frame = -1;
	double ms = 0.0;
	stilb_good(LARGE "--frames 300 --fault slow:200 --spike 90 --capture c.json");
	const char *line = strstr(run.out, "trace: c.json, "); /* printed after the frame, at the latest at the end */
	assert_non_null(line);
	assert_int_equal(sscanf(line, "trace: c.json, frame %d took %lf ms", &frame, &ms), 2);
	assert_true(ms > 90.0);
	read_trace("c.json");
	assert_true(trace.frames > 0);
	if (frame == 199) { /* on a busy machine another frame may have been slow before */
		assert_int_equal(trace_check_zones(&trace, "main", "slow on purpose"), 1);
		assert_in_range(trace.frames, 120, 160); /* the frames around the slow one */
	}
	assert_int_equal(folder_entries(), 1);
	stilb_good(LARGE "--frames 300 --fault slow:200 --spike auto --capture c.csv");
	assert_said(run.out, "trace: c.csv, frame ");
	stilb_good(LARGE "--frames 300 --fault slow:200 --spike off --capture d.json");
	assert_int_equal(access("d.json", F_OK), -1);
}

/* Frames of a millisecond and more, in a scene that is made quickly. */
#if TEST_ASAN
#define LONG_FRAMES SMALL "--models 40000 "
#else
#define LONG_FRAMES SMALL "--models 200000 "
#endif

static void test_signal_captures(void **state)
{
	(void)state;
	/* Frames take a millisecond: the last 1,024 are remembered, and on a busy machine it takes tenths of a second until
	 * the capturing thread, of the lowest priority, copies them. Shorter frames would be overwritten by then. */
	stilb_start(no_display, -1, LONG_FRAMES "--frames 1000000 --capture c.json");
	bool ready = catches_interrupts(run.pid), first = false, second = false;
	if (ready) {
		kill(run.pid, SIGUSR1);
		first = await_file("c.json");
		kill(run.pid, SIGUSR1);
		second = await_file("c-2.json");
	}
	kill(run.pid, ready ? SIGINT : SIGKILL);
	program_wait(&run);
	assert_true(ready && first && second);
	assert_int_equal(run.code, 0);
	assert_string_equal(run.err, "");
	assert_said(run.out, "trace: c.json\n");
	assert_said(run.out, "trace: c-2.json\n");
	for (int i = 0; i < 2; i++) {
		read_trace(i ? "c-2.json" : "c.json");
		assert_true(trace.frames > 0);
	}
	assert_int_equal(folder_entries(), 2);
}

/* An error is printed once, however many captures fail; the run goes on, and no partial file is left. */
static void test_capture_that_cannot_be_written(void **state)
{
	(void)state;
	assert_int_equal(symlink("/dev/full", "c.json"), 0);
	assert_int_equal(symlink("/dev/full", "c-2.json"), 0);
	assert_int_equal(symlink("/dev/full", "c-3.json"), 0);
	/* Frames take a millisecond: on a busy machine shorter ones would be overwritten before the capture begins. */
	stilb_start(no_display, -1, LONG_FRAMES "--frames 1000000 --stats a.json --capture c.json");
	bool ready = catches_interrupts(run.pid);
	for (int i = 0; ready && i < 3; i++) {
		kill(run.pid, SIGUSR1);
		usleep(300000);
	}
	kill(run.pid, ready ? SIGINT : SIGKILL);
	program_wait(&run);
	assert_true(ready);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
	assert_said(run.err, "cannot write 'c");
	assert_said(run.err, strerror(ENOSPC));
	read_stats("a.json");
	assert_true(stat_int("frames") > 1); /* the run continued; a sanitizer build draws few frames */
	assert_int_equal(folder_entries(), 4);
}

/* The folder of the captures is removed during the run. */
static void test_capture_without_a_folder(void **state)
{
	(void)state;
	assert_int_equal(mkdir("folder", 0777), 0);
	stilb_start(no_display, -1, LONG_FRAMES "--frames 1000000 --capture folder/c.json");
	bool ready = catches_interrupts(run.pid);
	rmdir("folder");
	if (ready)
		kill(run.pid, SIGUSR1);
	usleep(300000);
	kill(run.pid, ready ? SIGINT : SIGKILL);
	program_wait(&run);
	assert_true(ready);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
	assert_said(run.err, "'folder/c.json'");
	assert_int_equal(folder_entries(), 0);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_trace_tells_all),
		FRESH_TEST(test_forms),
		FRESH_TEST(test_small_ring_forgets),
		FRESH_TEST(test_no_profile),
		FRESH_TEST(test_slow_frame_is_captured),
		FRESH_TEST(test_signal_captures),
		FRESH_TEST(test_capture_that_cannot_be_written),
		FRESH_TEST(test_capture_without_a_folder),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_game_profile")) {
		fprintf(stderr, "usage: test_game_profile STILB\n");
		return 1;
	}
	int failed = cmocka_run_group_tests(tests, NULL, folder_leave);
	trace_check_finish(&trace);
	return failed;
}
