/* stilb demo: draws the stress test, a scene of thousands of models, in a window or headless, which is without one. */
#include "base/base_file.h"
#include "demo_gamepads.h"
#include "demo_options.h"
#include "demo_picture.h"
#include "demo_progress.h"
#include "demo_report.h"
#include "demo_scene.h"
#include "demo_track.h"
#include "engine_faults.h"
#include "game/cli/stage_times.h"
#include "game/commands.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEMO_FRAMES 120u         /* frames of a headless run without --frames, */
#define DEMO_FRAMES_SOFTWARE 30u /* and on a device that draws on the CPU, where each takes a quarter of a second */
#define DEMO_TRACE_FRAMES 1000u  /* frames in the file of --trace, at most */
#define DEMO_VIEWS 3u            /* number of values of stilb_scene_stress_view */

typedef struct demo_run {
	demo_options options;
	stilb_engine *engine;
	demo_scene scene;
	stilb_engine_report report; /* of the last frame that was drawn */
	stage_times times;
	uint64_t frames; /* number of frames drawn */
	demo_track track;
	demo_gamepads gamepads;
	int view; /* a stilb_scene_stress_view */
	bool window;
	bool lost; /* the window's display has gone */
	/* Both are written by demo_on_captured on the profiler's capturing thread. The main thread reads them after it has
	 * destroyed the engine, which ends that thread. */
	int capture_error;   /* of the last capture: negative errno, or 0 */
	bool capture_failed; /* true if any capture failed */
} demo_run;

static volatile sig_atomic_t demo_interrupted; /* number of the signal; 0: none came */

static void demo_on_signal(int signal_number)
{
	demo_interrupted = signal_number; /* ends demo_loop; pictures, traces and statistics are written all the same */
}

/* Called on the capturing thread after each capture, a trace that is written during the run. An error that repeats,
 * like a full disk, is printed once, not for every slow frame. */
static void demo_on_captured(void *user, const stilb_prof_captured *captured)
{
	demo_run *run = user;
	FILE *out = demo_message_stream(&run->options);
	if (captured->error == 0 && captured->cause == STILB_PROF_CAUSE_SPIKE)
		fprintf(out, "trace: %s, frame %" PRIu64 " took %.1f ms\n", captured->path, captured->frame,
		        captured->frame_ms);
	else if (captured->error == 0)
		fprintf(out, "trace: %s\n", captured->path);
	else if (captured->error != run->capture_error)
		stilb_log("cannot write '%s': %s", captured->path, strerror(-captured->error));
	fflush(out);
	run->capture_error = captured->error;
	run->capture_failed |= captured->error != 0;
}

/* Creates the engine and then the scene, which would be made in vain without a driver; without a display the engine
 * runs headless, after a line that says so. */
static stilb_result demo_start(demo_run *run)
{
	stilb_engine_desc desc = demo_options_engine(&run->options);
	desc.capture.done = demo_on_captured;
	desc.capture.user = run;
	demo_faults faults = demo_options_faults(&run->options);
	demo_scene_init(&run->scene, &run->options, faults.slow_frame);
	desc.choice = &run->scene.light;
	desc.update = demo_scene_update;
	desc.user = &run->scene;
	stilb_engine_set_faults(&faults.render);
	stilb_result result = stilb_engine_create(&desc, &run->engine);
	if (result == STILB_ERROR_WINDOW) {
		stilb_log("%s; running headless", stilb_error_message());
		desc.window = false;
		result = stilb_engine_create(&desc, &run->engine);
	}
	run->window = desc.window;
	return result == STILB_OK ? demo_scene_show(&run->scene, &run->options, run->engine) : result;
}

static void demo_say_result(const demo_run *run, stilb_result result, const char *what, const char *path)
{
	if (result == STILB_OK)
		fprintf(demo_message_stream(&run->options), "%s: %s\n", what, path);
	else
		stilb_log("%s", stilb_error_message());
}

static void demo_take_picture(demo_run *run)
{
	const char *last = run->options.screenshot;
	char *path = demo_picture_name(last && !stilb_file_is_stdout(last) ? last : DEMO_PICTURE, last);
	if (path)
		demo_say_result(run, stilb_engine_screenshot(run->engine, path), "picture", path);
	else
		stilb_log("no memory for a picture's name");
	fflush(demo_message_stream(&run->options));
	free(path);
}

/* Carries out the commands of keys and gamepads in the last frame's input. A file that cannot be written is one line on
 * stderr; only a failure of the engine ends the run. */
static stilb_result demo_act(demo_run *run, const stilb_engine_report *report)
{
	if (report->input.capture && stilb_engine_capture(run->engine) != STILB_OK)
		stilb_log("%s", stilb_error_message());
	if (report->input.screenshot)
		demo_take_picture(run);
	if (report->input.next_view % DEMO_VIEWS > 0) {
		run->view = (int)(((uint32_t)run->view + report->input.next_view) % DEMO_VIEWS);
		demo_scene_look(&run->scene, (stilb_scene_stress_view)run->view, run->engine);
	}
	int64_t workers = (int64_t)stilb_engine_workers(run->engine) + report->input.workers;
	workers = workers < 0 ? 0 : workers > STILB_JOB_MAX_WORKERS ? STILB_JOB_MAX_WORKERS : workers;
	if (workers == (int64_t)stilb_engine_workers(run->engine))
		return STILB_OK;
	fprintf(demo_message_stream(&run->options), "workers: %" PRId64 "\n", workers);
	return stilb_engine_set_workers(run->engine, (uint32_t)workers);
}

/* Updates the window's title twice a second. *last is the time of the last update, ns. */
static void demo_title(demo_run *run, uint64_t *last)
{
	uint64_t now = stilb_time_ns();
	char title[160];
	if (!run->window || now - *last < 500000000u)
		return;
	*last = now;
	uint32_t workers = stilb_engine_workers(run->engine);
	snprintf(title, sizeof title, "Stilb: %u of %" PRIu64 " models, %u worker%s, frame %.1f ms", run->report.visible,
	         run->options.models, workers, workers == 1 ? "" : "s", run->report.times.frame);
	stilb_engine_set_title(run->engine, title);
}

/* Number of frames after which the run ends; 0: it ends with its window, its recording or a signal. */
static uint64_t demo_frames_wanted(const demo_run *run)
{
	bool open_ended = run->window || run->lost || demo_options_is_replay(&run->options);
	uint64_t frames = stilb_engine_device_is_software(run->engine) ? DEMO_FRAMES_SOFTWARE : DEMO_FRAMES;
	return run->options.frames > 0 ? run->options.frames : open_ended ? 0 : frames;
}

/* True if the run has ended. Without a window and --frames, a run that replays a gamepad recording ends with it. */
static bool demo_is_over(const demo_run *run, const stilb_engine_report *report)
{
	uint64_t wanted = demo_frames_wanted(run);
	if (demo_interrupted || report->close)
		return true;
	if (wanted > 0)
		return run->frames >= wanted;
	return !run->window && (!demo_options_is_replay(&run->options) || report->replayed);
}

/* Called once, when the window's display has gone. The outputs are written all the same. */
static void demo_lose_window(demo_run *run)
{
	run->window = false;
	run->lost = true;
	bool over = demo_frames_wanted(run) == 0 && !demo_options_is_replay(&run->options);
	stilb_log("the display has gone after %" PRIu64 " frames; %s", run->frames,
	          over ? "ending the run, because no window is left to close" : "running on headless");
}

static stilb_result demo_frame(demo_run *run, stilb_engine_report *report)
{
	stilb_result result = demo_act(run, report); /* on the input of the frame before */
	if (result == STILB_OK)
		result = stilb_engine_frame(run->engine, report);
	if (result != STILB_OK)
		return result;
	if (report->drawn) {
		run->report = *report;
		run->frames++;
		demo_track_add(&run->track, run->engine, report);
		if (!stage_times_add(&run->times, &report->times))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the times of %" PRIu64 " frames", run->frames);
	}
	if (report->lost && run->window)
		demo_lose_window(run);
	return STILB_OK;
}

static stilb_result demo_loop(demo_run *run)
{
	uint64_t last_title = 0;
	stilb_engine_report report = {0};
	demo_progress progress;
	demo_progress_begin(&progress);
	stilb_result result = STILB_OK;
	while (result == STILB_OK && !demo_is_over(run, &report)) {
		result = demo_frame(run, &report);
		demo_gamepads_say(&run->gamepads, run->engine, report.replayed, demo_message_stream(&run->options));
		demo_title(run, &last_title);
		if (!run->window)
			demo_progress_show(&progress, run->frames, demo_frames_wanted(run));
	}
	demo_progress_end(&progress);
	return result;
}

static void demo_say_end(const demo_run *run)
{
	uint64_t wanted = demo_frames_wanted(run);
	char of[32] = "";
	if (!demo_interrupted)
		return;
	if (wanted > 0)
		snprintf(of, sizeof of, " of %" PRIu64, wanted);
	fprintf(demo_message_stream(&run->options), "stopped by SIG%s after %" PRIu64 "%s frames\n",
	        sigabbrev_np(demo_interrupted), run->frames, of);
}

/* Writes all outputs and prints the summary; an output that fails does not keep the others from being written. Returns
 * true if everything succeeded. */
static bool demo_finish(demo_run *run)
{
	const demo_options *o = &run->options;
	demo_report report = {.options = o,
	                      .engine = run->engine,
	                      .last = run->report,
	                      .frames = run->frames,
	                      .light = run->scene.light.chosen};
	double gpu_ms;
	stilb_result waited = stilb_engine_wait(run->engine, &gpu_ms);
	if (waited != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return false;
	}
	stage_times_last_gpu(&run->times, gpu_ms);
	bool good = stage_times_summarise(&run->times, report.summary, &report.warmup);
	if (!good)
		stilb_log("no memory to sort the stage times; they are reported as 0");
	stilb_result picture = STILB_OK, trace = STILB_OK, stats = STILB_OK, dump = STILB_OK, track = STILB_OK;
	if (o->screenshot)
		demo_say_result(run, picture = stilb_engine_screenshot(run->engine, o->screenshot), "picture", o->screenshot);
	if (o->trace)
		demo_say_result(run, trace = stilb_engine_trace(run->engine, o->trace, DEMO_TRACE_FRAMES), "trace", o->trace);
	if (o->stats)
		demo_say_result(run, stats = demo_report_save(&report), "stats", o->stats);
	if (o->dump)
		demo_say_result(run, dump = stilb_engine_dump(run->engine, o->dump), "dump", o->dump);
	if (o->track)
		demo_say_result(run, track = demo_track_save(&run->track), "track", o->track);
	demo_say_end(run);
	demo_report_print(&report);
	uint32_t messages = stilb_engine_validation_messages(run->engine);
	if (messages > 0)
		stilb_log("the validation layer had %u message%s", messages, messages == 1 ? "" : "s");
	return good && picture == STILB_OK && trace == STILB_OK && stats == STILB_OK && dump == STILB_OK &&
	       track == STILB_OK && messages == 0;
}

static int demo_main(demo_run *run)
{
	stilb_result started = demo_start(run);
	if (started == STILB_OK && run->options.track)
		started = demo_track_open(&run->track, run->options.track);
	if (started != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return exit_code_of(started);
	}
	struct sigaction once = {.sa_handler = demo_on_signal, .sa_flags = SA_RESETHAND}; /* a second one kills */
	sigaction(SIGINT, &once, NULL);
	sigaction(SIGTERM, &once, NULL);
	if (run->options.no_profile)
		signal(SIGUSR1, SIG_IGN); /* SIGUSR1 requests a capture; without a profiler it would kill the process */
	if (run->window)
		fprintf(demo_message_stream(&run->options), DEMO_KEYS ";\nclose the window to end\n");
	fflush(stdout);
	if (demo_loop(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	if (run->frames == 0) {
		stilb_log("no frame was drawn");
		return EXIT_FAILED;
	}
	bool cut_short = run->lost && demo_frames_wanted(run) == 0 && !run->report.replayed;
	return demo_finish(run) && !cut_short ? EXIT_DONE : EXIT_FAILED;
}

int demo_command(int argc, char **argv)
{
	demo_run run = {.options = demo_options_default()};
	flags_result parsed = demo_options_parse(&run.options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !demo_options_check(&run.options))
		return EXIT_REFUSED;
	run.view = run.options.view;
	int code = demo_main(&run);
	demo_track_finish(&run.track);
	stilb_engine_destroy(run.engine); /* writes the captures that are still pending */
	demo_scene_finish(&run.scene);
	stage_times_finish(&run.times);
	return code == EXIT_DONE && run.capture_failed ? EXIT_FAILED : code;
}
