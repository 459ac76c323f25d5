/* bench_record: what the files of the suite `record` share. */
#ifndef BENCH_RECORD_H
#define BENCH_RECORD_H

#include "bench/harness/bench.h"

#define BENCH_RECORD_PLOT_ROWS 2

/* bench_record_report.c: the goals beside what was measured, and a picture of it. */
void bench_record_goals(FILE *out, const bench_results *results);
void bench_record_plot(FILE *out, const bench_results *results);

#endif
