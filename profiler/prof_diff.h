/*
 * prof_diff: compares two traces of the same program, zone by zone: did it get slower, or is the difference noise?
 *
 * Verdict.     A zone is slower in B if three conditions hold: the median of B exceeds that of A by more than
 *              threshold; it exceeds it by more than the resolution of the clocks; and a Mann-Whitney test says that
 *              such a difference is unlikely by chance. The test assumes no normal distribution, which durations do not
 *              have. As many zones are tested at once, each is held to alpha divided by their number (Bonferroni):
 *              alpha bounds the probability that any zone of two equal programs is called different.
 *              The zones of one run share conditions that the test cannot see (other programs, clock speed, memory
 *              layout), so two runs of the same program may differ as a whole. threshold is for that: choose it larger
 *              than the difference of two such runs.
 * Life cycle.  stilb_prof_diff diff = {0}; stilb_prof_diff_make any number of times; stilb_prof_diff_finish.
 * Example.
 *                  stilb_prof_diff diff = {0};
 *                  stilb_prof_diff_desc desc = stilb_prof_diff_desc_default();
 *                  if (stilb_prof_diff_make(&diff, &before, &after, &desc) == 0 && diff.slower > 0)
 *                      printf("%s got %.2f times slower\n", diff.rows[0].name, diff.rows[0].ratio);
 *                  stilb_prof_diff_finish(&diff);
 *
 * Threads.     [any-thread], one thread at a time per stilb_prof_diff. The snapshots are only read.
 * Errors.      0 or a negative errno. Nothing here prints.
 */
#ifndef STILB_PROF_DIFF_H
#define STILB_PROF_DIFF_H

#include "prof_stats.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The samples that are compared. */
typedef enum stilb_prof_diff_sample {
	STILB_PROF_DIFF_PER_CALL,  /* the duration of each zone */
	STILB_PROF_DIFF_PER_FRAME, /* for each whole frame the time in zones of the name; 0 if there was none */
} stilb_prof_diff_sample;

/* The settings; start from stilb_prof_diff_desc_default. */
typedef struct stilb_prof_diff_desc {
	stilb_prof_diff_sample sample;
	double threshold; /* relative difference of the medians, >= 0: 0.05 is 5 % */
	double alpha;     /* 0..1: the accepted probability that any zone of two equal programs is called different */
} stilb_prof_diff_desc;

/* Per call, threshold 0.05, alpha 0.01. [any-thread] */
stilb_prof_diff_desc stilb_prof_diff_desc_default(void);

/* The result for a zone. Rows are sorted in this order. */
typedef enum stilb_prof_verdict {
	STILB_PROF_SLOWER, /* B is slower than A */
	STILB_PROF_FASTER, /* B is faster than A */
	STILB_PROF_ONLY_B, /* A has no call */
	STILB_PROF_ONLY_A, /* B has no call */
	STILB_PROF_SAME,   /* no difference beyond noise */
} stilb_prof_verdict;

/* One side of a row: sums as in stilb_prof_row; p50_ns and p99_ns are those of the samples. */
typedef struct stilb_prof_diff_side {
	uint32_t calls;
	uint64_t inclusive_ns, self_ns, p50_ns, p99_ns;
} stilb_prof_diff_side;

/* The zones of one name on one kind of lane. */
typedef struct stilb_prof_diff_row {
	const char *name; /* belongs to one of the snapshots */
	stilb_prof_lane_kind kind;
	stilb_prof_diff_side a, b;
	double ratio; /* median of B / median of A, each at least 1 ns; 0 if a side has no call */
	double p;     /* probability that equal programs differ this much or more; 1 if a side has no call */
	stilb_prof_verdict verdict;
} stilb_prof_diff_row;

typedef struct stilb_prof_diff {
	const stilb_prof_diff_row *rows; /* in the order of the verdicts, then the largest inclusive_ns first */
	uint32_t row_count;
	uint32_t slower; /* number of rows whose verdict is STILB_PROF_SLOWER; they come first */
	bool frames;     /* both have whole frames: only zones charged to a frame count. Otherwise all zones count */
	void *memory;    /* of the library */
} stilb_prof_diff;

/* Compares a with b. Zones belong together if their names and kinds of lane are equal. diff is {0} or an earlier one;
 * no pointer is NULL and desc->sample is in range (asserted). The rows are valid as long as both snapshots. Returns 0;
 * -EINVAL: threshold or alpha out of range, or samples per frame without whole frames on both sides; -ENOMEM: no
 * memory. After an error there are no rows. [any-thread] */
int stilb_prof_diff_make(stilb_prof_diff *diff, const stilb_prof_snapshot *a, const stilb_prof_snapshot *b,
                         const stilb_prof_diff_desc *desc);

/* Frees diff and leaves {0}. Safe on {0}. [any-thread] */
void stilb_prof_diff_finish(stilb_prof_diff *diff);

/* Two-sided p of the Mann-Whitney U test of a[0..a_count) and b[0..b_count), both ascending (asserted); 1 if either is
 * empty. Up to 20 values a side it is exact, ties included: the share of all ways to deal out the ranks that lie at
 * least as far from the mean. Above, the normal approximation with corrections for ties and continuity. Sources: Mann
 * and Whitney, "On a test of whether one of two random variables is stochastically larger than the other", 1947;
 * Lehmann, "Nonparametrics", 1975, chapter 1. [any-thread] */
double stilb_prof_mann_whitney(const uint64_t *a, size_t a_count, const uint64_t *b, size_t b_count);

#ifdef __cplusplus
}
#endif
#endif
