/*
 * Zones: PROFILE measures the rest of its scope, however the scope is left. A snapshot is what has been recorded so
 * far, as plain data: parents come before their children, and level is the depth.
 *
 * Prints: update( move( ) collide( ) collide( ) )
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

static int collide(int bodies)
{
	PROFILE_FUNCTION();
	if (bodies == 0)
		return 0;
	return bodies - 1;
}

static void update(void)
{
	PROFILE_COLOR("update", 0x3070c0);
	{
		PROFILE("move");
	}
	collide(0);
	collide(1);
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	update();
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		int next = i + 1 < lane->zone_count ? lane->zones[i + 1].level : 0;
		printf("%s%s(", i > 0 ? " " : "", snapshot.labels[lane->zones[i].label].name);
		for (int level = lane->zones[i].level; level >= next; level--)
			printf(" )");
	}
	printf("\n");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
