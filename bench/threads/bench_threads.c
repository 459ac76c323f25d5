/*
 * The suite `threads`: times whole frames of the stress test with different numbers of workers, and repeats the
 * experiments of the article that the stress test comes from (Rory Driscoll, "Direct3D 11 Multithreading", 2009).
 */
#include "bench/threads/bench_threads.h"
#include "bench/harness/bench_internal.h"

#include "game/cli/flags.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define PROGRAM "stilb-bench-threads"

/* ---- metrics ----------------------------------------------------------------------------------------------------- */

static const bench_metric sweep_metrics[] = {
	{"frame", "ms", true, NULL},        {"cull", "ms", true, NULL},        {"record", "ms", true, NULL},
	{"replay", "ms", true, NULL},       {"rest", "ms", true, NULL},        {"p99", "ms", true, NULL},
	{"worst", "ms", true, NULL},        {"cpu", "ms", true, NULL},         {"switched-out", "1/s", true, NULL},
	{"visible", "models", false, NULL}, {"software", "bool", false, NULL}, {"speed-up", "x", false, NULL},
	{"efficiency", "%", false, NULL},
};
static const bench_metric pool_metrics[] = {
	{"frame", "ms", true, NULL}, {"p99", "ms", true, NULL},           {"worst", "ms", true, NULL},
	{"cpu", "ms", true, NULL},   {"switched-out", "1/s", true, NULL},
};
static const bench_metric dedicated_metrics[] = {
	{"frame", "ms", true, NULL},   {"p99", "ms", true, NULL}, {"worst", "ms", true, NULL},
	{"latency", "ms", true, NULL}, {"cpu", "ms", true, NULL},
};
static const bench_metric queue_metrics[] = {
	{"frame", "ms", true, NULL},  {"p99", "ms", true, NULL},       {"worst", "ms", true, NULL},
	{"feed", "ms", true, NULL},   {"recording", "%", false, NULL}, {"waiting", "%", true, NULL},
	{"no-work", "%", true, NULL}, {"cpu", "ms", true, NULL},       {"switched-out", "1/s", true, NULL},
};
static const bench_metric replay_metrics[] = {
	{"replay", "ms", true, NULL}, {"record", "ms", true, NULL}, {"frame", "ms", true, NULL},
	{"p99", "ms", true, NULL},    {"worst", "ms", true, NULL},
};
static const bench_metric stolen_metrics[] = {
	{"before", "ms", true, NULL}, {"before-mean", "ms", true, NULL}, {"before-p99", "ms", true, NULL},
	{"during", "ms", true, NULL}, {"during-mean", "ms", true, NULL}, {"during-p99", "ms", true, NULL},
	{"worst", "ms", true, NULL},  {"after", "ms", true, NULL},       {"recovery", "ms", true, NULL},
};

/* ---- cases and subjects ------------------------------------------------------------------------------------------ */

/* Bits of bench_subject.abilities and bench_case.needs: the kinds of case that a subject can run. */
enum { SWEEP = 1, TWO_POOLS = 2, DEDICATED = 4, QUEUES = 8, STOLEN = 16, REPLAYS = 32 };

#define CASE(NAME, TITLE, METRICS, NEEDS, LENGTH)                                                                      \
	{                                                                                                                  \
		.name = NAME, .title = TITLE, .metrics = METRICS##_metrics, .metric_count = COUNT(METRICS##_metrics),          \
		.needs = NEEDS, .length = LENGTH                                                                               \
	}

static const bench_case cases[] = {
	CASE("null-all", "null device, every model in view", sweep, SWEEP, 1.0),
	CASE("null-half", "null device, half of the models in view", sweep, SWEEP, 1.0),
	CASE("null-few", "null device, one model in a hundred in view", sweep, SWEEP, 1.0),
	CASE("one-vs-four", "one worker for each CPU but the main thread's, and twice as many workers as CPUs", pool,
         TWO_POOLS, 1.0),
	CASE("dedicated", "a dedicated render thread that gets every model through a queue, beside the engine's workers",
         dedicated, DEDICATED, 1.0),
	CASE("mutex-vs-lowlock", "every draw through a queue", queue, QUEUES, 1.0),
	CASE("mutex-vs-lowlock-2009", "every draw through a queue, and it costs what it did in 2009", queue, QUEUES, 1.0),
	CASE("mutex-vs-lowlock-segments", "the workers get draws through a queue, 512 in each item", queue, QUEUES, 1.0),
	CASE("stolen", "another process occupies a CPU for a third of the run", stolen, STOLEN, 2.0),
	CASE("white-bar", "Vulkan: the main thread's time to replay the lists of every model in view", replay, REPLAYS,
         2.0),
	CASE("vulkan-all", "Vulkan, every model in view", sweep, SWEEP, 4.0),
	CASE("vulkan-half", "Vulkan, half of the models in view", sweep, SWEEP, 2.0),
	CASE("vulkan-few", "Vulkan, one model in a hundred in view", sweep, SWEEP, 1.0),
};

/* The subjects beside stilb-workers-N. fill_subjects appends the number of workers to the first two names. */
static const bench_subject others[] = {
	{.name = "sutter-",
     .program = PROGRAM,
     .note = "as many workers, which get every draw through Sutter's queue; a draw costs what it did in 2009",
     .abilities = TWO_POOLS},
	{.name = "sutter-", .program = PROGRAM, .abilities = TWO_POOLS},
	{.name = "dedicated",
     .program = PROGRAM,
     .note = "the main thread culls and pushes every model into stilb_job_spsc; one thread records and replays",
     .abilities = DEDICATED},
	{.name = "stilb-direct",
     .program = PROGRAM,
     .note = "replays every draw into one command buffer, on the main thread",
     .abilities = REPLAYS},
	{.name = "stilb-secondary",
     .program = PROGRAM,
     .note =
         "replays into one secondary command buffer for each worker, in parallel, like the article's deferred contexts",
     .abilities = REPLAYS},
	{.name = "stilb-indirect",
     .program = PROGRAM,
     .note = "replays as one multi-draw-indirect that reads the workers' lists",
     .abilities = REPLAYS},
	{.name = "no-queue",
     .program = PROGRAM,
     .note = "one thread records everything, without a queue",
     .abilities = QUEUES,
     .reference = true},
	{.name = "mutex", .program = PROGRAM, .note = "a linked list under one pthread mutex", .abilities = QUEUES},
	{.name = "kernel-mutex",
     .program = PROGRAM,
     .note =
         "the same list under a lock that enters the kernel for every lock and unlock, as Windows' mutex objects do",
     .abilities = QUEUES},
	{.name = "sutter",
     .program = PROGRAM,
     .note = "the two-lock queue of Herb Sutter's article (Dr. Dobb's Journal, November 2008)",
     .abilities = QUEUES},
	{.name = "stilb-low-lock", .program = PROGRAM, .abilities = QUEUES},
	{.name = "stilb-lock-free", .program = PROGRAM, .abilities = QUEUES},
};

static char names[2][32]; /* names of the first two of `others`, with their numbers of workers */
static bench_subject subjects[BENCH_THREADS_MAX_COUNTS + COUNT(others)];

static size_t fill_subjects(void)
{
	size_t filled = 0;
	uint32_t fitting = bench_threads_fitting(), most = bench_threads_too_many(), pools[] = {fitting, most};
	for (size_t i = 0; i < bench_threads_count; i++, filled++) {
		uint32_t workers = bench_threads_counts[i];
		uint32_t few = workers == 0 || workers == fitting ? DEDICATED : 0;
		uint32_t two = workers == fitting || workers == most ? TWO_POOLS : 0;
		uint32_t stolen = workers == 0 || workers == fitting || workers == most ? STOLEN : 0;
		subjects[filled] = (bench_subject){
			.name = bench_threads_name(workers), .program = PROGRAM, .abilities = SWEEP | few | two | stolen};
	}
	for (size_t i = 0; i < COUNT(others); i++, filled++) {
		subjects[filled] = others[i];
		if (i < COUNT(pools)) {
			snprintf(names[i], sizeof names[i], "%s%u", others[i].name, pools[i]);
			subjects[filled].name = names[i];
		}
	}
	return filled;
}

/* ---- before the first run ---------------------------------------------------------------------------------------- */

static bool find_hash(const char *view, uint64_t *hash)
{
	bench_child_result result;
	bench_child_run(PROGRAM, "reference", view, 0.0, 0, NULL, (bench_limit){120.0, 120.0}, &result);
	if (result.state != BENCH_CHILD_DONE || result.value_count != 2) {
		stilb_log("cannot draw the reference frame, whose command stream every run must have: %s", result.message);
		return false;
	}
	*hash = (uint64_t)result.values[0].value << 32 | (uint64_t)result.values[1].value;
	return true;
}

/* The programs' argument: the stream hashes (stilb_render_stream_hash) that every run must have, and the folder for
 * timelines. */
static const char *prepare(const bench_options *options)
{
	static char argument[PATH_MAX + 64];
	const char *traces = options->traces ? options->traces : "";
	if (options->traces && mkdir(options->traces, 0777) != 0 && errno != EEXIST) {
		stilb_log("--traces: cannot create the folder '%s': %s", options->traces, strerror(errno));
		return NULL;
	}
	if (!find_hash("all", &bench_threads_hashes[0]) || !find_hash("half", &bench_threads_hashes[1]) ||
	    !find_hash("few", &bench_threads_hashes[2]))
		return NULL;
	snprintf(argument, sizeof argument, "%016llx:%016llx:%016llx:%s", (unsigned long long)bench_threads_hashes[0],
	         (unsigned long long)bench_threads_hashes[1], (unsigned long long)bench_threads_hashes[2], traces);
	return argument;
}

/* ---- after the last run ------------------------------------------------------------------------------------------ */

/* Each run of the row's subject and case, even a failed one, may have left the timeline of its slowest frame: keeps
 * that of the run with the largest value of `row`, and removes the others. */
static void keep_worst(const bench_results *results, const bench_row *row)
{
	const char *folder = results->options->traces;
	char path[PATH_MAX], kept[PATH_MAX];
	snprintf(kept, sizeof kept, "%s/%s.%s.trace.json", folder, row->on->name, row->name);
	for (uint32_t round = 0; round < results->rounds; round++) {
		snprintf(path, sizeof path, "%s/%s.%s.%u.trace.json", folder, row->on->name, row->name, round);
		bool worst = row->runs > 0 && row->values[round] == row->max;
		if (worst ? rename(path, kept) != 0 : unlink(path) != 0 && errno != ENOENT)
			stilb_log("--traces: '%s': %s", path, strerror(errno));
	}
}

/* Sets two metrics of each round: speed-up, the frame time without workers / the frame time, and efficiency, 100 *
 * speed-up / the number of threads that can run at once (the workers and the main thread, at most one for each CPU). */
static void add_gain(bench_results *results, const bench_case *on, const bench_subject *subject, uint32_t workers)
{
	const bench_row *alone = bench_find(results, on->name, subjects[0].name, "frame");
	const bench_row *frame = bench_find(results, on->name, subject->name, "frame");
	for (uint32_t round = 0; alone && frame && round < results->rounds; round++) {
		double gain = alone->values[round] / frame->values[round];
		bench_set_value(results, on, subject, "speed-up", round, gain);
		bench_set_value(results, on, subject, "efficiency", round,
		                100.0 * gain / fmin(workers + 1.0, bench_cpu_count()));
	}
}

static void finish(bench_results *results)
{
	for (size_t c = 0; c < COUNT(cases); c++)
		for (size_t n = 0; cases[c].needs == SWEEP && n < bench_threads_count; n++)
			add_gain(results, &cases[c], &subjects[n], bench_threads_counts[n]);
	for (size_t i = 0; results->options->traces && i < results->row_count; i++)
		if (strcmp(results->rows[i].metric, "worst") == 0)
			keep_worst(results, &results->rows[i]);
}

/* ---- the suite --------------------------------------------------------------------------------------------------- */

const bench_suite *bench_threads_suite(void)
{
	static bench_suite suite = {.name = "threads",
	                            .help = "the whole frame by number of workers; dedicated threads, queues, stolen CPUs",
	                            .subjects = subjects,
	                            .cases = cases,
	                            .case_count = COUNT(cases),
	                            .prepare = prepare,
	                            .finish = finish,
	                            .traces = true,
	                            .quick_rounds = 1,
	                            .start_seconds = 0.1,
	                            .report = bench_threads_report,
	                            .report_alone = true,
	                            .plot = bench_threads_plot,
	                            .plot_rows = BENCH_THREADS_PLOT_ROWS};
	if (suite.subject_count == 0) {
		bench_threads_choose_counts();
		suite.subject_count = fill_subjects();
	}
	return &suite;
}
