/* stilb-bench gltf: a short run of the real program, which checks its own results; every metric has a value. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const metrics[] = {"tinygltf", "stilb", "of-tinygltf", "of-cpu", "memory"};
	assert_int_equal(stilb_code(NULL, "gltf --goals --case small --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof metrics / sizeof *metrics; i++)
		assert_true(row_median("small", "stilb", metrics[i]) > 0.0);
	assert_said(run.out, "  small ");
	assert_said(run.out, "goal: stilb within 1.2 x of tinygltf");
}

static void test_trouble_is_reported(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-gltf", "echo the import process sent another scene >&2; exit 1");
	assert_int_equal(copy_code(NULL, "gltf --case small --rounds 1 --seconds 0.01"), 1);
	assert_said(run.err, "sent another scene");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_numbers, folder_fresh),
		cmocka_unit_test_setup(test_trouble_is_reported, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_gltf")) {
		fprintf(stderr, "usage: test_bench_gltf STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
