/* What the files of the suite `threads` share. */
#ifndef BENCH_THREADS_H
#define BENCH_THREADS_H

#include "bench/harness/bench.h"

#define BENCH_THREADS_PLOT_ROWS 4
#define BENCH_THREADS_OURS "stilb-workers-"

/* The counts of workers of the sweep, ascending; the first is 0. */
#define BENCH_THREADS_MAX_COUNTS 16
extern uint32_t bench_threads_counts[BENCH_THREADS_MAX_COUNTS];
extern size_t bench_threads_count;

/* Fills them: 0 to twice the CPUs. */
void bench_threads_choose_counts(void);

/* One worker a CPU beside the main thread, and twice as many workers as CPUs: as the article's one and four. */
uint32_t bench_threads_fitting(void);
uint32_t bench_threads_too_many(void);

/* "stilb-workers-3": constant memory, round and round. */
const char *bench_threads_name(uint32_t workers);

/* The stream hash that every run must have, of each view: all, half, few. */
extern uint64_t bench_threads_hashes[3];

void bench_threads_report(FILE *out, const bench_results *results);
void bench_threads_plot(FILE *out, const bench_results *results);

#endif
