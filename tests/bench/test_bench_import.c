/* stilb-bench import: a short run of the real program, which checks its own results; every metric has a value. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const metrics[] = {"libpng", "libpng-kept", "stilb", "of-libpng", "of-libpng-kept"};
	assert_int_equal(stilb_code(NULL, "import --goals --case noise,palette --rounds 1 --seconds 0.01 --json f.json"),
	                 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof metrics / sizeof *metrics; i++) {
		assert_true(row_median("noise", "stilb", metrics[i]) > 0.0);
		assert_true(row_median("palette", "stilb", metrics[i]) > 0.0);
	}
	assert_said(run.out, "  noise ");
	assert_said(run.out, "goal: stilb within 1.1 x of libpng");
}

static void test_trouble_is_reported(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-import", "echo the import process gave other pixels >&2; exit 1");
	assert_int_equal(copy_code(NULL, "import --case rgb --rounds 1 --seconds 0.01"), 1);
	assert_said(run.err, "gave other pixels");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_numbers, folder_fresh),
		cmocka_unit_test_setup(test_trouble_is_reported, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_import")) {
		fprintf(stderr, "usage: test_bench_import STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
