/* The suite `gi`: compares the offline renderer (engine/gi) with Embree alone and with a plain path tracer, and its
 * techniques with each other. The cases are in gi_cases.h. */
#include "bench/gi/gi_cases.h"
#include "bench/harness/bench.h"

#include "base/base.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))
#define PROGRAM "stilb-bench-gi"

static const bench_metric build_metrics[] = {{"stilb", "ms", true, NULL},
                                             {"embree", "ms", true, NULL},
                                             {"ratio", "x", true, NULL},
                                             {"memory", "x", true, NULL},
                                             {"threads", "besides ours", true, NULL}};
static const bench_metric move_metrics[] = {{"whole", "ms", true, NULL},
                                            {"movable", "ms", true, NULL},
                                            {"update", "ms", true, NULL},
                                            {"ratio", "x", true, NULL},
                                            {"rays", "x", false, NULL}};
static const bench_metric rate_metrics[] = {
	{"stilb", "Mrays/s", false, NULL}, {"embree", "Mrays/s", false, NULL}, {"ratio", "x", false, NULL}};
/* A share is the rate over Embree's on the same rays. */
static const bench_metric rays_metrics[] = {
	{"path", "Mrays/s", false, NULL},       {"path-share", "x", false, NULL},
	{"primary", "Mrays/s", false, NULL},    {"primary-share", "x", false, NULL},
	{"shadow", "Mrays/s", false, NULL},     {"shadow-share", "x", false, NULL},
	{"shadow-one", "Mrays/s", false, NULL}, {"bounce-alone", "Mrays/s", false, NULL}};
static const bench_metric samples_metrics[] = {
	{"sobol", "Msamples/s", false, NULL}, {"random", "Msamples/s", false, NULL}, {"ratio", "x", false, NULL}};
static const bench_metric workers_metrics[] = {
	{"one", "Msamples/s", false, NULL}, {"two", "Msamples/s", false, NULL}, {"ratio", "x", false, NULL}};
static const bench_metric choice_metrics[] = {{"tree-rmse", "of mean", true, NULL},
                                              {"uniform-rmse", "of mean", true, NULL},
                                              {"ideal-rmse", "of mean", true, NULL},
                                              {"slower", "x", true, NULL},
                                              {"ratio", "x", true, NULL},
                                              {"ratio-ideal", "x", true, NULL},
                                              {"ratio-ideal-time", "x", true, NULL}};
static const bench_metric row_metrics[] = {{"stilb", "1/s", false, NULL},
                                           {"plain", "1/s", false, NULL},
                                           {"ratio", "x", false, NULL},
                                           {"stilb-seconds", "CPU s", true, NULL},
                                           {"plain-seconds", "CPU s", true, NULL},
                                           {"stilb-rmse", "radiance", true, NULL},
                                           {"plain-rmse", "radiance", true, NULL},
                                           {"apart", "%", true, NULL}};
static const bench_metric denoise_metrics[] = {{"ratio", "x", true, NULL},
                                               {"ratio-input", "x", true, NULL},
                                               {"ratio-time", "x", true, NULL},
                                               {"few-rmse", "radiance", true, NULL},
                                               {"denoised-rmse", "radiance", true, NULL},
                                               {"many-rmse", "radiance", true, NULL},
                                               {"few-seconds", "CPU s", true, NULL},
                                               {"denoise-seconds", "CPU s", true, NULL},
                                               {"many-seconds", "CPU s", true, NULL}};
static const bench_metric cache_time_metrics[] = {{"seconds", "s", true, NULL},
                                                  {"rmse", "radiance", true, NULL},
                                                  {"bias", "%", true, NULL},
                                                  {"records", "records", true, NULL}};
static const bench_metric equal_time_metrics[] = {
	{"cache-rmse", "radiance", true, NULL}, {"path-rmse", "radiance", true, NULL}, {"ratio", "x", true, NULL},
	{"cache-seconds", "s", true, NULL},     {"path-seconds", "s", true, NULL},     {"bias", "%", true, NULL}};
static const bench_metric hessian_metrics[] = {
	{"hessian-rmse", "radiance", true, NULL}, {"plain-rmse", "radiance", true, NULL},
	{"bounded-rmse", "radiance", true, NULL}, {"ratio", "x", true, NULL},
	{"ratio-bounded", "x", true, NULL},       {"hessian-records", "records", true, NULL},
	{"plain-records", "records", true, NULL}, {"bounded-records", "records", true, NULL}};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, METRICS)                                                                                     \
	{.name = NAME, .title = TITLE, .metrics = METRICS##_metrics, .metric_count = COUNT(METRICS##_metrics)},
	GI_CASES(CASE)
#undef CASE
#define ROW(NAME, TITLE) {.name = NAME, .title = TITLE, .metrics = row_metrics, .metric_count = COUNT(row_metrics)},
		GI_ROWS(ROW)
#undef ROW
#define ROW(NAME, TITLE)                                                                                               \
	{.name = GI_DENOISE NAME,                                                                                          \
	 .title = TITLE ", denoised",                                                                                      \
	 .metrics = denoise_metrics,                                                                                       \
	 .metric_count = COUNT(denoise_metrics)},
			GI_ROWS(ROW)
#undef ROW
};

static const bench_subject subjects[] = {
	{.name = "stilb", .program = PROGRAM, .note = "what a case compares takes turns in one process"},
};

/* ---- goals ------------------------------------------------------------------------------------------------------- */

typedef struct goal {
	const char *name, *metric, *what; /* name: of the case */
	double bound;                     /* of the median */
	bool at_most;
} goal;

static const goal goals[] = {
	{"build-100k", "ratio", "build time / rtcCommitScene's", 1.02, true},
	{"build", "ratio", "build time / rtcCommitScene's", 1.02, true},
	{"build-10m", "ratio", "build time / rtcCommitScene's", 1.02, true},
	{"build-10m", "memory", "memory of tree, vertices and triangles / of Embree's program", 1.1, true},
#define RAYS(NAME)                                                                                                     \
	{"rays-" NAME, "path-share", "rays/s of a picture / Embree alone on the same rays", 0.8, false},                   \
		{"rays-" NAME, "primary-share", "camera rays/s with their surfaces / Embree alone", 0.9, false},               \
		{"rays-" NAME, "shadow-share", "shadow rays/s / Embree alone", 0.9, false},
	RAYS("cornell") RAYS("open-sky") RAYS("foliage") RAYS("million") RAYS("door") RAYS("metals")
#undef RAYS
		{"sobol", "ratio", "samples/s, Owen-scrambled Sobol / independent numbers", 0.95, false},
	{"choice", "ratio", "RMSE at equal time, light tree / uniform choice", 0.5, true},
	{"choice", "ratio-ideal", "RMSE at equal samples, light tree / ideal choice", 1.1, true},
	{"choice", "ratio-ideal-time", "RMSE at equal time, light tree / ideal choice, 64 samples a point", 1.1, true},
	{"cache-time", "seconds", "seconds (Radiance's rpict: 25.4 on another machine)", 1.3, true},
	{"cache-time", "rmse", "RMSE", .01117, true},
	{"cache-time", "bias", "bias, %", 0.3, true},
	{"cache-0.25s", "ratio", "RMSE of the cache / of the path tracer", 1.0, true},
	{"cache-1s", "ratio", "RMSE of the cache / of the path tracer", 1.0, true},
	{"hessian", "ratio", "RMSE with Hessian radii / with plain split-sphere radii", 0.25, true},
	{"workers", "ratio", "samples/s, two threads / one", 1.95, false},
	{"pathtracer", "ratio", "rays/s of CPU time / embree-tools' pathtracer", 1.3, false},
#define ROW(NAME, TITLE) {NAME, "ratio", "efficiency 1 / (RMSE^2 CPU s) / the plain path tracer's", 2.0, false},
	GI_ROWS(ROW)
#undef ROW
#define ROW(NAME, TITLE)                                                                                               \
	{GI_DENOISE NAME, "ratio", "RMSE, denoised / eight times the samples", 1.0, true},                                 \
		{GI_DENOISE NAME, "ratio-input", "RMSE, denoised / not", 1.0, true},
		GI_ROWS(ROW)
#undef ROW
};

static double magnitude(double a)
{
	return a < 0.0 ? -a : a;
}

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
	for (size_t i = 0; i < COUNT(cases); i++)
		report_case(out, results, &cases[i]);
	fprintf(
		out,
		"\n  move: whole, movable: a new scene that is not and that is movable; rays: rates of movable / not\n"
		"  build: memory: tree, vertices and triangles, of Stilb / of Embree's program; threads: started besides "
		"Stilb's\n"
		"  rays: shares are of what Embree alone traces of the same rays in as much CPU time; shadow-one: one by one\n"
		"  rows (cornell ... foliage): 128 x 128 pixels, 64 samples, one thread; plain: a plain path tracer on Embree "
		"with Owen-scrambled Sobol points, one light sample for each hit, multiple importance sampling, Russian "
		"roulette; stilb, plain: 1 / (rmse^2 CPU s); apart: difference of their means\n"
		"  denoise-*: 128 x 128 pixels, one thread; few: 16 samples (--quick: 4), many: eight times as many; "
		"ratio-time: "
		"denoised / samples in the same time\n"
		"  rmse: of linear radiance, without the pixels around visible lights; of the cache's cases against a "
		"reference rendered first whose own noise is subtracted\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoals for medians, set on the CPU named in docs/benchmarks.md\n");
	for (size_t i = 0; i < COUNT(goals); i++) {
		const goal *g = &goals[i];
		const bench_row *row = bench_find(results, g->name, "stilb", g->metric);
		if (!row)
			continue;
		double value = magnitude(row->median);
		bool met = g->at_most ? value <= g->bound : value >= g->bound;
		fprintf(out, "  %-16s %-52s %9.4g   %s %.4g: %s\n", g->name, g->what, value,
		        g->at_most ? "at most " : "at least", g->bound, met ? "met" : "MISSED");
	}
}

/* ---- the reference ----------------------------------------------------------------------------------------------- */

#define REFERENCE_SAMPLES 512u
#define REFERENCE_SAMPLES_QUICK 64u
#define REFERENCE_SECONDS 300.0

static char reference[256];

static void remove_reference(void)
{
	unlink(reference);
}

/* False if only cases were chosen, by their names, that compare with no reference. */
static bool needs_reference(const char *chosen)
{
	return !chosen || strpbrk(chosen, "*?[") || strstr(chosen, "cache") || strstr(chosen, "hessian");
}

/* Lets the suite's program render the reference picture of the Cornell box into a file, once for all rounds; the file's
 * path is the argument of later runs. */
static const char *prepare(const bench_options *options)
{
	const char *folder = getenv("TMPDIR");
	snprintf(reference, sizeof reference, "%s/stilb-bench-gi-XXXXXX", folder && *folder ? folder : "/tmp");
	int file = mkstemp(reference);
	if (file < 0) {
		stilb_log("cannot create %s for the reference picture; set TMPDIR to a folder that can be written to",
		          reference);
		return NULL;
	}
	close(file);
	atexit(remove_reference);
	if (!needs_reference(options->cases))
		return reference;
	bench_child_result result;
	bench_child_run(PROGRAM, "stilb", "reference", 0.0, options->quick ? REFERENCE_SAMPLES_QUICK : REFERENCE_SAMPLES,
	                reference, (bench_limit){REFERENCE_SECONDS, REFERENCE_SECONDS}, &result);
	if (result.state == BENCH_CHILD_DONE)
		return reference;
	stilb_log("cannot render the reference picture: %s", result.message);
	return NULL;
}

const bench_suite bench_gi_suite = {.name = "gi",
                                    .help =
                                        "the offline renderer: speed and error, beside Embree and a plain path tracer",
                                    .subjects = subjects,
                                    .subject_count = COUNT(subjects),
                                    .cases = cases,
                                    .case_count = COUNT(cases),
                                    .prepare = prepare,
                                    .report = report,
                                    .goals = print_goals,
                                    .report_alone = true,
                                    .start_seconds = 0.5,
                                    .quick_cpu_seconds = 8.0};
