/* The suites `lod` and `pop`: what levels of detail cost and save, and what is seen of their changes. */
#include "bench/detail/detail_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))
#define PROGRAM "stilb-bench-detail"

static const bench_metric frame_metrics[] = {{"off", "ms", true, NULL},          {"pop", "ms", true, NULL},
                                             {"fade", "ms", true, NULL},         {"morph", "ms", true, NULL},
                                             {"pop/off", "x", true, NULL},       {"fade/off", "x", true, NULL},
                                             {"morph/off", "x", true, NULL},     {"triangles-off", "k", true, NULL},
                                             {"triangles-pop", "k", true, NULL}, {"triangles-morph", "k", true, NULL}};
static const bench_metric record_metrics[] = {{"off", "ms", true, NULL},     {"pop", "ms", true, NULL},
                                              {"fade", "ms", true, NULL},    {"morph", "ms", true, NULL},
                                              {"pop/off", "x", true, NULL},  {"fade/off", "x", true, NULL},
                                              {"morph/off", "x", true, NULL}};
static const bench_metric flight_metrics[] = {{"off", "ms", true, NULL},     {"pop", "ms", true, NULL},
                                              {"fade", "ms", true, NULL},    {"morph", "ms", true, NULL},
                                              {"pop/off", "x", true, NULL},  {"fade/off", "x", true, NULL},
                                              {"morph/off", "x", true, NULL}};
static const bench_metric million_metrics[] = {
	{"off", "ms", true, NULL}, {"pop", "ms", true, NULL}, {"pop/off", "x", true, NULL}, {"memory", "%", true, NULL}};
static const bench_metric horde_metrics[] = {{"impostors", "ms", true, NULL},
                                             {"meshes", "ms", true, NULL},
                                             {"impostors/meshes", "x", true, NULL},
                                             {"levels", "ms", true, NULL},
                                             {"level-triangles", "a model", true, NULL},
                                             {"bake", "ms", true, NULL},
                                             {"maps", "MiB", true, NULL},
                                             {"pixels", "px", false, NULL},
                                             {"rms-8", "%", true, NULL},
                                             {"rms-16", "%", true, NULL}};
#define VIEW_METRICS(VIEW)                                                                                             \
	{VIEW "-off", "ms", true, NULL}, {VIEW "-pop", "ms", true, NULL}, {VIEW "-pop/off", "x", true, NULL},              \
		{VIEW "-record", "ms", true, NULL}, {VIEW "-draws", "", true, NULL},                                           \
	{                                                                                                                  \
		VIEW "-triangles", "/px", true, NULL                                                                           \
	}
static const bench_metric clusters_metrics[] = {
	VIEW_METRICS("near"), VIEW_METRICS("whole"), {"triangles", "k", false, NULL}, {"make", "s", true, NULL}};
static const bench_metric vertices_metrics[] = {{"floats", "ms", true, NULL},       {"packed", "ms", true, NULL},
                                                {"packed/floats", "x", true, NULL}, {"away-floats", "ns", true, NULL},
                                                {"away-packed", "ns", true, NULL},  {"upload-floats", "ms", true, NULL},
                                                {"upload-packed", "ms", true, NULL}};
static const bench_metric memory_metrics[] = {{"scene-off", "MiB", true, NULL},   {"scene-pop", "MiB", true, NULL},
                                              {"scene-morph", "MiB", true, NULL}, {"off", "MiB", true, NULL},
                                              {"pop", "MiB", true, NULL},         {"morph", "MiB", true, NULL},
                                              {"more-pop", "%", true, NULL},      {"more-morph", "%", true, NULL}};
#define POP_METRICS(MODE)                                                                                              \
	{MODE "-pixel", "%", true, NULL}, {MODE "-8x8", "%", true, NULL}, {MODE "-static", "%", true, NULL},               \
		{MODE "-static-8x8", "%", true, NULL},                                                                         \
	{                                                                                                                  \
		MODE "-rms", "%", true, NULL                                                                                   \
	}
static const bench_metric pop_metrics[] = {POP_METRICS("pop"), POP_METRICS("fade"), POP_METRICS("morph")};
static const bench_metric nearer_metrics[] = {
	{"fade-static-8x8", "x", false, NULL},  {"fade-8x8", "x", false, NULL},  {"fade-static", "x", false, NULL},
	{"morph-static-8x8", "x", false, NULL}, {"morph-8x8", "x", false, NULL}, {"morph-static", "x", false, NULL}};

#define CASE(NAME, TITLE, METRICS, ...)                                                                                \
	{.name = NAME, .title = TITLE, .metrics = METRICS##_metrics, .metric_count = COUNT(METRICS##_metrics)},
static const bench_case lod_cases[] = {DETAIL_FRAMES(CASE) DETAIL_OTHERS(CASE)};
static const bench_case pop_cases[] = {DETAIL_POPS(CASE)};
#undef CASE

static const bench_subject subjects[] = {
	{.name = "stilb", .program = PROGRAM, .note = "the modes of --lod take turns, frame by frame, in one process"},
};

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void report_case(FILE *out, const bench_results *results, const bench_case *on)
{
	bool titled = false;
	for (size_t m = 0; m < on->metric_count; m++) {
		const bench_row *row = bench_find(results, on->name, "stilb", on->metrics[m].name);
		if (!row)
			continue;
		if (!titled)
			fprintf(out, "  %s: %s\n", on->name, on->title);
		titled = true;
		fprintf(out, "    %-18s %10.4g [%.4g-%.4g] %s\n", row->metric, row->median, row->min, row->max, row->unit);
	}
}

static void report(FILE *out, const bench_results *results)
{
	const bench_suite *suite = bench_suite_of(results);
	for (size_t i = 0; i < suite->case_count; i++)
		report_case(out, results, &suite->cases[i]);
}

typedef struct goal {
	const char *name, *metric, *what; /* name: of the case */
	double bound;                     /* the median is at most this */
} goal;

static const goal goals[] = {
	{"frame-360", "morph/off", "CPU time of a frame / in full detail", 0.27},
	{"frame-720", "morph/off", "CPU time of a frame / in full detail", 0.45},
	{"many-360", "morph/off", "CPU time of a frame / in full detail", 0.2},
	{"many-720", "morph/off", "CPU time of a frame / in full detail", 0.2},
	{"record", "pop/off", "recording with the choice of levels / without", 1.15},
	{"million", "pop/off", "CPU time of a frame / in full detail", 0.1},
	{"million", "memory", "additional memory of the process, %", 2.0},
	{"memory-million", "more-pop", "additional memory of scene and renderer, %", 2.0},
	{"horde", "impostors/meshes", "CPU time of a frame as impostors / as meshes in full detail", 0.05},
	{"horde", "rms-8", "difference from meshes, 8 pixels high, % of white", 2.0},
	{"horde", "rms-16", "difference from meshes, 16 pixels high, % of white", 2.0},
	{"clusters", "near-triangles", "triangles for each pixel of the mesh, from its surface", 2.0},
	{"clusters", "whole-triangles", "triangles for each pixel of the mesh, seen as a whole", 2.0},
	{"clusters", "near-pop/off", "CPU time of a frame / in full detail, from its surface", 0.1},
	{"clusters", "whole-pop/off", "CPU time of a frame / in full detail, as a whole", 0.1},
	{"boulders", "morph-static", "a frame's change of a static pixel that morphs, % of white", 100.0 / 16.0},
	{"boulders", "fade-static-8x8", "a frame's change of 8 x 8 static pixels that fade, % of white", 100.0 / 16.0},
};

static void print_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoals for medians, set on the CPU named in docs/benchmarks.md\n");
	for (size_t i = 0; i < COUNT(goals); i++) {
		const bench_row *row = bench_find(results, goals[i].name, "stilb", goals[i].metric);
		if (row)
			fprintf(out, "  %-12s %-52s %9.4g   at most  %.4g: %s\n", goals[i].name, goals[i].what, row->median,
			        goals[i].bound, row->median <= goals[i].bound ? "met" : "MISSED");
	}
}

const bench_suite bench_lod_suite = {.name = "lod",
                                     .help = "levels of detail: frames and recording beside full detail",
                                     .subjects = subjects,
                                     .subject_count = COUNT(subjects),
                                     .cases = lod_cases,
                                     .case_count = COUNT(lod_cases),
                                     .report = report,
                                     .goals = print_goals,
                                     .report_alone = true,
                                     .start_seconds = 2.0,
                                     .quick_rounds = 1,
                                     .quick_cpu_seconds = 240.0};

const bench_suite bench_pop_suite = {.name = "pop",
                                     .help = "levels of detail: what is seen of their changes in a fixed flight",
                                     .subjects = subjects,
                                     .subject_count = COUNT(subjects),
                                     .cases = pop_cases,
                                     .case_count = COUNT(pop_cases),
                                     .report = report,
                                     .goals = print_goals,
                                     .report_alone = true,
                                     .start_seconds = 2.0,
                                     .quick_rounds = 1,
                                     .quick_cpu_seconds = 240.0};
