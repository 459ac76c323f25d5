/* The suite `upload`: what it costs to bring bytes to the device: the caller's part against plain memcpy, the way from
 * the ring to images against a plain Vulkan program, and what frames feel of a second thread that uploads. */
#include "bench/harness/bench.h"
#include "bench/upload/upload_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics_CALLER[] = {{"written", "GB/s", false, NULL}};
static const bench_metric metrics_IMAGE[] = {{"copied", "us", true, NULL}};
static const bench_metric metrics_STREAM[] = {
	{"quiet", "ms", true, NULL}, {"busy", "ms", true, NULL},      {"ratio", "", true, NULL},
	{"median", "", true, NULL},  {"streamed", "MB", false, NULL}, {"rate", "MB/s", false, NULL},
	{"waits", "", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, KIND, ...)                                                                                   \
	{.name = NAME,                                                                                                     \
	 .title = TITLE,                                                                                                   \
	 .metrics = metrics_##KIND,                                                                                        \
	 .metric_count = COUNT(metrics_##KIND),                                                                            \
	 .needs = UPLOAD_##KIND,                                                                                           \
	 .length = UPLOAD_##KIND == UPLOAD_STREAM ? 20 : 1},
	UPLOAD_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-upload-own",
     .abilities = UPLOAD_CALLER | UPLOAD_IMAGE | UPLOAD_STREAM,
     .note = "on Mesa's software device; each value is the median of many batches"},
	{.name = "memcpy",
     .program = "stilb-bench-upload-bare",
     .abilities = UPLOAD_CALLER,
     .reference = true,
     .note = "the same bytes, written to memory of the ring's size"},
	{.name = "vulkan_bare",
     .program = "stilb-bench-upload-bare",
     .abilities = UPLOAD_IMAGE,
     .reference = true,
     .note = "barriers for all images, the copies, barriers for all; from the first command to the fence"},
};

static void print_ratio(FILE *out, const bench_results *results, const char *name, const char *other,
                        const char *metric, double goal)
{
	const bench_row *own = bench_find(results, name, "stilb", metric), *to = bench_find(results, name, other, metric);
	bench_ratio ratio;
	if (!own || !to || !bench_paired_ratio(results, own, to, &ratio))
		return;
	bool met = goal < 1.0 ? ratio.median >= goal : ratio.median <= goal;
	fprintf(out, "goal: %s is %.3g times %s's, %s %.3g: %s\n", name, ratio.median, other,
	        goal < 1.0 ? "at least" : "at most", goal, met ? "met" : "MISSED");
}

static void print_bound(FILE *out, const bench_results *results, const char *metric, const char *what, double most)
{
	const bench_row *row = bench_find(results, "stream", "stilb", metric);
	if (row)
		fprintf(out, "goal: while 1 GB is streamed, %s is %.3g, at most %.3g: %s\n", what, row->median, most,
		        row->median <= most ? "met" : "MISSED");
}

static void print_goals(FILE *out, const bench_results *results)
{
	fputc('\n', out);
	for (size_t i = 0; i < COUNT(cases); i++) {
		if (cases[i].needs == UPLOAD_CALLER)
			print_ratio(out, results, cases[i].name, "memcpy", "written", 0.8);
		if (cases[i].needs == UPLOAD_IMAGE)
			print_ratio(out, results, cases[i].name, "vulkan_bare", "copied", 1.1);
	}
	print_bound(out, results, "ratio", "a frame's time, p95, to that of quiet frames,", 1.3);
	print_bound(out, results, "waits", "the number of waits in calls that must not wait", 0.0);
}

const bench_suite bench_upload_suite = {.name = "upload",
                                        .help = "uploads to the device: the caller's part, images, streaming",
                                        .subjects = subjects,
                                        .subject_count = COUNT(subjects),
                                        .cases = cases,
                                        .case_count = COUNT(cases),
                                        .goals = print_goals};
