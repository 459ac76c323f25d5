/* jobs_arrays: what the subjects of the suite `jobs` do with arrays: transpose a matrix in tiles, add floats up, sort.
 * Each kind has _make, which makes the arrays, _run, which is measured, and _right, which tells whether the last run
 * left the right result. No job is counted here: the arrays themselves are verified. [main-thread] */
#ifndef JOBS_ARRAYS_H
#define JOBS_ARRAYS_H

#include "bench/jobs/jobs_subject.h"

/* Square matrices of so many rows. */
void jobs_tiles_make(uint32_t side);
void jobs_tiles_run(const jobs_subject *subject);
bool jobs_tiles_right(void);

void jobs_reduce_make(uint32_t count);
void jobs_reduce_run(const jobs_subject *subject);
bool jobs_reduce_right(void);

/* Random elements, or in ascending order. _fill goes before each _run. */
void jobs_sort_make(uint32_t count, bool ordered);
void jobs_sort_fill(void);
void jobs_sort_run(const jobs_subject *subject);
bool jobs_sort_right(void);

#endif
