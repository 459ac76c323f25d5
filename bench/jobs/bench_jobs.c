/* The suite `jobs` of stilb-bench: compares job systems of Stilb and of other libraries. The cases are in
 * jobs_cases.h. */
#include "bench/jobs/bench_jobs.h"
#include "bench/jobs/jobs_cases.h"

#include "base/base.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- metrics ------------------------------------------------------------------------------------------------- */

/* A list of metrics for each kind of case. A run repeats the same turn (one spawn of all jobs, one fork-join); p50, p99
 * and worst are over its turns. */
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
static const bench_metric times_late[] = {
	{"p50", "ms", true, NULL},
	{"p97", "ms", true, NULL}, /* what 39 of 40 turns do not exceed */
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
#define METRICS_BATCH rates
#define METRICS_OUTSIDE rates
#define METRICS_JOIN times_us
#define METRICS_LOOP times_ms
#define METRICS_LATE times_late
#define METRICS_FIB times_ms
#define METRICS_GRAPH times_us
#define METRICS_RANGE times_ms
#define METRICS_TILES times_ms
#define METRICS_REDUCE times_ms
#define METRICS_SORT times_ms
#define METRICS_WAKE wakes
#define METRICS_STEAL steals
#define METRICS_IDLE idles

/* Length of a case: idle CPU time needs longer runs to be measurable, and 40 turns of 50 ms take two seconds. */
#define LENGTH(KIND) (JOBS_##KIND == JOBS_IDLE ? 4.0 : JOBS_##KIND == JOBS_LATE ? 5.0 : 1.0)

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
#define CAN_LOOPS (CAN(JOIN) | CAN(LOOP) | CAN(LATE) | CAN(RANGE))
#define CAN_COMPUTE (CAN_LOOPS | CAN(SPAWN) | CAN(ARRAY) | CAN(FIB) | CAN(TILES) | CAN(REDUCE))
#define CAN_START (CAN(WAKE) | CAN(STEAL))

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-jobs-own",
     .note = "stilb_job_pool with its defaults: low-lock queues, workers pinned to CPUs",
     .abilities = CAN_COMPUTE | CAN_START | CAN(BATCH) | CAN(OUTSIDE) | CAN(GRAPH) | CAN(SORT) | CAN(IDLE)},
	{.name = "stilb-lock-free",
     .program = "stilb-bench-jobs-own",
     .note = "stilb_job_pool with lock-free queues",
     .abilities = CAN(SPAWN) | CAN(OUTSIDE)},
	{.name = "stilb-over-sutter",
     .program = "stilb-bench-jobs-own",
     .note = "stilb_job_pool with the queue of Sutter's article",
     .abilities = CAN(OUTSIDE)},
	{.name = "stilb-over-mutex",
     .program = "stilb-bench-jobs-own",
     .note = "stilb_job_pool with a linked list under a mutex",
     .abilities = CAN(OUTSIDE)},
	{.name = "tbb",
     .program = "stilb-bench-jobs-tbb",
     .package = "libtbb-dev",
     .note =
         "oneTBB: task_group; parallel_for with simple_partitioner and grain 1; loops with auto_partitioner; graphs "
         "of continue_node; sorts with parallel_sort, which is not stable",
     .abilities = CAN_COMPUTE | CAN_START | CAN(OUTSIDE) | CAN(GRAPH) | CAN(SORT) | CAN(IDLE)},
	{.name = "tbb-static",
     .program = "stilb-bench-jobs-tbb",
     .package = "libtbb-dev",
     .note = "oneTBB: parallel_for with static_partitioner",
     .abilities = CAN_LOOPS},
	{.name = "openmp",
     .program = "stilb-bench-jobs-openmp",
     .package = "libgomp1",
     .note = "OpenMP: tasks; parallel for with schedule(dynamic, 1), tiles of 64 x 64, too; loops with "
             "schedule(guided); reductions with schedule(static)",
     .abilities = CAN_COMPUTE | CAN(IDLE)},
	{.name = "openmp-static",
     .program = "stilb-bench-jobs-openmp",
     .package = "libgomp1",
     .note = "OpenMP: parallel for with schedule(static); rows instead of tiles",
     .abilities = CAN_LOOPS | CAN(TILES)},
	{.name = "std",
     .program = "stilb-bench-jobs-std",
     .package = "libtbb-dev",
     .note = "std::stable_sort, on one thread",
     .abilities = CAN(SORT)},
	{.name = "std-par",
     .program = "stilb-bench-jobs-std",
     .package = "libtbb-dev",
     .note = "std::stable_sort with std::execution::par",
     .abilities = CAN(SORT)},
	{.name = "serial",
     .program = "stilb-bench-jobs-limits",
     .note = "a plain loop on one thread; qsort_r",
     .abilities = CAN_COMPUTE | CAN(GRAPH) | CAN(SORT),
     .reference = true},
	{.name = "ideal",
     .program = "stilb-bench-jobs-limits",
     .note = "the time of a plain loop divided by the number of threads that can run at once",
     .abilities = CAN_LOOPS,
     .reference = true},
	{.name = "futex",
     .program = "stilb-bench-jobs-limits",
     .note = "waking a thread that sleeps on a futex, without a job system",
     .abilities = CAN(WAKE),
     .reference = true},
	{.name = "counter",
     .program = "stilb-bench-jobs-limits",
     .note = "a thread that spins on a counter until it changes, without a job system",
     .abilities = CAN(STEAL),
     .reference = true},
};

/* ---- the suite ----------------------------------------------------------------------------------------------- */

/* Measures how many multiplications take a microsecond and returns that as the programs' argument, so that the jobs of
 * all subjects are the same work. */
static const char *prepare(const bench_options *options)
{
	static char per_us[32];
	bench_child_result result;
	(void)options;
	bench_child_run("stilb-bench-jobs-limits", "serial", "calibrate", 0.0, 0, NULL, (bench_limit){60.0, 60.0}, &result);
	if (result.state != BENCH_CHILD_DONE || result.value_count != 1) {
		stilb_log("cannot measure how many multiplications take 1 us: %s", result.message);
		return NULL;
	}
	snprintf(per_us, sizeof per_us, "%.3f", result.values[0].value);
	return per_us;
}

static const char *const empty_cases[] = {"spawn-1", "spawn", "spawn-pinned", "batch", "batch-pinned",
                                          "array-1", "array", "array-pinned", NULL};
static const char *const outside_cases[] = {"outside", "outside-4", NULL};
static const char *const join_cases[] = {"join2",        "join8",         "join64", "join2-pinned",
                                         "join8-pinned", "join64-pinned", NULL};
static const char *const idle_join_cases[] = {"join8-phase", "join8-idle",        "join8-idle-phase",
                                              "join64-idle", "join64-idle-phase", NULL};
static const char *const loop_cases[] = {"loop-1", "loop-2", "loop-4", "loop-8", NULL};
static const char *const late_cases[] = {"late-2", "late-8", "late-2-other", "late-8-other", NULL};
static const char *const fib_cases[] = {"fib-1", "fib", NULL};
static const char *const graph_cases[] = {"graph-chain", "graph-fan", "graph-1", "graph", "graph-us", NULL};
static const char *const array_cases[] = {"range",  "tiles-1", "tiles",      "reduce-1",     "reduce",
                                          "sort-1", "sort",    "sort-10000", "sort-ordered", NULL};
static const char *const wake_cases[] = {"wake", "wake-pinned", NULL};
static const char *const steal_cases[] = {"steal", "steal-pinned", NULL};
static const char *const quiet_cases[] = {"idle", NULL};

static const bench_panel panels[] = {
	{"empty jobs, submitted one by one and as an array", empty_cases, "rate", true},
	{"empty jobs, submitted by threads outside of the pool", outside_cases, "rate", false},
	{"fork-join of 2, 8, 64 chunks of 1 us, median", join_cases, "p50", true},
	{"fork-join of 2, 8, 64 chunks of 1 us, 99th percentile", join_cases, "p99", true},
	{"fork-join in a phase, and after 2 ms of idleness, median", idle_join_cases, "p50", true},
	{"fork-join in a phase, and after 2 ms of idleness, 99th percentile", idle_join_cases, "p99", true},
	{"loop over 20,000 items of 200 ns on 1 to 8 threads, median", loop_cases, "p50", false},
	{"loop over 20,000 items of 200 ns on 1 to 8 threads, slowest of a run", loop_cases, "worst", true},
	{"a loop of long slices after 1,000 short loops and 5 ms of sleep, 39 of 40", late_cases, "p97", false},
	{"fib(20), each call a job", fib_cases, "p50", true},
	{"a run of a graph of 10,000 nodes, median", graph_cases, "p50", true},
	{"loop with 64-bit indices, transposition in tiles, sum, sort, median", array_cases, "p50", true},
	{"time from submit to start for a sleeping worker, 99th percentile", wake_cases, "start-p99", true},
	{"time that submit takes if it wakes a worker", wake_cases, "submit-p50", true},
	{"time from submit to start for a worker that is awake", steal_cases, "start-p50", true},
	{"time from submit until a worker that is awake has taken the job", steal_cases, "taken-mean", true},
	{"CPU time of the other threads in the 20 ms after the last job", quiet_cases, "burnt", true},
};

const bench_suite bench_jobs_suite = {.name = "jobs",
                                      .help = "job systems: submitting, fork-join, loops, waking workers, idling",
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
