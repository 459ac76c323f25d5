/*
 * Devices: zones that were timed elsewhere, for example by timestamps of a GPU, in a lane of their own. Times are
 * nanoseconds of CLOCK_MONOTONIC; children are recorded before their parents.
 *
 * Prints: GPU: frame 900 us, shadows 300 us, opaque 500 us
 */
#include <stilb/prof.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>
#include <time.h>

STILB_PROF_SITE(site_frame, "frame", 0);
STILB_PROF_SITE(site_shadows, "shadows", 0);
STILB_PROF_SITE(site_opaque, "opaque", 0);

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_lane_handle *gpu;
	struct timespec time;
	if (stilb_prof_lane_create("GPU", &gpu) != 0)
		return 1;
	clock_gettime(CLOCK_MONOTONIC, &time);
	uint64_t now = (uint64_t)time.tv_sec * 1000000000 + (uint64_t)time.tv_nsec; /* when the results were read */
	stilb_prof_lane_zone(gpu, &site_shadows, 1, now + 50000, now + 350000);
	stilb_prof_lane_zone(gpu, &site_opaque, 1, now + 380000, now + 880000);
	stilb_prof_lane_zone(gpu, &site_frame, 0, now, now + 900000);
	if (stilb_prof_snapshot_take(&snapshot, NULL) != 0)
		return 1;
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	printf("%s:", lane->name);
	for (uint32_t i = 0; i < lane->zone_count; i++)
		printf("%s %s %llu us", i > 0 ? "," : "", snapshot.labels[lane->zones[i].label].name,
		       (unsigned long long)(lane->zones[i].end_ns - lane->zones[i].begin_ns) / 1000);
	printf("\n");
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_lane_destroy(gpu);
	stilb_prof_shutdown();
	return 0;
}
