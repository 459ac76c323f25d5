/*
 * render_progress: how far a render is, on stderr: a bar where that is a terminal, else a plain line every ten seconds.
 * [main-thread], but for render_progress_clear.
 */
#ifndef STILB_RENDER_PROGRESS_H
#define STILB_RENDER_PROGRESS_H

#include "render_work.h"

typedef struct render_progress {
	bool terminal;
	uint64_t start_ns, last_ns; /* of all; of the last line */
	uint64_t first_ns;          /* when rendering was seen for the first time, 0: not yet */
	double first_done;          /* share of the work done then: a checkpoint's */
} render_progress;

void render_progress_begin(render_progress *progress);

/* Shows it, where it is time to. */
void render_progress_show(render_progress *progress, render_stage stage, const stilb_gi_progress *at);

/* The samples that there are: "12 samples a pixel", or in the coarse passes "16 samples in 1 of 64 pixels". */
void render_progress_samples(const stilb_gi_progress *at, char *text, size_t size);

/* The same in words: "42 %, pass 9, 64 samples a pixel, 5.31 Mrays/s, 0:12 left". */
void render_progress_words(const render_progress *progress, render_stage stage, const stilb_gi_progress *at, char *text,
                           size_t size);

/* Takes the bar away, so that a line can stand there. [any-thread] */
void render_progress_clear(void);

#endif
