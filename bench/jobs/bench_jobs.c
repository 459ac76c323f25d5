/* The suite `jobs`: job systems side by side. What a case is: jobs_cases.h. */
#include "bench/jobs/bench_jobs.h"
#include "bench/jobs/jobs_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- metrics ------------------------------------------------------------------------------------------------- */

/* Per kind of case; the p50, p99 and worst of a run are over its turns. */
static const bench_metric rates[] = {
	{"rate", "Mjobs/s", false, BENCH_LIMIT_UNCONTENDED},
	{"slowest", "Mjobs/s", false, NULL},
};
static const bench_metric times_us[] = {
	{"p50", "us", true, NULL},
	{"p99", "us", true, NULL},
	{"worst", "us", true, NULL},
};
static const bench_metric times_ms[] = {
	{"p50", "ms", true, NULL},
	{"p99", "ms", true, NULL},
	{"worst", "ms", true, NULL},
};
static const bench_metric wakes[] = {
	{"start-p50", "us", true, BENCH_LIMIT_WAKE},
	{"start-p99", "us", true, BENCH_LIMIT_WAKE_P99},
	{"start-worst", "us", true, NULL},
	{"submit-p50", "us", true, NULL},
	{"submit-p99", "us", true, NULL},
	{"submit-worst", "us", true, NULL},
};
static const bench_metric steals[] = {
	{"taken-mean", "ns", true, BENCH_LIMIT_CONTENDED},
	{"taken-p50", "ns", true, NULL},
	{"taken-p99", "ns", true, NULL},
	{"taken-worst", "ns", true, NULL},
	{"start-p50", "ns", true, NULL},
	{"start-p99", "ns", true, NULL},
	{"start-worst", "ns", true, NULL},
};
static const bench_metric idles[] = {
	{"burnt", "ms", true, NULL},
	{"burnt-worst", "ms", true, NULL},
	{"idle", "%", true, NULL},
};

#define METRICS_SPAWN rates
#define METRICS_ARRAY rates
#define METRICS_OUTSIDE rates
#define METRICS_JOIN times_us
#define METRICS_LOOP times_ms
#define METRICS_FIB times_ms
#define METRICS_WAKE wakes
#define METRICS_STEAL steals
#define METRICS_IDLE idles

/* The time in which a subject may show that it idles, as a multiple of a run's length. */
#define LENGTH(KIND) (JOBS_##KIND == JOBS_IDLE ? 4.0 : 1.0)

static const bench_case cases[] = {
#define CASE(NAME, TITLE, KIND, ...)                                                                                   \
	{.name = NAME,                                                                                                     \
	 .title = TITLE,                                                                                                   \
	 .metrics = METRICS_##KIND,                                                                                        \
	 .metric_count = COUNT(METRICS_##KIND),                                                                            \
	 .needs = 1u << JOBS_##KIND,                                                                                       \
	 .length = LENGTH(KIND)},
	JOBS_CASES(CASE)
#undef CASE
};

/* ---- subjects ------------------------------------------------------------------------------------------------ */

#define CAN(KIND) (1u << JOBS_##KIND)
#define CAN_LOOPS (CAN(JOIN) | CAN(LOOP))
#define CAN_COMPUTE (CAN_LOOPS | CAN(SPAWN) | CAN(ARRAY) | CAN(FIB))
#define CAN_START (CAN(WAKE) | CAN(STEAL))

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-jobs-own",
     .note = "the pool as it comes: low-lock queues, workers on CPUs of their own",
     .abilities = CAN_COMPUTE | CAN_START | CAN(OUTSIDE) | CAN(IDLE)},
	{.name = "stilb-lock-free",
     .program = "stilb-bench-jobs-own",
     .note = "the pool on lock-free queues",
     .abilities = CAN(SPAWN) | CAN(OUTSIDE)},
	{.name = "stilb-over-sutter",
     .program = "stilb-bench-jobs-own",
     .note = "the pool on the article's queue",
     .abilities = CAN(OUTSIDE)},
	{.name = "stilb-over-mutex",
     .program = "stilb-bench-jobs-own",
     .note = "the pool on a list under a mutex",
     .abilities = CAN(OUTSIDE)},
	{.name = "tbb",
     .program = "stilb-bench-jobs-tbb",
     .package = "libtbb-dev",
     .note = "oneTBB: task_group; parallel_for with simple_partitioner and grain 1, the loop with auto_partitioner",
     .abilities = CAN_COMPUTE | CAN_START | CAN(OUTSIDE) | CAN(IDLE)},
	{.name = "tbb-static",
     .program = "stilb-bench-jobs-tbb",
     .package = "libtbb-dev",
     .note = "oneTBB: parallel_for with static_partitioner",
     .abilities = CAN_LOOPS},
	{.name = "openmp",
     .program = "stilb-bench-jobs-openmp",
     .package = "libgomp1",
     .note = "tasks; parallel for with schedule(dynamic, 1), the loop with schedule(guided)",
     .abilities = CAN_COMPUTE | CAN(IDLE)},
	{.name = "openmp-static",
     .program = "stilb-bench-jobs-openmp",
     .package = "libgomp1",
     .note = "parallel for with schedule(static)",
     .abilities = CAN_LOOPS},
	{.name = "serial",
     .program = "stilb-bench-jobs-limits",
     .note = "a plain loop",
     .abilities = CAN_COMPUTE,
     .reference = true},
	{.name = "ideal",
     .program = "stilb-bench-jobs-limits",
     .note = "the time of a plain loop, divided by the threads that can run at the same moment",
     .abilities = CAN_LOOPS,
     .reference = true},
	{.name = "futex",
     .program = "stilb-bench-jobs-limits",
     .note = "a thread asleep on a futex, and the call that wakes it",
     .abilities = CAN(WAKE),
     .reference = true},
	{.name = "counter",
     .program = "stilb-bench-jobs-limits",
     .note = "a thread that looks at a counter until it changes",
     .abilities = CAN(STEAL),
     .reference = true},
};

/* ---- the suite ----------------------------------------------------------------------------------------------- */

/* How fast this machine multiplies, so that all subjects run the same jobs. */
static const char *prepare(const bench_options *options)
{
	static char per_us[32];
	bench_child_result result;
	(void)options;
	bench_child_run("stilb-bench-jobs-limits", "serial", "calibrate", 0.0, 0, NULL, (bench_limit){60.0, 60.0}, &result);
	if (result.state != BENCH_CHILD_DONE || result.value_count != 1) {
		fprintf(stderr, "stilb: cannot measure how long a job of 1 us is: %s\n", result.message);
		return NULL;
	}
	snprintf(per_us, sizeof per_us, "%.3f", result.values[0].value);
	return per_us;
}

static const char *const empty_cases[] = {"spawn-1", "spawn", "spawn-pinned", "array-1", "array", "array-pinned", NULL};
static const char *const outside_cases[] = {"outside", "outside-4", NULL};
static const char *const join_cases[] = {"join2",        "join8",         "join64", "join2-pinned",
                                         "join8-pinned", "join64-pinned", NULL};
static const char *const idle_join_cases[] = {"join8-phase", "join8-idle",        "join8-idle-phase",
                                              "join64-idle", "join64-idle-phase", NULL};
static const char *const loop_cases[] = {"loop-1", "loop-2", "loop-4", "loop-8", NULL};
static const char *const fib_cases[] = {"fib-1", "fib", NULL};
static const char *const wake_cases[] = {"wake", "wake-pinned", NULL};
static const char *const steal_cases[] = {"steal", "steal-pinned", NULL};
static const char *const quiet_cases[] = {"idle", NULL};

static const bench_panel panels[] = {
	{"empty jobs, one by one and as an array", empty_cases, "rate", true},
	{"empty jobs from outside", outside_cases, "rate", false},
	{"fork-join of 2, 8, 64 chunks of 1 us, back to back", join_cases, "p50", true},
	{"the same, 99 of 100 take less", join_cases, "p99", true},
	{"fork-join in a phase, and after 2 ms of idleness", idle_join_cases, "p50", true},
	{"the same, 99 of 100 take less", idle_join_cases, "p99", true},
	{"loop over 20,000 items of 200 ns, 1 to 8 threads", loop_cases, "p50", false},
	{"the same, slowest of a run", loop_cases, "worst", true},
	{"fib(20) by jobs", fib_cases, "p50", true},
	{"from submit to start, worker asleep: 99 of 100 take less", wake_cases, "start-p99", true},
	{"cost of that submit", wake_cases, "submit-p50", true},
	{"from submit to start, worker awake", steal_cases, "start-p50", true},
	{"from submit until the job is taken, worker awake", steal_cases, "taken-mean", true},
	{"CPU time burnt in the 20 ms after the last job", quiet_cases, "burnt", true},
};

const bench_suite bench_jobs_suite = {.name = "jobs",
                                      .help = "job systems: spawning, fork and join, loops, waking, idling",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .panels = panels,
                                      .panel_count = COUNT(panels),
                                      .prepare = prepare,
                                      .goals = bench_jobs_goals,
                                      .plot = bench_jobs_plot,
                                      .plot_rows = BENCH_JOBS_PLOT_ROWS};
