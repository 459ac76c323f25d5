/* The camera's way through a run of `stilb demo`, a line for each frame: the same bytes whenever a recording is flown
 * headless. */
#ifndef STILB_DEMO_TRACK_H
#define STILB_DEMO_TRACK_H

#include "base/base_file.h"
#include "engine.h"

/* {0}: none is written. */
typedef struct demo_track {
	stilb_file file;
	int64_t begin_us; /* of the first frame */
} demo_track;

stilb_result demo_track_open(demo_track *track, const char *path);
void demo_track_add(demo_track *track, const stilb_engine *engine, const stilb_engine_report *report);

/* The file takes its place. Errors so far come out here. */
stilb_result demo_track_save(demo_track *track);

/* Drops what was not saved. */
void demo_track_finish(demo_track *track);

#endif
