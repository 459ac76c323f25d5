/* Sorting and percentiles of durations, for prof_stats.c and prof_diff.c. */
#ifndef STILB_PROF_SORT_H
#define STILB_PROF_SORT_H

#include <stddef.h>
#include <stdint.h>

/* Sorts ascending, in linear time. scratch has room for count values. */
void prof_sort(uint64_t *values, uint64_t *scratch, size_t count);

/* The percentile, 0..100, by nearest rank; count > 0. */
uint64_t prof_quantile(const uint64_t *sorted, size_t count, uint32_t percent);

#endif
