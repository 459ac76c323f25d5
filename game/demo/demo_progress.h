/* demo_progress: on a terminal, how far a headless run is, for those who would think that it hangs. Nothing for runs of
 * a second or two, and nothing where stderr is no terminal. [main-thread] */
#ifndef STILB_DEMO_PROGRESS_H
#define STILB_DEMO_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct demo_progress {
	uint64_t start_ns, last_ns;
	bool terminal, shown;
} demo_progress;

void demo_progress_begin(demo_progress *progress);

/* After each frame: frames drawn so far, of so many; wanted is 0 where nobody knows. */
void demo_progress_show(demo_progress *progress, uint64_t frames, uint64_t wanted);

/* The line is taken away. */
void demo_progress_end(demo_progress *progress);

#endif
