/* prof.h in C++17: compiled by the C++ compiler of the build, read back here. */
#include "support/test.h"
#include "test_prof_records.h"

int test_prof_cpp_zones(void);
void test_prof_cpp_never(void);

/* The number of sites of that name that stilb_prof_site_next gives. */
static int listed(const char *name)
{
	int count = 0;
	for (const stilb_prof_site *site = stilb_prof_site_next(NULL); site; site = stilb_prof_site_next(site))
		count += strcmp(site->name, name) == 0;
	return count;
}

static void zones_of_cpp_code(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		int sites;
		uint64_t events;
	} expected[] = {
		{"plain", 1, 1},        {"cpp hook", 1, 1}, {"throws", 1, 1},   {"catch", 1, 1},         {"template", 2, 2},
		{"template too", 2, 2}, {"inline", 1, 2},   {"in_class", 1, 1}, {"lambda", 1, 1},        {"begun", 1, 1},
		{"next", 1, 1},         {"precise", 1, 1},  {"counter", 1, 1},  {"instant", 1, 1},       {"cpp flow", 2, 2},
		{"local hook", 1, 1},   {"made", 1, 1},     {"never", 0, 0},    {"static member", 1, 1},
	};
	prof_copy copy = {0};
	uint64_t events = 0;
	assert_int_equal(listed("cpp hook"), 1); /* a site outside of functions is listed before main */
	assert_int_equal(listed("plain"), 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	assert_int_equal(test_prof_cpp_zones(), 2 + 3 + 3 + 3 + 4 + 5);
	assert_int_equal(stilb_prof_thread_ring->depth, 0); /* after an exception too */
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
		if (record_count(&copy, 0, expected[i].name) != expected[i].events ||
		    listed(expected[i].name) != expected[i].sites)
			fail_msg("%s: %d events, %d sites", expected[i].name, (int)record_count(&copy, 0, expected[i].name),
			         listed(expected[i].name));
		events += expected[i].events;
	}
	assert_int_equal(copy.lanes[0].event_count, events);
	prof_copy_free(&copy);
	stilb_prof_shutdown();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(zones_of_cpp_code),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
