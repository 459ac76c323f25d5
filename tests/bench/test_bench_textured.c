/* stilb-bench textured: a short run of the real program, which compares the engine's picture with the plain program's;
 * every subject has values. */
#include "bench/textured/textured_cases.h"
#include "support/bench_program.h"

static const char *const subjects[] = {"stilb",
#define NAME(ID, identifier, subject, ...) subject,
                                       TEXTURED_VARIANTS(NAME)
#undef NAME
};

static void test_numbers(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "textured --goals --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++) {
		assert_true(row_median("helmet", subjects[i], "cpu") > 0.0);
		assert_true(row_median("helmet", subjects[i], "frame") > 0.0);
	}
	assert_true(row_median("helmet", "stilb", "rms") > 0.0);
	assert_said(run.out, "stilb / vulkan-bare");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_numbers, folder_fresh)};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_textured")) {
		fprintf(stderr, "usage: test_bench_textured STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
