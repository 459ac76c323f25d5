/*
 * Who flies the camera: the keys and the mouse of the window and the gamepads, live or from a recording, through one
 * control. What a pad says comes with its own time, so the camera takes the same way whatever the frames were.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#include <string.h>

#define INPUT_FRAMES 60u /* a second, headless */
#define INPUT_RUMBLE_HEAVY 0.4f
#define INPUT_RUMBLE_LIGHT 0.8f
#define INPUT_RUMBLE_MS 150u

/* ---- time -------------------------------------------------------------------------------------------------------- */

static int64_t engine_input_now_us(void)
{
	return (int64_t)(stilb_time_ns() / 1000u);
}

/* Only what is live knows the clock: a replay has the recording's time, and without a window a frame is a sixtieth. */
static int64_t engine_input_time_us(stilb_engine *engine)
{
	engine_input *input = &engine->input;
	if (!engine->window && !input->pads)
		return (int64_t)(engine->frame * 1000000u / INPUT_FRAMES);
	int64_t now = engine_input_now_us();
	if (!input->recording)
		return now;
	if (input->start_us == 0)
		input->start_us = now;
	return now - input->start_us;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_input_pose stilb_engine_pose(const stilb_engine *engine)
{
	const stilb_scene_camera *camera = &engine->scene->camera;
	return (stilb_input_pose){
		{camera->position[0], camera->position[1], camera->position[2]}, camera->yaw, camera->pitch};
}

static void engine_input_move_camera(stilb_scene_camera *camera, const stilb_input_pose *pose)
{
	for (int i = 0; i < 3; i++)
		camera->position[i] = pose->position[i];
	camera->yaw = pose->yaw;
	camera->pitch = pose->pitch;
}

static stilb_result engine_input_open_pads(engine_input *input, const stilb_engine_desc *desc)
{
	stilb_input_pads_desc pads = {
		.backend =
			desc->gamepad == STILB_ENGINE_GAMEPAD_HIDAPI ? STILB_INPUT_BACKEND_HIDAPI : STILB_INPUT_BACKEND_HIDRAW,
		.sys = desc->gamepad_sys,
		.dev = desc->gamepad_dev,
	};
	stilb_result result = stilb_input_pads_create(&pads, &input->pads);
	if (result == STILB_OK || desc->gamepad != STILB_ENGINE_GAMEPAD_AUTO)
		return result;
	stilb_log("%s; going on without gamepads", stilb_error_message());
	return STILB_OK;
}

stilb_result engine_input_start(stilb_engine *engine)
{
	engine_input *input = &engine->input;
	const stilb_engine_desc *desc = &engine->desc;
	bool live = desc->gamepad == STILB_ENGINE_GAMEPAD_HIDRAW || desc->gamepad == STILB_ENGINE_GAMEPAD_HIDAPI ||
	            (desc->gamepad == STILB_ENGINE_GAMEPAD_AUTO && desc->window);
	bool replay = desc->gamepad == STILB_ENGINE_GAMEPAD_REPLAY;
	stilb_result result = STILB_OK;
	if (!engine->window && !live && !replay)
		return STILB_OK;
	if (replay)
		result = stilb_input_recording_load(desc->gamepad_recording, &input->recording);
	if (live)
		result = engine_input_open_pads(input, desc);
	if (result != STILB_OK)
		return result;
	input->focused = true;
	input->pose = stilb_engine_pose(engine);
	int64_t time_us = replay ? 0 : engine_input_time_us(engine); /* a replay begins with the first frame */
	return stilb_input_control_create(&desc->control, &input->pose, time_us, &input->control);
}

void engine_input_finish(engine_input *input)
{
	stilb_input_pads_destroy(input->pads);
	stilb_input_recording_free(input->recording);
	stilb_input_control_destroy(input->control);
	*input = (engine_input){0};
}

/* ---- what pads say ----------------------------------------------------------------------------------------------- */

/* Refused reports of the pad of this number, or of all for 0. */
static uint64_t engine_input_corrupt(const engine_input *input, uint32_t pad)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_input_control_pads(input->control, pads);
	uint64_t corrupt = 0;
	for (uint32_t i = 0; i < count; i++)
		if (pad == 0 || pads[i].pad == pad)
			corrupt += pads[i].corrupt;
	return corrupt;
}

static void engine_input_take(stilb_engine *engine, const stilb_input_event *event)
{
	engine_input *input = &engine->input;
	if (event->kind == STILB_INPUT_PAD_DENIED)
		engine_overlay_deny(engine, event->pad, event->info);
	if (event->kind == STILB_INPUT_PAD_REMOVED) {
		engine_notice_remove(&engine->overlay.notice, event->pad);
		input->corrupt += engine_input_corrupt(input, event->pad);
	}
	if (event->kind == STILB_INPUT_PAD_REPORT) {
		input->reports++;
		input->newest_us = event->time_us;
	}
	stilb_input_control_event(input->control, event);
}

/* All that came since the frame before. */
static void engine_input_take_live(stilb_engine *engine, int64_t time_us)
{
	engine_input *input = &engine->input;
	stilb_input_event event;
	while (input->pads && stilb_input_pads_next(input->pads, time_us, &event))
		engine_input_take(engine, &event);
	if (!engine->window || engine->desc.gamepad == STILB_ENGINE_GAMEPAD_OFF)
		return;
	stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS];
	stilb_window_gamepads(engine->window, gamepads);
	stilb_input_window_feed(&input->window, gamepads, time_us, input->control);
}

/* At the recording's end all pads are let go of: nobody holds a stick any more. */
static void engine_input_take_replay(stilb_engine *engine, int64_t time_us)
{
	engine_input *input = &engine->input;
	int64_t end_us = stilb_input_recording_end_us(input->recording);
	stilb_input_event event;
	while (stilb_input_recording_next(input->recording, time_us, &event))
		engine_input_take(engine, &event);
	if (input->replayed || time_us < end_us)
		return;
	input->replayed = true;
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	for (uint32_t i = stilb_input_control_pads(input->control, pads); i-- > 0;)
		engine_input_take(engine,
		                  &(stilb_input_event){.kind = STILB_INPUT_PAD_REMOVED, .pad = pads[i].pad, .time_us = end_us});
}

int64_t engine_input_frame(stilb_engine *engine, stilb_input_state *state)
{
	PROFILE("input");
	engine_input *input = &engine->input;
	int64_t time_us = engine_input_time_us(engine);
	if (!input->control)
		return time_us;
	input->newest_us = 0;
	stilb_input_pose before = stilb_engine_pose(engine);
	if (memcmp(&before, &input->pose, sizeof before) != 0) /* the program has put it elsewhere */
		stilb_input_control_place(input->control, input->time_us, &before);
	if (input->recording)
		engine_input_take_replay(engine, time_us);
	else
		engine_input_take_live(engine, time_us);
	stilb_input_state keys = *state;
	stilb_input_control_frame(input->control, time_us, &keys, input->focused, state, &input->pose);
	input->pad_captures = state->capture && !keys.capture;
	input->time_us = time_us;
	engine_input_move_camera(&engine->scene->camera, &input->pose);
	if (input->newest_us != 0)
		PROFILE_COUNTER("pad report to camera, ms", (double)(time_us - input->newest_us) * 1e-3);
	return time_us;
}

double engine_input_latency(const stilb_engine *engine)
{
	const engine_input *input = &engine->input;
	if (!input->pads || input->newest_us == 0)
		return 0.0;
	double ms = (double)(engine_input_now_us() - input->newest_us) * 1e-3;
	PROFILE_COUNTER("pad report to submit, ms", ms);
	return ms;
}

void engine_input_captured(stilb_engine *engine)
{
	const engine_input *input = &engine->input;
	int64_t last_us;
	if (input->pads && input->pad_captures)
		stilb_input_pads_rumble(input->pads, stilb_input_control_leader(input->control, &last_us), INPUT_RUMBLE_HEAVY,
		                        INPUT_RUMBLE_LIGHT, INPUT_RUMBLE_MS);
}

/* ---- what is known of them --------------------------------------------------------------------------------------- */

uint32_t stilb_engine_gamepads(const stilb_engine *engine, stilb_input_control_pad pads[STILB_INPUT_PADS_MAX])
{
	return engine->input.control ? stilb_input_control_pads(engine->input.control, pads) : 0;
}

stilb_engine_gamepad_counts stilb_engine_gamepad_counts_get(const stilb_engine *engine)
{
	const engine_input *input = &engine->input;
	if (!input->control)
		return (stilb_engine_gamepad_counts){0};
	return (stilb_engine_gamepad_counts){
		.reports = input->reports,
		.corrupt = input->corrupt + engine_input_corrupt(input, 0),
		.lost = input->pads ? stilb_input_pads_stats_get(input->pads).lost : 0,
	};
}
