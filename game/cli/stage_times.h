/* The stage times of a run's frames, and their medians. */
#ifndef STILB_STAGE_TIMES_H
#define STILB_STAGE_TIMES_H

#include "engine.h"

typedef enum stage {
	STAGE_FRAME,
	STAGE_CULL,
	STAGE_RECORD,
	STAGE_UI,
	STAGE_REPLAY,
	STAGE_PRESENT,
	STAGE_GPU,
	STAGE_PAD, /* no stage: a gamepad's report until then */
	STAGE_COUNT
} stage;

extern const char *const stage_names[STAGE_COUNT];

/* At most this many frames are kept, the latest ones: an endless run does not grow. */
#define STAGE_TIMES_MAX 1000000u

typedef struct stage_times {
	float (*frames)[STAGE_COUNT]; /* milliseconds; a ring */
	uint64_t count;               /* frames added */
	uint32_t capacity;
} stage_times;

/* Milliseconds. */
typedef struct stage_summary {
	double median, p99, min;
} stage_summary;

/* false: out of memory, the frame is not kept. */
bool stage_times_add(stage_times *times, const stilb_engine_times *frame);

/* The device's time of a frame comes some frames late: this is the last one's. */
void stage_times_last_gpu(stage_times *times, double ms);

/* Over all frames kept but the run's first tenth (warm-up); zeros when there are none. Frames whose time on the device
 * is not known do not count there, nor do those without a gamepad's report. false: out of memory. */
bool stage_times_summarise(const stage_times *times, stage_summary summary[STAGE_COUNT], uint64_t *warmup);

void stage_times_finish(stage_times *times);

#endif
