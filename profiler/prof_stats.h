/*
 * prof_stats: the table of a snapshot: calls and times of each name of zones. For tables in a window, lists of what
 * takes the most time, and comparisons.
 *
 * Life cycle.  stilb_prof_stats stats = {0}; stilb_prof_stats_take any number of times (memory is reused: one call a
 *              frame soon allocates nothing more); stilb_prof_stats_finish.
 * Example.
 *                  stilb_prof_stats stats = {0};
 *                  if (stilb_prof_stats_take(&stats, &snapshot, NULL) == 0)
 *                      for (uint32_t i = 0; i < stats.row_count; i++)
 *                          printf("%s %llu ns\n", snapshot.labels[stats.rows[i].label].name,
 *                                 (unsigned long long)stats.rows[i].inclusive_ns);
 *                  stilb_prof_stats_finish(&stats);
 *
 * Threads.     [any-thread], one thread at a time per stilb_prof_stats. The snapshot is only read.
 * Errors.      0 or a negative errno. Nothing here prints.
 * Cost.        Linear in the number of zones in the range of time; with a range of frames, in the number of all zones,
 *              since a job may run in a later frame than the one it is charged to. About 10 us for 1,000 zones.
 */
#ifndef STILB_PROF_STATS_H
#define STILB_PROF_STATS_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Selects the zones that are added up: those that are in all three ranges. {0}: all zones. */
typedef struct stilb_prof_stats_range {
	uint32_t first_lane, lane_count;   /* on these lanes; lane_count 0: on any lane */
	uint32_t first_frame, frame_count; /* charged to these frames (indices); frame_count 0: to any frame or none */
	uint64_t begin_ns, end_ns;         /* in [begin_ns, end_ns), cut to it; end_ns 0: at any time */
} stilb_prof_stats_range;

/* All zones of one label, on threads or on devices: a GPU's "shadows" is another row than the CPU's. Zones that had not
 * ended count up to the time of the snapshot. */
typedef struct stilb_prof_row {
	uint32_t label; /* index into the snapshot's labels */
	stilb_prof_lane_kind kind;
	uint32_t calls;                          /* number of zones added up in this row, at least 1 */
	uint64_t inclusive_ns;                   /* children included; a zone inside one of its label is not added again */
	uint64_t self_ns;                        /* children excluded; the sum over all rows is the time spent in zones */
	uint64_t off_cpu_ns;                     /* how much of inclusive_ns the threads were not running */
	uint64_t min_ns, p50_ns, p99_ns, max_ns; /* of the durations of the calls; percentiles by nearest rank */
	const uint64_t *durations_ns;            /* of all calls, ascending: calls values */
} stilb_prof_row;

typedef struct stilb_prof_stats {
	stilb_prof_row *rows; /* sorted by STILB_PROF_BY_INCLUSIVE; valid until the next take or finish */
	uint32_t row_count;
	void *memory; /* of the library */
} stilb_prof_stats;

/* Orders of rows: the largest value first; equal ones, and BY_NAME, in the order of strcmp. */
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

/* Fills stats from the zones of snapshot in range; NULL stands for {0}. stats is {0} or an earlier one; neither it nor
 * snapshot is NULL (asserted). Returns 0; -EINVAL: a lane or frame of range is not in the snapshot; -ENOMEM: no memory.
 * After an error there are no rows. [any-thread] */
int stilb_prof_stats_take(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot,
                          const stilb_prof_stats_range *range);

/* Sorts the rows by order. snapshot is the one that they were taken from (asserted as far as labels tell).
 * [any-thread] */
void stilb_prof_stats_sort(stilb_prof_stats *stats, const stilb_prof_snapshot *snapshot, stilb_prof_order order);

/* Frees stats and leaves {0}. Safe on {0}. [any-thread] */
void stilb_prof_stats_finish(stilb_prof_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
