/* The suite `prefilter`: a panorama or a cube as GGX mips of a cube of 256 x 256 texels (numeric/numeric_prefilter.h),
 * on one thread and on two, and how far it is from quadrature. */
#include "bench/harness/bench.h"
#include "bench/prefilter/prefilter_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

#define ERROR_METRIC(METRIC, MIP) {METRIC, "%", true, NULL},
static const bench_metric metrics[] = {{"core", "ms", true, NULL},
                                       {"two", "ms", true, NULL},
                                       {"speedup", "x", false, NULL},
                                       {"texel", "ns", true, NULL},
                                       PREFILTER_ERRORS(ERROR_METRIC)};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, SIDE, IS_CUBE)                                                                               \
	{.name = NAME,                                                                                                     \
	 .title = TITLE,                                                                                                   \
	 .metrics = metrics,                                                                                               \
	 .metric_count = (SIDE) == 1024 ? COUNT(metrics) : 4,                                                              \
	 .length = 2.0},
	PREFILTER_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-prefilter",
     .note =
         "CPU time of one thread; two: one worker beside the caller; texel: CPU time over the cube's texels; errors "
         "against quadrature of the same source, of some texels, half of them close to the sun"},
};

#define CORE_GOAL 1000.0
#define SPEEDUP_GOAL 1.9
#define ERROR_GOAL 1.0

static void print_goals(FILE *out, const bench_results *results)
{
	fputc('\n', out);
	for (size_t i = 0; i < COUNT(cases); i++) {
		const bench_row *core = bench_find(results, cases[i].name, "stilb", "core");
		const bench_row *speedup = bench_find(results, cases[i].name, "stilb", "speedup");
		if (core && speedup)
			fprintf(out,
			        "goal: %s takes %.0f ms of a core, at most %.0f: %s; two threads %.2f times as fast, %.1f: %s\n",
			        cases[i].name, core->median, CORE_GOAL, core->median <= CORE_GOAL ? "met" : "MISSED",
			        speedup->median, SPEEDUP_GOAL, speedup->median >= SPEEDUP_GOAL ? "met" : "MISSED");
	}
	const bench_row *error = bench_find(results, "panorama-1024", "stilb", "error-1");
	if (error)
		fprintf(out, "goal: mip 1, the narrowest lobe, is within %.2f %% of quadrature, %.0f: %s\n", error->median,
		        ERROR_GOAL, error->median <= ERROR_GOAL ? "met" : "MISSED");
}

const bench_suite bench_prefilter_suite = {.name = "prefilter",
                                           .help = "environments as GGX mips of a cube, and their error",
                                           .subjects = subjects,
                                           .subject_count = COUNT(subjects),
                                           .cases = cases,
                                           .case_count = COUNT(cases),
                                           .goals = print_goals};
