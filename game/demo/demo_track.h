/*
 * demo_track: the camera's path through a run of `stilb demo`, a text file with one pose a frame. A gamepad recording
 * that is replayed headless gives the same bytes in every run.
 *
 *   demo_track_open -> demo_track_add after each frame -> demo_track_save -> demo_track_finish.   All [main-thread].
 */
#ifndef STILB_DEMO_TRACK_H
#define STILB_DEMO_TRACK_H

#include "base/base_file.h"
#include "engine.h"

/* {0}: no track is wanted. */
typedef struct demo_track {
	stilb_file file;
	int64_t begin_us; /* time of the first frame */
} demo_track;

/* Begins the file and writes its heading. STILB_ERROR_FILE. */
stilb_result demo_track_open(demo_track *track, const char *path);

/* Writes a line for the frame that was drawn last; nothing for {0}. An error is kept for demo_track_save. */
void demo_track_add(demo_track *track, const stilb_engine *engine, const stilb_engine_report *report);

/* Puts the complete file in its place. STILB_ERROR_FILE, also for earlier errors. */
stilb_result demo_track_save(demo_track *track);

/* Discards a file that was not saved. */
void demo_track_finish(demo_track *track);

#endif
