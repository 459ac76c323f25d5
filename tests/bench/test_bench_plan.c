/* stilb-bench plan: a short run of the real program, which checks its own plans; every metric has a value. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const names[] = {"passes-10", "passes-100", "passes-1000"};
	assert_int_equal(stilb_code(NULL, "plan --goals --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		static const char *const metrics[] = {"same", "program", "new", "same-run", "program-run", "new-run"};
		for (size_t m = 0; m < sizeof metrics / sizeof *metrics; m++)
			assert_true(row_median(names[i], "stilb", metrics[m]) > 0.0);
	}
	assert_true(row_median("passes-1000", "stilb", "barriers") == 2000.0);
	assert_said(run.out, "a pass of 1,000");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_numbers, folder_fresh)};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_plan")) {
		fprintf(stderr, "usage: test_bench_plan STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
