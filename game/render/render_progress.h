/*
 * offline_progress: shows on stderr how far a render is: as a bar on a terminal, else as a line every ten seconds.
 *
 *   offline_progress_begin -> offline_progress_show again and again -> offline_progress_clear, on a terminal.
 *
 * Threads.  All [main-thread], but for offline_progress_clear and offline_progress_samples, which are [any-thread].
 */
#ifndef STILB_RENDER_PROGRESS_H
#define STILB_RENDER_PROGRESS_H

#include "render_work.h"

typedef struct offline_progress {
	bool terminal;    /* stderr is a terminal that can redraw a line */
	uint64_t last_ns; /* time of the last bar or line */
	/* The time, and the share of the render that was done, 0..1, when the stage RENDER_RENDERING was first seen. The
	 * time left is estimated from the progress since then: the share that a resumed checkpoint brought took no time of
	 * this run. first_ns is 0 until then. */
	uint64_t first_ns;
	double first_done;
} offline_progress;

void offline_progress_begin(offline_progress *progress);

/* Draws the bar or prints the line if it is time to. */
void offline_progress_show(offline_progress *progress, offline_stage stage, const stilb_gi_progress *at);

/* Writes which pixels have how many samples: "16 samples a pixel, 32 in 42 % of them", in the coarse passes "16 samples
 * in 1 of 64 pixels", in a picture of parts "64 samples in 42 % of the pixels".
 * size is that of text, at least 64. */
void offline_progress_samples(const stilb_gi_progress *at, char *text, size_t size);

/* Writes the whole state: "42 %, pass 9, 64 samples a pixel, 5.31 Mrays/s, 0:12 left". size is that of text, at least
 * 160. */
void offline_progress_words(const offline_progress *progress, offline_stage stage, const stilb_gi_progress *at,
                            char *text, size_t size);

/* Clears the bar, so that a message can be printed in its place; without a terminal does nothing. [any-thread] */
void offline_progress_clear(void);

#endif
