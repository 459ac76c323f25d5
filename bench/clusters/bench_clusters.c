/* The suite `clusters`: clusters and levels of meshes of millions of triangles: time, memory, what errors say. */
#include "bench/clusters/clusters_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"elapsed", "s", true, NULL}, {"cpu", "s", true, NULL},         {"memory", "x", true, NULL},
	{"groups", "", true, NULL},   {"coarser", "x", true, NULL},     {"level", "k", true, NULL},
	{"error", "x", true, NULL},   {"transformed", "x", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, ...) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	CLUSTERS_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {{.name = "stilb", .program = "stilb-bench-clusters"}};

static double value(const bench_results *results, const char *on, const char *metric)
{
	const bench_row *row = bench_find(results, on, "stilb", metric);
	return row ? row->median : 0.0;
}

static void report(FILE *out, const bench_results *results)
{
	fprintf(out, "\nclusters and levels (stilb_geometry_levels); medians\n\n");
	fprintf(out, "  %-8s %9s %9s %9s %9s %8s %10s %10s %8s %8s\n", "", "elapsed,s", "CPU, s", "thread, s", "memory, x",
	        "groups", "coarser, x", "level 1, k", "error, x", "vertices");
	for (size_t i = 0; i < COUNT(cases); i++) {
		const char *on = cases[i].name;
		if (value(results, on, "cpu") > 0.0)
			fprintf(out, "  %-8s %9.1f %9.1f %9.1f %9.2f %8.0f %10.2f %10.1f %8.2f %8.2f\n", on,
			        value(results, on, "elapsed"), value(results, on, "cpu"), value(results, on, "thread"),
			        value(results, on, "memory"), value(results, on, "groups"), value(results, on, "coarser"),
			        value(results, on, "level"), value(results, on, "error"), value(results, on, "transformed"));
	}
	fprintf(out,
	        "\n  thread: CPU time of the calling thread, which is what two idle CPUs would take\n"
	        "  memory: the most that the process had, by the size of the mesh alone\n"
	        "  coarser: triangles of all clusters that are not the mesh's own, by the mesh's\n"
	        "  error: what is stated for cuts as seen from three places, by the farthest of 10^6 points of the mesh\n"
	        "  vertices: transformed for a triangle, with a cache of 16\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	static const struct {
		const char *metric, *title, *unit;
		double goal;
	} goals[] = {{"elapsed", "10 million triangles on two CPUs", "s", 30.0}, {"memory", "memory", "x", 3.0}};
	fprintf(out, "\ngoals:\n");
	for (size_t g = 0; g < COUNT(goals); g++)
		for (size_t i = 0; i < COUNT(cases); i++) {
			double own = value(results, cases[i].name, goals[g].metric);
			if (own > 0.0)
				fprintf(out, "  %s, %-8s %6.2f %s of %.0f: %s\n", goals[g].title, cases[i].name, own, goals[g].unit,
				        goals[g].goal, own <= goals[g].goal ? "met" : "MISSED");
		}
}

const bench_suite bench_clusters_suite = {.name = "clusters",
                                          .help = "clusters of meshes of millions of triangles",
                                          .subjects = subjects,
                                          .subject_count = COUNT(subjects),
                                          .cases = cases,
                                          .case_count = COUNT(cases),
                                          .report = report,
                                          .goals = print_goals,
                                          .report_alone = true,
                                          .start_seconds = 5.0,
                                          .quick_rounds = 1,
                                          .quick_cpu_seconds = 200.0};
