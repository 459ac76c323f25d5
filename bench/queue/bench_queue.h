/* bench_queue: shared by the files of the suite `queue`. [main-thread] */
#ifndef BENCH_QUEUE_H
#define BENCH_QUEUE_H

#include "bench/harness/bench.h"

/* Prints the bounds of the suite, each met or MISSED: bench_suite.goals. */
void bench_queue_goals(FILE *out, const bench_results *results);

#endif
