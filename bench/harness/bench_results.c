/* The rows of a benchmark suite's results, each the values of one metric of one subject in one case: adding rows, their
 * medians, and ratios of two rows. */
#include "bench/harness/bench_child.h"
#include "bench/harness/bench_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const bench_metric limit_metrics[] = {
	{BENCH_LIMIT_CLOCK, "ns", true, NULL},     {BENCH_LIMIT_UNCONTENDED, "ns", true, NULL},
	{BENCH_LIMIT_CONTENDED, "ns", true, NULL}, {BENCH_LIMIT_WAKE, "ns", true, NULL},
	{BENCH_LIMIT_WAKE_P99, "ns", true, NULL},
};
const bench_case bench_limits_case = {.name = "limits",
                                      .title = "limits of this machine",
                                      .metrics = limit_metrics,
                                      .metric_count = sizeof limit_metrics / sizeof *limit_metrics,
                                      .length = 0.6};
const bench_subject bench_limits_subject = {.name = "machine", .program = "stilb-bench-limits", .reference = true};

const bench_suite *bench_suite_of(const bench_results *results)
{
	return results->suite;
}

stilb_result bench_add_row(bench_results *results, const bench_case *on, const bench_subject *subject,
                           const bench_metric *metric)
{
	STILB_ASSERT(on && subject && metric && results->rounds == 0 && "rows are added before the first round");
	if (results->row_count == results->row_capacity) {
		size_t capacity = results->row_capacity ? results->row_capacity * 2 : 256;
		bench_row *grown = realloc(results->rows, capacity * sizeof *grown);
		if (!grown)
			return stilb_fail(STILB_ERROR_MEMORY, "out of memory for the table");
		results->rows = grown;
		results->row_capacity = capacity;
	}
	double *values = malloc(results->options->rounds * sizeof *values);
	if (!values)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for the table");
	for (uint32_t i = 0; i < results->options->rounds; i++)
		values[i] = BENCH_NO_NUMBER;
	results->rows[results->row_count++] = (bench_row){.on = on,
	                                                  .subject = subject,
	                                                  .name = subject->name,
	                                                  .metric = metric->name,
	                                                  .unit = metric->unit,
	                                                  .less_is_better = metric->less_is_better,
	                                                  .values = values};
	return STILB_OK;
}

void bench_set_value(bench_results *results, const bench_case *on, const bench_subject *subject, const char *metric,
                     uint32_t round, double value)
{
	STILB_ASSERT(on && subject && metric);
	STILB_ASSERT(round < results->rounds && "the round has begun");
	for (size_t i = 0; i < results->row_count; i++) {
		bench_row *row = &results->rows[i];
		if (row->on == on && row->subject == subject && strcmp(row->metric, metric) == 0) {
			((double *)row->values)[round] = value;
			return;
		}
	}
}

static int compare_doubles(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* Median, least and largest of the finite values; returns their number, and leaves *summary alone if that is 0. */
static uint32_t summarise(const double *values, uint32_t count, bench_ratio *summary)
{
	double *sorted = malloc((count ? count : 1) * sizeof *sorted);
	uint32_t known = 0;
	for (uint32_t i = 0; sorted && i < count; i++)
		if (isfinite(values[i]))
			sorted[known++] = values[i];
	if (known > 0) {
		qsort(sorted, known, sizeof *sorted, compare_doubles);
		summary->median = (sorted[known / 2] + sorted[(known - 1) / 2]) * 0.5;
		summary->min = sorted[0];
		summary->max = sorted[known - 1];
	}
	free(sorted);
	return known;
}

void bench_summarise(bench_results *results)
{
	for (size_t i = 0; i < results->row_count; i++) {
		bench_row *row = &results->rows[i];
		bench_ratio summary = {BENCH_NO_NUMBER, BENCH_NO_NUMBER, BENCH_NO_NUMBER};
		row->runs = summarise(row->values, results->rounds, &summary);
		row->median = summary.median, row->min = summary.min, row->max = summary.max;
	}
}

const bench_row *bench_find(const bench_results *results, const char *case_name, const char *subject_name,
                            const char *metric)
{
	STILB_ASSERT(metric && !case_name == !subject_name && "a case and a subject, or neither for the machine's limits");
	if (!case_name)
		case_name = bench_limits_case.name, subject_name = bench_limits_subject.name;
	for (size_t i = 0; i < results->row_count; i++) {
		const bench_row *row = &results->rows[i];
		if (strcmp(row->on->name, case_name) == 0 && strcmp(row->name, subject_name) == 0 &&
		    strcmp(row->metric, metric) == 0)
			return row->runs > 0 ? row : NULL;
	}
	return NULL;
}

bool bench_paired_ratio(const bench_results *results, const bench_row *numerator, const bench_row *denominator,
                        bench_ratio *ratio)
{
	STILB_ASSERT(numerator && denominator && ratio);
	double *ratios = malloc((results->rounds ? results->rounds : 1) * sizeof *ratios);
	for (uint32_t i = 0; ratios && i < results->rounds; i++)
		ratios[i] = numerator->values[i] / denominator->values[i];
	bool any = ratios && summarise(ratios, results->rounds, ratio) > 0;
	free(ratios);
	return any;
}

double bench_of_limit(const bench_row *row, const bench_row *limit)
{
	static const struct {
		const char *unit;
		double ns;
	} times[] = {{"ns", 1.0}, {"us", 1e3}, {"ms", 1e6}, {"s", 1e9}},
	  rates[] = {{"Mops/s", 1e3}, {"Mjobs/s", 1e3}, {"kops/s", 1e6}};
	STILB_ASSERT(row && limit && strcmp(limit->unit, "ns") == 0);
	for (size_t i = 0; i < sizeof times / sizeof *times; i++)
		if (strcmp(row->unit, times[i].unit) == 0)
			return row->median * times[i].ns / limit->median;
	for (size_t i = 0; i < sizeof rates / sizeof *rates; i++)
		if (strcmp(row->unit, rates[i].unit) == 0)
			return row->median * limit->median / rates[i].ns;
	return BENCH_NO_NUMBER;
}
