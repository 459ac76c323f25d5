/* What prof_stats.c and prof_diff.c share: sorted durations. */
#ifndef STILB_PROF_SORT_H
#define STILB_PROF_SORT_H

#include <stddef.h>
#include <stdint.h>

/* Ascending, in linear time; scratch has room for as many. */
void prof_sort(uint64_t *values, uint64_t *scratch, size_t count);

/* Nearest rank; count > 0. */
uint64_t prof_quantile(const uint64_t *sorted, size_t count, uint32_t percent);

#endif
