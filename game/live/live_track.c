#include "live_track.h"

#include <inttypes.h>
#include <string.h>

stilb_result live_track_open(live_track *track, const char *path)
{
	static const char head[] = "# frame, time in microseconds, position in metres, yaw and pitch in radians\n";
	stilb_result result = stilb_file_open(&track->file, path);
	if (result == STILB_OK)
		stilb_file_write(&track->file, head, strlen(head)); /* an error is kept for stilb_file_commit */
	return result;
}

void live_track_add(live_track *track, const stilb_engine *engine, const stilb_engine_report *report)
{
	if (!track->file.path)
		return;
	STILB_ASSERT(report->drawn);
	stilb_input_pose pose = stilb_engine_pose(engine);
	char line[160];
	if (report->frame == 1)
		track->begin_us = report->time_us;
	/* %.9g gives different floats different digits. */
	int length = snprintf(line, sizeof line, "%" PRIu64 " %" PRId64 " %.9g %.9g %.9g %.9g %.9g\n", report->frame,
	                      report->time_us - track->begin_us, (double)pose.position[0], (double)pose.position[1],
	                      (double)pose.position[2], (double)pose.yaw, (double)pose.pitch);
	STILB_ASSERT(length > 0 && (size_t)length < sizeof line);
	stilb_file_write(&track->file, line, (size_t)length);
}

stilb_result live_track_save(live_track *track)
{
	return stilb_file_commit(&track->file);
}

void live_track_finish(live_track *track)
{
	stilb_file_finish(&track->file);
}
