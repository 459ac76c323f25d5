/*
 * offline_progress: how far a render is, on stderr: a bar on a terminal, else a plain line every ten seconds.
 * [main-thread], but for offline_progress_clear.
 */
#ifndef STILB_RENDER_PROGRESS_H
#define STILB_RENDER_PROGRESS_H

#include "render_work.h"

typedef struct offline_progress {
	bool terminal;
	uint64_t start_ns, last_ns; /* of all; of the last line */
	uint64_t first_ns;          /* when rendering was seen for the first time, 0: not yet */
	double first_done;          /* share of the work done then: a checkpoint's */
} offline_progress;

void offline_progress_begin(offline_progress *progress);

/* Shows it, where it is time to. */
void offline_progress_show(offline_progress *progress, offline_stage stage, const stilb_gi_progress *at);

/* The samples that there are: "12 samples a pixel", or in the coarse passes "16 samples in 1 of 64 pixels". */
void offline_progress_samples(const stilb_gi_progress *at, char *text, size_t size);

/* The same in words: "42 %, pass 9, 64 samples a pixel, 5.31 Mrays/s, 0:12 left". */
void offline_progress_words(const offline_progress *progress, offline_stage stage, const stilb_gi_progress *at,
                            char *text, size_t size);

/* Takes the bar away, so that a line can stand there. [any-thread] */
void offline_progress_clear(void);

#endif
