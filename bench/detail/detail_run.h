/* What the files of the program of the suites `lod` and `pop` share. */
#ifndef DETAIL_RUN_H
#define DETAIL_RUN_H

#include "bench/harness/bench_child.h"

#include <stdint.h>

/* CPU time of all threads of this process, ms. */
double detail_cpu_ms(void);
double detail_median(double *values, uint32_t count);

/* detail_vertices.c: the cases about vertices on the device and about memory. */
void detail_run_vertices(const bench_child *child, uint32_t models, uint32_t width, uint32_t height);
void detail_run_memory(const bench_child *child, uint32_t models, uint32_t width, uint32_t height);

#endif
