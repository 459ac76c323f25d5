/* bench_queue: what the files of the suite `queue` share. */
#ifndef BENCH_QUEUE_H
#define BENCH_QUEUE_H

#include "bench/harness/bench.h"

/* The goals, and which of them were reached. */
void bench_queue_goals(FILE *out, const bench_results *results);

#endif
