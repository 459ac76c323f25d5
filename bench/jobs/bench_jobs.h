/* bench_jobs: what the files of the suite `jobs` share. */
#ifndef BENCH_JOBS_H
#define BENCH_JOBS_H

#include "bench/harness/bench.h"

#define BENCH_JOBS_PLOT_ROWS 3

/* bench_jobs_report.c: ours beside what it is to be measured by, and a picture of it. */
void bench_jobs_goals(FILE *out, const bench_results *results);
void bench_jobs_plot(FILE *out, const bench_results *results);

#endif
