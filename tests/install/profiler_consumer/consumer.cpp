// The same in C++, with a zone in a template too: g++ cannot keep the static data of that zone in the same section of
// the object file as the data of zones in other functions.
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_stats.h>

#include <cstdio>

template <typename T> static T same(T value)
{
	PROFILE_FUNCTION();
	return value;
}

int main()
{
	stilb_prof_snapshot snapshot = {};
	stilb_prof_stats stats = {};
	unsigned sum = 0;
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	for (unsigned i = 0; i < 1000; i++) {
		PROFILE("add");
		sum += same(i);
	}
	if (stilb_prof_snapshot_take(&snapshot, nullptr) != 0 || stilb_prof_stats_take(&stats, &snapshot, nullptr) != 0)
		return 1;
	if (stats.row_count != 2 || stats.rows[0].calls != 1000)
		return 1;
	std::printf("sum %u\n", sum);
	stilb_prof_stats_finish(&stats);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
