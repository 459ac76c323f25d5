/* The suite `bake`: unwrapping, packing and the raster of texels (engine/bake), on one thread and on two. */
#include "bench/bake/bake_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric unwrap_metrics[] = {
	{"core", "ms", true, NULL}, {"two", "ms", true, NULL}, {"stretch", "x", true, NULL}, {"charts", "", true, NULL}};
static const bench_metric pack_metrics[] = {{"core", "ms", true, NULL}, {"pages", "", true, NULL}};
static const bench_metric texel_metrics[] = {{"core", "ms", true, NULL}, {"texels", "M/s", false, NULL}};

#define METRICS_BAKE_LAND unwrap_metrics
#define METRICS_BAKE_KNOT unwrap_metrics
#define METRICS_BAKE_PACK pack_metrics
#define METRICS_BAKE_LARGE texel_metrics
#define METRICS_BAKE_SMALL texel_metrics

static const bench_case cases[] = {
#define CASE(NAME, TITLE, KIND)                                                                                        \
	{.name = NAME, .title = TITLE, .metrics = METRICS_##KIND, .metric_count = COUNT(METRICS_##KIND), .length = 1.0},
	BAKE_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-bake",
     .note = "core: CPU time of one thread; two: wall time with one worker beside the caller; texels: covered ones for "
             "each second of a core"},
};

static void print_goal(FILE *out, const bench_results *results, const char *name, const char *metric, double goal,
                       bool at_most)
{
	const bench_row *row = bench_find(results, name, "stilb", metric);
	if (row)
		fprintf(out, "goal: %s: %s %.4g, %s %.4g: %s\n", name, metric, row->median, at_most ? "at most" : "at least",
		        goal, (at_most ? row->median <= goal : row->median >= goal) ? "met" : "MISSED");
}

static void print_goals(FILE *out, const bench_results *results)
{
	fputc('\n', out);
	print_goal(out, results, "unwrap-land", "two", 2000.0, true);
	print_goal(out, results, "unwrap-knot", "two", 2000.0, true);
	print_goal(out, results, "pack-ones", "core", 10000.0, true);
	print_goal(out, results, "texels-large", "texels", 20.0, false);
	print_goal(out, results, "texels-small", "texels", 20.0, false);
}

const bench_suite bench_bake_suite = {.name = "bake",
                                      .help = "unwrapping scenes: charts, pages and texels",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .goals = print_goals};
