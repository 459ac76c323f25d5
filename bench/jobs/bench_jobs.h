/* bench_jobs: shared by the files of the suite `jobs`. [main-thread] */
#ifndef BENCH_JOBS_H
#define BENCH_JOBS_H

#include "bench/harness/bench.h"

#define BENCH_JOBS_PLOT_ROWS 3

/* bench_suite.goals and .plot of the suite; bench_jobs_report.c. */
void bench_jobs_goals(FILE *out, const bench_results *results);
void bench_jobs_plot(FILE *out, const bench_results *results);

#endif
