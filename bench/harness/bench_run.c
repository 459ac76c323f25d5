/* Runs a benchmark suite: chooses the subjects (implementations) and cases (workloads), runs them in rounds within
 * their time limits, and reports. */
#include "bench/harness/bench_child.h"
#include "bench/harness/bench_internal.h"

#include "base/base_file.h"
#include "game/cli/flags.h"
#include "game/cli/gnuplot.h"

#include <fnmatch.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define QUICK_BUDGET 17.0     /* --quick: seconds for all runs of the suite and for the starts of their processes */
#define QUICK_DEADLINE 25.0   /* --quick: seconds after which no run starts */
#define QUICK_CPU_SECONDS 1.5 /* --quick: CPU time, s, that a run may use on each CPU beyond 1.5 times its length */
#define CPU_SECONDS 20.0      /* the same without --quick */
#define MAX_TIMEOUTS 2        /* a subject that timed out so often in a case is not run in it again; --quick: 1 */
#define PROCESS_SECONDS 0.008 /* the time to start and end a process */

#define LIST_WIDTH 25 /* columns for a name that --list prints */

/* ---- choosing ---------------------------------------------------------------------------------------------------- */

/* True if a word of the list "a,b*", each a shell pattern, matches the name; a NULL list matches everything. */
static bool listed(const char *list, const char *name)
{
	if (!list)
		return true;
	for (const char *at = list; *at;) {
		size_t length = strcspn(at, ",");
		char pattern[128];
		snprintf(pattern, sizeof pattern, "%.*s", (int)length, at);
		if (fnmatch(pattern, name, 0) == 0)
			return true;
		at += length + (at[length] == ',');
	}
	return false;
}

/* The name of the i-th case (cases true) or subject; NULL after the last. */
static const char *name_of(const bench_suite *suite, bool cases, size_t i)
{
	if (cases)
		return i < suite->case_count ? suite->cases[i].name : NULL;
	return i < suite->subject_count ? suite->subjects[i].name : NULL;
}

/* False, after a line on stderr, if a word of the list matches no subject or case. */
static bool check_list(const bench_suite *suite, const char *flag_name, const char *list, bool cases)
{
	for (const char *at = list; at && *at;) {
		char word[128];
		size_t length = strcspn(at, ","), i = 0;
		snprintf(word, sizeof word, "%.*s", (int)length, at);
		while (name_of(suite, cases, i) && !listed(word, name_of(suite, cases, i)))
			i++;
		if (!name_of(suite, cases, i)) {
			stilb_log("%s: suite %s has no %s '%s'; --list shows them", flag_name, suite->name,
			          cases ? "case" : "subject", word);
			return false;
		}
		at += length + (at[length] == ',');
	}
	return true;
}

static bool built(const bench_subject *subject)
{
	char path[PATH_MAX];
	return bench_program_path(subject->program, path, sizeof path);
}

static bool runs(const bench_subject *subject, const bench_case *on)
{
	return (on->needs & ~subject->abilities) == 0;
}

static void print_list(const bench_suite *suite)
{
	printf("subjects of %s (what --only chooses from):\n", suite->name);
	for (size_t i = 0; i < suite->subject_count; i++) {
		const bench_subject *subject = &suite->subjects[i];
		printf("  %-*s", LIST_WIDTH, subject->name);
		if (!built(subject))
			printf(" (not built%s%s)", subject->package ? ": needs " : "", subject->package ? subject->package : "");
		printf(" %s\n", subject->note ? subject->note : "");
	}
	printf("\ncases of %s (what --case chooses from):\n", suite->name);
	for (size_t i = 0; i < suite->case_count; i++)
		printf("  %-*s %s\n", LIST_WIDTH, suite->cases[i].name, suite->cases[i].title);
}

/* ---- the table of results ---------------------------------------------------------------------------------------- */

/* Adds the rows of a case: metric by metric, and for each metric its subjects. */
static stilb_result add_rows(bench_results *results, const bench_case *on)
{
	static const bench_metric own[] = {{BENCH_METRIC_MEMORY, "MiB", true, NULL}, {BENCH_METRIC_STEAL, "%", true, NULL}};
	for (size_t m = 0; m < on->metric_count + 2; m++) {
		const bench_metric *metric = m < on->metric_count ? &on->metrics[m] : &own[m - on->metric_count];
		for (size_t p = 0; p < results->pair_count; p++)
			if (results->pairs[p].on == on && bench_add_row(results, on, results->pairs[p].subject, metric) != STILB_OK)
				return STILB_ERROR_MEMORY;
	}
	return STILB_OK;
}

/* Fills results->pairs and ->rows: the machine's limits, then every chosen subject that is built, in every chosen case
 * that it can do. */
static stilb_result plan(bench_results *results)
{
	const bench_suite *suite = results->suite;
	const bench_options *options = results->options;
	results->pairs = calloc(1 + suite->case_count * suite->subject_count, sizeof *results->pairs);
	if (!results->pairs)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for the table");
	results->pairs[results->pair_count++] = (bench_pair){.on = &bench_limits_case, .subject = &bench_limits_subject};
	for (size_t c = 0; c < suite->case_count; c++)
		for (size_t s = 0; s < suite->subject_count; s++) {
			const bench_case *on = &suite->cases[c];
			const bench_subject *subject = &suite->subjects[s];
			if (listed(options->cases, on->name) && listed(options->only, subject->name) && runs(subject, on) &&
			    built(subject))
				results->pairs[results->pair_count++] = (bench_pair){.on = on, .subject = subject};
		}
	if (results->pair_count == 1)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "none of the chosen subjects is built and has a chosen case; --list shows them");
	for (size_t p = 0; p < results->pair_count; p++)
		if ((p == 0 || results->pairs[p].on != results->pairs[p - 1].on) &&
		    add_rows(results, results->pairs[p].on) != STILB_OK)
			return STILB_ERROR_MEMORY;
	return STILB_OK;
}

static void results_finish(bench_results *results)
{
	for (size_t i = 0; i < results->row_count; i++)
		free((double *)results->rows[i].values);
	free(results->rows);
	free(results->pairs);
}

/* Sets the value of a pair's metric in the current round. */
static void set_value(bench_results *results, const bench_pair *pair, const char *metric, double value)
{
	bench_set_value(results, pair->on, pair->subject, metric, results->rounds - 1, value);
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* A run of this case lasts so many times run_seconds. */
static double length_of(const bench_case *on)
{
	return on->length > 0.0 ? on->length : 1.0;
}

/* The length, seconds, of a run of a case of length 1: that of --seconds. Without it, as --quick allows: so long that
 * all runs of all rounds, with the starts of their processes, fit into QUICK_BUDGET, but from 0.01 to 0.2 s. */
static double run_seconds(const bench_results *results)
{
	const bench_options *options = results->options;
	if (options->seconds > 0.0)
		return options->seconds;
	double lengths = 0.0;
	for (size_t p = 0; p < results->pair_count; p++)
		lengths += length_of(results->pairs[p].on);
	double starting = (double)results->pair_count * (PROCESS_SECONDS + results->suite->start_seconds);
	double seconds = (QUICK_BUDGET / options->rounds - starting) / lengths;
	return fmin(fmax(seconds, 0.01), 0.2);
}

static void run_pair(bench_results *results, bench_pair *pair, const char *argument)
{
	double seconds = results->seconds * length_of(pair->on);
	double usual = results->suite->quick_cpu_seconds > 0.0 ? results->suite->quick_cpu_seconds : QUICK_CPU_SECONDS;
	double each = seconds * 1.5 + (results->options->quick ? usual : CPU_SECONDS);
	bench_limit limit = {.cpu_seconds = each * bench_cpu_count(), .seconds = results->options->give_up};
	bench_child_result child;
	bench_child_run(pair->subject->program, pair->subject->name, pair->on->name, seconds, results->rounds - 1, argument,
	                limit, &child);
	pair->attempts++;
	switch (child.state) {
	case BENCH_CHILD_DONE:
		for (size_t i = 0; i < child.value_count; i++)
			set_value(results, pair, child.values[i].metric, child.values[i].value);
		set_value(results, pair, BENCH_METRIC_MEMORY, child.peak_mb);
		set_value(results, pair, BENCH_METRIC_STEAL, child.steal);
		return;
	case BENCH_CHILD_SKIPPED:
		pair->skipped = true;
		break;
	case BENCH_CHILD_FAILED:
		pair->failures++;
		break;
	case BENCH_CHILD_TIMED_OUT:
		pair->timeouts++;
		break;
	}
	memcpy(pair->message, child.message, sizeof pair->message);
}

static bool left_out(const bench_results *results, const bench_pair *pair)
{
	return pair->skipped || pair->timeouts >= (results->options->quick ? 1 : MAX_TIMEOUTS);
}

/* Runs each of the pairs [first, end), which are the subjects of one case, once. Each round starts with another pair,
 * since a run influences the next one (clock frequency, temperature, caches). False: the deadline has passed. */
static bool run_case(bench_results *results, size_t first, size_t end, const char *argument, uint64_t deadline_ns)
{
	size_t count = end - first, turn = results->rounds - 1;
	for (size_t i = 0; i < count; i++) {
		bench_pair *pair = &results->pairs[first + (i + turn) % count];
		if (left_out(results, pair))
			continue;
		if (bench_child_now_ns() > deadline_ns)
			return false;
		if (isatty(STDERR_FILENO))
			fprintf(stderr, "\r\033[Kround %u of %u: %s, %s", results->rounds, results->options->rounds, pair->on->name,
			        pair->subject->name);
		run_pair(results, pair, argument);
	}
	return true;
}

static void run_rounds(bench_results *results, const char *argument)
{
	uint64_t begin = bench_child_now_ns();
	uint64_t deadline_ns = results->options->quick ? begin + (uint64_t)(QUICK_DEADLINE * 1e9) : UINT64_MAX;
	bool in_time = true;
	while (in_time && results->rounds < results->options->rounds) {
		results->rounds++;
		for (size_t first = 0, end; in_time && first < results->pair_count; first = end) {
			for (end = first; end < results->pair_count && results->pairs[end].on == results->pairs[first].on;)
				end++;
			in_time = run_case(results, first, end, argument, deadline_ns);
		}
		fprintf(stderr, "%sround %u of %u done after %.0f s\n", isatty(STDERR_FILENO) ? "\r\033[K" : "",
		        results->rounds, results->options->rounds, (double)(bench_child_now_ns() - begin) * 1e-9);
	}
	if (!in_time)
		stilb_log("--quick: out of time before all rounds were done; rows with fewer runs say how many they have");
}

/* Logs every pair that failed and every subject of Stilb's that timed out; EXIT_FAILED if there is one. */
static int verdict(const bench_results *results)
{
	int code = EXIT_DONE;
	for (size_t p = 0; p < results->pair_count; p++) {
		const bench_pair *pair = &results->pairs[p];
		bool ours = strncmp(pair->subject->name, "stilb", 5) == 0;
		if (pair->failures == 0 && !(ours && pair->timeouts > 0))
			continue;
		stilb_log("%s in %s: %s", pair->subject->name, pair->on->name, pair->message);
		code = EXIT_FAILED;
	}
	return code;
}

static int run_and_report(bench_results *results)
{
	const bench_options *options = results->options;
	const char *argument = NULL;
	results->seconds = run_seconds(results);
	if (getloadavg(&results->load, 1) != 1)
		results->load = 0.0;
	if (results->suite->prepare && !(argument = results->suite->prepare(options)))
		return EXIT_FAILED;
	run_rounds(results, argument);
	bench_summarise(results);
	if (results->suite->finish) {
		results->suite->finish(results);
		bench_summarise(results); /* again, for the rows that suite->finish has filled */
	}
	FILE *out = options->json && stilb_file_is_stdout(options->json) ? stderr : stdout;
	bench_print(out, results);
	int code = verdict(results);
	bench_print_words(out, results);
	if (options->json && bench_save_json(results, options->json) != EXIT_DONE)
		code = EXIT_FAILED;
	if (options->plot && bench_save_plot(results, options->plot) != EXIT_DONE)
		code = EXIT_FAILED;
	return code;
}

/* True if the name can be a word on a command line and in a list of --only or --case. */
static bool is_word(const char *name)
{
	return name && *name && !strpbrk(name, " \t\n,");
}

static bool case_is_sound(const bench_case *on)
{
	bool sound = is_word(on->name) && on->title && on->metric_count > 0 && on->length >= 0.0;
	for (size_t m = 0; sound && m < on->metric_count; m++)
		sound = is_word(on->metrics[m].name) && strlen(on->metrics[m].name) < 48 && on->metrics[m].unit;
	return sound;
}

static bool case_has_metric(const bench_suite *suite, const char *case_name, const char *metric)
{
	for (size_t c = 0; c < suite->case_count; c++)
		for (size_t m = 0; m < suite->cases[c].metric_count; m++)
			if (strcmp(suite->cases[c].name, case_name) == 0 && strcmp(suite->cases[c].metrics[m].name, metric) == 0)
				return true;
	return false;
}

/* True if the suite's tables meet the demands of bench.h. Tables are part of the source, so false is a programmer's
 * mistake. */
static bool suite_is_sound(const bench_suite *suite)
{
	bool sound = suite->name && suite->help && suite->case_count > 0 && suite->subject_count <= BENCH_MAX_SUBJECTS &&
	             (!suite->report_alone || suite->report) && (!suite->plot || suite->plot_rows > 0);
	for (size_t c = 0; sound && c < suite->case_count; c++) {
		sound = case_is_sound(&suite->cases[c]);
		for (size_t other = 0; sound && other < c; other++)
			sound = strcmp(suite->cases[c].name, suite->cases[other].name) != 0;
	}
	for (size_t s = 0; sound && s < suite->subject_count; s++) {
		sound =
			is_word(suite->subjects[s].name) && suite->subjects[s].program && !strchr(suite->subjects[s].program, '/');
		for (size_t other = 0; sound && other < s; other++)
			sound = strcmp(suite->subjects[s].name, suite->subjects[other].name) != 0;
	}
	for (size_t p = 0; sound && p < suite->panel_count; p++)
		for (const char *const *name = suite->panels[p].cases; sound && *name; name++)
			sound = case_has_metric(suite, *name, suite->panels[p].metric);
	return sound;
}

int bench_run(const bench_suite *suite, const bench_options *options)
{
	STILB_ASSERT(suite && options);
	STILB_ASSERT(options->rounds >= 1 && options->give_up >= 1 && options->seconds >= 0.0);
	STILB_ASSERT((options->quick || options->list || options->seconds > 0.0) && "only --quick chooses the length");
	STILB_ASSERT((!options->traces || suite->traces) && "the suite's programs write timelines");
	STILB_CHECK(suite_is_sound(suite));
	if (!check_list(suite, "--only", options->only, false) || !check_list(suite, "--case", options->cases, true))
		return EXIT_REFUSED;
	if (options->list) {
		print_list(suite);
		return EXIT_DONE;
	}
	if (options->plot && !gnuplot_found()) {
		stilb_log("--plot: " GNUPLOT_MISSING);
		return EXIT_REFUSED;
	}
	bench_results results = {.suite = suite, .options = options};
	stilb_result planned = plan(&results);
	int code;
	if (planned == STILB_OK) {
		code = run_and_report(&results);
	} else {
		stilb_log("%s", stilb_error_message());
		code = planned == STILB_ERROR_ARGUMENT ? EXIT_REFUSED : EXIT_FAILED;
	}
	results_finish(&results);
	return code;
}
