/* The suite `simplify`: the simplifier of engine/geometry beside libmeshoptimizer at the same number of triangles: time
 * and how far the surface, its normals and its texture are from what they were. */
#include "bench/harness/bench.h"
#include "bench/simplify/simplify_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"peer", "ms", true, NULL},        {"stilb", "ms", true, NULL},     {"of-time", "x", true, NULL},
	{"speedup", "x", false, NULL},     {"of-rms", "x", true, NULL},     {"of-farthest", "x", true, NULL},
	{"of-normals", "x", true, NULL},   {"of-texture", "x", true, NULL}, {"triangles", "", true, NULL},
	{"of-triangles", "x", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, ...) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	SIMPLIFY_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-simplify",
     .package = "libmeshoptimizer-dev",
     .note = "time: CPU time of one thread; speedup: elapsed time of one thread by that of two"},
};

static double value(const bench_results *results, const char *on, const char *metric)
{
	const bench_row *row = bench_find(results, on, "stilb", metric);
	return row ? row->median : 0.0;
}

static void report(FILE *out, const bench_results *results)
{
	fprintf(out, "\nlibmeshoptimizer (meshopt_simplify) and Stilb; medians; x: Stilb's by libmeshoptimizer's\n\n");
	fprintf(out, "  %-10s %9s %8s %8s %7s %8s %8s %9s %8s %8s\n", "", "triangles", "peer, ms", "own, ms", "time, x",
	        "2 threads", "rms, x", "largest, x", "normal, x", "uv, x");
	for (size_t i = 0; i < COUNT(cases); i++) {
		const char *on = cases[i].name;
		if (value(results, on, "peer") > 0.0)
			fprintf(out, "  %-10s %9.0f %8.1f %8.1f %7.2f %9.2f %8.2f %10.2f %9.2f %8.2f\n", on,
			        value(results, on, "triangles"), value(results, on, "peer"), value(results, on, "stilb"),
			        value(results, on, "of-time"), value(results, on, "speedup"), value(results, on, "of-rms"),
			        value(results, on, "of-farthest"), value(results, on, "of-normals"),
			        value(results, on, "of-texture"));
	}
	fprintf(out,
	        "\n  rms, largest: distance of 60,000 points of each surface from the other\n"
	        "  normal, uv: rms of the difference at the nearest point; of several points that are as near, the best\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	static const struct {
		const char *metric, *title;
		double goal;
	} goals[] = {{"of-time", "time", 2.0},
	             {"of-rms", "distance, rms", 1.0},
	             {"of-normals", "normals", 0.7},
	             {"of-texture", "texture", 0.7}};
	fprintf(out, "\ngoals, at the same number of triangles:\n");
	for (size_t g = 0; g < COUNT(goals); g++) {
		uint32_t met = 0, of = 0;
		for (size_t i = 0; i < COUNT(cases); i++) {
			double ratio = value(results, cases[i].name, goals[g].metric);
			of += value(results, cases[i].name, "peer") > 0.0;
			met += ratio > 0.0 && ratio <= goals[g].goal;
		}
		fprintf(out, "  %-14s within %.1f x of libmeshoptimizer: %s in %u of %u cases\n", goals[g].title, goals[g].goal,
		        met == of ? "met" : "MISSED", met == of ? of : of - met, of);
	}
}

const bench_suite bench_simplify_suite = {.name = "simplify",
                                          .help = "coarser meshes, beside libmeshoptimizer",
                                          .subjects = subjects,
                                          .subject_count = COUNT(subjects),
                                          .cases = cases,
                                          .case_count = COUNT(cases),
                                          .report = report,
                                          .goals = print_goals,
                                          .report_alone = true,
                                          .start_seconds = 0.8,
                                          .quick_cpu_seconds = 20.0};
