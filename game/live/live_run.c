#include "live_run.h"

#include "base/base_file.h"
#include "engine_faults.h"
#include "live_picture.h"
#include "live_progress.h"
#include "live_report.h"
#include "profiler/prof.h"

#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define LIVE_TRACE_FRAMES 1000u /* frames in the file of --trace, at most */
#define LIVE_TITLE_NS 500000000u

static volatile sig_atomic_t live_interrupted; /* number of the signal; 0: none came */

static void live_on_signal(int signal_number)
{
	live_interrupted = signal_number; /* ends live_loop; pictures, traces and statistics are written all the same */
}

bool live_run_is_stopped(void)
{
	return live_interrupted != 0;
}

/* Hands the main thread what the window is to say of a capture, in place of what it has not yet said. */
static void live_tell_later(live_run *run, const stilb_prof_captured *captured)
{
	char *text = NULL;
	if (captured->error == 0 && asprintf(&text, "%s written", captured->path) < 0)
		return;
	if (captured->error != 0 &&
	    asprintf(&text, "cannot write '%s': %s", captured->path, strerror(-captured->error)) < 0)
		return;
	/* acq_rel: with the exchange of live_tell_now; either side may have to read and free the other's text */
	free(atomic_exchange_explicit(&run->told, text, memory_order_acq_rel));
}

/* Called on the capturing thread after each capture, a trace that is written during the run. An error that repeats,
 * like a full disk, is printed once, not for every slow frame. */
static void live_on_captured(void *user, const stilb_prof_captured *captured)
{
	live_run *run = user;
	FILE *out = live_message_stream(run->options);
	if (captured->error == 0 && captured->cause == STILB_PROF_CAUSE_SPIKE)
		fprintf(out, "trace: %s, frame %" PRIu64 " took %.1f ms\n", captured->path, captured->frame,
		        captured->frame_ms);
	else if (captured->error == 0)
		fprintf(out, "trace: %s\n", captured->path);
	else if (captured->error != run->capture_error)
		stilb_log("cannot write '%s': %s", captured->path, strerror(-captured->error));
	fflush(out);
	live_tell_later(run, captured);
	run->capture_error = captured->error;
	run->capture_failed |= captured->error != 0;
}

static void live_stall(void)
{
	PROFILE("slow on purpose");
	nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
}

static void live_update(void *user, const stilb_engine_update *update)
{
	live_run *run = user;
	if (update->frame == run->slow_frame)
		live_stall();
	run->program->update(run->user, update);
	live_draw_frame(&run->draw, run->engine);
}

uint32_t live_run_asked(const live_run *run, const stilb_engine_report *report, live_key key)
{
	return report->input.actions[live_keys_number(run->program->keys, key)];
}

void live_run_say(const live_run *run, stilb_result result, const char *what, const char *path)
{
	if (result == STILB_OK)
		fprintf(live_message_stream(run->options), "%s: %s\n", what, path);
	else
		stilb_log("%s", stilb_error_message());
}

void live_run_tell(live_run *run, const char *text)
{
	if (run->window && !run->options->screenshot)
		stilb_engine_tell(run->engine, text);
}

void live_run_warn(live_run *run, const char *text)
{
	stilb_log("%s", text);
	live_run_tell(run, text);
}

/* Says of the newest capture what live_tell_later left. */
static void live_tell_now(live_run *run)
{
	/* acq_rel: with the exchange of live_tell_later */
	char *text = atomic_exchange_explicit(&run->told, NULL, memory_order_acq_rel);
	if (text)
		live_run_tell(run, text);
	free(text);
}

/* Says how a picture went that was written beside the frames. A series ends with the first that fails. */
static void live_on_pictured(void *user, const stilb_engine_pictured *pictured)
{
	live_run *run = user;
	char text[256];
	bool series = run->options->pictures > 0;
	if (pictured->result == STILB_OK) {
		fprintf(live_message_stream(run->options), "picture: %s\n", pictured->path);
		fflush(live_message_stream(run->options));
		snprintf(text, sizeof text, "%s written", pictured->path);
		live_run_tell(run, text);
		return;
	}
	if (run->picture_result == STILB_OK)
		live_run_warn(run, pictured->message);
	run->picture_result = series ? pictured->result : STILB_OK;
}

stilb_result live_run_grade(const live_run *run)
{
	const live_options *o = run->options;
	stilb_post_table *grade = NULL;
	stilb_result result = o->picture.grade ? stilb_post_table_open(o->picture.grade, &grade) : STILB_OK;
	if (result == STILB_OK && o->preset)
		result = stilb_engine_set_grade(run->engine, grade ? grade : o->preset->grade, o->preset->areas,
		                                o->preset->area_count);
	else if (result == STILB_OK)
		result = stilb_engine_set_grade(run->engine, grade, NULL, 0);
	stilb_post_table_destroy(grade);
	return result;
}

/* Creates the engine and then the scene, which would be made in vain without a driver; without a display the engine
 * runs headless, after a line that says so. */
static stilb_result live_start(live_run *run)
{
	stilb_engine_desc desc = live_options_engine(run->options);
	desc.capture.done = live_on_captured;
	desc.capture.user = run;
	live_faults faults = live_options_faults(run->options);
	bool known = live_draw_parse(run->options->draw, &run->draw);
	STILB_ASSERT(known && "live_options_check accepted the options");
	run->slow_frame = faults.slow_frame;
	desc.actions = run->rows;
	desc.action_count = live_keys_rows(run->program->keys, run->rows);
	desc.update = live_update;
	desc.pictured = live_on_pictured;
	desc.user = run;
	stilb_engine_set_faults(&faults.render);
	stilb_result result = stilb_engine_create(&desc, &run->engine);
	if (result == STILB_ERROR_WINDOW) {
		stilb_log("%s; running headless%s", stilb_error_message(),
		          run->options->screenshot ? "" : "; --screenshot FILE.png keeps the picture");
		desc.window = false;
		desc.times = run->options->times;
		result = stilb_engine_create(&desc, &run->engine);
	}
	run->window = desc.window;
	if (result == STILB_OK)
		result = live_run_grade(run);
	picture_shown image;
	if (result == STILB_OK && picture_flags_show(&run->options->picture, &desc.show, &image))
		stilb_engine_show_image(
			run->engine,
			&(stilb_render_shown){
				.name = image.name, .mip = image.mip, .layer = image.layer, .low = image.low, .high = image.high});
	return result == STILB_OK ? run->program->start(run->user, run) : result;
}

/* Writes the last frame's picture, in the size of --photo if that is given. */
static stilb_result live_photo(const live_run *run, const char *path)
{
	const live_options *o = run->options;
	if (o->photo[0] == 0)
		return stilb_engine_screenshot(run->engine, path);
	const char *whole = stilb_engine_photo_whole(run->engine);
	if (whole)
		fprintf(live_message_stream(o), "photo: in one piece, as %s\n", whole);
	return stilb_engine_photo_take(
		run->engine, &(stilb_engine_photo){
						 .path = path, .width = o->photo[0], .height = o->photo[1], .tile = (uint32_t)o->photo_tile});
}

/* The same for a key, under a name that is reserved. */
static stilb_result live_key_photo(live_run *run, const char *path)
{
	if (run->options->photo[0] == 0)
		return stilb_engine_picture(run->engine, path, true);
	stilb_result result = live_photo(run, path);
	if (result == STILB_OK)
		live_on_pictured(run, &(stilb_engine_pictured){path, STILB_OK, ""});
	else
		unlink(path);
	return result;
}

/* Takes the picture that a key asked for, under a name of its own. */
static void live_take_picture(live_run *run)
{
	const char *last = run->options->screenshot;
	char *path;
	stilb_result result =
		live_picture_reserve(last && !stilb_file_is_stdout(last) ? last : run->program->picture, last, &path);
	if (result == STILB_OK)
		result = live_key_photo(run, path);
	if (result != STILB_OK)
		live_run_warn(run, stilb_error_message());
	free(path);
}

/* Takes the picture of this frame under --screenshot's name with the frame's number: "a.png" becomes "a-001.png", or
 * "a-2-001.png" if there are pictures of an earlier run. */
static stilb_result live_take_numbered(live_run *run)
{
	const live_options *o = run->options;
	char *path = NULL;
	stilb_result result = STILB_OK;
	if (!run->series)
		result = live_picture_series(o->screenshot, (uint32_t)o->pictures, &run->series);
	if (result == STILB_OK)
		result = live_picture_reserve_numbered(run->series, (uint32_t)run->frames, &path);
	if (result == STILB_OK)
		result = stilb_engine_picture(run->engine, path, true);
	free(path);
	return result;
}

/* Writes the look that frames have now. */
static stilb_result live_save_look(const live_run *run, const char *path)
{
	stilb_post_preset *look;
	stilb_result result = live_options_look_of(run->options, run->engine, &look);
	if (result != STILB_OK)
		return result;
	result = stilb_post_preset_save(look, path);
	stilb_post_preset_destroy(look);
	return result;
}

/* The same for the effects' window, under a name of its own. */
static void live_keep_look(live_run *run)
{
	char *path, text[256];
	stilb_result result = live_picture_reserve("stilb-look.json", run->options->save_preset, &path);
	if (result == STILB_OK) {
		result = live_save_look(run, path);
		if (result != STILB_OK)
			unlink(path);
	}
	if (result == STILB_OK) {
		live_run_say(run, result, "preset", path);
		snprintf(text, sizeof text, "%s written; --preset shows it", path);
		live_run_tell(run, text);
	} else {
		live_run_warn(run, stilb_error_message());
	}
	free(path);
}

/* Carries out the commands of keys and gamepads in the last frame's input. A file that cannot be written is one line on
 * stderr; only a failure of the engine ends the run. */
static stilb_result live_act(live_run *run, const stilb_engine_report *report)
{
	if (report->input.actions[STILB_ENGINE_CAPTURE] > 0 && stilb_engine_capture(run->engine) != STILB_OK)
		live_run_warn(run, stilb_error_message());
	if (report->input.actions[STILB_ENGINE_PICTURE] > 0)
		live_take_picture(run);
	if (report->saves_look)
		live_keep_look(run);
	live_tell_now(run);
	int64_t workers = (int64_t)stilb_engine_workers(run->engine) + live_run_asked(run, report, LIVE_KEY_MORE_WORKERS) -
	                  live_run_asked(run, report, LIVE_KEY_FEWER_WORKERS);
	workers = workers < 0 ? 0 : workers > STILB_JOB_MAX_WORKERS ? STILB_JOB_MAX_WORKERS : workers;
	if (workers == (int64_t)stilb_engine_workers(run->engine))
		return run->program->act(run->user, run, report);
	char text[64];
	snprintf(text, sizeof text, "workers: %" PRId64, workers);
	fprintf(live_message_stream(run->options), "%s\n", text);
	fflush(live_message_stream(run->options));
	live_run_tell(run, text);
	if (run->program->release)
		run->program->release(run->user);
	stilb_result result = stilb_engine_set_workers(run->engine, (uint32_t)workers);
	return result == STILB_OK ? run->program->act(run->user, run, report) : result;
}

static void live_title(live_run *run)
{
	uint64_t now = stilb_time_ns();
	char title[256];
	if (!run->window || now - run->titled_ns < LIVE_TITLE_NS)
		return;
	run->titled_ns = now;
	run->program->title(run->user, run, title);
	size_t length = strlen(title);
	if (picture_flags_adapt(&run->options->picture))
		snprintf(title + length, sizeof title - length, ", %+.1f EV", (double)run->report.exposure);
	stilb_engine_set_title(run->engine, title);
}

uint64_t live_run_wanted(const live_run *run)
{
	bool open_ended = run->window || run->lost || live_options_is_replay(run->options);
	uint64_t frames =
		stilb_engine_device_is_software(run->engine) ? run->program->software_frames : run->program->frames;
	if (run->options->pictures > 0)
		return run->options->pictures;
	return run->options->frames > 0 ? run->options->frames : open_ended ? 0 : frames;
}

/* True if the run has ended. Without a window and --frames, a run that replays a gamepad recording ends with it. */
static bool live_is_over(const live_run *run, const stilb_engine_report *report)
{
	uint64_t wanted = live_run_wanted(run);
	if (live_interrupted || report->close || run->picture_result != STILB_OK)
		return true;
	if (wanted > 0)
		return run->frames >= wanted;
	return !run->window && (!live_options_is_replay(run->options) || report->replayed);
}

/* Called once, when the window's display has gone. The outputs are written all the same. */
static void live_lose_window(live_run *run)
{
	run->window = false;
	run->lost = true;
	bool over = live_run_wanted(run) == 0 && !live_options_is_replay(run->options);
	stilb_log("the display has gone after %" PRIu64 " frames; %s", run->frames,
	          over ? "ending the run, because no window is left to close" : "running on headless");
}

/* Says once that the device's kind makes shadows coarser than elsewhere, if nobody chose how fine they are. */
static void live_tell_shadows(live_run *run, const stilb_engine_report *report)
{
	const picture_flags *picture = &run->options->picture;
	if (run->shadows_told || report->shadow_maps == 0 || !stilb_engine_device_is_software(run->engine))
		return;
	run->shadows_told = true;
	stilb_engine_shadows shadows = stilb_engine_shadows_used(run->engine);
	char text[128];
	snprintf(text, sizeof text, "Shadows on a software device: %u cascades of %u texels; --cascades and --cascade-size",
	         shadows.cascades, shadows.size);
	if (!picture->shadow_objects && (picture->cascades == 0 || picture->cascade_size == 0))
		live_run_tell(run, text);
}

static stilb_result live_frame(live_run *run, stilb_engine_report *report)
{
	stilb_result result = live_act(run, report); /* on the input of the frame before */
	if (result == STILB_OK)
		result = stilb_engine_frame(run->engine, report);
	if (result == STILB_OK)
		result = run->wrong;
	if (result != STILB_OK)
		return result;
	if (report->drawn) {
		run->report = *report;
		run->frames++;
		live_tell_shadows(run, report);
		live_track_add(&run->track, run->engine, report);
		if (!stage_times_add(&run->times, &report->times))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the times of %" PRIu64 " frames", run->frames);
	}
	if (report->lost && run->window)
		live_lose_window(run);
	return report->drawn && run->options->pictures > 0 && run->picture_result == STILB_OK ? live_take_numbered(run)
	                                                                                      : STILB_OK;
}

static stilb_result live_loop(live_run *run)
{
	stilb_engine_report report = {0};
	live_progress progress;
	live_progress_begin(&progress);
	stilb_result result = STILB_OK;
	while (result == STILB_OK && !live_is_over(run, &report)) {
		result = live_frame(run, &report);
		live_gamepads_say(&run->gamepads, run->engine, report.replayed, live_message_stream(run->options));
		live_title(run);
		if (!run->window)
			live_progress_show(&progress, run->frames, live_run_wanted(run));
	}
	live_progress_end(&progress);
	return result;
}

static void live_say_end(const live_run *run)
{
	uint64_t wanted = live_run_wanted(run);
	char of[32] = "";
	if (!live_interrupted)
		return;
	if (wanted > 0)
		snprintf(of, sizeof of, " of %" PRIu64, wanted);
	fprintf(live_message_stream(run->options), "stopped by SIG%s after %" PRIu64 "%s frames\n",
	        sigabbrev_np(live_interrupted), run->frames, of);
}

/* Writes all outputs and prints the summary; an output that fails does not keep the others from being written. Returns
 * true if everything succeeded. */
static bool live_finish(live_run *run)
{
	const live_options *o = run->options;
	live_report report = {
		.options = o, .engine = run->engine, .last = run->report, .frames = run->frames, .light = run->light};
	double gpu_ms;
	stilb_result waited = stilb_engine_wait(run->engine, &gpu_ms);
	if (waited != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return false;
	}
	stilb_engine_pictures_wait(run->engine);
	stage_times_last_gpu(&run->times, gpu_ms);
	bool good = stage_times_summarise(&run->times, report.summary, &report.warmup);
	if (!good)
		stilb_log("no memory to sort the stage times; they are reported as 0");
	stilb_result picture = STILB_OK, trace = STILB_OK, stats = STILB_OK, dump = STILB_OK, track = STILB_OK;
	stilb_result plan = STILB_OK, look = STILB_OK;
	bool shot = o->screenshot && o->pictures == 0, photo = shot && o->photo[0] > 0;
	if (shot && !photo)
		live_run_say(run, picture = live_photo(run, o->screenshot), "picture", o->screenshot);
	if (o->trace)
		live_run_say(run, trace = stilb_engine_trace(run->engine, o->trace, LIVE_TRACE_FRAMES), "trace", o->trace);
	if (o->stats)
		live_run_say(run, stats = live_report_save(&report), "stats", o->stats);
	if (o->dump)
		live_run_say(run, dump = stilb_engine_dump(run->engine, o->dump), "dump", o->dump);
	if (o->dump && dump == STILB_OK && run->report.shadow_maps > 0)
		fputs("dump: without shadow maps; 'stilb replay' draws the frame as --shadows off does\n",
		      live_message_stream(o));
	if (o->plan)
		live_run_say(run, plan = stilb_engine_save_plan(run->engine, o->plan), "plan", o->plan);
	if (o->save_preset)
		live_run_say(run, look = live_save_look(run, o->save_preset), "preset", o->save_preset);
	if (o->track)
		live_run_say(run, track = live_track_save(&run->track), "track", o->track);
	live_say_end(run);
	live_report_print(&report);
	if (photo) /* draws other frames than those that are reported */
		live_run_say(run, picture = live_photo(run, o->screenshot), "picture", o->screenshot);
	uint32_t messages = stilb_engine_validation_messages(run->engine);
	if (messages > 0)
		stilb_log("the validation layer had %u message%s", messages, messages == 1 ? "" : "s");
	return good && run->picture_result == STILB_OK && picture == STILB_OK && trace == STILB_OK && stats == STILB_OK &&
	       dump == STILB_OK && track == STILB_OK && plan == STILB_OK && look == STILB_OK && messages == 0;
}

/* Says why the run ends; of memory also what helps, unless the message does so itself. */
static void live_say_failed(stilb_result result)
{
	const char *message = stilb_error_message();
	bool hint = result == STILB_ERROR_MEMORY && strncmp(message, "no memory", 9) == 0 && !strstr(message, "ulimit");
	stilb_log("%s%s", message, hint ? "; close other programs, or raise the limit that 'ulimit -v' shows" : "");
}

static int live_run_frames(live_run *run)
{
	stilb_result started = live_start(run);
	if (started == STILB_OK && run->options->track)
		started = live_track_open(&run->track, run->options->track);
	if (started != STILB_OK) {
		if (started == STILB_ERROR_DEVICE)
			picture_flags_log_start(&run->options->picture, started);
		else
			live_say_failed(started);
		return exit_code_of(started);
	}
	struct sigaction once = {.sa_handler = live_on_signal, .sa_flags = SA_RESETHAND}; /* a second one kills */
	sigaction(SIGINT, &once, NULL);
	sigaction(SIGTERM, &once, NULL);
	if (run->options->no_profile)
		signal(SIGUSR1, SIG_IGN); /* SIGUSR1 requests a capture; without a profiler it would kill the process */
	if (run->window)
		fputs("H shows what the keys do; close the window to end\n", live_message_stream(run->options));
	fflush(stdout);
	stilb_result result = live_loop(run);
	if (result != STILB_OK) {
		live_say_failed(result);
		return run->starting ? exit_code_of(result) : EXIT_FAILED;
	}
	if (run->frames == 0) {
		if (live_interrupted)
			stilb_log("stopped by SIG%s before a frame was drawn; nothing was written", sigabbrev_np(live_interrupted));
		else
			stilb_log("no frame was drawn");
		return EXIT_FAILED;
	}
	bool cut_short = run->lost && live_run_wanted(run) == 0 && !run->report.replayed;
	return live_finish(run) && !cut_short ? EXIT_DONE : EXIT_FAILED;
}

int live_run_main(live_run *run)
{
	int code = live_run_frames(run);
	live_track_finish(&run->track);
	if (run->program->finish)
		run->program->finish(run->user);
	stilb_engine_destroy(run->engine); /* writes the captures that are still pending */
	run->engine = NULL;
	/* relaxed: the engine's end has joined the capturing thread */
	free(atomic_load_explicit(&run->told, memory_order_relaxed));
	free(run->series);
	stage_times_finish(&run->times);
	return code == EXIT_DONE && run->capture_failed ? EXIT_FAILED : code;
}
