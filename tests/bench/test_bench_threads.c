/* stilb-bench threads: short runs on the null device, their JSON and timelines, and refused command lines. */
#include "support/bench_program.h"

static char program_path[PATH_MAX]; /* stilb-bench-threads */

static int bench_code(const char *environment_word, const char *line)
{
	const char *const environment[] = {environment_word, NULL};
	return stilb_code(environment_word ? environment : NULL, line);
}

static void bench_good(const char *line)
{
	int code = bench_code(NULL, line);
	if (code != 0)
		print_error("stilb-bench %s\n%s", line, run.err);
	assert_int_equal(code, 0);
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void test_help_and_list(void **state)
{
	(void)state;
	stilb_good("--help");
	assert_said(run.out, "\n  threads ");
	assert_said(run.out, "\n  --traces ");
	stilb_good("threads --list");
	static const char *const words[] = {"stilb-workers-0", "dedicated",        "sutter-",       "kernel-mutex",
	                                    "null-all",        "vulkan-few",       "stolen",        "one-vs-four",
	                                    "dedicated",       "mutex-vs-lowlock", "stilb-low-lock"};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s", words[i]);
		assert_said(run.out, line);
	}
	assert_int_equal(folder_entries(), 0);
}

/* A command line that is refused, and a word that the line on stderr must have. */
static const char *const refusals[][2] = {
	{"threads --bogus", "'--bogus'"},
	{"threads --case null-none", "'null-none'"},
	{"threads --only stilb-workers-1000", "'stilb-workers-1000'"},
	{"threads --case dedicated --only mutex", "--list"},
	{"threads --steps", "--steps"},
	{"threads --traces", "missing"},
	{"threads --traces missing/a", "--traces"},
	{"threads --traces {}", "--traces"},
	{"queue --traces a", "--traces"},
	{"jobs --traces a", "'jobs'"},
};

static void test_refusals(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = bench_code(NULL, refusals[i][0]);
		if (code != 2)
			print_error("stilb-bench %s: %s", refusals[i][0], run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), 0);
	}
	FILE *file = fopen("file", "w");
	assert_non_null(file);
	fclose(file);
	assert_int_equal(bench_code(NULL, "threads --traces file"), 2);
	assert_said(run.err, "is not a folder");
}

static void test_sweep(void **state)
{
	(void)state;
	static const char line[] =
		"threads --quick --seconds 0.02 --rounds 2 --case null-* --only stilb-workers-0,stilb-workers-2 "
		"--json a.json";
	bench_good(line);
	assert_said(run.out, "null-few: null device, one model in a hundred in view (101)");
	assert_said(run.out, "efficiency");
	assert_said(run.out, "cull and record, which workers share, are");
	assert_null(strstr(run.out, "vulkan-all:")); /* a case that --case did not choose */
	read_stats("a.json");
	assert_string_equal(stat_text("suite", '"'), "threads");
	static const char *const cases[] = {"null-all", "null-half", "null-few"};
	static const char *const subjects[] = {"stilb-workers-0", "stilb-workers-2"};
	static const double visible[] = {10000.0, 5002.0, 101.0};
	for (int c = 0; c < 3; c++)
		for (int s = 0; s < 2; s++) {
			double frame = some(cases[c], subjects[s], "frame");
			double cull = some(cases[c], subjects[s], "cull"), record = some(cases[c], subjects[s], "record");
			assert_true(cull < frame && record < frame);
			assert_true(some(cases[c], subjects[s], "p99") >= frame);
			assert_true(some(cases[c], subjects[s], "worst") >= some(cases[c], subjects[s], "p99"));
			assert_true(row_median(cases[c], subjects[s], "visible") == visible[c]);
		}
	for (int c = 0; c < 3; c++) {
		assert_true(row_median(cases[c], "stilb-workers-0", "speed-up") == 1.0);
		assert_true(row_median(cases[c], "stilb-workers-0", "efficiency") == 100.0);
		double gain = some(cases[c], "stilb-workers-2", "speed-up"),
			   part = some(cases[c], "stilb-workers-2", "efficiency");
		double at_once = stat_int("machine.cpus") < 3 ? (double)stat_int("machine.cpus") : 3.0;
		assert_true(fabs(part - 100.0 * gain / at_once) < 0.1);
	}
	assert_true(isnan(row_median("null-all", "stilb-workers-1", "frame")));
	assert_int_equal(folder_entries(), 1);
}

/* Without a Vulkan driver the report says so, and the run succeeds. */
static void test_no_driver(void **state)
{
	(void)state;
	static const char line[] =
		"threads --seconds 0.01 --rounds 1 --case null-few,vulkan-few --only stilb-workers-0 --json a.json";
	assert_int_equal(stilb_code(no_driver, line), 0);
	assert_said(run.out, "\n  skipped: ");
	read_stats("a.json");
	some("null-few", "stilb-workers-0", "frame");
	assert_true(isnan(row_median("vulkan-few", "stilb-workers-0", "frame")));
}

/* ---- experiments ------------------------------------------------------------------------------------------------- */

static uint64_t zones(const char *case_name, const char *subject, const char *thread, const char *zone)
{
	char path[128];
	trace_check_report report;
	snprintf(path, sizeof path, "traces/%s.%s.trace.json", case_name, subject);
	int broken = trace_check_file(path, &report);
	if (broken)
		print_error("%s: %s\n", path, report.error);
	assert_int_equal(broken, 0);
	assert_true(report.frames >= 1 && report.frames <= 2);
	uint64_t count = trace_check_zones(&report, thread, zone);
	trace_check_finish(&report);
	return count;
}

static void test_experiments(void **state)
{
	(void)state;
	static const char line[] =
		"threads --seconds 0.03 --rounds 2 --case dedicated,mutex-vs-lowlock,stolen --json a.json "
		"--only dedicated,stilb-workers-0,no-queue,mutex,kernel-mutex,sutter,stilb-low-lock,stilb-lock-free --traces "
		"traces";
	static const char *const queues[] = {"mutex", "kernel-mutex", "sutter", "stilb-low-lock", "stilb-lock-free"};
	bench_good(line);
	read_stats("a.json");
	some("dedicated", "dedicated", "frame");
	assert_true(some("dedicated", "dedicated", "latency") > 0.0);
	assert_true(zones("dedicated", "dedicated", "render", "record") >= 1);
	some("mutex-vs-lowlock", "no-queue", "frame");
	assert_true(isnan(row_median("mutex-vs-lowlock", "no-queue", "waiting"))); /* no-queue has no workers that wait */
	for (size_t q = 0; q < sizeof queues / sizeof *queues; q++) {
		double recording = some("mutex-vs-lowlock", queues[q], "recording");
		double waiting = some("mutex-vs-lowlock", queues[q], "waiting");
		assert_true(recording < 100.0 && waiting < 100.0);
		/* no-work is the rest to 100 %. The cost of reading the clock is subtracted elsewhere, so it may be below 0. */
		assert_true(row_median("mutex-vs-lowlock", queues[q], "no-work") > -1.0);
		assert_true(zones("mutex-vs-lowlock", queues[q], "worker 1", "record") >= 1);
		assert_true(zones("mutex-vs-lowlock", queues[q], "main", "feed") >= 1);
	}
	some("stolen", "stilb-workers-0", "before");
	some("stolen", "stilb-workers-0", "during-mean");
	assert_true(some("stolen", "stilb-workers-0", "worst") >= some("stolen", "stilb-workers-0", "during"));
	assert_true(zones("stolen", "stilb-workers-0", "main", "record segment") >= 40);
	assert_said(run.out, "timelines of the slowest frames: traces/");
	/* One timeline is left for each subject in each case: that of the slowest round. */
	assert_int_equal(system("test $(ls traces | wc -l) = 9 && rm -r traces"), 0);
}

/* A run fails if its stream hash, a checksum of its draws in order, is not the expected one in its argument. */
static void test_another_stream_is_a_failure(void **state)
{
	(void)state;
	static const char *const runs[][2] = {
		{"stilb-workers-0", "null-all"}, {"dedicated", "dedicated"}, {"mutex", "mutex-vs-lowlock"}};
	for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
		const char *const words[] = {program_path, runs[i][0], runs[i][1], "0.01", "0", "1:2:3:", NULL};
		assert_true(program_start(&run, words, NULL, -1));
		program_wait(&run);
		assert_int_equal(run.code, 1);
		assert_said(run.err, "wrong result: the command stream's hash is");
		assert_string_equal(run.out, "");
	}
}

/* gnuplot is a stand-in that copies its script to the file where the picture should go. */
static void test_picture(void **state)
{
	(void)state;
	char path[PATH_MAX + 32], script[65536];
	snprintf(path, sizeof path, "PATH=%s:/usr/bin:/bin", stilb_folder);
	FILE *file = fopen("gnuplot", "w");
	assert_non_null(file);
	fputs("#!/bin/sh\n[ $1 = --version ] || cp $1 $(sed -n \"s/^set output '\\(.*\\)'$/\\1/p\" $1)\n", file);
	fclose(file);
	assert_int_equal(chmod("gnuplot", 0755), 0);
	assert_int_equal(
		bench_code(path, "threads --seconds 0.01 --rounds 1 --case null-few --only stilb-workers-0,stilb-workers-1 "
	                     "--plot a.png"),
		0);
	file = fopen("a.png", "r");
	assert_non_null(file);
	script[fread(script, 1, sizeof script - 1, file)] = '\0';
	fclose(file);
	assert_said(script, "speed-up, null device");
	assert_said(script, "$gain2 using");
	assert_said(script, "not measured"); /* diagrams of cases that were not chosen */
	assert_null(strstr(script, "nan"));
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_help_and_list), FRESH_TEST(test_refusals),    FRESH_TEST(test_sweep),
		FRESH_TEST(test_no_driver),     FRESH_TEST(test_experiments), FRESH_TEST(test_another_stream_is_a_failure),
		FRESH_TEST(test_picture),
	};
	if (argc != 3 || !realpath(argv[2], program_path) || !folder_enter(argv[1], "bench_threads")) {
		fprintf(stderr, "usage: test_bench_threads STILB-BENCH STILB-BENCH-THREADS\n");
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
