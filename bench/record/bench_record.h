/* bench_record: shared by the files of the suite `record`. [main-thread] */
#ifndef BENCH_RECORD_H
#define BENCH_RECORD_H

#include "bench/harness/bench.h"

#define BENCH_RECORD_PLOT_ROWS 2

/* bench_suite.goals and .plot of the suite; bench_record_report.c. */
void bench_record_goals(FILE *out, const bench_results *results);
void bench_record_plot(FILE *out, const bench_results *results);

#endif
