/* stilb-bench shade: short runs of the real program, which compares every implementation of a BRDF with its formula in
 * double, and the verdict of the goal for numbers that a stand-in for the program prints. */
#include "support/bench_program.h"

static const char *const names[] = {"wrapped", "phong-modified", "blinn-phong-modified", "minimalist",
                                    "ggx",     "cook-torrance"};

static void test_list(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "--help"), 0);
	assert_said(run.out, "\n  shade ");
	assert_int_equal(stilb_code(NULL, "shade --list"), 0);
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		assert_said(run.out, names[i]);
}

static void test_runs(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "shade --goals --rounds 1 --seconds 0.02 --json s.json"), 0);
	read_stats("s.json");
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		assert_true(row_median(names[i], "stilb", "scalar") > 0.0);
		assert_true(row_median(names[i], "stilb", "hand") > 0.0);
		assert_true(row_median(names[i], "stilb", "limit") > 0.0);
		double error = row_median(names[i], "stilb", "error");
		assert_true(error > 0.0 && error < 20.0);
	}
	assert_said(run.out, "goal: ggx within 1.1 x");
}

/* Asserts that the goal has this verdict if the program prints `ratio` as the ratio of-hand (headers / by hand). */
static void assert_goal(const char *ratio, const char *verdict)
{
	char program[256];
	snprintf(program, sizeof program, "echo scalar 2; echo hand 2; echo limit 1; echo of-hand %s; echo error 1", ratio);
	write_program("stilb-bench-shade", program);
	assert_int_equal(copy_code(NULL, "shade --goals --rounds 1 --seconds 0.02 --case ggx"), 0);
	assert_said(run.out, verdict);
}

static void test_goal(void **state)
{
	(void)state;
	copy_bench();
	assert_goal("1.099", "1.099, met");
	assert_goal("1.101", "1.101, MISSED");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_list, folder_fresh),
		cmocka_unit_test_setup(test_runs, folder_fresh),
		cmocka_unit_test_setup(test_goal, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_shade")) {
		fprintf(stderr, "usage: test_bench_shade STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
