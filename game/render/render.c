/* stilb render: a picture by ray tracing. The work runs on a thread of its own (render_work.h); this file starts it,
 * shows its progress on the terminal and in the window of --preview, and reports the result. */
#include "game/commands.h"
#include "render_merge.h"
#include "render_options.h"
#include "render_progress.h"
#include "render_report.h"
#include "render_work.h"

#include "profiler/prof.h"
#include "viewer.h"

#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define RENDER_TICK 0.1           /* seconds between two updates of progress and window */
#define RENDER_PREVIEW_SHARE 0.04 /* share of the main thread's time that updates of the window's picture may take */
#define RENDER_MANY_RAYS 1e10     /* --integrator montecarlo needs --force for more: they take minutes to hours */

static volatile sig_atomic_t offline_interrupted;

static volatile sig_atomic_t offline_continued;

static void offline_on_continue(int signal_number)
{
	(void)signal_number;
	offline_continued = 1;
}

/* Where ranks work together, the host decides when they end. mpirun sends SIGCONT to all when a rank has died or Ctrl-C
 * was pressed, a second later SIGTERM and another second later SIGKILL: the first is the hint to write a checkpoint. */
static void offline_catch_crew_signals(bool guest)
{
	struct sigaction ignore = {.sa_handler = SIG_IGN}, again = {.sa_handler = offline_on_continue};
	if (guest) {
		sigaction(SIGINT, &ignore, NULL);
		sigaction(SIGTERM, &ignore, NULL);
		sigaction(SIGHUP, &ignore, NULL);
	} else {
		sigaction(SIGCONT, &again, NULL);
		sigaction(SIGPIPE, &ignore, NULL); /* mpirun, which prints what we write, may be gone */
	}
}

static void offline_on_signal(int signal_number)
{
	(void)signal_number;
	offline_interrupted = 1; /* stops the work, which writes the picture so far */
}

/* The first signal stops the work; a second one kills the program. SIGHUP stays ignored if the program was started with
 * it ignored, as nohup does. */
static void offline_catch_signals(void)
{
	static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
	struct sigaction once = {.sa_handler = offline_on_signal, .sa_flags = SA_RESETHAND};
	for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
		struct sigaction before;
		bool nohup = signals[i] == SIGHUP && sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler == SIG_IGN;
		if (!nohup)
			sigaction(signals[i], &once, NULL);
	}
}

/* ---- the window -------------------------------------------------------------------------------------------------- */

/* The window of --preview; {0}: none is open. */
typedef struct offline_window {
	stilb_engine_viewer *viewer;
	float *radiance; /* the picture, 3 floats a pixel */
	uint8_t *srgb;   /* the picture for display, 3 bytes a pixel */
	size_t pixels;
	uint64_t next_ns; /* time of the next update of the picture */
	bool closed;
} offline_window;

static void offline_window_finish(offline_window *window)
{
	stilb_engine_viewer_destroy(window->viewer);
	free(window->radiance);
	free(window->srgb);
	*window = (offline_window){0};
}

/* Opens the window; if that fails, the work goes on without one, after a line that says so. */
static void offline_window_open(offline_window *window, const offline_options *o)
{
	char title[160];
	snprintf(title, sizeof title, "Stilb: %s", o->scene);
	stilb_engine_viewer_desc desc = {.title = title, .width = o->size[0], .height = o->size[1], .window = true};
	*window = (offline_window){.pixels = (size_t)o->size[0] * o->size[1]};
	window->radiance = calloc(window->pixels, 3 * sizeof *window->radiance);
	window->srgb = calloc(window->pixels, 3);
	stilb_result result = window->radiance && window->srgb
	                          ? stilb_engine_viewer_create(&desc, &window->viewer)
	                          : stilb_fail(STILB_ERROR_MEMORY, "no memory for the preview");
	if (result == STILB_OK)
		return;
	stilb_log("%s; rendering without a preview", stilb_error_message());
	offline_window_finish(window);
}

/* Updates the window's picture if it is time to: rarely enough that RENDER_PREVIEW_SHARE holds. */
static void offline_window_refresh(offline_window *window, offline_work *work)
{
	float exposure;
	uint32_t tone;
	uint64_t start = stilb_time_ns();
	if (start < window->next_ns || !offline_work_preview(work, window->radiance, &exposure, &tone))
		return;
	stilb_gi_display(window->radiance, window->pixels, exposure, tone, window->srgb);
	stilb_engine_viewer_picture(window->viewer, window->srgb);
	uint64_t now = stilb_time_ns();
	window->next_ns = now + (uint64_t)((double)(now - start) / RENDER_PREVIEW_SHARE);
}

/* Draws the window and handles its events, for `seconds`. A window that fails is closed after a line that says so; the
 * work goes on. */
static void offline_window_frame(offline_window *window, const char *words, double seconds)
{
	stilb_result result = stilb_engine_viewer_frame(window->viewer, words, seconds, &window->closed);
	if (result == STILB_OK)
		return;
	offline_progress_clear();
	stilb_log("%s; rendering on without a preview", stilb_error_message());
	offline_window_finish(window);
}

/* ---- beside the work --------------------------------------------------------------------------------------------- */

static void offline_sleep(double seconds)
{
	struct timespec time = {.tv_nsec = (long)(seconds * 1e9)};
	nanosleep(&time, NULL); /* a signal wakes it early */
}

/* Shows the progress until the work is done, requests the periodic checkpoints, and stops the work after a signal or
 * when the window is closed. */
static void offline_attend(const offline_options *o, offline_work *work, offline_window *window)
{
	offline_progress progress;
	stilb_gi_progress at;
	offline_stage stage;
	char words[192];
	uint64_t between = (uint64_t)((double)o->checkpoint_s * 1e9);
	uint64_t checkpoint_ns = stilb_time_ns();
	offline_progress_begin(&progress);
	while ((stage = offline_work_look(work, &at)) != RENDER_DONE) {
		uint64_t now = stilb_time_ns();
		if (offline_interrupted || window->closed)
			offline_work_stop(work);
		else if (offline_continued || (between > 0 && now - checkpoint_ns >= between)) {
			if (offline_continued)
				stilb_log("SIGCONT: writing '%s'; if mpirun ends this job, the same command with --resume continues it",
				          o->checkpoint);
			offline_continued = 0;
			offline_work_checkpoint(work);
			checkpoint_ns = now;
		}
		if (!o->guest)
			offline_progress_show(&progress, stage, &at);
		if (window->viewer && !window->closed) {
			offline_progress_words(&progress, stage, &at, words, sizeof words);
			offline_window_refresh(window, work);
			offline_window_frame(window, words, RENDER_TICK);
		} else {
			offline_sleep(RENDER_TICK);
		}
	}
	if (progress.terminal && !o->guest)
		offline_progress_clear();
}

/* Keeps the window with the finished picture open until the user closes it, if stderr is a terminal. */
static void offline_linger(offline_window *window, const offline_result *result)
{
	if (!window->viewer || result->code != EXIT_DONE || !isatty(STDERR_FILENO))
		return;
	while (window->viewer && !window->closed && !offline_interrupted)
		offline_window_frame(window, "finished; close the window to end", RENDER_TICK);
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

/* Refuses --integrator montecarlo if its number of rays, which grows exponentially with --depth, is above
 * RENDER_MANY_RAYS. */
static bool offline_check_rays(const offline_options *o)
{
	static const stilb_scene nothing;
	stilb_gi_settings settings = offline_options_settings(o, &nothing);
	if (settings.integrator != STILB_GI_INTEGRATOR_MONTECARLO || o->force)
		return true;
	double rays = stilb_gi_montecarlo_rays(&settings);
	if (rays <= RENDER_MANY_RAYS)
		return true;
	stilb_log("--integrator montecarlo: %.3g rays would take minutes to hours; lower --depth, --rays or --spp, or give "
	          "--force",
	          rays);
	return false;
}

static int offline_dry_run(const offline_options *o)
{
	static const stilb_scene nothing;
	stilb_gi_settings s = offline_options_settings(o, &nothing);
	double pixels = (double)s.width * s.height;
	char name[FLAG_CHOICE_SIZE];
	printf("%s: %.0f pixels, %" PRIu32 " sample%s a pixel", flags_choice(name, rays_integrators[s.integrator]), pixels,
	       s.samples, s.samples == 1 ? "" : "s");
	if (s.integrator == STILB_GI_INTEGRATOR_MONTECARLO)
		printf(", %" PRIu32 " rays at each of %" PRIu32 " bounces: %.0f rays at most, and shadow rays\n", s.rays,
		       s.depth, stilb_gi_montecarlo_rays(&s));
	else
		printf(": %.0f camera rays\n", pixels * s.samples);
	return EXIT_DONE;
}

static bool offline_write_stats(const offline_options *o, const offline_result *result)
{
	if (!o->stats)
		return true;
	if (offline_report_save(o, result) == STILB_OK) {
		fprintf(offline_message_stream(o), "stats: %s\n", o->stats);
		return true;
	}
	stilb_log("%s", stilb_error_message());
	return false;
}

/* True if the run has made a picture; one of a row is enough, at whatever point of the next it was stopped. */
static bool offline_has_picture(const offline_options *o, const offline_result *result)
{
	return o->frames ? result->frames > 0 : result->progress.camera_rays > 0;
}

static int offline_finish(const offline_options *o, const offline_result *result)
{
	bool picture = offline_has_picture(o, result);
	if (result->message[0])
		stilb_log("%s", result->message);
	if (result->code == EXIT_REFUSED)
		return EXIT_REFUSED;
	if (result->code == EXIT_DONE && !picture)
		stilb_log("stopped before the first %s; there is no picture", o->frames ? "frame was done" : "sample");
	else if (result->code == EXIT_DONE)
		offline_report_print(o, result);
	bool stats = offline_write_stats(o, result);
	if (o->trace && result->code == EXIT_DONE)
		fprintf(offline_message_stream(o), "trace: %s\n", o->trace);
	bool whole = stats && (picture || !o->output);
	return result->code == EXIT_DONE && !whole ? EXIT_FAILED : result->code;
}

/* A guest's troubles are the host's to tell. */
static void offline_say_nothing(void *user, const char *line)
{
	(void)user;
	(void)line;
}

static int offline_main(const offline_options *o)
{
	offline_work *work;
	offline_window window = {0};
	static offline_crew crew;
	if (!offline_crew_join(&crew))
		return EXIT_FAILED;
	offline_catch_signals();
	if (crew.many)
		offline_catch_crew_signals(o->guest);
	if (offline_work_start(o, &crew, &work) != STILB_OK) {
		offline_result failed = {.code = EXIT_FAILED};
		snprintf(failed.message, sizeof failed.message, "%s", stilb_error_message());
		int code = offline_finish(o, &failed);
		offline_crew_leave(&crew, code);
		return code;
	}
	if (o->preview)
		offline_window_open(&window, o);
	offline_attend(o, work, &window);
	offline_result result = offline_work_join(work);
	int code = o->guest ? EXIT_DONE : offline_finish(o, &result);
	fflush(stdout);
	offline_crew_leave(&crew, code);
	offline_linger(&window, &result);
	offline_window_finish(&window);
	stilb_prof_shutdown(); /* after the window, whose renderer has a lane in the profile */
	return code;
}

/* Refuses a part of a picture that all ranks of mpirun would compute together. */
static bool offline_part_is_alone(const offline_options *o)
{
	if (o->part)
		stilb_log("--part is for machines that do not talk to each other; leave it out, or mpirun");
	return !o->part;
}

int offline_command(int argc, char **argv)
{
	static offline_options options;
	if (offline_merge_is_asked(argc, argv))
		return offline_merge(argc, argv);
	bool guest = offline_crew_is_guest();
	if (guest)
		stilb_log_set(offline_say_nothing, NULL);
	flags_result parsed = offline_options_parse(&options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (guest)
		offline_options_be_guest(&options);
	if (parsed == FLAGS_REFUSED || !offline_options_check(&options))
		return EXIT_REFUSED;
	if (stilb_farm_link_is_asked() &&
	    (!offline_options_share_check(&options, "mpirun") || !offline_part_is_alone(&options)))
		return EXIT_REFUSED;
	if (options.dry_run)
		return offline_dry_run(&options);
	if (!offline_check_rays(&options))
		return EXIT_REFUSED;
	return offline_main(&options);
}
