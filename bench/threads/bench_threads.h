/* What the files of the suite `threads` share. */
#ifndef BENCH_THREADS_H
#define BENCH_THREADS_H

#include "bench/harness/bench.h"

#define BENCH_THREADS_PLOT_ROWS 4
#define BENCH_THREADS_OURS "stilb-workers-"

/* The counts of workers of the sweep, ascending; the first is 0. */
extern uint32_t bench_threads_counts[];
extern size_t bench_threads_count;
/* One worker a CPU beside the main thread, and twice as many workers as CPUs: as the article's one and four. */
uint32_t bench_threads_fitting(void);
uint32_t bench_threads_too_many(void);

/* "stilb-workers-3": constant memory, round and round. */
const char *bench_threads_name(uint32_t workers);

/* Of each view, what every run had. */
uint64_t bench_threads_hash(size_t view);

void bench_threads_report(FILE *out, const bench_results *results);
void bench_threads_plot(FILE *out, const bench_results *results);

#endif
