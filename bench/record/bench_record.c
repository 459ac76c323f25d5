/* The suite `record`: recording and replay of draws, beside lower bounds of this machine and a plain Vulkan program.
 * The cases are in record_cases.h. */
#include "bench/record/bench_record.h"
#include "bench/record/record_child.h"

#include "base/base.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- metrics ----------------------------------------------------------------------------------------------------- */

static const bench_metric draws_metrics[] = {
	{"record", "ns/draw", true, NULL},
	{"bytes", "B/draw", true, NULL},
};
static const bench_metric phase_metrics[] = {
	{"one", "us", true, NULL},
	{"two", "us", true, NULL},
	{"speed-up", "x", false, NULL},
};
static const bench_metric parked_metrics[] = {
	{"one", "us", true, NULL},       {"two", "us", true, NULL},    {"wake", "us", true, NULL},
	{"wake-cost", "us", true, NULL}, {"of-best", "x", true, NULL},
};
static const bench_metric views_metrics[] = {
	{"one", "us", true, NULL},   {"two", "us", true, NULL},       {"speed-up", "x", false, NULL},
	{"of-sum", "x", true, NULL}, {"bytes", "B/draw", true, NULL},
};
static const bench_metric replay_metrics[] = {
	{"replay", "ns/draw", true, NULL},
};
static const bench_metric sort_metrics[] = {
	{"sort", "ns/draw", true, NULL},
	{"replay", "ns/draw", true, NULL},
};
static const bench_metric frame_metrics[] = {
	{"frame", "ms", true, NULL},
	{"cull", "us", true, NULL},
	{"record", "us", true, NULL},
	{"replay", "us", true, NULL},
};
static const bench_metric picture_metrics[] = {
	{"frame", "ms", true, NULL},
	{"least", "ms", true, NULL},
	{"cpu", "ms", true, NULL},
	{"replay", "ns/draw", true, NULL},
};

#define METRICS_DRAWS draws_metrics
#define METRICS_PHASE phase_metrics
#define METRICS_PARKED parked_metrics
#define METRICS_VIEWS views_metrics
#define METRICS_REPLAY replay_metrics
#define METRICS_SORT sort_metrics
#define METRICS_FRAME frame_metrics
#define METRICS_PICTURE picture_metrics

/* Length of a case: a single frame on lavapipe takes longer than most other runs. */
#define LENGTH(KIND) (RECORD_##KIND == RECORD_PICTURE ? 6.0 : 1.0)

/* The bit of bench_subject.abilities and bench_case.needs for a kind of case. */
#define CAN(KIND) (1u << RECORD_##KIND)

static const bench_case cases[] = {
#define CASE(NAME, TITLE, KIND, ...)                                                                                   \
	{.name = NAME,                                                                                                     \
	 .title = TITLE,                                                                                                   \
	 .metrics = METRICS_##KIND,                                                                                        \
	 .metric_count = COUNT(METRICS_##KIND),                                                                            \
	 .needs = CAN(KIND),                                                                                               \
	 .length = LENGTH(KIND)},
	RECORD_CASES(CASE)
#undef CASE
};

/* ---- subjects ---------------------------------------------------------------------------------------------------- */

#define OWN "stilb-bench-record-own"
#define LIMITS "stilb-bench-record-limits"
#define CAN_RECORD (CAN(DRAWS) | CAN(PHASE) | CAN(PARKED))
#define CAN_REPLAY (CAN(REPLAY) | CAN(SORT) | CAN(FRAME) | CAN(PICTURE))

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = OWN,
     .note = "stilb_render_draw for each draw, in segments of 256 draws",
     .abilities = CAN_RECORD},
	{.name = "stilb-scene",
     .program = OWN,
     .note = "stilb_render_record, which draws a scene's visible models",
     .abilities = CAN_RECORD | CAN(VIEWS)},
	{.name = "stilb-indirect", .program = OWN, .note = "replay as multi-draw-indirect", .abilities = CAN_REPLAY},
	{.name = "stilb-direct", .program = OWN, .note = "replay as one command for each draw", .abilities = CAN_REPLAY},
	{.name = "stilb-secondary",
     .program = OWN,
     .note = "replay into one secondary command buffer for each worker",
     .abilities = CAN_REPLAY},
	{.name = "write",
     .program = LIMITS,
     .note = "a loop that writes 32 bytes and copies 64 bytes for each draw: a lower bound",
     .abilities = CAN(DRAWS),
     .reference = true},
	{.name = "write-non-temporal",
     .program = LIMITS,
     .note = "the same, the 64 bytes by non-temporal stores",
     .abilities = CAN(DRAWS),
     .reference = true},
	{.name = "atomic",
     .program = LIMITS,
     .note = "one uncontended atomic add for each draw, nothing else",
     .abilities = CAN(DRAWS),
     .reference = true},
	{.name = "malloc",
     .program = LIMITS,
     .note = "malloc and free of 96 bytes for each draw, nothing else",
     .abilities = CAN(DRAWS),
     .reference = true},
	{.name = "radix",
     .program = LIMITS,
     .note = "a plain stable radix sort of keys and indices, 3 passes of 8 bits",
     .abilities = CAN(SORT),
     .reference = true},
	{.name = "vulkan-bare",
     .program = "stilb-bench-record-vulkan_bare",
     .package = "libvulkan-dev",
     .note = "a plain Vulkan program with one thread and one multi-draw-indirect",
     .abilities = CAN(PICTURE),
     .reference = true},
};

/* ---- the suite --------------------------------------------------------------------------------------------------- */

/* Lets the plain Vulkan program draw its picture, and returns the checksum, which every other subject's picture must
 * have, as the programs' argument (record_child.h). */
static const char *prepare(const bench_options *options)
{
	static char sum[32];
	bench_child_result result;
	bench_child_run("stilb-bench-record-vulkan_bare", "vulkan-bare", "picture", 0.0, 0, NULL,
	                (bench_limit){120.0, 120.0}, &result);
	if (result.state == BENCH_CHILD_SKIPPED) {
		stilb_log("the cases picture* are skipped: %s", result.message);
		return RECORD_NO_PICTURE;
	}
	if (result.state != BENCH_CHILD_DONE || result.value_count != 2) {
		stilb_log("cannot draw the reference picture for the cases picture*: %s", result.message);
		return NULL;
	}
	uint64_t high = (uint64_t)result.values[0].value, low = (uint64_t)result.values[1].value;
	snprintf(sum, sizeof sum, "%llu%s", (unsigned long long)(high << 24 | low), options->quick ? RECORD_SHORT : "");
	if (options->quick)
		stilb_log("--quick skips the cases picture-bind and picture-pipeline");
	return sum;
}

const bench_suite bench_record_suite = {.name = "record",
                                        .help = "recording and replay of draws, beside memory writes and plain Vulkan",
                                        .subjects = subjects,
                                        .subject_count = COUNT(subjects),
                                        .cases = cases,
                                        .case_count = COUNT(cases),
                                        .prepare = prepare,
                                        .goals = bench_record_goals,
                                        .plot = bench_record_plot,
                                        .plot_rows = BENCH_RECORD_PLOT_ROWS,
                                        .start_seconds = 0.05,
                                        .quick_cpu_seconds = 4.0}; /* one frame on lavapipe may take half a second */
