/* The frame times of late, in order. */
#ifndef STILB_PROF_FRAMES_H
#define STILB_PROF_FRAMES_H

#include <stdint.h>

#define PROF_WINDOW_FRAMES 100

typedef struct prof_frame_window {
	uint64_t ns[PROF_WINDOW_FRAMES];     /* a ring */
	uint64_t sorted[PROF_WINDOW_FRAMES]; /* the same, ascending */
	uint32_t count, next;
} prof_frame_window;

/* Takes in one more, the oldest goes. */
void prof_frame_window_add(prof_frame_window *window, uint64_t ns);

/* The nearest-rank percentile, 1..100; 0 of an empty window. */
uint64_t prof_frame_window_rank(const prof_frame_window *window, uint32_t percent);

/* max(2 x p50, budget): what is slower is a spike; infinite with too few frames to tell. */
double prof_frame_window_limit_ms(const prof_frame_window *window, double budget_ms);

#endif
