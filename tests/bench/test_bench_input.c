/* stilb-bench input: short runs of the real program, which checks its own results; every metric has a value. */
#include "support/bench_program.h"

static void test_numbers(void **state)
{
	(void)state;
	static const char *const numbers[][2] = {
		{"parse", "joystick"}, {"parse", "pad"},        {"parse", "fullest"}, {"find", "known"},
		{"find", "fields"},    {"decode", "usb"},       {"decode", "crc"},    {"decode", "bluetooth"},
		{"frame", "idle"},     {"frame", "reports-16"}, {"camera", "frame"},  {"frame", "reports-500"},
	};
	assert_int_equal(stilb_code(NULL, "input --goals --rounds 1 --seconds 0.01 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
		assert_true(row_median(numbers[i][0], "stilb", numbers[i][1]) > 0.0);
	assert_said(run.out, "a descriptor of 625 bytes");
}

static void test_trouble_is_reported(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-input", "echo the report is wrong >&2; exit 1");
	assert_int_equal(copy_code(NULL, "input --case decode --rounds 1 --seconds 0.01"), 1);
	assert_said(run.err, "the report is wrong");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_numbers, folder_fresh),
		cmocka_unit_test_setup(test_trouble_is_reported, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_input")) {
		fprintf(stderr, "usage: test_bench_input STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
