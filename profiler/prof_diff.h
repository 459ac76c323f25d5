/*
 * prof_diff: two traces of the same program against each other, zone by zone: did it get slower, or is it noise?
 *
 * A zone is slower when three things hold: the median of B is over that of A by more than the threshold; by more than
 * the clocks resolve; and a Mann-Whitney test says that such a difference does not come about by chance. That test asks
 * for no normal distribution, which times never have. Many zones are tested at once, so each must pass at alpha divided
 * by their number (Bonferroni): alpha is the chance that any zone of two equal runs is called different.
 * What the test cannot know: zones of one run share its luck (other programs, clock speed, where memory lay), so runs
 * of the same program may differ as a whole. The threshold is for that: set it above what two such runs differ by.
 *
 * Life cycle.  stilb_prof_diff d = {0}; stilb_prof_diff_make; stilb_prof_diff_finish.
 * Threads.     [any-thread], one thread at a time per stilb_prof_diff.
 */
#ifndef STILB_PROF_DIFF_H
#define STILB_PROF_DIFF_H

#include "prof_stats.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum stilb_prof_diff_sample {
	STILB_PROF_DIFF_PER_CALL,  /* the duration of each zone */
	STILB_PROF_DIFF_PER_FRAME, /* the time in zones of the name in each whole frame; 0 where there was none */
} stilb_prof_diff_sample;

typedef struct stilb_prof_diff_desc {
	stilb_prof_diff_sample sample;
	double threshold; /* of the medians: 0.05 is 5 % */
	double alpha;     /* 0..1 */
} stilb_prof_diff_desc;

/* Per call, 5 %, 0.01. */
stilb_prof_diff_desc stilb_prof_diff_desc_default(void);

typedef enum stilb_prof_verdict {
	STILB_PROF_SLOWER, /* B than A */
	STILB_PROF_FASTER,
	STILB_PROF_ONLY_B, /* no call in A */
	STILB_PROF_ONLY_A,
	STILB_PROF_SAME,
} stilb_prof_verdict;

/* As in stilb_prof_row; p50_ns and p99_ns are those of the samples. */
typedef struct stilb_prof_diff_side {
	uint32_t calls;
	uint64_t inclusive_ns, self_ns, p50_ns, p99_ns;
} stilb_prof_diff_side;

typedef struct stilb_prof_diff_row {
	const char *name; /* of one of the snapshots */
	stilb_prof_lane_kind kind;
	stilb_prof_diff_side a, b;
	double ratio; /* of the medians, B to A, less than 1 ns counting as 1; 0 when one side has no call */
	double p;     /* that equal programs differ so much or more; 1 when one side has no call */
	stilb_prof_verdict verdict;
} stilb_prof_diff_row;

typedef struct stilb_prof_diff {
	const stilb_prof_diff_row *rows; /* in the order of the verdicts, then the largest inclusive_ns first */
	uint32_t row_count;
	uint32_t slower; /* that many rows */
	bool frames;     /* both have whole frames: only zones that are charged to one count. Else all do */
	void *memory;
} stilb_prof_diff;

/* Zones are the same when name and lane kind are. Returns 0, -EINVAL (threshold or alpha out of range, or per frame
 * without whole frames on both sides) or -ENOMEM; after an error there are no rows. */
int stilb_prof_diff_make(stilb_prof_diff *diff, const stilb_prof_snapshot *a, const stilb_prof_snapshot *b,
                         const stilb_prof_diff_desc *desc);
void stilb_prof_diff_finish(stilb_prof_diff *diff);

/* Two-sided p of the Mann-Whitney U test between two ascending samples; 1 when one is empty. Up to 20 values a side
 * exact, ties included: the share of all ways to deal the ranks out that lie at least as far from the mean; above, the
 * normal approximation with corrections for ties and continuity. Source: Mann and Whitney, "On a test of whether one of
 * two random variables is stochastically larger than the other", 1947; Lehmann, "Nonparametrics", 1975, chapter 1.
 * [any-thread] */
double stilb_prof_mann_whitney(const uint64_t *a, size_t a_count, const uint64_t *b, size_t b_count);

#ifdef __cplusplus
}
#endif
#endif
