/*
 * Frames: one call per frame marks them. A snapshot can be limited to the last frames, which is cheap enough to take
 * and draw one in every frame. Lengths of frames are also available by themselves.
 *
 * Prints: 50 zones in 10 frames, all charged to them: yes; 99 frame times held
 */
#include <stilb/prof.h>
#include <stilb/prof_capture.h>
#include <stilb/prof_snapshot.h>

#include <stdio.h>

static void frame(void)
{
	PROFILE("frame");
	for (int i = 0; i < 4; i++) {
		PROFILE("draw");
	}
}

int main(void)
{
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_window window = {.last_frames = 10};
	stilb_prof_frame_stats times;
	if (stilb_prof_thread_begin("main") != 0)
		return 1;
	for (int i = 0; i < 99; i++) {
		stilb_prof_frame_mark();
		frame();
	}
	stilb_prof_frame_mark(); /* ends the last one */
	if (stilb_prof_snapshot_take(&snapshot, &window) != 0)
		return 1;
	const stilb_prof_lane *lane = &snapshot.lanes[0];
	uint32_t charged = 0;
	for (uint32_t i = 0; i < lane->zone_count; i++)
		charged += lane->zones[i].frame < snapshot.frame_count;
	stilb_prof_frame_stats_take(&times, 16.7);
	printf("%u zones in %u frames, all charged to them: %s; %u frame times held\n", lane->zone_count,
	       snapshot.frame_count, charged == lane->zone_count ? "yes" : "no", times.count);
	stilb_prof_snapshot_finish(&snapshot);
	stilb_prof_shutdown();
	return 0;
}
