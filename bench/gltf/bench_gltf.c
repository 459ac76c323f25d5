/* The suite `gltf`: opening a glTF file by the import process, beside tinygltf in one program. The cases are in
 * gltf_cases.h. */
#include "bench/gltf/gltf_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"tinygltf", "ms", true, NULL}, {"stilb", "ms", true, NULL},   {"of-tinygltf", "x", true, NULL},
	{"of-cpu", "x", true, NULL},    {"memory", "MiB", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, PARTS, SIDE, TEXTURES, PIXELS, LENGTH)                                                       \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .length = LENGTH},
	GLTF_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-gltf",
     .package = "libtinygltf-dev",
     .note = "elapsed time, with the start and the end of the import process; of-cpu: the ratio of CPU time, user and "
             "system, of all processes; medians"},
};

#define GOAL 1.2

static double value(const bench_results *results, const char *on, const char *metric)
{
	const bench_row *row = bench_find(results, on, "stilb", metric);
	return row ? row->median : 0.0;
}

static void report(FILE *out, const bench_results *results)
{
	fprintf(out, "\nms until a file is open, medians; ratios: median [least-most]\n\n");
	fprintf(out, "  %-10s %10s %10s   %-22s %8s %12s\n", "", "tinygltf", "stilb", "stilb / tinygltf", "of CPU",
	        "memory, MiB");
	for (size_t i = 0; i < COUNT(cases); i++) {
		const char *on = cases[i].name;
		const bench_row *ratio = bench_find(results, on, "stilb", "of-tinygltf");
		char text[40];
		if (!ratio)
			continue;
		snprintf(text, sizeof text, "%.3f [%.3f-%.3f]", ratio->median, ratio->min, ratio->max);
		fprintf(out, "  %-10s %10.1f %10.1f   %-22s %8.3f %12.1f\n", on, value(results, on, "tinygltf"),
		        value(results, on, "stilb"), text, value(results, on, "of-cpu"), value(results, on, "memory"));
	}
	fprintf(out, "\n  tinygltf: parses the file, reads its buffers and decodes its textures, in this process and one "
	             "thread; makes no scene\n"
	             "  stilb: stilb_scene_open, until the scene is here and its memory is seen\n"
	             "  memory: the most that the import process had at once\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	double ratio = value(results, "million", "of-tinygltf");
	fprintf(out, "\ngoal: stilb within %.1f x of tinygltf with textures\n", GOAL);
	if (ratio > 0.0)
		fprintf(out, "  million %.3f, %s\n", ratio, ratio <= GOAL ? "met" : "MISSED");
}

const bench_suite bench_gltf_suite = {.name = "gltf",
                                      .help = "opening glTF files, beside tinygltf",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .report = report,
                                      .goals = print_goals,
                                      .report_alone = true,
                                      .start_seconds = 0.5,
                                      .quick_cpu_seconds = 60.0};
