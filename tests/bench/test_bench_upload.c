/* stilb-bench upload: a short run of the real programs, which compare what arrives with what was written; every metric
 * has a value. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const callers[] = {"caller-4k", "caller-64k", "caller-1m"};
	static const char *const images[] = {"image-64", "image-256", "image-1024"};
	assert_int_equal(stilb_code(NULL, "upload --goals --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < 3; i++) {
		assert_true(row_median(callers[i], "stilb", "written") > 0.0);
		assert_true(row_median(callers[i], "memcpy", "written") > 0.0);
		assert_true(row_median(images[i], "stilb", "copied") > 0.0);
		assert_true(row_median(images[i], "vulkan_bare", "copied") > 0.0);
		assert_said(run.out, callers[i]);
		assert_said(run.out, images[i]);
	}
	assert_true(row_median("stream", "stilb", "streamed") > 0.0);
	assert_true(row_median("stream", "stilb", "waits") == 0.0);
	assert_said(run.out, "while 1 GB is streamed");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_numbers, folder_fresh)};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_upload")) {
		fprintf(stderr, "usage: test_bench_upload STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
