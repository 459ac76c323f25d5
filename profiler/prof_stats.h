/*
 * prof_stats: a snapshot in one table: what each name cost. For the table in a window, for `top` lists and comparisons.
 *
 * Life cycle.  stilb_prof_stats s = {0}; stilb_prof_stats_take, any number of times (memory is used again: one a frame
 *              soon allocates no more); stilb_prof_stats_finish.
 * Threads.     [any-thread], one thread at a time per stilb_prof_stats.
 * Cost.        Linear in the zones of the time asked for; by frames in all zones, since a job may run in a later frame
 *              than the one it is charged to. Some 10 us for 1,000 zones.
 */
#ifndef STILB_PROF_STATS_H
#define STILB_PROF_STATS_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Which zones. {0}: all. */
typedef struct stilb_prof_stats_range {
	uint32_t first_lane, lane_count;   /* of these lanes; lane_count 0: of all */
	uint32_t first_frame, frame_count; /* charged to these frames (indices); frame_count 0: to any or none */
	uint64_t begin_ns, end_ns;         /* in this time, what sticks out is cut off; end_ns 0: at any time */
} stilb_prof_stats_range;

/* The zones of one label, on threads or on devices: a GPU's "shadows" are not the CPU's. Zones that are still open
 * count up to when they were looked at. */
typedef struct stilb_prof_row {
	uint32_t label; /* index into the snapshot's labels */
	stilb_prof_lane_kind kind;
	uint32_t calls;
	uint64_t inclusive_ns; /* with what lies inside; a zone inside another of its label does not count again */
	uint64_t self_ns;      /* without its children; the rows' self times add up to the time that was in zones */
	uint64_t off_cpu_ns;   /* how much of inclusive_ns the threads did not run */
	uint64_t min_ns, p50_ns, p99_ns, max_ns; /* of one zone; the quantiles by nearest rank */
	const uint64_t *durations_ns;            /* of all calls, ascending */
} stilb_prof_row;

typedef struct stilb_prof_stats {
	stilb_prof_row *rows; /* with at least one call each; sorted by STILB_PROF_BY_INCLUSIVE */
	uint32_t row_count;
	void *memory; /* its own */
} stilb_prof_stats;

/* The largest first, equal ones and names by the alphabet. */
typedef enum stilb_prof_order {
	STILB_PROF_BY_INCLUSIVE,
	STILB_PROF_BY_SELF,
	STILB_PROF_BY_OFF_CPU,
	STILB_PROF_BY_CALLS,
	STILB_PROF_BY_P50,
	STILB_PROF_BY_P99,
	STILB_PROF_BY_MAX,
	STILB_PROF_BY_NAME,
} stilb_prof_order;

/* range may be NULL for {0}. Returns 0, -EINVAL (a lane or frame that is not there) or -ENOMEM; after an error there
 * are no rows. */
int stilb_prof_stats_take(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot,
                          const stilb_prof_stats_range *range);

/* Sorts the rows anew. snapshot is the one they were taken from. */
void stilb_prof_stats_sort(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot, stilb_prof_order order);

void stilb_prof_stats_finish(stilb_prof_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
