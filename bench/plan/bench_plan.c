/* The suite `plan`: what planning a frame costs on the CPU: rows that are added and a plan that is made of them, from a
 * table that is last frame's but for constants, from one of which a pass has another program each frame, and from one
 * of which a pass samples another image; -run: with the null device's run. */
#include "bench/harness/bench.h"
#include "bench/plan/plan_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"same", "ns", true, NULL},     {"program", "ns", true, NULL},     {"new", "ns", true, NULL},
	{"same-run", "ns", true, NULL}, {"program-run", "ns", true, NULL}, {"new-run", "ns", true, NULL},
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

#define GOAL_NS 150.0

static void print_goal(FILE *out, const bench_results *results, const char *metric, const char *table)
{
	const bench_row *row = bench_find(results, "passes-1000", "stilb", metric);
	if (row)
		fprintf(out,
		        "goal: a pass of 1,000 with its image, %s, run by the null device, takes %.3g ns, at most %.3g: %s\n",
		        table, row->median, GOAL_NS, row->median <= GOAL_NS ? "met" : "MISSED");
}

static void print_goals(FILE *out, const bench_results *results)
{
	fputc('\n', out);
	print_goal(out, results, "same-run", "the table last frame's");
	print_goal(out, results, "program-run", "one with another program");
	print_goal(out, results, "new-run", "one that samples another image");
}

const bench_suite bench_plan_suite = {.name = "plan",
                                      .help = "planning a frame: rows of passes and images, barriers, memory",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .goals = print_goals};
