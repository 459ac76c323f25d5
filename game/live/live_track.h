/*
 * live_track: the camera's path through a live run, a text file with one pose a frame. A gamepad recording
 * that is replayed headless gives the same bytes in every run.
 *
 *   live_track_open -> live_track_add after each frame -> live_track_save -> live_track_finish.   All [main-thread].
 */
#ifndef STILB_LIVE_TRACK_H
#define STILB_LIVE_TRACK_H

#include "base/base_file.h"
#include "engine.h"

/* {0}: no track is wanted. */
typedef struct live_track {
	stilb_file file;
	int64_t begin_us; /* time of the first frame */
} live_track;

/* Begins the file and writes its heading. STILB_ERROR_FILE. */
stilb_result live_track_open(live_track *track, const char *path);

/* Writes a line for the frame that was drawn last; nothing for {0}. An error is kept for live_track_save. */
void live_track_add(live_track *track, const stilb_engine *engine, const stilb_engine_report *report);

/* Puts the complete file in its place. STILB_ERROR_FILE, also for earlier errors. */
stilb_result live_track_save(live_track *track);

/* Discards a file that was not saved. */
void live_track_finish(live_track *track);

#endif
