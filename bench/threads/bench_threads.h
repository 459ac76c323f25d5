/* bench_threads: shared by the files of the suite `threads` in stilb-bench. [main-thread] */
#ifndef BENCH_THREADS_H
#define BENCH_THREADS_H

#include "bench/harness/bench.h"

#define BENCH_THREADS_PLOT_ROWS 4
#define BENCH_THREADS_OURS "stilb-workers-"

/* The sweep times the same frame with different numbers of workers: these, ascending; the first is 0. */
#define BENCH_THREADS_MAX_COUNTS 16
extern uint32_t bench_threads_counts[BENCH_THREADS_MAX_COUNTS];
extern size_t bench_threads_count;

/* Fills the two with numbers from 0 to twice the number of CPUs. */
void bench_threads_choose_counts(void);

/* The article (bench_threads.c) compares pools of one and of four workers. Their counterparts on this machine: one
 * worker for each CPU but the main thread's, at least one; and too many, twice the number of CPUs. */
uint32_t bench_threads_fitting(void);
uint32_t bench_threads_too_many(void);

/* The subject's name for a number of workers of the sweep, "stilb-workers-3". */
const char *bench_threads_name(uint32_t workers);

/* The stream hash (stilb_render_stream_hash) that every run must have, for each view of the stress test: all, half or
 * few of its models in the picture. */
extern uint64_t bench_threads_hashes[3];

void bench_threads_report(FILE *out, const bench_results *results);
void bench_threads_plot(FILE *out, const bench_results *results);

#endif
