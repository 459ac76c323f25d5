/* The tables of the suite `threads`: the sweep with speed-ups, and the experiments beside the article's results. */
#include "bench/harness/bench_internal.h"
#include "bench/threads/bench_threads.h"

#include <string.h>

/* ---- cells ------------------------------------------------------------------------------------------------------- */

static double median_of(const bench_results *results, const char *on, const char *subject, const char *metric)
{
	const bench_row *row = bench_find(results, on, subject, metric);
	return row ? row->median : BENCH_NO_NUMBER;
}

/* The ratio of a metric of two subjects in one case, round by round; false if they did not both run. */
static bool ratio_of(const bench_results *results, const char *on, const char *numerator, const char *denominator,
                     const char *metric, bench_ratio *ratio)
{
	const bench_row *a = bench_find(results, on, numerator, metric), *b = bench_find(results, on, denominator, metric);
	return a && b && bench_paired_ratio(results, a, b, ratio);
}

/* ---- the sweep --------------------------------------------------------------------------------------------------- */

static void print_workers(FILE *out, const bench_results *results, const char *on, uint32_t workers)
{
	static const char *const plain[] = {"cull", "record", "replay", "rest", "cpu", "p99"};
	const char *name = bench_threads_name(workers);
	const bench_row *frame = bench_find(results, on, name, "frame"), *worst = bench_find(results, on, name, "worst");
	const bench_row *gain = bench_find(results, on, name, "speed-up");
	if (!frame)
		return;
	fprintf(out, "  %7u", workers);
	bench_print_range(out, 22, frame->median, frame->min, frame->max);
	for (size_t i = 0; i < sizeof plain / sizeof *plain; i++)
		bench_print_number(out, 8, median_of(results, on, name, plain[i]));
	bench_print_number(out, 8, worst->max);
	if (gain) {
		bench_print_range(out, 18, gain->median, gain->min, gain->max);
		fprintf(out, " %9.0f %%", median_of(results, on, name, "efficiency"));
	}
	fputc('\n', out);
}

/* Prints the share of the frame that workers can take over, and the upper bound of the speed-up by Amdahl's law. */
static void print_bound(FILE *out, const bench_results *results, const char *on)
{
	const char *alone = bench_threads_name(0);
	double frame = median_of(results, on, alone, "frame");
	double shared = (median_of(results, on, alone, "cull") + median_of(results, on, alone, "record")) / frame;
	if (!isfinite(shared))
		return;
	uint32_t cpus = bench_cpu_count();
	fprintf(out,
	        "  cull and record, which workers share, are %.1f %% of the frame without workers: %u CPUs can make it at "
	        "most %.2f",
	        100.0 * shared, cpus, 1.0 / (1.0 - shared + shared / cpus));
	fprintf(out, " times as fast (Amdahl's law)\n");
	const bench_row *software = bench_find(results, on, alone, "software");
	if (software && software->median > 0.5)
		fprintf(out, "  The device is a software renderer with one thread for each CPU, so workers take CPU time from "
		             "it, and the\n"
		             "  gain of the stages lies within the noise\n");
}

/* The reason that the program gave for skipping a chosen case, or NULL. */
static const char *left_out(const bench_results *results, const bench_case *on)
{
	for (size_t p = 0; p < results->pair_count; p++)
		if (results->pairs[p].on == on && results->pairs[p].skipped)
			return results->pairs[p].message;
	return NULL;
}

static bool chosen(const bench_results *results, const bench_case *on)
{
	for (size_t p = 0; p < results->pair_count; p++)
		if (results->pairs[p].on == on)
			return true;
	return false;
}

static void print_sweep(FILE *out, const bench_results *results, const bench_case *on)
{
	fprintf(out, "\n%s: %s", on->name, on->title);
	double visible = median_of(results, on->name, bench_threads_name(0), "visible");
	if (isfinite(visible))
		fprintf(out, " (%.0f)", visible);
	fprintf(out,
	        "; ms for each frame, of the main thread; cpu: of all threads\n  %7s %22s %8s %8s %8s %8s %8s %8s %8s %18s "
	        "%11s\n",
	        "workers", "frame [least-most]", "cull", "record", "replay", "rest", "cpu", "p99", "worst", "speed-up",
	        "efficiency");
	for (size_t i = 0; i < bench_threads_count; i++)
		print_workers(out, results, on->name, bench_threads_counts[i]);
	print_bound(out, results, on->name);
}

/* ---- the experiments --------------------------------------------------------------------------------------------- */

/* A table: a row for each subject, a column for each metric; `worst` is the largest value of all runs, not a median. */
static void print_experiment(FILE *out, const bench_results *results, const bench_case *on)
{
	fprintf(out, "\n%s: %s; medians of the runs; worst: the worst of all runs\n  %-18s", on->name, on->title, "");
	for (size_t m = 0; m < on->metric_count; m++) {
		char head[64];
		snprintf(head, sizeof head, "%s, %s", on->metrics[m].name, on->metrics[m].unit);
		fprintf(out, m == 0 ? " %22s" : " %15s", head);
	}
	fputc('\n', out);
	for (size_t s = 0; s < results->suite->subject_count; s++) {
		const char *name = results->suite->subjects[s].name;
		const bench_row *first = bench_find(results, on->name, name, on->metrics[0].name);
		if (!first)
			continue;
		fprintf(out, "  %-18s", name);
		bench_print_range(out, 22, first->median, first->min, first->max);
		for (size_t m = 1; m < on->metric_count; m++) {
			const bench_row *row = bench_find(results, on->name, name, on->metrics[m].name);
			bool worst = strcmp(on->metrics[m].name, "worst") == 0;
			bench_print_number(out, 15, !row ? BENCH_NO_NUMBER : worst ? row->max : row->median);
		}
		fputc('\n', out);
	}
}

/* Prints "  A / B, METRIC: 1.20 [1.10-1.31]; REMARK", the ratio of subjects a and b. article: the remark, for example
 * the ratio in the article, or NULL. */
static void print_ratio(FILE *out, const bench_results *results, const char *on, const char *a, const char *b,
                        const char *metric, const char *article)
{
	bench_ratio ratio;
	if (ratio_of(results, on, a, b, metric, &ratio))
		fprintf(out, "  %s / %s, %s: %.2f [%.2f-%.2f]%s%s\n", a, b, metric, ratio.median, ratio.min, ratio.max,
		        article ? "; " : "", article ? article : "");
}

static void compare_pools(FILE *out, const bench_results *results, const char *on)
{
	char few[32], many[32];
	const char *article = "the article: each thread was slower, the frame rate the same, limited by its GPU";
	uint32_t fitting = bench_threads_fitting(), most = bench_threads_too_many();
	snprintf(few, sizeof few, "sutter-%u", fitting);
	snprintf(many, sizeof many, "sutter-%u", most);
	print_ratio(out, results, on, bench_threads_name(most), bench_threads_name(fitting), "frame", NULL);
	print_ratio(out, results, on, many, few, "frame", article);
}

static void compare_dedicated(FILE *out, const bench_results *results, const char *on)
{
	const char *fitting = bench_threads_name(bench_threads_fitting());
	print_ratio(out, results, on, "dedicated", fitting, "frame", NULL);
	print_ratio(out, results, on, "dedicated", fitting, "latency", NULL);
	print_ratio(out, results, on, "dedicated", bench_threads_name(0), "frame", NULL);
}

static void compare_queues(FILE *out, const bench_results *results, const char *on)
{
	const char *article = "the article: at least 1.3, and 40 % of the time waiting for mutexes";
	print_ratio(out, results, on, "mutex", "sutter", "frame", article);
	print_ratio(out, results, on, "kernel-mutex", "sutter", "frame", article);
	print_ratio(out, results, on, "mutex", "stilb-low-lock", "frame", NULL);
	print_ratio(out, results, on, "mutex", "stilb-lock-free", "frame", NULL);
	print_ratio(out, results, on, "stilb-low-lock", "no-queue", "frame", "below 1: workers pay");
}

static void compare_stolen(FILE *out, const bench_results *results, const char *on)
{
	uint32_t counts[] = {0, bench_threads_fitting(), bench_threads_too_many()};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		const char *name = bench_threads_name(counts[i]);
		const bench_row *during = bench_find(results, on, name, "during-mean"),
						*before = bench_find(results, on, name, "before-mean");
		bench_ratio ratio;
		if (during && before && bench_paired_ratio(results, during, before, &ratio))
			fprintf(out, "  %s: while the CPU is occupied a frame takes on average %.2f [%.2f-%.2f] times as long%s\n",
			        name, ratio.median, ratio.min, ratio.max,
			        i == 1 ? "; the article: one frame took more than twice as long" : "");
	}
}

static void compare_replays(FILE *out, const bench_results *results, const char *on)
{
	print_ratio(out, results, on, "stilb-direct", "stilb-secondary", "replay", NULL);
	print_ratio(out, results, on, "stilb-direct", "stilb-indirect", "replay",
	            "the article: 3.5 ms to execute its command list");
}

static const struct {
	const char *on; /* the beginning of the cases' names */
	void (*print)(FILE *out, const bench_results *results, const char *on);
} comparisons[] = {
	{"one-vs-four", compare_pools}, {"dedicated", compare_dedicated}, {"mutex-vs-lowlock", compare_queues},
	{"stolen", compare_stolen},     {"white-bar", compare_replays},
};

static void print_comparison(FILE *out, const bench_results *results, const bench_case *on)
{
	for (size_t i = 0; i < sizeof comparisons / sizeof *comparisons; i++)
		if (strncmp(on->name, comparisons[i].on, strlen(comparisons[i].on)) == 0)
			comparisons[i].print(out, results, on->name);
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static void print_hashes(FILE *out)
{
	static const char *const views[] = {"all", "half", "few"};
	fprintf(out, "\nhash of the command stream, equal in every run whatever the workers, device or queue:");
	for (size_t v = 0; v < sizeof views / sizeof *views; v++)
		fprintf(out, "%s %s %016llx", v ? "," : "", views[v], (unsigned long long)bench_threads_hashes[v]);
	fputc('\n', out);
}

void bench_threads_report(FILE *out, const bench_results *results)
{
	print_hashes(out);
	for (size_t c = 0; c < results->suite->case_count; c++) {
		const bench_case *on = &results->suite->cases[c];
		if (!chosen(results, on))
			continue;
		const char *why = left_out(results, on);
		if (why) {
			fprintf(out, "\n%s: %s\n  skipped: %s\n", on->name, on->title, why);
			continue;
		}
		if (strncmp(on->name, "null-", 5) == 0 || strncmp(on->name, "vulkan-", 7) == 0) {
			print_sweep(out, results, on);
		} else {
			print_experiment(out, results, on);
			print_comparison(out, results, on);
		}
	}
	if (results->options->traces)
		fprintf(out, "\ntimelines of the slowest frames: %s/CASE.SUBJECT.trace.json\n", results->options->traces);
}
