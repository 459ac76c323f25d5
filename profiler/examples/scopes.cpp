/*
 * C++: the same macros in templates, member functions and lambdas; an exception ends a zone like a return.
 *
 * Prints: parse: 2 zones, lambda: 1, throws: 1, catch: 1, still open: 0
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <cstdio>
#include <cstring>
#include <stdexcept>

template <typename T> static T parse(T value)
{
	PROFILE_FUNCTION();
	return value;
}

static void throws()
{
	PROFILE("throws");
	throw std::runtime_error("out");
}

static unsigned count(const stilb_prof_snapshot &snapshot, const char *name)
{
	unsigned zones = 0;
	for (uint32_t i = 0; i < snapshot.lanes[0].zone_count; i++)
		zones += std::strcmp(snapshot.labels[snapshot.lanes[0].zones[i].label].name, name) == 0;
	return zones;
}

int main()
{
	stilb_prof_snapshot snapshot = {};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	parse(1);
	parse(2.0);
	const auto lambda = [] { PROFILE("lambda"); };
	lambda();
	try {
		throws();
	} catch (const std::runtime_error &) {
		PROFILE("catch");
	}
	if (stilb_prof_snapshot_take(&snapshot, nullptr) != 0)
		return 1;
	unsigned open = 0;
	for (uint32_t i = 0; i < snapshot.lanes[0].zone_count; i++)
		open += snapshot.lanes[0].zones[i].open;
	std::printf("parse: %u zones, lambda: %u, throws: %u, catch: %u, still open: %u\n", count(snapshot, "parse"),
	            count(snapshot, "lambda"), count(snapshot, "throws"), count(snapshot, "catch"), open);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
