/* Runs of the whole engine: by number of workers, by replay mode, and with a CPU occupied by another process. */
#include "bench/threads/threads_run.h"

#include "engine.h"
#include "tests/engine/stress_engine.h"

#include <limits.h>
#include <malloc.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>

/* Size of the picture in pixels: small, since lavapipe draws on the CPU; the aspect ratio is that of the engine's
 * default size, so that the same models are visible. */
#define PICTURE_WIDTH 320u
#define PICTURE_HEIGHT 180u

/* lavapipe frees memory in each frame and allocates it again in the next one. If malloc returned it to the kernel in
 * between, page faults could take half of the frame and make runs differ by a factor of two. */
static void keep_memory(void)
{
	mallopt(M_TRIM_THRESHOLD, INT_MAX);
	mallopt(M_MMAP_THRESHOLD, 32 << 20); /* the largest value that mallopt accepts */
}

static stilb_engine *open_engine(const threads_setup *setup)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	desc.workers = setup->workers;
	desc.device = setup->device;
	desc.replay = setup->replay;
	desc.shadows.kind = STILB_ENGINE_SHADOWS_OFF; /* the draws that are measured are those of one view */
	if (setup->device == STILB_RENDER_DEVICE_VULKAN) {
		desc.width = PICTURE_WIDTH;
		desc.height = PICTURE_HEIGHT;
		keep_memory();
	}
	stress_engine stress = {.models = THREADS_MODELS, .seed = THREADS_SEED, .view = setup->view};
	stilb_result result = stress_engine_create(&desc, &stress, &engine);
	if (result == STILB_OK)
		return engine;
	fprintf(stderr, "%s\n", stilb_error_message());
	exit(result == STILB_ERROR_DEVICE ? BENCH_CHILD_SKIP : 1); /* no driver: the case is skipped with this reason */
}

static stilb_engine_report run_frame(stilb_engine *engine)
{
	stilb_engine_report report;
	if (stilb_engine_frame(engine, &report) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	return report;
}

/* Draws frames for a tenth of the run, at least as many as are in flight. */
static void warm_up(stilb_engine *engine, double seconds)
{
	uint64_t end = bench_child_now_ns() + (uint64_t)(0.1 * seconds * 1e9);
	for (uint32_t frames = 0; frames < 2 || bench_child_now_ns() < end; frames++)
		run_frame(engine);
}

/* ---- stages ------------------------------------------------------------------------------------------------------ */

/* Times of whole frames and of their stages; rest: waiting for the device, updating the scene, presenting. */
typedef struct stages {
	threads_series frame, cull, record, replay, rest;
} stages;

static void add_stages(stages *all, const stilb_engine_times *times)
{
	threads_series_add(&all->frame, times->frame);
	threads_series_add(&all->cull, times->cull);
	threads_series_add(&all->record, times->record);
	threads_series_add(&all->replay, times->replay);
	threads_series_add(&all->rest, times->frame - times->cull - times->record - times->replay);
}

static void print_stages(const stages *all)
{
	threads_print_frames(&all->frame);
	bench_child_metric(
		"latency", threads_series_quantile(&all->frame, 0.5)); /* without pipelining a frame's latency is its time */
	bench_child_metric("cull", threads_series_quantile(&all->cull, 0.5));
	bench_child_metric("record", threads_series_quantile(&all->record, 0.5));
	bench_child_metric("replay", threads_series_quantile(&all->replay, 0.5));
	bench_child_metric("rest", threads_series_quantile(&all->rest, 0.5));
}

void threads_run_engine(threads_run *run, const threads_setup *setup)
{
	stilb_engine *engine = open_engine(setup);
	static stages all;
	stilb_engine_report report = {0};
	uint32_t frames = 0;
	warm_up(engine, run->child.seconds);
	threads_usage before = threads_usage_now();
	for (threads_run_begin(run); !threads_run_over(run, all.frame.count); frames++) {
		report = run_frame(engine);
		if (threads_run_frame(run, report.times.frame))
			add_stages(&all, &report.times);
	}
	threads_usage after = threads_usage_now();
	double seconds = (double)(bench_child_now_ns() - run->begin_ns) * 1e-9;
	threads_run_check(run, setup->view, stilb_engine_stream_hash(engine));
	print_stages(&all);
	bench_child_metric("cpu", (after.cpu_ms - before.cpu_ms) / (double)frames);
	bench_child_metric("switched-out", (after.switched_out - before.switched_out) / seconds);
	bench_child_metric("visible", (double)report.visible);
	bench_child_metric("software", stilb_engine_device_is_software(engine));
	stress_engine_destroy(engine);
}

/* ---- an occupied CPU --------------------------------------------------------------------------------------------- */

/* Starts the thief, a process that spins and so occupies a CPU; on return it is stopped until it gets SIGCONT. Must be
 * called before threads are created, since it forks. */
static pid_t thief_start(void)
{
	pid_t parent = getpid(), thief = fork();
	if (thief < 0)
		bench_child_fail("cannot start another process");
	if (thief > 0) {
		waitpid(thief, NULL, WUNTRACED); /* until it has stopped itself */
		return thief;
	}
	prctl(PR_SET_PDEATHSIG, SIGKILL);
	if (getppid() != parent)
		_exit(1); /* the parent ended before prctl */
	raise(SIGSTOP);
	for (;;)
		__asm__ volatile("");
}

static void thief_end(pid_t thief)
{
	kill(thief, SIGKILL);
	waitpid(thief, NULL, 0);
}

/* The frame rate has recovered if the median of RECOVERY_FRAMES frames in a row is at most RECOVERY_SLOWDOWN times the
 * median before the disturbance. */
#define RECOVERY_FRAMES 16u
#define RECOVERY_SLOWDOWN 1.1

/* The sum of the frame times, in ms, from frame `first` until the frame rate has recovered. */
static double recovery_ms(const threads_series *frames, uint32_t first, double usual)
{
	double sum = 0.0;
	for (uint32_t i = first; i + RECOVERY_FRAMES <= frames->count; i++) {
		if (threads_series_part(frames, i, i + RECOVERY_FRAMES, 0.5) <= RECOVERY_SLOWDOWN * usual)
			return sum;
		sum += frames->at[i];
	}
	return sum;
}

static double mean(const threads_series *frames, uint32_t first, uint32_t end)
{
	double sum = 0.0;
	for (uint32_t i = first; i < end; i++)
		sum += frames->at[i];
	return end > first ? sum / (double)(end - first) : 0.0;
}

static void print_stolen(const threads_series *frames, uint32_t taken, uint32_t given_back)
{
	double usual = threads_series_part(frames, 0, taken, 0.5);
	bench_child_metric("before", usual);
	bench_child_metric("before-mean", mean(frames, 0, taken));
	bench_child_metric("before-p99", threads_series_part(frames, 0, taken, 0.99));
	bench_child_metric("during", threads_series_part(frames, taken, given_back, 0.5));
	bench_child_metric("during-mean", mean(frames, taken, given_back));
	bench_child_metric("during-p99", threads_series_part(frames, taken, given_back, 0.99));
	bench_child_metric("worst", threads_series_part(frames, taken, given_back, 1.0));
	bench_child_metric("after", threads_series_part(frames, given_back, frames->count, 0.5));
	bench_child_metric("recovery", recovery_ms(frames, given_back, usual));
}

/* A third of the run is measured without the thief, a third while it spins, a third without it. The timeline shows the
 * slowest frame of the second third. */
void threads_run_stolen(threads_run *run, uint32_t workers)
{
	pid_t thief = thief_start();
	stilb_engine *engine = open_engine(&(threads_setup){.device = STILB_RENDER_DEVICE_NULL, .workers = workers});
	const char *trace = run->trace;
	threads_series frames = {0};
	uint32_t first[4] = {0}; /* first frame of each third, and the number of frames */
	warm_up(engine, run->child.seconds);
	threads_run_begin(run);
	for (uint32_t third = 0; third < 3; third++) {
		uint64_t end = run->begin_ns + (third + 1) * (run->end_ns - run->begin_ns) / 3;
		run->trace = third == 1 ? trace : NULL;
		run->worst_ms = 0.0;
		if (third == 1)
			kill(thief, SIGCONT);
		else if (third == 2)
			thief_end(thief);
		while (bench_child_now_ns() < end || frames.count < first[third] + THREADS_LEAST_FRAMES) {
			stilb_engine_report report = run_frame(engine);
			if (threads_run_frame(run, report.times.frame))
				threads_series_add(&frames, report.times.frame);
		}
		first[third + 1] = frames.count;
	}
	threads_run_check(run, STILB_SCENE_VIEW_ALL, stilb_engine_stream_hash(engine));
	print_stolen(&frames, first[1], first[2]);
	free(frames.at);
	stress_engine_destroy(engine);
}
