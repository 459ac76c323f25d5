/*
 * Steps: PROFILE_NEXT ends one zone and begins the next with a single read of the clock: half the cost, and no gap
 * between them.
 *
 * Prints: 3 steps, gaps between them: 0
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

static volatile uint32_t work;

static void step(void)
{
	for (int i = 0; i < 10000; i++)
		work += 1;
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	PROFILE_BEGIN("load");
	step();
	PROFILE_NEXT("parse");
	step();
	PROFILE_NEXT("link");
	step();
	PROFILE_END();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	uint64_t gaps = 0;
	for (uint32_t i = 1; i < lane->zone_count; i++)
		gaps += lane->zones[i].begin_ns - lane->zones[i - 1].end_ns;
	printf("%u steps, gaps between them: %llu\n", lane->zone_count, (unsigned long long)gaps);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
