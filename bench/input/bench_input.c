/* The suite `input`: measures the CPU time that recognising and reading gamepads takes. The cases are in
 * input_cases.h. */
#include "bench/harness/bench.h"
#include "bench/input/input_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- metrics ----------------------------------------------------------------------------------------------------- */

static const bench_metric parse_metrics[] = {
	{"joystick", "us", true, NULL},
	{"pad", "us", true, NULL},
	{"fullest", "us", true, NULL},
};
static const bench_metric find_metrics[] = {
	{"known", "us", true, NULL},
	{"fields", "us", true, NULL},
};
static const bench_metric decode_metrics[] = {
	{"usb", "ns", true, NULL},
	{"bluetooth", "ns", true, NULL},
	{"crc", "ns", true, NULL},
};
static const bench_metric frame_metrics[] = {
	{"idle", "us", true, NULL},
	{"reports-16", "us", true, NULL},
	{"reports-500", "us", true, NULL},
};
static const bench_metric camera_metrics[] = {
	{"frame", "ns", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, METRICS)                                                                                     \
	{.name = NAME, .title = TITLE, .metrics = METRICS##_metrics, .metric_count = COUNT(METRICS##_metrics)},
	INPUT_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb", .program = "stilb-bench-input", .note = "each value is the least of many batches of calls"},
};

/* ---- goals ------------------------------------------------------------------------------------------------------- */

#define PARSE_GOAL_US 10.0

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *row = bench_find(results, "parse", "stilb", "joystick");
	if (row)
		fprintf(out,
		        "\ngoals for medians, set on the CPU named in docs/benchmarks.md\n  a descriptor of 625 bytes  %.3g us "
		        "  at most %.3g: %s\n",
		        row->median, PARSE_GOAL_US, row->median <= PARSE_GOAL_US ? "met" : "MISSED");
}

const bench_suite bench_input_suite = {.name = "input",
                                       .help = "gamepads: parsing descriptors, decoding reports, moving the camera",
                                       .subjects = subjects,
                                       .subject_count = COUNT(subjects),
                                       .cases = cases,
                                       .case_count = COUNT(cases),
                                       .goals = print_goals};
