/* Adds up numbers, each inside a zone of the profiler, and prints the sum only if the profiler counted all zones. */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_stats.h>

#include <stdio.h>

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_stats stats = {0};
	unsigned sum = 0;
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	for (unsigned i = 0; i < 1000; i++) {
		PROFILE("add");
		sum += i;
	}
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0 || stilb_prof_stats_take(&stats, &snapshot, NULL) != 0)
		return 1;
	if (stats.row_count != 1 || stats.rows[0].calls != 1000)
		return 1;
	printf("sum %u\n", sum);
	stilb_prof_stats_finish(&stats);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
