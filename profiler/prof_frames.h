/* The lengths of the last 100 frames, also sorted: for percentiles, and to tell which frame is a spike (much longer
 * than the others). */
#ifndef STILB_PROF_FRAMES_H
#define STILB_PROF_FRAMES_H

#include <stdint.h>

#define PROF_WINDOW_FRAMES 100

typedef struct prof_frame_window {
	uint64_t ns[PROF_WINDOW_FRAMES];     /* a ring buffer */
	uint64_t sorted[PROF_WINDOW_FRAMES]; /* the same values, ascending */
	uint32_t count, next;                /* next: index into ns of the next value */
} prof_frame_window;

/* Adds a length in nanoseconds; if the window is full, the oldest one leaves it. */
void prof_frame_window_add(prof_frame_window *window, uint64_t ns);

/* The percentile by nearest rank, percent in 1..100 (asserted); 0 for an empty window. */
uint64_t prof_frame_window_rank(const prof_frame_window *window, uint32_t percent);

/* max(2 x p50, budget): a longer frame is a spike. Infinite while there are fewer than 20 frames. */
double prof_frame_window_limit_ms(const prof_frame_window *window, double budget_ms);

#endif
