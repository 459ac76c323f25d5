/* stilb-bench prefilter: a short run of the real program, which compares both cubes; errors are small. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const names[] = {"panorama-1024", "cube-256"};
	static const char *const errors[] = {"error-1", "error-2", "error-3", "error-4", "error-5", "error-6"};
	assert_int_equal(stilb_code(NULL, "prefilter --goals --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		assert_true(row_median(names[i], "stilb", "core") > 0.0 && row_median(names[i], "stilb", "two") > 0.0);
		assert_true(row_median(names[i], "stilb", "speedup") > 0.0 && row_median(names[i], "stilb", "texel") > 0.0);
	}
	for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
		assert_true(row_median("panorama-1024", "stilb", errors[i]) < (i == 0 ? 1.0 : 0.2));
	assert_said(run.out, "of quadrature");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_numbers, folder_fresh)};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_prefilter")) {
		fprintf(stderr, "usage: test_bench_prefilter STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
