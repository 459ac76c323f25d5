/* stilb-bench furnace, which traces paths in a scene of known radiance: short runs of the real program, whose numbers
 * are compared with theory, and a program that fails. */
#include "support/bench_program.h"

#include "bench/furnace/furnace_cases.h"

#include <math.h>

static const char *const subjects[] = {"stilb", "pcg", "rand", "rand-15-bit"};
#define SUBJECT_COUNT (sizeof subjects / sizeof *subjects)

static void test_list(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "--help"), 0);
	assert_said(run.out, "\n  furnace ");
	assert_int_equal(stilb_code(NULL, "furnace --list"), 0);
	for (size_t i = 0; i < SUBJECT_COUNT; i++)
		assert_said(run.out, subjects[i]);
}

/* With cosine-weighted directions paths of n bounces have no variance: for every source of random numbers the share of
 * light lost is exactly the rest of the geometric series of reflections, rho^(n + 1). */
static void test_bounces(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "furnace --case bounces --rounds 1 --seconds 0.02 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < SUBJECT_COUNT; i++)
		for (unsigned n = 0; n <= FURNACE_MOST_BOUNCES; n++) {
			char metric[32];
			snprintf(metric, sizeof metric, "error-%u", n);
			double truth = 100.0 * pow(FURNACE_REFLECTANCE, n + 1);
			assert_true(fabs(row_median("bounces", subjects[i], metric) - truth) <= 1e-3);
		}
	assert_said(run.out, "light lost");
}

static void test_survival(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "furnace --case survival --rounds 1 --seconds 0.02 --json f.json"), 0);
	read_stats("f.json");
	for (size_t i = 0; i < SUBJECT_COUNT; i++) {
		/* 4 experiments of 1,000 paths; furnace_variance gives 2 for survival 50 %, 0.0714 for 95 %. */
		assert_true(fabs(row_median("survival", subjects[i], "variance-50") - 2.0) < 0.4);
		assert_true(fabs(row_median("survival", subjects[i], "variance-95") - furnace_variance(0.95)) < 0.01);
		assert_true(fabs(row_median("survival", subjects[i], "bias-80")) < 2.0);
		assert_true(row_median("survival", subjects[i], "error-50") < 6.0);
	}
	assert_true(row_median("survival", "stilb", "error-95") < 0.5 * row_median("survival", "pcg", "error-95"));
}

static void test_equal_time(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "furnace --case equal-time --rounds 1 --seconds 0.05 --json f.json"), 0);
	read_stats("f.json");
	assert_true(row_median("equal-time", "stilb", "path") > 0.0);
	assert_true(row_median("equal-time", "stilb", "montecarlo-8") > 0.0);
	assert_said(run.out, "x the time of path");
}

static void test_trouble_is_reported(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-furnace", "echo a ray left the ball >&2; exit 1");
	assert_int_equal(copy_code(NULL, "furnace --case bounces --rounds 1 --seconds 0.02"), 1);
	assert_said(run.err, "a ray left the ball");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_list, folder_fresh),
		cmocka_unit_test_setup(test_bounces, folder_fresh),
		cmocka_unit_test_setup(test_survival, folder_fresh),
		cmocka_unit_test_setup(test_equal_time, folder_fresh),
		cmocka_unit_test_setup(test_trouble_is_reported, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_bench_furnace")) {
		fprintf(stderr, "usage: test_bench_furnace STILB-BENCH\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
