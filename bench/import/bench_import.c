/* The suite `import`: what it costs that pictures are decoded by a process of their own (scene_import.h), beside libpng
 * in the same program. The cases are in import_cases.h. */
#include "bench/harness/bench.h"
#include "bench/import/import_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"libpng", "ms", true, NULL},   {"libpng-kept", "ms", true, NULL},   {"stilb", "ms", true, NULL},
	{"of-libpng", "x", true, NULL}, {"of-libpng-kept", "x", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, ...) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	IMPORT_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-import",
     .note = "CPU time of both processes together, user and system; medians; the process is started before"},
};

#define GOAL 1.1

static double value(const bench_results *results, const char *on, const char *metric)
{
	const bench_row *row = bench_find(results, on, "stilb", metric);
	return row ? row->median : 0.0;
}

static void print_ratio(FILE *out, const bench_row *row)
{
	char text[40];
	snprintf(text, sizeof text, "%.3f [%.3f-%.3f]", row->median, row->min, row->max);
	fprintf(out, "   %-20s", text);
}

static void report(FILE *out, const bench_results *results)
{
	fprintf(out, "\nms of CPU time for a PNG of 1024 x 1024, medians; ratios: median [least-most]\n\n");
	fprintf(out, "  %-10s %8s %8s %8s   %-20s   %s\n", "", "libpng", "kept", "stilb", "stilb / libpng", "/ kept");
	for (size_t i = 0; i < COUNT(cases); i++) {
		const char *on = cases[i].name;
		const bench_row *ratio = bench_find(results, on, "stilb", "of-libpng");
		const bench_row *kept = bench_find(results, on, "stilb", "of-libpng-kept");
		if (!ratio || !kept)
			continue;
		fprintf(out, "  %-10s %8.2f %8.2f %8.2f", on, value(results, on, "libpng"), value(results, on, "libpng-kept"),
		        value(results, on, "stilb"));
		print_ratio(out, ratio);
		print_ratio(out, kept);
		fputc('\n', out);
	}
	fprintf(out, "\n  libpng: decodes the file, which is in memory, into new memory of malloc's, and frees it\n"
	             "  kept: decodes into the same memory again and again\n"
	             "  stilb: asks the import process for the picture, until its pixels are here, and frees it\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoal: stilb within %.1f x of libpng\n", GOAL);
	for (size_t i = 0; i < COUNT(cases); i++) {
		double ratio = value(results, cases[i].name, "of-libpng");
		if (ratio > 0.0)
			fprintf(out, "  %-10s %.3f, %s\n", cases[i].name, ratio, ratio <= GOAL ? "met" : "MISSED");
	}
}

const bench_suite bench_import_suite = {.name = "import",
                                        .help = "pictures by way of the import process, beside libpng in this one",
                                        .subjects = subjects,
                                        .subject_count = COUNT(subjects),
                                        .cases = cases,
                                        .case_count = COUNT(cases),
                                        .report = report,
                                        .goals = print_goals,
                                        .report_alone = true,
                                        .start_seconds = 0.5};
