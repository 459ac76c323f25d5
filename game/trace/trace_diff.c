/* stilb trace diff: compares two traces and lists the zones that got slower. */
#include "game/cli/flags.h"
#include "trace.h"

#include "base/base_file.h"
#include "profiler/prof_diff.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct diff_options {
	const char *threshold, *alpha, *json;
	const char *file[2];
	uint64_t lines;
	int per;
} diff_options;

typedef struct diff_run {
	diff_options options;
	stilb_prof_diff_desc desc;
	stilb_prof_snapshot trace[2];
	stilb_prof_diff diff;
} diff_run;

static const char *const per_choices[] = {"call", "frame", NULL};
static const char *const verdicts[] = {"slower", "faster", "only in B", "only in A", "same"};

static flags_result diff_parse(diff_options *o, int argc, char **argv)
{
	const flag flags[] = {
		{"--threshold", FLAG_TEXT, &o->threshold, "PERCENT", "smallest change of the median that counts, percent (5)",
	     0, 0, NULL},
		{"--alpha", FLAG_TEXT, &o->alpha, "P", "chance of a false alarm in two equal runs, 0..1 (0.01)", 0, 0, NULL},
		{"--per", FLAG_CHOICE, &o->per, "call|frame",
	     "compare single calls of a zone, or its total in each frame (call)", 0, 0, per_choices},
		{"--lines", FLAG_NUMBER, &o->lines, "N", "zones to list, 1..1000000 (30)", 1, 1000000, NULL},
		{"--json", FLAG_TEXT, &o->json, "FILE", "all rows as JSON; - is standard output", 0, 0, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf(
			"stilb trace diff A B [FLAGS]: lists the zones that got slower from A to B. It compares medians; a\n"
			"Mann-Whitney test tells changes from chance. Exit status 0: no zone is slower, 1: one is, 2: an error.\n"
			"A busy machine makes all zones slower: compare runs on a quiet one, and set the threshold above the\n"
			"difference of two runs of the same program.\n\n");
		flags_print(flags, count);
	}
	return result;
}

/* Reads a decimal number in [0, high]; NULL leaves *value alone. False after a message: text is no such number. */
static bool diff_number(const char *flag_name, const char *text, double high, double *value)
{
	char *end;
	if (!text)
		return true;
	double number = strtod(text, &end);
	if (strspn(text, "0123456789.") == strlen(text) && end != text && *end == '\0' && number <= high) {
		*value = number;
		return true;
	}
	stilb_log("%s: '%s' is not a number in 0..%g", flag_name, text, high);
	return false;
}

static bool diff_check(diff_run *run, const trace_files *files)
{
	double percent = 100.0 * run->desc.threshold;
	if (!diff_number("--threshold", run->options.threshold, 1e6, &percent) ||
	    !diff_number("--alpha", run->options.alpha, 1.0, &run->desc.alpha) ||
	    !trace_check("diff", files, run->options.json))
		return false;
	run->desc.threshold = percent / 100.0;
	run->desc.sample = (stilb_prof_diff_sample)run->options.per;
	for (int i = 0; i < 2; i++)
		run->options.file[i] = files->path[i];
	return true;
}

static bool diff_load(diff_run *run)
{
	for (int i = 0; i < 2; i++) {
		if (!trace_load(run->options.file[i], &run->trace[i]))
			return false;
		if (run->desc.sample == STILB_PROF_DIFF_PER_FRAME && run->trace[i].frame_count == 0) {
			stilb_log("--per frame: there are no whole frames in '%s'; use --per call", run->options.file[i]);
			return false;
		}
	}
	if (stilb_prof_diff_make(&run->diff, &run->trace[0], &run->trace[1], &run->desc) == 0)
		return true;
	stilb_log("no memory to compare '%s' and '%s'", run->options.file[0], run->options.file[1]);
	return false;
}

/* Returns a total of trace A (side 0) or B (side 1), divided by its number of frames if both traces have frames, so
 * that traces of different length can be compared. */
static double diff_mean(const diff_run *run, int side, double total)
{
	return run->diff.frames ? total / run->trace[side].frame_count : total;
}

static void diff_print_row(FILE *out, const diff_run *run, const stilb_prof_diff_row *row)
{
	char change[16] = "-", p[16] = "-";
	int digits = run->diff.frames ? 2 : 0; /* decimals of the number of calls; a number per frame has a fraction */
	if (row->a.calls > 0 && row->b.calls > 0) {
		if (row->ratio < 10.0)
			snprintf(change, sizeof change, "%+.1f %%", 100.0 * (row->ratio - 1.0));
		else
			snprintf(change, sizeof change, "%.3g x", row->ratio);
		snprintf(p, sizeof p, row->p >= 0.001 ? "%.3f" : "%.0e", row->p);
	}
	fprintf(out, "%-9s %9.*f %9.*f %10.3f %10.3f %9s %8s %10.3f %10.3f %10.4f %10.4f  ", verdicts[row->verdict], digits,
	        diff_mean(run, 0, row->a.calls), digits, diff_mean(run, 1, row->b.calls), trace_us(row->a.p50_ns),
	        trace_us(row->b.p50_ns), change, p, trace_us(row->a.p99_ns), trace_us(row->b.p99_ns),
	        diff_mean(run, 0, trace_ms(row->a.self_ns)), diff_mean(run, 1, trace_ms(row->b.self_ns)));
	trace_print_name(out, row->name, row->kind);
}

static void diff_print(FILE *out, const diff_run *run)
{
	const stilb_prof_diff *diff = &run->diff;
	for (int i = 0; i < 2; i++) {
		fprintf(out, "%c  ", "AB"[i]);
		trace_print_summary(out, run->options.file[i], &run->trace[i]);
	}
	fprintf(out, "p50 and p99 are those of %s, calls and self times %s\n\n",
	        run->desc.sample == STILB_PROF_DIFF_PER_FRAME ? "a zone's time in a frame" : "single zones",
	        diff->frames ? "are per frame" : "of the whole file");
	fprintf(out, "%-9s %9s %9s %10s %10s %9s %8s %10s %10s %10s %10s  zone\n", "", "calls A", "calls B", "p50 us A",
	        "p50 us B", "change", "p", "p99 us A", "p99 us B", "self ms A", "self ms B");
	uint32_t lines = run->options.lines < diff->row_count ? (uint32_t)run->options.lines : diff->row_count;
	for (uint32_t i = 0; i < lines; i++)
		diff_print_row(out, run, &diff->rows[i]);
	if (lines < diff->row_count)
		fprintf(out, "and %" PRIu32 " more: --lines %" PRIu32 "\n", diff->row_count - lines, diff->row_count);
	fprintf(out, "\n%" PRIu32 " of %" PRIu32 " zones %s slower by more than %g %% (alpha %g)\n", diff->slower,
	        diff->row_count, diff->slower == 1 ? "is" : "are", 100.0 * run->desc.threshold, run->desc.alpha);
}

static void diff_json_side(stilb_json *json, const char *key, const stilb_prof_diff_side *side)
{
	stilb_json_begin(json, key, '{');
	stilb_json_int(json, "calls", side->calls);
	trace_json_ns(json, "total_ns", side->inclusive_ns);
	trace_json_ns(json, "self_ns", side->self_ns);
	trace_json_ns(json, "p50_ns", side->p50_ns);
	trace_json_ns(json, "p99_ns", side->p99_ns);
	stilb_json_end(json, '}');
}

static stilb_result diff_save(const diff_run *run)
{
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "a", run->options.file[0]);
	stilb_json_string(&json, "b", run->options.file[1]);
	stilb_json_int(&json, "frames_a", run->trace[0].frame_count);
	stilb_json_int(&json, "frames_b", run->trace[1].frame_count);
	stilb_json_string(&json, "per", per_choices[run->options.per]);
	stilb_json_double(&json, "threshold", run->desc.threshold);
	stilb_json_double(&json, "alpha", run->desc.alpha);
	stilb_json_int(&json, "slower", run->diff.slower);
	stilb_json_begin(&json, "rows", '[');
	for (uint32_t i = 0; i < run->diff.row_count; i++) {
		const stilb_prof_diff_row *row = &run->diff.rows[i];
		stilb_json_begin(&json, NULL, '{');
		stilb_json_string(&json, "zone", row->name);
		stilb_json_bool(&json, "device", row->kind == STILB_PROF_LANE_DEVICE);
		stilb_json_string(&json, "verdict", verdicts[row->verdict]);
		stilb_json_double(&json, "ratio", row->ratio);
		stilb_json_double(&json, "p", row->p);
		diff_json_side(&json, "a", &row->a);
		diff_json_side(&json, "b", &row->b);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, run->options.json);
}

/* Errors are EXIT_REFUSED, even while running: exit status 1 (EXIT_FAILED) means only that a zone is slower. */
static int diff_main(diff_run *run)
{
	const char *json = run->options.json;
	if (!diff_load(run))
		return EXIT_REFUSED;
	diff_print(json && stilb_file_is_stdout(json) ? stderr : stdout, run);
	if (json && diff_save(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_REFUSED;
	}
	if (fflush(stdout) != 0 || ferror(stdout)) {
		stilb_log("cannot write to standard output");
		return EXIT_REFUSED;
	}
	return run->diff.slower > 0 ? EXIT_FAILED : EXIT_DONE;
}

int trace_diff_command(int argc, char **argv)
{
	diff_run run = {.options = {.lines = 30}, .desc = stilb_prof_diff_desc_default()};
	trace_files files = trace_take_files(2, &argc, &argv);
	flags_result parsed = diff_parse(&run.options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !diff_check(&run, &files))
		return EXIT_REFUSED;
	int code = diff_main(&run);
	stilb_prof_diff_finish(&run.diff);
	for (int i = 0; i < 2; i++)
		stilb_prof_snapshot_finish(&run.trace[i]);
	return code;
}
