/* The suite `textured`: frames of a textured model, beside a plain Vulkan program that draws the same and nothing
 * else. */
#include "bench/harness/bench.h"
#include "bench/textured/textured_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"cpu", "ms", true, NULL},
	{"frame", "ms", true, NULL},
	{"least", "ms", true, NULL},
	{"rms", "", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE)                                                                                              \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .length = 4},
	TEXTURED_CASES(CASE)
#undef CASE
};

#define PROGRAM "stilb-bench-textured"

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = PROGRAM,
     .note =
         "stilb_engine_frame, headless, one worker; cpu: of all threads, a frame; rms: to vulkan-bare's picture, in "
         "light"},
#define VARIANT(ID, identifier, SUBJECT, WORDS) {.name = SUBJECT, .program = PROGRAM, .note = WORDS, .reference = true},
	TEXTURED_VARIANTS(VARIANT)
#undef VARIANT
};

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *bare = bench_find(results, cases[0].name, "vulkan-bare", "cpu");
	fputc('\n', out);
	for (size_t i = 0; i < COUNT(subjects); i++) {
		const bench_row *row = bench_find(results, cases[0].name, subjects[i].name, "cpu");
		bench_ratio ratio;
		if (!row || !bare || row == bare || !bench_paired_ratio(results, row, bare, &ratio))
			continue;
		fprintf(out, "CPU time a frame, %s / vulkan-bare: %.3f [%.3f-%.3f]", subjects[i].name, ratio.median, ratio.min,
		        ratio.max);
		if (i == 0)
			fprintf(out, ", goal at most 1.1: %s", ratio.median <= 1.1 ? "met" : "MISSED");
		fputc('\n', out);
	}
}

const bench_suite bench_textured_suite = {.name = "textured",
                                          .help = "frames of a textured model, beside plain Vulkan",
                                          .subjects = subjects,
                                          .subject_count = COUNT(subjects),
                                          .cases = cases,
                                          .case_count = COUNT(cases),
                                          .goals = print_goals,
                                          .start_seconds = 2.0,
                                          .quick_cpu_seconds = 8.0};
