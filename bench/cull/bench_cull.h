/* bench_cull: what the files of the suite `cull` share. */
#ifndef BENCH_CULL_H
#define BENCH_CULL_H

#include "bench/harness/bench.h"

#define BENCH_CULL_PLOT_ROWS 2

/* bench_cull_report.c: one table for all cases, the goals beside what was measured, and a picture. */
void bench_cull_report(FILE *out, const bench_results *results);
void bench_cull_goals(FILE *out, const bench_results *results);
void bench_cull_plot(FILE *out, const bench_results *results);

#endif
