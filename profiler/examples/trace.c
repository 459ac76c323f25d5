/*
 * Traces: writes a snapshot to files for Perfetto or speedscope (.json), flame graphs (.folded) and spreadsheets
 * (.csv), and reads the first one back, exact to the nanosecond.
 *
 * Prints: written and read back: 300 zones in 100 frames, the same times: yes
 */
#include <stilb/prof.h>
#include <stilb/prof_read.h>
#include <stilb/prof_snapshot.h>
#include <stilb/prof_trace.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void run(void)
{
	for (int i = 0; i < 101; i++) {
		stilb_prof_frame_mark();
		if (i == 100)
			break;
		PROFILE("frame");
		PROFILE("cull");
		PROFILE_NEXT("draw");
	}
}

static bool same(const stilb_prof_lane *a, const stilb_prof_lane *b)
{
	uint32_t equal = 0;
	for (uint32_t i = 0; i < a->zone_count && i < b->zone_count; i++)
		equal += a->zones[i].begin_ns == b->zones[i].begin_ns && a->zones[i].end_ns == b->zones[i].end_ns;
	return equal == a->zone_count && equal == b->zone_count;
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0}, again = {0};
	char folder[] = "/tmp/stilb-trace-XXXXXX", path[3][64], error[256];
	const char *names[] = {"run.json", "run.folded", "run.csv"};
	if (!mkdtemp(folder) || stilb_prof_thread_begin("main") != 0)
		return 1;
	run();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	for (int i = 0; i < 3; i++) {
		snprintf(path[i], sizeof path[i], "%s/%s", folder, names[i]);
		int failed = stilb_prof_trace_save(&snapshot, "example", path[i]);
		if (failed != 0)
			fprintf(stderr, "%s: %s\n", path[i], strerror(-failed));
	}
	if (stilb_prof_trace_read(path[0], &again, error, sizeof error) != 0)
		fprintf(stderr, "%s\n", error);
	else
		printf("written and read back: %u zones in %u frames, the same times: %s\n", again.lanes[0].zone_count,
		       again.frame_count, same(&snapshot.lanes[0], &again.lanes[0]) ? "yes" : "no");
	for (int i = 0; i < 3; i++)
		unlink(path[i]);
	rmdir(folder);
	stilb_prof_snapshot_finish(&again);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
