/* Two snapshots against each other; prof_diff.h says when a zone counts as slower. */
#include "profiler/prof_diff.h"

#include "profiler/prof_contract.h"
#include "profiler/read/prof_sort.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PROF_EXACT_MAX ((size_t)20)                                    /* values per side */
#define PROF_RANKS_MAX (2 * PROF_EXACT_MAX * (2 * PROF_EXACT_MAX + 1)) /* sum of all ranks, doubled */
#define PROF_FRAME_TIMES_MAX ((size_t)1 << 27)                         /* rows times frames: a gigabyte */

/* ---- Mann-Whitney ------------------------------------------------------------------------------------------------ */

/* The ranks of two samples together. Equal values share the mean of their ranks; ranks are doubled, to be integers. */
typedef struct prof_ranks {
	double a_sum;                       /* sum of the doubled ranks of a */
	double ties;                        /* sum of t^3 - t over groups of t equal values */
	uint32_t ranks[2 * PROF_EXACT_MAX]; /* all doubled ranks, if both sides are small */
} prof_ranks;

static bool samples_ascend(const uint64_t *values, size_t count)
{
	for (size_t i = 1; i < count; i++)
		if (values[i - 1] > values[i])
			return false;
	return true;
}

static void prof_rank(prof_ranks *ranks, const uint64_t *a, size_t a_count, const uint64_t *b, size_t b_count)
{
	bool small = a_count <= PROF_EXACT_MAX && b_count <= PROF_EXACT_MAX;
	*ranks = (prof_ranks){0};
	for (size_t i = 0, j = 0; i < a_count || j < b_count;) {
		size_t before = i + j, first_a = i;
		uint64_t value = j == b_count || (i < a_count && a[i] < b[j]) ? a[i] : b[j];
		while (i < a_count && a[i] == value)
			i++;
		while (j < b_count && b[j] == value)
			j++;
		size_t equal = i + j - before, rank = 2 * before + equal + 1;
		ranks->a_sum += (double)(i - first_a) * (double)rank;
		ranks->ties += (double)equal * ((double)equal * (double)equal - 1.0);
		for (size_t k = before; small && k < i + j; k++)
			ranks->ranks[k] = (uint32_t)rank;
	}
}

/* The exact p: of all ways to choose a_count of the ranks, the share of those whose sum of ranks is at least as far
 * from the mean as the observed one. ways[k][s] is the number of ways to choose k of the ranks seen so far with the sum
 * s. Negative: no memory. */
static double prof_rank_exact(const prof_ranks *ranks, size_t a_count, size_t count)
{
	assert(a_count <= PROF_EXACT_MAX && a_count <= count && count <= 2 * PROF_EXACT_MAX);
	size_t largest = 0; /* the sum of all ranks so far */
	double(*ways)[PROF_RANKS_MAX + 1] = calloc(PROF_EXACT_MAX + 1, sizeof *ways);
	double far = 0.0, all = 0.0;
	double mean = (double)a_count * ((double)count + 1.0), distance = fabs(ranks->a_sum - mean);
	if (!ways)
		return -1.0;
	ways[0][0] = 1.0;
	for (size_t i = 0; i < count; i++) {
		assert(ranks->ranks[i] > 0 && (i == 0 || ranks->ranks[i - 1] <= ranks->ranks[i]) && "ranks ascend from 1");
		largest += ranks->ranks[i];
		for (size_t k = i < a_count ? i + 1 : a_count; k > 0; k--)
			for (size_t s = largest; s >= ranks->ranks[i]; s--)
				ways[k][s] += ways[k - 1][s - ranks->ranks[i]];
	}
	for (size_t s = 0; s <= largest; s++) {
		all += ways[a_count][s];
		far += fabs((double)s - mean) >= distance ? ways[a_count][s] : 0.0;
	}
	assert(largest <= PROF_RANKS_MAX && far > 0.0 && far <= all && "what was observed is one of all ways");
	free(ways);
	return far / all;
}

static double prof_rank_normal(const prof_ranks *ranks, double a_count, double b_count)
{
	assert(a_count > 0 && b_count > 0);
	double count = a_count + b_count;
	double u = ranks->a_sum / 2.0 - a_count * (a_count + 1.0) / 2.0, mean = a_count * b_count / 2.0;
	double variance = a_count * b_count / 12.0 * (count + 1.0 - ranks->ties / (count * (count - 1.0)));
	double distance = fabs(u - mean) - 0.5;
	if (variance <= 0.0 || distance <= 0.0)
		return 1.0;
	return erfc(distance / sqrt(variance) / sqrt(2.0));
}

double stilb_prof_mann_whitney(const uint64_t *a, size_t a_count, const uint64_t *b, size_t b_count)
{
	assert((a || a_count == 0) && (b || b_count == 0));
	PROF_CHECK(samples_ascend(a, a_count) && samples_ascend(b, b_count));
	prof_ranks ranks;
	double p = -1.0;
	if (a_count == 0 || b_count == 0)
		return 1.0;
	prof_rank(&ranks, a, a_count, b, b_count);
	if (a_count <= PROF_EXACT_MAX && b_count <= PROF_EXACT_MAX)
		p = prof_rank_exact(&ranks, a_count, a_count + b_count);
	return p >= 0.0 ? p : prof_rank_normal(&ranks, (double)a_count, (double)b_count);
}

/* ---- one side ---------------------------------------------------------------------------------------------------- */

typedef struct prof_side {
	const stilb_prof_snapshot *snapshot;
	stilb_prof_stats stats;
	uint64_t *frame_times; /* per frame: for each row, its time in each frame, ascending */
} prof_side;

/* A table that gives the row of a label: the one at 2 * label, or 2 * label + 1 for devices; STILB_PROF_NONE: there is
 * none. NULL: no memory. */
static uint32_t *prof_side_rows(const prof_side *side)
{
	size_t count = 2 * (size_t)side->snapshot->label_count;
	uint32_t *rows = malloc((count + 1) * sizeof *rows);
	if (!rows)
		return NULL;
	for (size_t i = 0; i < count; i++)
		rows[i] = STILB_PROF_NONE;
	for (uint32_t i = 0; i < side->stats.row_count; i++)
		rows[2 * (size_t)side->stats.rows[i].label + (side->stats.rows[i].kind == STILB_PROF_LANE_DEVICE)] = i;
	return rows;
}

/* True if the zone is inside another of its label that is charged to the same frame. */
static bool prof_zone_recurs(const stilb_prof_lane *lane, const stilb_prof_zone *zone)
{
	for (uint32_t p = zone->parent; p != STILB_PROF_NONE; p = lane->zones[p].parent)
		if (lane->zones[p].label == zone->label && lane->zones[p].frame == zone->frame)
			return true;
	return false;
}

/* Adds the zones of a lane to the times of their rows and frames. until[row] is the index after the last zone that is
 * inside a zone of the row. */
static void prof_side_add_lane(prof_side *side, const stilb_prof_lane *lane, const uint32_t *rows, uint32_t *until)
{
	size_t frames = side->snapshot->frame_count;
	memset(until, 0, side->stats.row_count * sizeof *until);
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		if (zone->frame >= frames)
			continue;
		uint32_t row = rows[2 * (size_t)zone->label + (lane->kind == STILB_PROF_LANE_DEVICE)];
		assert(row < side->stats.row_count && "each zone's label has a row");
		if (i < until[row] && prof_zone_recurs(lane, zone))
			continue;
		until[row] = i + zone->size > until[row] ? i + zone->size : until[row];
		side->frame_times[row * frames + zone->frame] += zone->end_ns - zone->begin_ns;
	}
}

static bool prof_side_frame_times(prof_side *side)
{
	size_t frames = side->snapshot->frame_count, count = side->stats.row_count;
	if (count * frames > PROF_FRAME_TIMES_MAX)
		return false;
	uint32_t *rows = prof_side_rows(side), *until = malloc((count + 1) * sizeof *until);
	uint64_t *scratch = malloc(frames * sizeof *scratch);
	side->frame_times = calloc(count * frames + 1, sizeof *side->frame_times);
	bool good = rows && until && scratch && side->frame_times;
	for (uint32_t i = 0; good && i < side->snapshot->lane_count; i++)
		prof_side_add_lane(side, &side->snapshot->lanes[i], rows, until);
	for (size_t i = 0; good && i < count; i++)
		prof_sort(side->frame_times + i * frames, scratch, frames);
	free(rows);
	free(until);
	free(scratch);
	return good;
}

static const uint64_t *prof_side_samples(const prof_side *side, uint32_t row, size_t *count)
{
	assert(row < side->stats.row_count);
	if (!side->frame_times) {
		*count = side->stats.rows[row].calls;
		return side->stats.rows[row].durations_ns;
	}
	*count = side->snapshot->frame_count;
	return side->frame_times + row * *count;
}

static int prof_side_make(prof_side *side, bool frames, stilb_prof_diff_sample sample)
{
	stilb_prof_stats_range range = {.frame_count = frames ? side->snapshot->frame_count : 0};
	int error = stilb_prof_stats_take(&side->stats, side->snapshot, &range);
	if (error != 0)
		return error;
	stilb_prof_stats_sort(&side->stats, side->snapshot, STILB_PROF_BY_NAME);
	return sample == STILB_PROF_DIFF_PER_FRAME && !prof_side_frame_times(side) ? -ENOMEM : 0;
}

static void prof_side_free(prof_side *side)
{
	stilb_prof_stats_finish(&side->stats);
	free(side->frame_times);
}

static const char *prof_side_name(const prof_side *side, uint32_t row)
{
	return side->snapshot->labels[side->stats.rows[row].label].name;
}

static stilb_prof_diff_side prof_side_row(const prof_side *side, uint32_t row)
{
	size_t count;
	const uint64_t *samples = prof_side_samples(side, row, &count);
	const stilb_prof_row *r = &side->stats.rows[row];
	return (stilb_prof_diff_side){
		.calls = r->calls,
		.inclusive_ns = r->inclusive_ns,
		.self_ns = r->self_ns,
		.p50_ns = prof_quantile(samples, count, 50),
		.p99_ns = prof_quantile(samples, count, 99),
	};
}

/* ---- both -------------------------------------------------------------------------------------------------------- */

/* The order of rows by name, then by kind. A side without further rows comes last. */
static int prof_diff_order(const prof_side *a, uint32_t i, const prof_side *b, uint32_t j)
{
	if (i == a->stats.row_count || j == b->stats.row_count)
		return i == a->stats.row_count ? 1 : -1;
	int names = strcmp(prof_side_name(a, i), prof_side_name(b, j));
	return names != 0 ? names : (int)a->stats.rows[i].kind - (int)b->stats.rows[j].kind;
}

static stilb_prof_diff_row prof_diff_one(const prof_side *side, uint32_t row, stilb_prof_verdict verdict)
{
	assert(verdict == STILB_PROF_ONLY_A || verdict == STILB_PROF_ONLY_B);
	stilb_prof_diff_side times = prof_side_row(side, row);
	stilb_prof_diff_row out = {
		.name = prof_side_name(side, row), .kind = side->stats.rows[row].kind, .p = 1.0, .verdict = verdict};
	*(verdict == STILB_PROF_ONLY_A ? &out.a : &out.b) = times;
	return out;
}

static stilb_prof_diff_row prof_diff_both(const prof_side *a, uint32_t i, const prof_side *b, uint32_t j)
{
	size_t a_count, b_count;
	const uint64_t *a_samples = prof_side_samples(a, i, &a_count), *b_samples = prof_side_samples(b, j, &b_count);
	stilb_prof_diff_row row = prof_diff_one(a, i, STILB_PROF_ONLY_A);
	row.b = prof_side_row(b, j);
	row.ratio = (double)(row.b.p50_ns > 0 ? row.b.p50_ns : 1) / (double)(row.a.p50_ns > 0 ? row.a.p50_ns : 1);
	row.p = stilb_prof_mann_whitney(a_samples, a_count, b_samples, b_count);
	row.verdict = STILB_PROF_SAME;
	return row;
}

static void prof_diff_judge(stilb_prof_diff_row *row, const stilb_prof_diff_desc *desc, uint32_t tests,
                            double resolution_ns)
{
	assert(row->verdict == STILB_PROF_SAME && row->p >= 0.0 && row->p <= 1.0 && tests > 0);
	double a = (double)row->a.p50_ns, b = (double)row->b.p50_ns;
	if (row->p * tests >= desc->alpha || fabs(b - a) <= resolution_ns)
		return;
	if (b > a * (1.0 + desc->threshold))
		row->verdict = STILB_PROF_SLOWER;
	else if (a > b * (1.0 + desc->threshold))
		row->verdict = STILB_PROF_FASTER;
}

static int prof_compare_diff_rows(const void *left, const void *right)
{
	const stilb_prof_diff_row *a = left, *b = right;
	if (a->verdict != b->verdict)
		return a->verdict < b->verdict ? -1 : 1;
	uint64_t x = a->a.inclusive_ns > a->b.inclusive_ns ? a->a.inclusive_ns : a->b.inclusive_ns;
	uint64_t y = b->a.inclusive_ns > b->b.inclusive_ns ? b->a.inclusive_ns : b->b.inclusive_ns;
	if (x != y)
		return x < y ? 1 : -1;
	int names = strcmp(a->name, b->name);
	return names != 0 ? names : (int)a->kind - (int)b->kind;
}

/* Merges the rows of both sides into rows, which has room for all. Returns how many there are; *tests is how many of
 * them are on both sides, and so can be tested. */
static uint32_t prof_diff_join(stilb_prof_diff_row *rows, const prof_side *a, const prof_side *b, uint32_t *tests)
{
	uint32_t count = 0;
	for (uint32_t i = 0, j = 0; i < a->stats.row_count || j < b->stats.row_count;) {
		int order = prof_diff_order(a, i, b, j);
		if (order < 0) {
			rows[count++] = prof_diff_one(a, i++, STILB_PROF_ONLY_A);
		} else if (order > 0) {
			rows[count++] = prof_diff_one(b, j++, STILB_PROF_ONLY_B);
		} else {
			rows[count++] = prof_diff_both(a, i++, b, j++);
			(*tests)++;
		}
	}
	return count;
}

static int prof_diff_rows(stilb_prof_diff *diff, const prof_side *a, const prof_side *b,
                          const stilb_prof_diff_desc *desc)
{
	double resolution_ns = fmax(a->snapshot->resolution_ns, b->snapshot->resolution_ns);
	size_t room = (size_t)a->stats.row_count + b->stats.row_count + 1;
	uint32_t tests = 0;
	stilb_prof_diff_row *rows = malloc(room * sizeof *rows);
	if (!rows)
		return -ENOMEM;
	diff->memory = rows;
	diff->rows = rows;
	diff->row_count = prof_diff_join(rows, a, b, &tests);
	assert(diff->row_count + tests == a->stats.row_count + b->stats.row_count && "each row of a side once");
	for (uint32_t i = 0; i < diff->row_count; i++) {
		if (rows[i].verdict == STILB_PROF_SAME)
			prof_diff_judge(&rows[i], desc, tests, resolution_ns);
		diff->slower += rows[i].verdict == STILB_PROF_SLOWER;
	}
	if (diff->row_count > 1)
		qsort(rows, diff->row_count, sizeof *rows, prof_compare_diff_rows);
	return 0;
}

stilb_prof_diff_desc stilb_prof_diff_desc_default(void)
{
	return (stilb_prof_diff_desc){.sample = STILB_PROF_DIFF_PER_CALL, .threshold = 0.05, .alpha = 0.01};
}

int stilb_prof_diff_make(stilb_prof_diff *diff, const stilb_prof_snapshot *a, const stilb_prof_snapshot *b,
                         const stilb_prof_diff_desc *desc)
{
	assert(diff && a && b && desc && desc->sample <= STILB_PROF_DIFF_PER_FRAME);
	bool frames = a->frame_count > 0 && b->frame_count > 0;
	prof_side sides[2] = {{.snapshot = a}, {.snapshot = b}};
	stilb_prof_diff_finish(diff);
	if (!(desc->threshold >= 0.0) || !(desc->alpha >= 0.0 && desc->alpha <= 1.0) ||
	    (desc->sample == STILB_PROF_DIFF_PER_FRAME && !frames))
		return -EINVAL;
	diff->frames = frames;
	int error = prof_side_make(&sides[0], frames, desc->sample);
	if (error == 0)
		error = prof_side_make(&sides[1], frames, desc->sample);
	if (error == 0)
		error = prof_diff_rows(diff, &sides[0], &sides[1], desc);
	prof_side_free(&sides[0]);
	prof_side_free(&sides[1]);
	return error;
}

void stilb_prof_diff_finish(stilb_prof_diff *diff)
{
	assert(diff);
	free(diff->memory);
	*diff = (stilb_prof_diff){0};
}
