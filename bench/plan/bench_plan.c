/* The suite `plan`: what planning a frame costs on the CPU: rows that are added and a plan that is made of them, from a
 * table that is last frame's but for constants, and from one with another pass each frame. */
#include "bench/harness/bench.h"
#include "bench/plan/plan_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"same", "ns", true, NULL},
	{"new", "ns", true, NULL},
	{"barriers", "", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, ...) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	PLAN_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-plan",
     .note = "ns a pass, with the row of its image; each value is the least of many frames"},
};

#define SAME_GOAL_NS 100.0

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *row = bench_find(results, "passes-1000", "stilb", "same");
	if (row)
		fprintf(out, "\ngoal: a pass of 1,000, the table last frame's, takes %.3g ns, at most %.3g: %s\n", row->median,
		        SAME_GOAL_NS, row->median <= SAME_GOAL_NS ? "met" : "MISSED");
}

const bench_suite bench_plan_suite = {.name = "plan",
                                      .help = "planning a frame: rows of passes and images, barriers, memory",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .goals = print_goals};
