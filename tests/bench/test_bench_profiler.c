/* stilb-bench profiler: short runs of the real programs, which check their own results, and the verdicts (met, MISSED)
 * of goals for numbers that stand-ins for the programs print. */
#include "support/bench_program.h"

static void test_list(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "--help"), 0);
	assert_said(run.out, "\n  profiler ");
	assert_int_equal(stilb_code(NULL, "profiler --list"), 0);
	static const char *const words[] = {"stilb", "microprofile", "rdtsc",   "clock_gettime", "zone", "next",
	                                    "work",  "off",          "capture", "file",          "live", "switches"};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++)
		assert_said(run.out, words[i]);
}

/* Each program fails if its profiler did not record all zones, or recorded zones while recording was off. */
static void test_runs(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "profiler --goals --rounds 1 --seconds 0.05 --only stilb,rdtsc --json p.json "
	                                  "--case zone,next,precise,work,off,frame,live,switches"),
	                 0);
	read_stats("p.json");
	double zone = row_median("zone", "stilb", "of-pair"), limit = row_median("zone", "rdtsc", "of-pair");
	assert_true(zone > 0.5 && limit > 0.5);
	assert_true(row_median("next", "stilb", "zone") > 0.0 && row_median("precise", "stilb", "zone") > 0.0);
	assert_true(row_median("work", "stilb", "with") > 0.0 && row_median("off", "stilb", "with") > 0.0);
	assert_true(row_median("frame", "stilb", "mark") > 0.0 && row_median("live", "stilb", "snapshot") > 0.0);
	assert_said(run.out, "empty zone / two rdtsc");
	assert_said(run.out, "added while off");
}

/* Asserts that the line of a goal has the verdict, "met" or "MISSED". */
static void assert_goal(const char *what, const char *verdict)
{
	const char *goals = strstr(run.out, "\ngoals, "), *line = goals ? strstr(goals, what) : NULL;
	assert_non_null(line);
	char text[256];
	snprintf(text, sizeof text, "%.*s", (int)strcspn(line, "\n"), line);
	if (!strstr(text, verdict))
		print_error("%s\n", text);
	assert_non_null(strstr(text, verdict));
}

static void test_goals(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-profiler-own", "case $2 in\n"
	                                          "zone) echo pair 20; echo zone 20.6; echo of-pair 1.03 ;;\n"
	                                          "next) echo pair 20; echo zone 10; echo of-pair 0.5 ;;\n"
	                                          "switches) echo kernel 10; echo seen 9; echo of-kernel 0.9 ;;\n"
	                                          "live) echo snapshot 100 ;;\n"
	                                          "esac");
	int code =
		copy_code(NULL, "profiler --goals --rounds 1 --seconds 0.05 --only stilb --case zone,next,switches,live");
	assert_int_equal(code, 0);
	assert_goal("empty zone / two rdtsc", "MISSED");
	assert_goal("PROFILE_NEXT / two rdtsc", "met");
	assert_goal("context switches seen", "MISSED");
	assert_goal("snapshot for an overlay", "met");
	assert_null(strstr(run.out, "added while off"));
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_list, folder_fresh),
		cmocka_unit_test_setup(test_runs, folder_fresh),
		cmocka_unit_test_setup(test_goals, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_profiler")) {
		fprintf(stderr, "usage: test_bench_profiler STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
