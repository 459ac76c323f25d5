/*
 * threads_run: shared by the files of the program stilb-bench-threads, which makes one run: one subject (the engine or
 * a pool to compare it with) in one case (a workload). DEVICE is vulkan or null; VIEW tells how many models are in the
 * picture: all, half or few; N is the number of workers.
 *
 *   case              subject           run                                           file
 *   DEVICE-VIEW       stilb-workers-N   the engine's frame with N workers             threads_engine.c
 *   one-vs-four       stilb-workers-N   the same                                      threads_engine.c
 *   one-vs-four       sutter-N          the article's pool                            threads_queue.c
 *   dedicated         dedicated         one render thread behind a queue              threads_dedicated.c
 *   mutex-vs-lowlock  a queue           recording jobs that go through that queue     threads_queue.c
 *   stolen            stilb-workers-N   another process occupies a CPU for a while    threads_engine.c
 *   white-bar         stilb-REPLAY      Vulkan, by replay mode                        threads_engine.c
 *
 * Every run draws the stress test of 10,000 models, and fails if its command stream differs from that of the null
 * device without workers. Errors end the program. [main-thread] unless a function says otherwise.
 */
#ifndef BENCH_THREADS_RUN_H
#define BENCH_THREADS_RUN_H

#include "bench/harness/bench_child.h"
#include "render/render.h"
#include "scene/scene.h"

#include <stdbool.h>

#define THREADS_MODELS 10000u
#define THREADS_SEED 1u
#define THREADS_VIEWS 3u        /* number of views in stilb_scene_stress_view */
#define THREADS_LEAST_FRAMES 2u /* measured in every run, however long they take */
#define THREADS_CALM_FRAMES 2u  /* frames not measured after a timeline was written, which leaves cold caches */

extern const char *const threads_view_names[THREADS_VIEWS];

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* A growing list of times in ms. {0} is empty. */
typedef struct threads_series {
	double *at;
	uint32_t count, capacity;
} threads_series;

void threads_series_add(threads_series *series, double ms);
/* The quantile `part` of times [first, end): 0 the least, 1 the largest; 0 if there is none. */
double threads_series_part(const threads_series *series, uint32_t first, uint32_t end, double part);
/* The quantile of all times. */
double threads_series_quantile(const threads_series *series, double part);

/* Prints the metrics frame (the median), p99 and worst. */
void threads_print_frames(const threads_series *frames);

/* ---- a run ------------------------------------------------------------------------------------------------------- */

/* CPU time and involuntary context switches of the process so far. */
typedef struct threads_usage {
	double cpu_ms;
	double switched_out;
} threads_usage;

threads_usage threads_usage_now(void);

typedef struct threads_run {
	bench_child child;
	uint64_t hash[THREADS_VIEWS]; /* stream hashes that every run must have */
	const char *trace;            /* file for the timeline of the slowest frame, or NULL */
	double worst_ms;              /* time of the slowest measured frame so far */
	uint32_t calm;                /* number of next frames that are not measured */
	uint64_t begin_ns, end_ns;    /* start and planned end of the measured time, as bench_child_now_ns counts */
} threads_run;

/* Frames are measured from now on. */
void threads_run_begin(threads_run *run);

/* Call it at the end of a frame that took ms. Writes the timeline if the frame is the slowest so far. False: the frame
 * is not to be measured. Called by the thread that marks the profiler's frames. */
bool threads_run_frame(threads_run *run, double ms);

/* True if the run's time is over and `frames`, the number measured, is at least THREADS_LEAST_FRAMES. */
bool threads_run_over(const threads_run *run, uint32_t frames);

void threads_run_check(const threads_run *run, stilb_scene_stress_view view, uint64_t hash);

/* ---- the runs ---------------------------------------------------------------------------------------------------- */

/* Settings of the engine that a run changes. */
typedef struct threads_setup {
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_scene_stress_view view;
	uint32_t workers;
} threads_setup;

void threads_run_engine(threads_run *run, const threads_setup *setup);
void threads_run_stolen(threads_run *run, uint32_t workers);
void threads_run_dedicated(threads_run *run);
/* kind: the name of a queue, or "no-queue". cost_of_2009: draws cost what they did in the article. */
void threads_run_queue(threads_run *run, const char *kind, uint32_t workers, bool cost_of_2009, uint32_t draws_an_item);

#endif
