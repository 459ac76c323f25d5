/*
 * stage_times: how long each stage of each frame of a run took, and the statistics of that.
 *
 *   stage_times times = {0};
 *   stage_times_add(&times, &report.times);              after each frame
 *   stage_times_last_gpu(&times, gpu_ms);                once the device has finished
 *   stage_times_summarise(&times, summary, &warmup);
 *   stage_times_finish(&times);
 *
 * Threads.  All [one-writer].
 */
#ifndef STILB_STAGE_TIMES_H
#define STILB_STAGE_TIMES_H

#include "engine.h"

typedef enum stage {
	STAGE_FRAME, /* the whole frame */
	STAGE_CULL,
	STAGE_RECORD,
	STAGE_UI,
	STAGE_REPLAY,
	STAGE_PRESENT,
	STAGE_GPU, /* the device's own time; 0: not known for this frame */
	STAGE_PAD, /* not a stage: age of the newest gamepad report when the draws went to the device; 0: no report */
	STAGE_COUNT
} stage;

/* The names in reports and JSON, by stage. */
extern const char *const stage_names[STAGE_COUNT];

/* Only this many of the latest frames are kept, so that the memory of an endless run does not grow: 32 MB. */
#define STAGE_TIMES_MAX 1000000u

/* The times of the frames of a run; {0} has none. */
typedef struct stage_times {
	float (*frames)[STAGE_COUNT]; /* milliseconds; a ring of `capacity` frames */
	uint64_t count;               /* frames added, also those overwritten since */
	uint32_t capacity;
} stage_times;

/* The times of one stage over the frames, milliseconds. p99: 99 % of the frames took at most that long. */
typedef struct stage_summary {
	double median, p99, min;
} stage_summary;

/* Adds a frame. False: out of memory, the frame is not kept. */
bool stage_times_add(stage_times *times, const stilb_engine_times *frame);

/* Sets the device's time of the frame that was added last: it is known only after the device has finished. Does nothing
 * if there is no frame. */
void stage_times_last_gpu(stage_times *times, double ms);

/* Summarises all kept frames but the first tenth of the run, its warm-up, whose length goes to *warmup. A stage without
 * frames is all 0; frames for which STAGE_GPU or STAGE_PAD is not known (0) are left out of its summary. Quantiles are
 * by nearest rank. False: out of memory, and the summary is all 0. */
bool stage_times_summarise(const stage_times *times, stage_summary summary[STAGE_COUNT], uint64_t *warmup);

/* Frees the frames; times is {0} again. */
void stage_times_finish(stage_times *times);

#endif
