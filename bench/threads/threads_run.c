/* main of the program of the suite `threads`: chooses the run, collects times, keeps the slowest frame's timeline. */
#include "bench/threads/threads_run.h"

#include "engine.h"
#include "profiler/prof.h"
#include "profiler/prof_trace.h"
#include "tests/engine/stress_engine.h"

#include <limits.h>
#include <string.h>
#include <sys/resource.h>

#define TRACED_FRAMES 2u /* the slowest frame, and the one before it for comparison */

const char *const threads_view_names[THREADS_VIEWS] = {"all", "half", "few"};

/* ---- times ------------------------------------------------------------------------------------------------------- */

void threads_series_add(threads_series *series, double ms)
{
	if (series->count == series->capacity) {
		uint32_t capacity = series->capacity ? 2 * series->capacity : 4096;
		double *grown = realloc(series->at, capacity * sizeof *grown);
		if (!grown)
			bench_child_fail("out of memory for the times of frames");
		series->at = grown;
		series->capacity = capacity;
	}
	series->at[series->count++] = ms;
}

static int compare_doubles(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

double threads_series_part(const threads_series *series, uint32_t first, uint32_t end, double part)
{
	if (end <= first)
		return 0.0;
	uint32_t count = end - first;
	double *sorted = malloc(count * sizeof *sorted);
	if (!sorted)
		bench_child_fail("out of memory for the times of frames");
	memcpy(sorted, series->at + first, count * sizeof *sorted);
	qsort(sorted, count, sizeof *sorted, compare_doubles);
	double value = sorted[(uint32_t)(part * (count - 1) + 0.5)];
	free(sorted);
	return value;
}

double threads_series_quantile(const threads_series *series, double part)
{
	return threads_series_part(series, 0, series->count, part);
}

void threads_print_frames(const threads_series *frames)
{
	bench_child_metric("frame", threads_series_quantile(frames, 0.5));
	bench_child_metric("p99", threads_series_quantile(frames, 0.99));
	bench_child_metric("worst", threads_series_quantile(frames, 1.0));
}

threads_usage threads_usage_now(void)
{
	struct rusage usage;
	getrusage(RUSAGE_SELF, &usage);
	return (threads_usage){
		.cpu_ms = 1e3 * (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
	              1e-3 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec),
		.switched_out = (double)usage.ru_nivcsw,
	};
}

/* ---- the timeline of the slowest frame --------------------------------------------------------------------------- */

static void write_trace(const char *path)
{
	stilb_prof_window window = {.last_frames = TRACED_FRAMES};
	stilb_prof_snapshot snapshot = {0};
	stilb_prof_frame_mark(); /* ends the slowest frame for the profiler, so that its snapshot has all of the frame */
	int error = stilb_prof_snapshot_take(&snapshot, &window);
	if (error == 0)
		error = stilb_prof_trace_save(&snapshot, "stilb-bench-threads", path);
	if (error != 0)
		bench_child_fail("cannot write '%s': %s", path, strerror(-error));
	stilb_prof_snapshot_finish(&snapshot);
}

void threads_run_begin(threads_run *run)
{
	run->begin_ns = bench_child_now_ns();
	run->end_ns = run->begin_ns + (uint64_t)(run->child.seconds * 1e9);
}

bool threads_run_frame(threads_run *run, double ms)
{
	if (run->calm > 0) {
		run->calm--;
		return false;
	}
	if (ms > run->worst_ms) {
		run->worst_ms = ms;
		if (run->trace) {
			write_trace(run->trace);
			run->calm = THREADS_CALM_FRAMES;
		}
	}
	return true;
}

bool threads_run_over(const threads_run *run, uint32_t frames)
{
	return frames >= THREADS_LEAST_FRAMES && bench_child_now_ns() >= run->end_ns;
}

void threads_run_check(const threads_run *run, stilb_scene_stress_view view, uint64_t hash)
{
	if (hash != run->hash[view])
		bench_child_fail("wrong result: the command stream's hash is %016llx, and %016llx without workers on the null "
		                 "device",
		                 (unsigned long long)hash, (unsigned long long)run->hash[view]);
}

/* ---- choosing the run -------------------------------------------------------------------------------------------- */

/* Parses the argument "HASH:HASH:HASH:FOLDER" of bench_threads.c; with an empty folder no timeline is written. */
static void parse_argument(threads_run *run)
{
	static char path[PATH_MAX];
	const char *at = run->child.argument ? run->child.argument : "";
	for (uint32_t v = 0; v < THREADS_VIEWS; v++) {
		char *end;
		run->hash[v] = strtoull(at, &end, 16);
		if (end == at || *end != ':')
			bench_child_fail("'%s' does not begin with the hashes of %u views", at, THREADS_VIEWS);
		at = end + 1;
	}
	if (*at == '\0')
		return;
	int length = snprintf(path, sizeof path, "%s/%s.%s.%u.trace.json", at, run->child.case_name, run->child.subject,
	                      run->child.round);
	if (length >= (int)sizeof path)
		bench_child_fail("the folder's name is too long: '%s'", at);
	run->trace = path;
}

/* The number of workers that gives one thread for each CPU, the main thread included; at least 1. */
static uint32_t usual_workers(void)
{
	uint32_t cpus = bench_child_cpu_count();
	return cpus > 1 ? cpus - 1 : 1;
}

/* True if text is name followed by a number, which goes to *number. */
static bool parse_numbered(const char *text, const char *name, uint32_t *number)
{
	size_t length = strlen(name);
	char *end;
	if (strncmp(text, name, length) != 0 || !text[length])
		return false;
	*number = (uint32_t)strtoul(text + length, &end, 10);
	return *end == '\0';
}

/* Fills in the engine's settings for the run's case and subject; false if the subject is not the engine. */
static bool parse_setup(const bench_child *child, threads_setup *setup)
{
	static const char *const devices[] = {[STILB_RENDER_DEVICE_VULKAN] = "vulkan", [STILB_RENDER_DEVICE_NULL] = "null"};
	static const char *const replays[] = {[STILB_RENDER_REPLAY_INDIRECT] = "stilb-indirect",
	                                      [STILB_RENDER_REPLAY_DIRECT] = "stilb-direct",
	                                      [STILB_RENDER_REPLAY_SECONDARY] = "stilb-secondary"};
	*setup = (threads_setup){.device = STILB_RENDER_DEVICE_NULL, .workers = usual_workers()};
	for (int r = 0; r < 3; r++)
		if (strcmp(child->subject, replays[r]) == 0) {
			setup->device = STILB_RENDER_DEVICE_VULKAN;
			setup->replay = (stilb_render_replay_mode)r;
			return true;
		}
	for (uint32_t d = 0; d < 2; d++)
		for (uint32_t v = 0; v < THREADS_VIEWS; v++) {
			char name[32];
			snprintf(name, sizeof name, "%s-%s", devices[d], threads_view_names[v]);
			if (strcmp(child->case_name, name) == 0) {
				setup->device = (stilb_render_device_kind)d;
				setup->view = (stilb_scene_stress_view)v;
			}
		}
	return parse_numbered(child->subject, "stilb-workers-", &setup->workers);
}

/* Prints the stream hash that every run must have, that of the null device without workers, as two 32-bit halves. */
static int print_reference(const char *view_name)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	stilb_engine_report report;
	stress_engine stress = {.models = THREADS_MODELS, .seed = THREADS_SEED};
	desc.workers = 0;
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.shadows.kind = STILB_ENGINE_SHADOWS_OFF; /* as in threads_engine.c */
	for (uint32_t v = 0; v < THREADS_VIEWS; v++)
		if (strcmp(view_name, threads_view_names[v]) == 0)
			stress.view = (stilb_scene_stress_view)v;
	if (stress_engine_create(&desc, &stress, &engine) != STILB_OK || stilb_engine_frame(engine, &report) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	uint64_t hash = stilb_engine_stream_hash(engine);
	bench_child_metric("hash-high", (double)(hash >> 32));
	bench_child_metric("hash-low", (double)(hash & UINT32_MAX));
	stress_engine_destroy(engine);
	return 0;
}

int main(int argc, char **argv)
{
	threads_run run = {.child = bench_child_args(argc, argv)};
	const char *on = run.child.case_name, *subject = run.child.subject;
	threads_setup setup;
	uint32_t workers = usual_workers();
	if (strcmp(subject, "reference") == 0)
		return print_reference(on);
	parse_argument(&run);
	bool engine = parse_setup(&run.child, &setup);
	if (engine && strcmp(on, "stolen") == 0)
		threads_run_stolen(&run, setup.workers);
	else if (engine)
		threads_run_engine(&run, &setup);
	else if (strcmp(subject, "dedicated") == 0)
		threads_run_dedicated(&run);
	else if (parse_numbered(subject, "sutter-", &workers))
		threads_run_queue(&run, "sutter", workers, true, 1);
	else
		threads_run_queue(&run, subject, workers, strcmp(on, "mutex-vs-lowlock-2009") == 0,
		                  strcmp(on, "mutex-vs-lowlock-segments") == 0 ? 512 : 1);
	return 0;
}
