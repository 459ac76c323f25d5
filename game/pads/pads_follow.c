/* stilb pads --watch, --record, --replay: events of pads, live or recorded, shown in a terminal or as lines, or written
 * as a recording or JSON. */
#include "game/cli/flags.h"
#include "pads.h"

#include "input/input_recording.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define FOLLOW_TICK_MS 33   /* at most, between two looks at the events; with a live view, between two updates of it */
#define FOLLOW_LOOK_MS 1000 /* longest wait for the first pads; their buffers hold reports of two seconds meanwhile */

typedef struct follow_run {
	const pads_options *o;
	stilb_input_pads *pads;           /* the source of live events; NULL: a recording is replayed */
	stilb_input_recording *recording; /* the source of recorded events; NULL: events are live */
	stilb_input_recorder *recorder;   /* NULL: nothing is recorded */
	stilb_input_control *control;
	int64_t start_us;         /* start of the run, CLOCK_MONOTONIC */
	int64_t last_us;          /* time of the last event, since start_us or in the recording's time */
	uint32_t added, gamepads; /* pads that came; those of them that are gamepads: a recording may be of others */
	uint64_t reports, corrupt;
	FILE *words;   /* stream for text; NULL: none */
	bool terminal; /* draw the pads instead of printing lines */
	bool states;   /* print a line for each new state of a pad's axes and buttons */
	bool failed;   /* the recorder failed; closing it gives the reason */
	pads_view view;
	stilb_json json;
} follow_run;

static int64_t follow_now_us(void)
{
	return (int64_t)(stilb_time_ns() / 1000);
}

/* ---- reporting an event ------------------------------------------------------------------------------------------ */

typedef enum follow_what {
	FOLLOW_NOTHING, /* the event changed nothing */
	FOLLOW_ADDED,
	FOLLOW_DENIED,
	FOLLOW_REMOVED,
	FOLLOW_CORRUPT,
	FOLLOW_STATE
} follow_what;

/* Prints a pad that came: "added: /dev/hidraw0 Wireless Controller; DualShock 4, USB: known pad 054c:05c4". */
static void follow_print_added(follow_run *run, const stilb_input_control_pad *pad)
{
	const stilb_input_pad_info *info = pad->info;
	char recognised[PADS_RECOGNISED_SIZE];
	fprintf(run->words, "added:%s%s%s%s; %s\n", info->path[0] ? " " : "", info->path, info->name[0] ? " " : "",
	        info->name[0] || info->path[0] ? info->name : " ?", pads_recognised_text(pad, recognised));
	if (run->o->rumble)
		fprintf(run->words, "                 %s\n", pads_has_rumble(info) ? "rumbles" : "has no known motors");
}

static void follow_print(follow_run *run, follow_what what, uint32_t number, const stilb_input_control_pad *pad)
{
	char buttons[PADS_BUTTONS_SIZE];
	const float *axes = pad->state.axes;
	if (what == FOLLOW_NOTHING || (what == FOLLOW_STATE && !run->states))
		return;
	fprintf(run->words, "%12.6f  %" PRIu32 "  ", (double)run->last_us * 1e-6, number);
	switch (what) {
	case FOLLOW_ADDED:
		follow_print_added(run, pad);
		break;
	case FOLLOW_DENIED:
		fprintf(run->words, "denied: %s %s\n", pad->info->path, pad->info->name);
		pads_print_rule(run->words, pad->info);
		break;
	case FOLLOW_REMOVED:
		fprintf(run->words, "removed\n");
		break;
	case FOLLOW_CORRUPT:
		fprintf(run->words, "corrupt\n");
		break;
	case FOLLOW_STATE:
		fprintf(run->words, "left %+.3f %+.3f  right %+.3f %+.3f  triggers %.3f %.3f  %s\n", (double)axes[0],
		        (double)axes[1], (double)axes[2], (double)axes[3], (double)axes[4], (double)axes[5],
		        pads_buttons_text(pad->state.buttons, buttons));
		break;
	case FOLLOW_NOTHING:
		break;
	}
}

static void follow_json(follow_run *run, follow_what what, uint32_t number, const stilb_input_control_pad *pad)
{
	static const char *const events[] = {"", "added", "denied", "removed", "corrupt", "state"};
	stilb_json *json = &run->json;
	if (what == FOLLOW_NOTHING)
		return;
	stilb_json_begin(json, NULL, '{');
	stilb_json_double(json, "time", (double)run->last_us * 1e-6);
	stilb_json_int(json, "pad", number);
	stilb_json_string(json, "event", events[what]);
	if (what == FOLLOW_ADDED) {
		pads_json_info(json, pad->info);
		stilb_json_string(json, "layout", pad->name);
		stilb_json_string(json, "recognised", pad->recognised);
	} else if (what == FOLLOW_STATE) {
		for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++)
			stilb_json_double(json, stilb_input_axis_names[i], (double)pad->state.axes[i]);
		stilb_json_begin(json, "buttons", '[');
		for (int i = 0; i < STILB_INPUT_BUTTON_COUNT; i++)
			if (pad->state.buttons >> i & 1)
				stilb_json_string(json, NULL, stilb_input_button_names[i]);
		stilb_json_end(json, ']');
	}
	stilb_json_end(json, '}');
}

/* The pad of this number; {0} if the engine does not know it. */
static stilb_input_control_pad follow_find(const follow_run *run, uint32_t number)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_input_control_pads(run->control, pads);
	for (uint32_t i = 0; i < count; i++)
		if (pads[i].pad == number)
			return pads[i];
	return (stilb_input_control_pad){0};
}

static follow_what follow_judge(const stilb_input_event *event, const stilb_input_control_pad *before,
                                const stilb_input_control_pad *after)
{
	if (event->kind == STILB_INPUT_PAD_REMOVED)
		return before->info ? FOLLOW_REMOVED : FOLLOW_NOTHING;
	if (!after->info)
		return FOLLOW_NOTHING;
	if (event->kind == STILB_INPUT_PAD_ADDED)
		return FOLLOW_ADDED;
	if (event->kind == STILB_INPUT_PAD_DENIED)
		return FOLLOW_DENIED;
	if (after->corrupt > before->corrupt)
		return FOLLOW_CORRUPT;
	return memcmp(&before->state, &after->state, sizeof after->state) != 0 ? FOLLOW_STATE : FOLLOW_NOTHING;
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

static bool follow_is_gamepad(const stilb_input_event *event)
{
	static stilb_input_layout layout;
	return event->kind == STILB_INPUT_PAD_ADDED && stilb_input_layout_find(event->info, &layout) == STILB_OK;
}

static void follow_take(follow_run *run, const stilb_input_event *event)
{
	stilb_input_control_pad before = follow_find(run, event->pad);
	stilb_input_control_event(run->control, event);
	stilb_input_control_pad after = follow_find(run, event->pad);
	follow_what what = follow_judge(event, &before, &after);
	run->last_us = run->recording ? event->time_us : event->time_us - run->start_us;
	run->added += event->kind == STILB_INPUT_PAD_ADDED;
	run->gamepads += follow_is_gamepad(event);
	run->reports += event->kind == STILB_INPUT_PAD_REPORT;
	run->corrupt += what == FOLLOW_CORRUPT;
	if (run->o->rumble && event->kind == STILB_INPUT_PAD_ADDED)
		stilb_input_pads_rumble(run->pads, event->pad, 0.6f, 0.6f, PADS_RUMBLE_MS);
	if (run->recorder && !run->failed)
		run->failed = stilb_input_recorder_add(run->recorder, event) != STILB_OK;
	if (run->o->json)
		follow_json(run, what, event->pad, &after);
	else if (!run->terminal)
		follow_print(run, what, event->pad, &after);
}

static bool follow_next(follow_run *run, int64_t until_us, stilb_input_event *event)
{
	return run->recording ? stilb_input_recording_next(run->recording, until_us, event)
	                      : stilb_input_pads_next(run->pads, run->start_us + until_us, event);
}

/* Waits FOLLOW_TICK_MS, or less if events of live pads come that are to be printed. */
static void follow_wait(follow_run *run)
{
	struct timespec time = {.tv_nsec = FOLLOW_TICK_MS * 1000000L};
	if (run->pads && !run->terminal)
		stilb_input_pads_wait(run->pads, FOLLOW_TICK_MS);
	else
		nanosleep(&time, NULL); /* the live view is redrawn at a fixed rate, and a recording cannot be waited for */
}

/* Runs until a signal, the end of the time or of the recording, or an error of the recorder or the output. */
static void follow_loop(follow_run *run)
{
	bool paced = run->pads || run->o->watch;
	int64_t limit_us = run->o->seconds > 0.0f ? (int64_t)((double)run->o->seconds * 1e6) : INT64_MAX;
	int64_t end_us = run->recording ? stilb_input_recording_end_us(run->recording) : INT64_MAX;
	for (bool over = false; !over && !pads_interrupted && !run->failed && !(run->words && ferror(run->words));) {
		stilb_input_event event;
		int64_t passed_us = follow_now_us() - run->start_us;
		int64_t until_us = paced && passed_us < limit_us ? passed_us : limit_us;
		while (!run->failed && follow_next(run, until_us, &event))
			follow_take(run, &event);
		over = until_us >= limit_us || until_us >= end_us;
		if (run->terminal)
			pads_view_draw(&run->view, run->control, run->recording ? until_us : run->start_us + until_us);
		else if (run->words)
			fflush(run->words);
		if (!over)
			follow_wait(run);
	}
}

/* ---- the end ----------------------------------------------------------------------------------------------------- */

static stilb_result follow_save(follow_run *run)
{
	stilb_json *json = &run->json;
	stilb_json_end(json, ']');
	stilb_json_int(json, "reports", (int64_t)run->reports);
	stilb_json_int(json, "corrupt", (int64_t)run->corrupt);
	stilb_json_double(json, "seconds", (double)run->last_us * 1e-6);
	stilb_json_end(json, '}');
	return stilb_json_save(json, run->o->json);
}

/* Prints the totals; the time is the recording's own, or the time that passed. */
static void follow_print_end(const follow_run *run)
{
	int64_t time_us = run->recording ? run->last_us : follow_now_us() - run->start_us;
	fprintf(run->words, "%" PRIu64 " reports of %" PRIu32 " pad%s in %.3f s, %" PRIu64 " corrupt", run->reports,
	        run->added, run->added == 1 ? "" : "s", (double)time_us * 1e-6, run->corrupt);
	if (run->pads)
		fprintf(run->words, ", %" PRIu64 " lost", stilb_input_pads_stats_get(run->pads).lost);
	fprintf(run->words, "\n");
}

/* Completes all outputs, also those left after one has failed. */
static int follow_finish(follow_run *run)
{
	int code = EXIT_DONE;
	if (run->terminal)
		pads_view_finish();
	if (run->words)
		follow_print_end(run);
	if (run->o->json && follow_save(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		code = EXIT_FAILED;
	}
	if (run->recorder && stilb_input_recorder_close(run->recorder) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		code = EXIT_FAILED;
	} else if (run->recorder && run->words) {
		fprintf(run->words, "recording: %s\n", run->o->record);
	}
	if (run->added > 0 && run->gamepads == 0 && run->recording) {
		stilb_log("no pad of '%s' is a gamepad", run->o->replay);
		code = EXIT_FAILED;
	}
	return code;
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

static stilb_result follow_open(follow_run *run)
{
	static const stilb_input_pose still;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	stilb_result result = stilb_input_control_create(&settings, &still, 0, &run->control);
	run->start_us = follow_now_us();
	if (result == STILB_OK && !run->recording)
		result = pads_open(run->o, &run->pads);
	if (result == STILB_OK && run->o->record)
		result = stilb_input_recorder_create(run->o->record, &run->recorder);
	return result;
}

/* For output without the live view: prints what the command does, waits for the first pads, and says if there is
 * none. */
static void follow_greet(follow_run *run)
{
	double look_ms = (double)run->o->seconds * 1e3;
	fprintf(stderr, "%s; Ctrl-C ends it\n", run->o->record ? "recording" : "watching");
	stilb_input_pads_wait(run->pads, look_ms > 0.0 && look_ms < FOLLOW_LOOK_MS ? (int)look_ms : FOLLOW_LOOK_MS);
	stilb_input_pads_stats stats = stilb_input_pads_stats_get(run->pads);
	if (stats.added + stats.denied == 0 && !pads_interrupted)
		fprintf(stderr, "no gamepad yet; waiting\n");
}

static int follow_run_all(follow_run *run)
{
	if (follow_open(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	if (run->pads && !run->terminal)
		follow_greet(run);
	if (run->terminal)
		pads_view_begin(&run->view);
	if (run->o->json) {
		stilb_json_begin(&run->json, NULL, '{');
		stilb_json_string(&run->json, "recording", run->o->replay);
		stilb_json_begin(&run->json, "events", '[');
	}
	follow_loop(run);
	return follow_finish(run);
}

int pads_follow(const pads_options *o)
{
	follow_run run = {.o = o, .words = pads_message_stream(o), .states = o->watch || !o->record};
	const char *kind = getenv("TERM");
	run.terminal = o->watch && isatty(STDOUT_FILENO) && !(kind && strcmp(kind, "dumb") == 0);
	pads_catch_signals();
	if (o->replay && stilb_input_recording_load(o->replay, &run.recording) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_REFUSED;
	}
	int code = follow_run_all(&run);
	stilb_input_pads_destroy(run.pads);
	stilb_input_recording_free(run.recording);
	stilb_input_control_destroy(run.control);
	return code;
}
