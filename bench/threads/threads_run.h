/*
 * threads_run: what the runs of the suite `threads` share. The program stilb-bench-threads makes one run: one subject
 * in one case, by name.
 *
 *   case              subject           what is run
 *   DEVICE-VIEW       stilb-workers-N   the engine's frame with N workers             threads_engine.c
 *   one-vs-four       stilb-workers-N   the same; sutter-N: the article's pool        threads_engine.c, threads_queue.c
 *   dedicated         dedicated         one render thread, fed every object           threads_dedicated.c
 *   mutex-vs-lowlock  a queue           recording jobs that go through that queue     threads_queue.c
 *   stolen            stilb-workers-N   another process takes a core for a while      threads_engine.c
 *   white-bar         stilb-REPLAY      Vulkan, by mode of replay                     threads_engine.c
 *
 * Every run draws the stress test of 10,000 models and fails when its command stream is not the one that the null
 * device is given without workers.
 */
#ifndef BENCH_THREADS_RUN_H
#define BENCH_THREADS_RUN_H

#include "bench/harness/bench_child.h"
#include "render/render.h"
#include "scene/scene.h"

#include <stdbool.h>

#define THREADS_MODELS 10000u
#define THREADS_SEED 1u
#define THREADS_VIEWS 3u        /* of stilb_scene_stress_view */
#define THREADS_LEAST_FRAMES 2u /* measured, however long they take */
#define THREADS_CALM_FRAMES 2u  /* not counted after a trace was written: it leaves cold caches behind */

extern const char *const threads_view_names[THREADS_VIEWS];

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Times, milliseconds. {0} is empty. */
typedef struct threads_series {
	double *at;
	uint32_t count, capacity;
} threads_series;

void threads_series_add(threads_series *series, double ms);
/* Below it lies that part of times [first, end); 0 is the least, 1 the largest; 0 when there is none. */
double threads_series_part(const threads_series *series, uint32_t first, uint32_t end, double part);
/* Of all of them. */
double threads_series_quantile(const threads_series *series, double part);

/* Prints frame (the median), p99 and worst. */
void threads_print_frames(const threads_series *frames);

/* ---- a run ------------------------------------------------------------------------------------------------------- */

/* CPU time and involuntary switches of the process so far. */
typedef struct threads_usage {
	double cpu_ms;
	double switched_out;
} threads_usage;

threads_usage threads_usage_now(void);

typedef struct threads_run {
	bench_child child;
	uint64_t hash[THREADS_VIEWS]; /* of the command stream that every run must have */
	const char *trace;            /* file for the timeline of the worst frame, or NULL */
	double worst_ms;              /* of the frames counted so far */
	uint32_t calm;                /* frames that are not counted yet */
	uint64_t begin_ns, end_ns;    /* of what is measured */
} threads_run;

/* Frames count from now on. */
void threads_run_begin(threads_run *run);

/* Another frame has ended, and took ms. Writes its timeline when it is the worst so far; false: it does not count. On
 * the thread that marks the profiler's frames. */
bool threads_run_frame(threads_run *run, double ms);

/* Are these frames enough? */
bool threads_run_over(const threads_run *run, uint32_t frames);

void threads_run_check(const threads_run *run, stilb_scene_stress_view view, uint64_t hash);

/* ---- what is run ------------------------------------------------------------------------------------------------- */

/* What of the engine's frame is not as usual. */
typedef struct threads_setup {
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_scene_stress_view view;
	uint32_t workers;
} threads_setup;

void threads_run_engine(threads_run *run, const threads_setup *setup);
void threads_run_stolen(threads_run *run, uint32_t workers);
void threads_run_dedicated(threads_run *run);
/* kind: a queue, or "no-queue": one thread does it all. */
void threads_run_queue(threads_run *run, const char *kind, uint32_t workers, bool cost_of_2009, uint32_t draws_an_item);

#endif
