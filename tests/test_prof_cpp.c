/* prof.h in C++17: compiled by the C++ compiler of the build, read back here. */
#include "test_prof_capture.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

int test_prof_cpp_zones(void);

static void zones_of_cpp_code(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		uint64_t zones;
	} expected[] = {
		{"plain", 1},        {"cpp hook", 1}, {"throws", 1},   {"catch", 1},  {"template", 2},
		{"template too", 2}, {"inline", 1},   {"in_class", 1}, {"lambda", 1},
	};
	capture c;
	uint64_t zones = 0;
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	assert_int_equal(test_prof_cpp_zones(), 2 + 3 + 3 + 4 + 5);
	assert_int_equal(stilb_prof_thread_ring->depth, 0); /* after an exception too */
	assert_trace(&c, 0);
	for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
		assert_int_equal(trace_check_zones(&c.report, "main", expected[i].name), expected[i].zones);
		zones += expected[i].zones;
	}
	assert_int_equal(c.report.zones, zones);
	capture_finish(&c);
	stilb_prof_shutdown();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(zones_of_cpp_code),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
