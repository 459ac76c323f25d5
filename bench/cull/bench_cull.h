/* bench_cull: shared by the files of the suite `cull`. [main-thread] */
#ifndef BENCH_CULL_H
#define BENCH_CULL_H

#include "bench/harness/bench.h"

#define BENCH_CULL_PLOT_ROWS 2

/* bench_suite.report (one table for all cases), .goals and .plot of the suite; bench_cull_report.c. */
void bench_cull_report(FILE *out, const bench_results *results);
void bench_cull_goals(FILE *out, const bench_results *results);
void bench_cull_plot(FILE *out, const bench_results *results);

#endif
