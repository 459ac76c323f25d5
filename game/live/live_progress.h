/*
 * live_progress: a line on the terminal that shows how far a headless run is, so that a long one does not seem to hang.
 * Shows nothing in the first two seconds, and nothing at all if stderr is not a terminal.
 *
 *   live_progress_begin -> live_progress_show after each frame -> live_progress_end.    All [main-thread].
 */
#ifndef STILB_LIVE_PROGRESS_H
#define STILB_LIVE_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct live_progress {
	uint64_t start_ns, last_ns; /* time of the start of the run; time at which the line was last printed */
	bool terminal, shown;
} live_progress;

void live_progress_begin(live_progress *progress);

/* Draws the line if it is time to: `frames` drawn so far, and `wanted`, the number after which the run ends; 0: the run
 * has no fixed number. */
void live_progress_show(live_progress *progress, uint64_t frames, uint64_t wanted);

/* Clears the line. */
void live_progress_end(live_progress *progress);

#endif
