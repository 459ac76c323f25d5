/* Prints a suite's results as tables and in words, and writes them as JSON. */
#include "bench/harness/bench_child.h"
#include "bench/harness/bench_internal.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "game/cli/flags.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>

/* ---- the machine and the build ----------------------------------------------------------------------------------- */

const char *bench_build_flags(void)
{
	if (strcmp(STILB_BENCH_C_FLAGS, STILB_BENCH_CXX_FLAGS) == 0)
		return STILB_BENCH_COMPILER " " STILB_BENCH_C_FLAGS ", for C and C++ alike";
	return STILB_BENCH_COMPILER " " STILB_BENCH_C_FLAGS " for C, but " STILB_BENCH_CXX_FLAGS " for C++";
}

uint32_t bench_cpu_count(void)
{
	return bench_child_cpu_count();
}

void bench_machine(char *text, size_t size)
{
	struct utsname kernel;
	stilb_cpu_features cpu = stilb_cpu_query();
	uint32_t cpus = bench_cpu_count();
	snprintf(text, size, "%s, %u CPU%s, Linux %s", cpu.name, cpus, cpus == 1 ? "" : "s",
	         uname(&kernel) == 0 ? kernel.release : "?");
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static bool ours(const bench_row *row)
{
	return strncmp(row->name, "stilb", 5) == 0;
}

static bool better(const bench_row *a, const bench_row *b)
{
	return a->less_is_better ? a->median < b->median : a->median > b->median;
}

/* True for metrics that are columns of other metrics' tables, without a table of their own. */
static bool shown_beside(const char *metric)
{
	return strcmp(metric, BENCH_METRIC_MEMORY) == 0 || strcmp(metric, BENCH_METRIC_STEAL) == 0 ||
	       strcmp(metric, BENCH_METRIC_ITEMS) == 0;
}

/* The index after the last of the consecutive rows that have the case and the metric of row `first`: one table. */
static size_t end_of_table(const bench_results *results, size_t first)
{
	size_t end = first;
	while (end < results->row_count && results->rows[end].on == results->rows[first].on &&
	       strcmp(results->rows[end].metric, results->rows[first].metric) == 0)
		end++;
	return end;
}

/* The best median of subjects that are neither Stilb's nor references; NULL if none ran. */
static const bench_row *best_peer(const bench_row *rows, size_t count)
{
	const bench_row *best = NULL;
	for (size_t i = 0; i < count; i++)
		if (rows[i].runs > 0 && !ours(&rows[i]) && !rows[i].subject->reference && (!best || better(&rows[i], best)))
			best = &rows[i];
	return best;
}

/* The name of the machine's limit that bounds the row's metric, a BENCH_LIMIT_..., or NULL. */
static const char *limit_name(const bench_row *row)
{
	for (size_t i = 0; i < row->on->metric_count; i++)
		if (strcmp(row->on->metrics[i].name, row->metric) == 0)
			return row->on->metrics[i].limit;
	return NULL;
}

/* The value in `width` columns; "-" if it is not finite. */
static void print_cell(FILE *out, int width, int digits, double value)
{
	if (isfinite(value))
		fprintf(out, " %*.*f", width, digits, value);
	else
		fprintf(out, " %*s", width, "-");
}

int bench_digits(double value)
{
	return fabs(value) >= 100.0 ? 0 : fabs(value) >= 10.0 ? 1 : fabs(value) >= 1.0 ? 2 : 3;
}

void bench_print_number(FILE *out, int width, double value)
{
	print_cell(out, width, bench_digits(value), value);
}

static double median_of(const bench_results *results, const bench_row *row, const char *metric)
{
	const bench_row *other = bench_find(results, row->on->name, row->name, metric);
	return other ? other->median : BENCH_NO_NUMBER;
}

static double most_of(const bench_results *results, const bench_row *row, const char *metric)
{
	const bench_row *other = bench_find(results, row->on->name, row->name, metric);
	return other ? other->max : BENCH_NO_NUMBER;
}

static const bench_pair *pair_of(const bench_results *results, const bench_row *row)
{
	for (size_t p = 0; p < results->pair_count; p++)
		if (results->pairs[p].on == row->on && results->pairs[p].subject == row->subject)
			return &results->pairs[p];
	return NULL;
}

static void print_trouble(FILE *out, const bench_pair *pair)
{
	if (pair->timeouts > 0)
		fprintf(out, "  TIMED OUT in %u of %u runs: %s", pair->timeouts, pair->attempts, pair->message);
	if (pair->failures > 0)
		fprintf(out, "  FAILED in %u of %u runs: %s", pair->failures, pair->attempts, pair->message);
}

static void print_row(FILE *out, const bench_results *results, const bench_row *row, const bench_row *peer,
                      const bench_row *limit)
{
	const bench_pair *pair = pair_of(results, row);
	if (pair->skipped)
		return;
	fprintf(out, "  %-20s", row->name);
	if (row->runs > 0) {
		bench_print_number(out, 10, row->median);
		bench_print_number(out, 10, row->min);
		bench_print_number(out, 10, row->max);
		print_cell(out, 7, 2, (row->less_is_better ? row->max : row->min) / row->median);
		print_cell(out, 8, 2, peer ? row->median / peer->median : BENCH_NO_NUMBER);
		print_cell(out, 9, 2, limit ? bench_of_limit(row, limit) : BENCH_NO_NUMBER);
		print_cell(out, 8, 1, median_of(results, row, BENCH_METRIC_ITEMS) * 1e-6);
		print_cell(out, 8, 0, most_of(results, row, BENCH_METRIC_MEMORY));
		print_cell(out, 7, 1, most_of(results, row, BENCH_METRIC_STEAL));
	}
	print_trouble(out, pair);
	if (row->runs > 0 && row->runs < results->rounds)
		fprintf(out, "  (%u runs)", row->runs);
	fputc('\n', out);
}

static void print_table(FILE *out, const bench_results *results, size_t first, size_t end)
{
	const bench_row *rows = &results->rows[first];
	const char *limit = limit_name(rows);
	const bench_row *peer = best_peer(rows, end - first),
					*limit_row = limit ? bench_find(results, NULL, NULL, limit) : NULL;
	fprintf(out, "\n%s: %s; %s in %s, %s is better", rows->on->name, rows->on->title, rows->metric, rows->unit,
	        rows->less_is_better ? "less" : "more");
	if (peer)
		fprintf(out, "; best peer: %s", peer->name);
	if (limit_row)
		fprintf(out, "; limit: %s", limit);
	fprintf(out, "\n  %-20s %10s %10s %10s %7s %8s %9s %8s %8s %7s\n", "subject", "median", "least", "most", "worst",
	        "/ peer", "/ limit", "M items", "MiB", "steal %");
	for (size_t i = first; i < end; i++)
		print_row(out, results, &results->rows[i], peer, limit_row);
}

void bench_print_range(FILE *out, int width, double median, double least, double most)
{
	char text[64] = "-";
	if (isfinite(median))
		snprintf(text, sizeof text, "%.*f [%.*f-%.*f]", bench_digits(median), median, bench_digits(least), least,
		         bench_digits(most), most);
	fprintf(out, " %*s", width, text);
}

/* True if at least one run of the pair (a subject in a case) gave a result. */
static bool any_run(const bench_pair *pair)
{
	return pair->attempts > pair->failures + pair->timeouts && !pair->skipped;
}

/* True if at least one chosen subject has not skipped the case. */
static bool case_was_run(const bench_results *results, const bench_case *on)
{
	for (size_t p = 0; p < results->pair_count; p++)
		if (results->pairs[p].on == on && !results->pairs[p].skipped)
			return true;
	return false;
}

/* The table of a case with several metrics: a row for each subject, a column for each metric. */
static void print_metrics(FILE *out, const bench_results *results, const bench_case *on)
{
	if (!case_was_run(results, on))
		return;
	fprintf(out, "\n%s: %s; median [least-most]\n  %-20s", on->name, on->title, "subject");
	for (size_t m = 0; m < on->metric_count; m++)
		if (!shown_beside(on->metrics[m].name)) {
			char head[64];
			snprintf(head, sizeof head, "%s, %s", on->metrics[m].name, on->metrics[m].unit);
			fprintf(out, " %22s", head);
		}
	fputc('\n', out);
	for (size_t p = 0; p < results->pair_count; p++) {
		const bench_pair *pair = &results->pairs[p];
		if (pair->on != on || pair->skipped)
			continue;
		fprintf(out, "  %-20s", pair->subject->name);
		for (size_t m = 0; any_run(pair) && m < on->metric_count; m++) {
			const bench_row *row = bench_find(results, on->name, pair->subject->name, on->metrics[m].name);
			if (!shown_beside(on->metrics[m].name))
				bench_print_range(out, 22, row ? row->median : BENCH_NO_NUMBER, row ? row->min : 0.0,
				                  row ? row->max : 0.0);
		}
		print_trouble(out, pair);
		fputc('\n', out);
	}
}

static void print_limits(FILE *out, const bench_results *results)
{
	static const char *const meanings[] = {
		"reading the time-stamp counter", "an atomic add by one thread", "an atomic add of one number by all CPUs",
		"from waking a sleeping thread until it runs, median", "the same, 99th percentile"};
	STILB_ASSERT(bench_limits_case.metric_count == sizeof meanings / sizeof *meanings);
	fprintf(out, "\nlimits of this machine, ns; median [least-most]\n");
	for (size_t m = 0; m < bench_limits_case.metric_count; m++) {
		const bench_row *row = bench_find(results, NULL, NULL, bench_limits_case.metrics[m].name);
		fprintf(out, "  %-20s", bench_limits_case.metrics[m].name);
		bench_print_range(out, 26, row ? row->median : BENCH_NO_NUMBER, row ? row->min : 0.0, row ? row->max : 0.0);
		fprintf(out, "  %s\n", meanings[m]);
	}
}

/* The number of metrics of the case that have a table of their own and are no column of other metrics' tables. */
static size_t own_tables(const bench_case *on)
{
	size_t count = 0;
	for (size_t m = 0; m < on->metric_count; m++)
		count += !shown_beside(on->metrics[m].name);
	return count;
}

static void print_tables(FILE *out, const bench_results *results)
{
	const bench_case *last = &bench_limits_case;
	for (size_t first = 0, end; first < results->row_count; first = end) {
		const bench_row *row = &results->rows[first];
		end = end_of_table(results, first);
		if (row->on != &bench_limits_case && own_tables(row->on) == 1 && !shown_beside(row->metric))
			print_table(out, results, first, end);
		else if (row->on != last && own_tables(row->on) > 1)
			print_metrics(out, results, row->on);
		last = row->on;
	}
}

/* ---- Stilb's subjects beside the others -------------------------------------------------------------------------- */

static const bench_row *panel_row(const bench_results *results, const bench_panel *panel, const char *case_name,
                                  const bench_subject *subject)
{
	return bench_find(results, case_name, subject->name, panel->metric);
}

/* Prints how many times as good as row `their` row `our` is, as "3.10 [2.50-4.40]": the median and range over the
 * rounds of our value / their value, inverted if less is better. */
static void print_times(FILE *out, const bench_results *results, const bench_row *our, const bench_row *their)
{
	bench_ratio ratio = {BENCH_NO_NUMBER, 0.0, 0.0};
	if (our && their) {
		bool less = our->less_is_better;
		bench_paired_ratio(results, less ? their : our, less ? our : their, &ratio);
	}
	bench_print_range(out, 20, ratio.median, ratio.min, ratio.max);
}

static bool subject_in_panel(const bench_results *results, const bench_panel *panel, const bench_subject *subject)
{
	for (const char *const *name = panel->cases; *name; name++)
		if (panel_row(results, panel, *name, subject))
			return true;
	return false;
}

static bool case_in_panel(const bench_results *results, const bench_panel *panel, const char *name)
{
	for (size_t s = 0; s < results->suite->subject_count; s++)
		if (panel_row(results, panel, name, &results->suite->subjects[s]))
			return true;
	return false;
}

static void print_comparison(FILE *out, const bench_results *results, const bench_panel *panel,
                             const bench_subject *our)
{
	const bench_suite *suite = results->suite;
	fprintf(out,
	        "\n%s, %s: how many times as good as the row's subject is %s? (above 1: better; median [least-most] of the "
	        "rounds)\n  %-20s",
	        panel->title, panel->metric, our->name, "");
	for (const char *const *name = panel->cases; *name; name++)
		if (case_in_panel(results, panel, *name))
			fprintf(out, " %20s", *name);
	fputc('\n', out);
	for (size_t s = 0; s < suite->subject_count; s++) {
		const bench_subject *their = &suite->subjects[s];
		if (their == our || !subject_in_panel(results, panel, their))
			continue;
		fprintf(out, "  %-20s", their->name);
		for (const char *const *name = panel->cases; *name; name++)
			if (case_in_panel(results, panel, *name))
				print_times(out, results, panel_row(results, panel, *name, our),
				            panel_row(results, panel, *name, their));
		fputc('\n', out);
	}
}

static void print_comparisons(FILE *out, const bench_results *results)
{
	for (size_t p = 0; p < results->suite->panel_count; p++)
		for (size_t s = 0; s < results->suite->subject_count; s++) {
			const bench_subject *subject = &results->suite->subjects[s];
			if (strncmp(subject->name, "stilb", 5) == 0 &&
			    subject_in_panel(results, &results->suite->panels[p], subject))
				print_comparison(out, results, &results->suite->panels[p], subject);
		}
}

/* ---- in words ---------------------------------------------------------------------------------------------------- */

/* The best of Stilb's subjects beside the best peer (another library), over all tables that have both. */
typedef struct standing {
	uint32_t tables;              /* that have both */
	uint32_t first;               /* those in which Stilb's is at least as good */
	double least;                 /* smallest ratio of ours to theirs (1: equally good); 1 if ours is behind in none */
	const bench_row *our, *their; /* the two of the table with that ratio; NULL if Stilb's is behind in none */
} standing;

/* The best median of Stilb's subjects; NULL if none ran. */
static const bench_row *best_of_ours(const bench_row *rows, size_t count)
{
	const bench_row *best = NULL;
	for (size_t i = 0; i < count; i++)
		if (rows[i].runs > 0 && ours(&rows[i]) && (!best || better(&rows[i], best)))
			best = &rows[i];
	return best;
}

static standing standing_of(const bench_results *results)
{
	standing s = {.least = 1.0};
	for (size_t first = 0, end; first < results->row_count; first = end) {
		const bench_row *rows = &results->rows[first];
		end = end_of_table(results, first);
		const bench_row *our = best_of_ours(rows, end - first), *their = best_peer(rows, end - first);
		if (rows->on == &bench_limits_case || shown_beside(rows->metric) || !our || !their)
			continue;
		double times = our->less_is_better ? their->median / our->median : our->median / their->median;
		if (isnan(times)) /* both are 0 */
			times = 1.0;
		s.tables++;
		s.first += times >= 1.0;
		if (times < s.least)
			s.least = times, s.our = our, s.their = their;
	}
	return s;
}

static int compare_spread(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* How much runs differ: the median over all rows of a row's (max - min) / median; NaN if no row has two runs. */
static double scatter_of(const bench_results *results)
{
	size_t count = 0;
	double *spread = malloc((results->row_count ? results->row_count : 1) * sizeof *spread), median = BENCH_NO_NUMBER;
	for (size_t i = 0; spread && i < results->row_count; i++) {
		const bench_row *row = &results->rows[i];
		if (row->runs > 1 && row->median > 0.0 && !shown_beside(row->metric))
			spread[count++] = (row->max - row->min) / row->median;
	}
	if (count > 0) {
		qsort(spread, count, sizeof *spread, compare_spread);
		median = spread[count / 2];
	}
	free(spread);
	return median;
}

static double most_stolen(const bench_results *results)
{
	double most = 0.0;
	for (size_t i = 0; i < results->row_count; i++)
		if (strcmp(results->rows[i].metric, BENCH_METRIC_STEAL) == 0 && results->rows[i].runs > 0)
			most = fmax(most, results->rows[i].max);
	return most;
}

static void say_what_ran(FILE *out, const bench_results *results)
{
	uint32_t pairs = 0, runs = 0, ended = 0;
	for (size_t p = 1; p < results->pair_count; p++) { /* pair 0 measures the machine's limits, no subject */
		const bench_pair *pair = &results->pairs[p];
		pairs += !pair->skipped;
		runs += pair->skipped ? 0 : pair->attempts;
		ended += pair->skipped ? 0 : pair->attempts - pair->failures - pair->timeouts;
	}
	fprintf(out,
	        "\n%s: %u run%s of %.2f s (%u pair%s of a subject and a case, %u round%s), of which %u gave a result.\n",
	        results->suite->name, runs, runs == 1 ? "" : "s", results->seconds, pairs, pairs == 1 ? "" : "s",
	        results->rounds, results->rounds == 1 ? "" : "s", ended);
}

static void say_standing(FILE *out, const bench_results *results)
{
	standing s = standing_of(results);
	if (s.tables == 0)
		fprintf(out, "Nothing but Stilb was measured in this run; compare with the limits of this machine above.\n");
	else if (!s.our)
		fprintf(out, "Stilb is at least as good as the best of the others in %s.\n",
		        s.tables == 1 ? "the only comparison" : "every comparison");
	else
		fprintf(out,
		        "Stilb is at least as good as the best of the others in %u of %u comparisons; it is furthest behind in "
		        "%s, whose %s is %.*f %s with %s and %.*f %s with %s.\n",
		        s.first, s.tables, s.our->on->name, s.our->metric, bench_digits(s.our->median), s.our->median,
		        s.our->unit, s.our->name, bench_digits(s.their->median), s.their->median, s.their->unit, s.their->name);
}

static void say_trust(FILE *out, const bench_results *results)
{
	double scatter = scatter_of(results), stolen = most_stolen(results);
	uint32_t cpus = bench_cpu_count();
	if (isfinite(scatter))
		fprintf(out, "Differences below %.0f %% are noise, the typical spread between rounds of one subject",
		        100.0 * scatter);
	else
		fprintf(out, "No subject ran twice, so the noise of these numbers is unknown");
	if (results->options->quick)
		fprintf(out, "; the runs were short (--quick)");
	if (results->load > BENCH_BUSY_LOAD * cpus || stolen > BENCH_BUSY_STEAL)
		fprintf(
			out,
			"; the machine was busy (load average %.1f on %u CPU%s before the first run, hypervisor took up to %.0f %%"
			"), so repeat this on an idle one",
			results->load, cpus, cpus == 1 ? "" : "s", stolen);
	fprintf(out, "; the numbers hold for this CPU only.\n");
}

void bench_print_words(FILE *out, const bench_results *results)
{
	say_what_ran(out, results);
	say_standing(out, results);
	say_trust(out, results);
	fflush(out);
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

/* True if the subject was chosen, is built, and ran. */
static bool subject_ran(const bench_results *results, const bench_subject *subject)
{
	for (size_t p = 0; p < results->pair_count; p++)
		if (results->pairs[p].subject == subject && results->pairs[p].attempts > 0 && !results->pairs[p].skipped)
			return true;
	return false;
}

/* Prints the notes of the subjects that ran, and names every subject that is not built. */
static void print_notes(FILE *out, const bench_results *results)
{
	const bench_suite *suite = results->suite;
	char path[4096];
	fputc('\n', out);
	for (size_t s = 0; s < suite->subject_count; s++) {
		const bench_subject *subject = &suite->subjects[s];
		if (!bench_program_path(subject->program, path, sizeof path))
			fprintf(out, "%s: not built%s%s\n", subject->name, subject->package ? "; needs " : "",
			        subject->package ? subject->package : "");
		else if (subject->note && subject_ran(results, subject))
			fprintf(out, "%s: %s\n", subject->name, subject->note);
	}
}

void bench_print(FILE *out, const bench_results *results)
{
	static const char legend[] =
		"worst: worst run / median. / peer: median / the best peer's. / limit: median / the machine's limit.\n"
		"p50, p99, p99.9: so many percent of the calls of a run take less.\n";
	char machine[256];
	bench_machine(machine, sizeof machine);
	fprintf(out, "stilb-bench %s on %s\nbuilt with %s\n%u round%s; a run lasts %.2f s%s\n%s", results->suite->name,
	        machine, bench_build_flags(), results->rounds, results->rounds == 1 ? "" : "s", results->seconds,
	        results->options->quick ? " (--quick: too short for precise numbers)" : "",
	        results->suite->report_alone ? "" : legend);
	print_limits(out, results);
	if (!results->suite->report_alone)
		print_tables(out, results);
	print_comparisons(out, results);
	if (results->suite->report)
		results->suite->report(out, results);
	if (results->suite->goals && results->options->goals)
		results->suite->goals(out, results);
	print_notes(out, results);
	fflush(out); /* later lines on stderr then follow the tables, even if both streams go to one file */
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* Writes one row as an object of the JSON array that the caller has begun. */
static void json_row(stilb_json *json, const bench_row *row, const char *metric, const char *unit,
                     const bench_ratio *values, uint32_t runs)
{
	stilb_json_begin(json, NULL, '{');
	stilb_json_string(json, "case", row->on->name);
	stilb_json_string(json, "subject", row->name);
	stilb_json_string(json, "metric", metric);
	stilb_json_string(json, "unit", unit);
	stilb_json_double(json, "median", values->median);
	stilb_json_double(json, "min", values->min);
	stilb_json_double(json, "max", values->max);
	stilb_json_int(json, "runs", runs);
	stilb_json_end(json, '}');
}

/* Writes every row that has a value, and for each pair with runs that timed out their number. */
static void json_rows(stilb_json *json, const bench_results *results)
{
	for (size_t i = 0; i < results->row_count; i++) {
		const bench_row *row = &results->rows[i];
		const bench_pair *pair = pair_of(results, row);
		if (row->runs > 0)
			json_row(json, row, row->metric, row->unit, &(bench_ratio){row->median, row->min, row->max}, row->runs);
		if (strcmp(row->metric, BENCH_METRIC_STEAL) == 0 && pair->timeouts > 0) { /* each pair has one such row */
			double count = pair->timeouts;
			json_row(json, row, "timed-out", "runs", &(bench_ratio){count, count, count}, pair->attempts);
		}
	}
}

int bench_save_json(const bench_results *results, const char *path)
{
	char machine[256];
	bench_machine(machine, sizeof machine);
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "suite", results->suite->name);
	stilb_json_begin(&json, "machine", '{');
	stilb_json_string(&json, "cpu", machine);
	stilb_json_int(&json, "cpus", bench_cpu_count());
	stilb_json_string(&json, "flags", bench_build_flags());
	stilb_json_string(&json, "version", STILB_VERSION);
	stilb_json_double(&json, "seconds", results->seconds);
	stilb_json_int(&json, "rounds", results->rounds);
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, "rows", '[');
	json_rows(&json, results);
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	if (stilb_json_save(&json, path) == STILB_OK)
		return EXIT_DONE;
	stilb_log("%s", stilb_error_message());
	return EXIT_FAILED;
}
