/* stilb-bench bake: a short run of the real program, whose two threads must find what one finds. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	assert_int_equal(
		stilb_code(NULL, "bake --goals --rounds 1 --seconds 0.01 --case unwrap-land,texels-large --json f.json"), 0);
	read_stats("f.json");
	assert_true(row_median("unwrap-land", "stilb", "core") > 0.0 && row_median("unwrap-land", "stilb", "two") > 0.0);
	assert_true(row_median("unwrap-land", "stilb", "stretch") < 1.05);
	assert_true(row_median("unwrap-land", "stilb", "charts") < 20.0);
	assert_true(row_median("texels-large", "stilb", "texels") > 0.0);
	assert_said(run.out, "goal: unwrap-land");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_numbers, folder_fresh)};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_bake")) {
		fprintf(stderr, "usage: test_bench_bake STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
