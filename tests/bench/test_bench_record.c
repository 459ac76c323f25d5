/* stilb-bench record: short runs of the real programs; verdicts (met, MISSED) of goals for numbers that stand-ins for
 * the programs print; wrong pictures. */
#include "support/bench_program.h"

static char programs[PATH_MAX]; /* folder of stilb-bench and its programs */

static int bench_code(const char *line)
{
	return stilb_code(NULL, line);
}

/* ---- stand-ins for programs, beside a copy of stilb-bench -------------------------------------------------------- */

static void copy_own(void)
{
	char path[PATH_MAX + 32];
	snprintf(path, sizeof path, "%s/stilb-bench-record-own", programs);
	copy_program(path, "stilb-bench-record-own");
}

/* Runs the copy of stilb-bench, without leak detection: a program that fails ends at once and frees nothing. */
static int made_up_code(const char *line, const char *more)
{
	const char *const environment[] = {"ASAN_OPTIONS=detect_leaks=0", more, NULL};
	return copy_code(environment, line);
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void test_list(void **state)
{
	(void)state;
	stilb_good("--help");
	assert_said(run.out, "\n  record ");
	stilb_good("record --list");
	static const char *const words[] = {"stilb",   "stilb-scene", "stilb-indirect", "stilb-direct", "stilb-secondary",
	                                    "write",   "radix",       "vulkan-bare",    "draws",        "draws-1000000",
	                                    "phase",   "parked",      "replay-2",       "sort",         "frame-1",
	                                    "picture", "picture-bind"};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s ", words[i]);
		assert_said(run.out, line);
	}
	static const char *const refusals[][2] = {
		{"record --case draw", "'draw'"},
		{"record --only bgfx", "'bgfx'"},
		{"record --case sort --only write", "--list"},
		{"record --steps", "--steps"},
	};
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		assert_int_equal(bench_code(refusals[i][0]), 2);
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
	}
	assert_int_equal(folder_entries(), 0);
}

/* ---- the real programs ------------------------------------------------------------------------------------------- */

#if TEST_ASAN
#define LARGE_CASE ""
#else
#define LARGE_CASE ",draws-1000000"
#endif

/* Each run compares its stream hash, a checksum of all draws in order, with the expected one, so exit code 0 is the
 * main assertion here. */
static void test_null_device(void **state)
{
	(void)state;
	/* With the address sanitizer without the million draws, which are 20,000 draws again and take ten times as long. */
	assert_int_equal(bench_code("record --seconds 0.01 --rounds 1 --json a.json --case "
	                            "phase,parked,replay-*,sort,frame-*,draws" LARGE_CASE),
	                 0);
	assert_null(strstr(run.out, "FAILED"));
	read_stats("a.json");
	assert_string_equal(stat_text("suite", '"'), "record");
	static const char *const recorders[] = {"stilb", "stilb-scene"};
	for (int i = 0; i < 2; i++) {
		some("draws", recorders[i], "record");
		if (!TEST_ASAN)
			some("draws-1000000", recorders[i], "record");
		assert_true(some("draws", recorders[i], "bytes") <= 96.0);
		double ratio = some("phase", recorders[i], "one") / some("phase", recorders[i], "two");
		assert_true(fabs(some("phase", recorders[i], "speed-up") - ratio) < 1e-3);
		double best = 0.5 * (some("parked", recorders[i], "one") + some("parked", recorders[i], "wake") +
		                     some("parked", recorders[i], "wake-cost"));
		assert_true(fabs(some("parked", recorders[i], "of-best") - some("parked", recorders[i], "two") / best) < 1e-3);
	}
	static const char *const replays[] = {"stilb-indirect", "stilb-direct", "stilb-secondary"};
	for (int i = 0; i < 3; i++) {
		some("replay-1", replays[i], "replay");
		some("textures", replays[i], "replay");
		some("textures-sizes", replays[i], "replay");
		some("textures-all", replays[i], "replay");
		some("replay-2", replays[i], "replay");
		some("sort", replays[i], "replay");
		some("frame-1", replays[i], "frame");
		some("frame-2", replays[i], "cull");
	}
	static const char *const limits[] = {"write", "write-non-temporal", "atomic", "malloc"};
	for (int i = 0; i < 4; i++)
		some("draws", limits[i], "record");
	some("sort", "radix", "sort");
}

static bool pictures_are_the_same(const char *cases)
{
	char line[256];
	snprintf(line, sizeof line, "record --goals --seconds 0.01 --rounds 1 --json a.json --case %s", cases);
	assert_int_equal(bench_code(line), 0);
	assert_null(strstr(run.out, "FAILED"));
	if (strstr(run.err, "left out")) {
		print_message("skipped: %s", run.err);
		return false;
	}
	read_stats("a.json");
	return true;
}

static void test_pictures_are_the_same(void **state)
{
	(void)state;
	/* With the address sanitizer one way of replay: test_render_picture has all. */
	if (!pictures_are_the_same(TEST_ASAN ? "picture --only stilb-indirect,vulkan-bare" : "picture"))
		skip();
	static const char *const replays[] = {"stilb-indirect", "stilb-direct", "stilb-secondary"};
	for (int i = 0; i < (TEST_ASAN ? 1 : 3); i++)
		assert_true(some("picture", replays[i], "least") <= some("picture", replays[i], "frame"));
	assert_true(some("picture", "vulkan-bare", "cpu") > 0.0);
	assert_said(run.out, "lavapipe frame / bare Vulkan");
}

/* The other materials in one way of replay: test_render_picture has them in all. With the address sanitizer, which sees
 * the same there, not at all. */
static void test_pictures_of_other_materials(void **state)
{
	(void)state;
	if (TEST_ASAN || !pictures_are_the_same("picture-* --only stilb-direct,vulkan-bare"))
		skip();
	static const char *const cases[] = {"picture-bind", "picture-pipeline"};
	for (int c = 0; c < 2; c++)
		assert_true(some(cases[c], "stilb-direct", "least") <= some(cases[c], "stilb-direct", "frame"));
	assert_true(isnan(row_median("picture-bind", "vulkan-bare", "frame"))); /* it does not have the case */
}

/* ---- wrong pictures, and no driver ------------------------------------------------------------------------------- */

#define SHORT_PICTURE "record --seconds 0.01 --rounds 1 --case picture,draws --only stilb,stilb-direct --json a.json"

static void test_wrong_picture(void **state)
{
	(void)state;
	copy_bench();
	copy_own();
	write_program("stilb-bench-record-vulkan_bare", "echo high 1; echo low 2");
	int code = made_up_code(SHORT_PICTURE, NULL);
	if (strstr(run.err, "Vulkan driver"))
		skip();
	assert_int_equal(code, 1);
	assert_said(run.out, "FAILED in 1 of 1 runs: wrong picture");
	assert_said(run.err, "that of the bare program's 16777218");
	read_stats("a.json");
	assert_true(isnan(row_median("picture", "stilb-direct", "frame")));
	some("draws", "stilb", "record");
}

static void test_no_lavapipe(void **state)
{
	(void)state;
	copy_bench();
	copy_own();
	write_program("stilb-bench-record-vulkan_bare", "echo nothing to draw with >&2; exit 77");
	assert_int_equal(made_up_code(SHORT_PICTURE, NULL), 0);
	assert_said(run.err, "stilb: the cases picture* are skipped: nothing to draw with");
	read_stats("a.json");
	assert_true(isnan(row_median("picture", "stilb-direct", "frame")));
	some("draws", "stilb", "record");
	write_program("stilb-bench-record-vulkan_bare", "echo broken >&2; exit 1");
	assert_int_equal(made_up_code(SHORT_PICTURE, NULL), 1);
	assert_said(run.err, "reference picture for the cases picture*: broken");
}

/* ---- goals ------------------------------------------------------------------------------------------------------- */

/* Asserts that the line of a goal has this text. */
static void assert_goal(const char *goal, const char *verdict)
{
	const char *line = strstr(run.out, goal);
	assert_non_null(line);
	char text[256];
	snprintf(text, sizeof text, "%.*s", (int)strcspn(line, "\n"), line);
	if (!strstr(text, verdict))
		print_error("not %s: %s\n", verdict, text);
	assert_non_null(strstr(text, verdict));
}

static void test_goals(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-record-vulkan_bare", "[ $5 ] && echo frame 100 || { echo high 1; echo low 2; }");
	write_program("stilb-bench-record-limits", "echo record 2");
	write_program("stilb-bench-record-own", "case $1-$2 in\n"
	                                        "stilb-draws) echo record 6; echo bytes 97;;\n"
	                                        "stilb-scene-draws) echo record 6.5; echo bytes 96;;\n"
	                                        "stilb-draws-1000000) echo record 8;;\n"
	                                        "stilb-scene-draws-1000000) echo record 10;;\n"
	                                        "stilb-phase) echo speed-up 1.81;;\n"
	                                        "stilb-scene-phase) echo speed-up 1.79;;\n"
	                                        "stilb-indirect-frame-1) echo frame 0.149;;\n"
	                                        "stilb-indirect-frame-2) echo frame 0.091;;\n"
	                                        "stilb-indirect-picture) [ $5 = 16777218 ] && echo frame 103;;\n"
	                                        "*) exit 77;;\n"
	                                        "esac");
	assert_int_equal(made_up_code("record --goals --seconds 0.01 --rounds 1 --only stilb*,write,vulkan-bare", NULL), 0);
	assert_goal("record by hand, 1 thread", "goal <= 6      met");
	assert_goal("record from a scene, 1 thread", "MISSED");
	assert_goal("bytes recorded", "MISSED");
	assert_goal("by hand / memory write", "       3 [3-3]");
	assert_goal("1,000,000 draws / 20,000, by hand", "1.333 [1.33-1.33]    x        goal <= 1.5    met");
	assert_goal("1,000,000 draws / 20,000, scene", "MISSED");
	assert_goal("2 threads / 1, in a phase, by hand", "goal >= 1.8    met");
	assert_goal("2 threads / 1, in a phase, scene", "MISSED");
	assert_goal("cull + record + replay, 1 thread", "goal <= 0.15   met");
	assert_goal("cull + record + replay, 2 threads", "MISSED");
	assert_goal("lavapipe frame / bare Vulkan", "1.03 [1.03-1.03]    x        goal <= 1.02   MISSED");
	assert_null(strstr(run.out, "order + replay, direct")); /* it was not measured */
}

/* ---- picture of the numbers -------------------------------------------------------------------------------------- */

/* gnuplot is a stand-in that keeps a copy of its script and writes a word into the picture file that it names. */
static void test_plot(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-record-vulkan_bare", "exit 77");
	write_program("stilb-bench-record-limits", "echo record 2.5");
	write_program("gnuplot", "[ $1 = --version ] && exit\ncp $1 script\n"
	                         "echo drawn >$(sed -n \"s/^set output '\\(.*\\)'$/\\1/p\" $1)");
	char path[PATH_MAX + 32];
	snprintf(path, sizeof path, "PATH=%s:/usr/bin:/bin", stilb_folder);
	assert_int_equal(made_up_code("record --seconds 0.01 --rounds 1 --only write --plot a.png", path), 0);
	assert_int_equal(system("grep -q drawn a.png && grep -q '^-0.20 2.5 2.5 2.5$' script"), 0);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_list),
		FRESH_TEST(test_null_device),
		FRESH_TEST(test_pictures_are_the_same),
		FRESH_TEST(test_pictures_of_other_materials),
		FRESH_TEST(test_wrong_picture),
		FRESH_TEST(test_no_lavapipe),
		FRESH_TEST(test_goals),
		FRESH_TEST(test_plot),
	};
	if (argc != 2 || !realpath(argv[1], programs) || !folder_enter(argv[1], "bench_record")) {
		fprintf(stderr, "usage: test_bench_record STILB-BENCH\n");
		return 2;
	}
	*strrchr(programs, '/') = '\0';
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
