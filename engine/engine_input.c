/*
 * The control of the camera: the keys and the mouse of the window and the gamepads, live or from a recording, are fed
 * into one stilb_input_control. Every gamepad report has the time at which it came, so the camera's path does not
 * depend on how long frames took.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#include <math.h>
#include <string.h>

#define INPUT_FRAMES 60u /* frames in a second of the camera's time, without a window */
#define INPUT_RUMBLE_HEAVY 0.4f
#define INPUT_RUMBLE_LIGHT 0.8f
#define INPUT_RUMBLE_MS 150u

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const stilb_input_action engine_actions[] = {
	[STILB_ENGINE_KEYS - STILB_INPUT_ACTIONS] = {.name = "keys",
                                                 .kind = STILB_INPUT_SWITCH,
                                                 .keys = {STILB_WINDOW_KEY_H},
                                                 .typed = "?",
                                                 .pad = STILB_INPUT_PAD(LEFT),
                                                 .main = true,
                                                 .help = "open or close the list of keys"},
	[STILB_ENGINE_TIMES - STILB_INPUT_ACTIONS] = {.name = "times",
                                                  .kind = STILB_INPUT_SWITCH,
                                                  .keys = {STILB_WINDOW_KEY_F3},
                                                  .help = "show or hide frame rate and time"},
	[STILB_ENGINE_PROFILER - STILB_INPUT_ACTIONS] = {.name = "profiler",
                                                     .kind = STILB_INPUT_SWITCH,
                                                     .keys = {STILB_WINDOW_KEY_F1},
                                                     .pad = STILB_INPUT_PAD(NORTH),
                                                     .main = true,
                                                     .help = "open or close the profiler"},
	[STILB_ENGINE_FREEZE - STILB_INPUT_ACTIONS] = {.name = "freeze",
                                                   .kind = STILB_INPUT_SWITCH,
                                                   .keys = {STILB_WINDOW_KEY_SPACE},
                                                   .pad = STILB_INPUT_PAD(SOUTH),
                                                   .help = "freeze the profiler; else pause the animation"},
	[STILB_ENGINE_MATERIALS - STILB_INPUT_ACTIONS] = {.name = "materials",
                                                      .kind = STILB_INPUT_SWITCH,
                                                      .keys = {STILB_WINDOW_KEY_F2},
                                                      .pad = STILB_INPUT_PAD(START),
                                                      .main = true,
                                                      .help = "open or close the materials"},
	[STILB_ENGINE_CAPTURE - STILB_INPUT_ACTIONS] = {.name = "trace",
                                                    .keys = {STILB_WINDOW_KEY_P},
                                                    .pad = STILB_INPUT_PAD(WEST),
                                                    .help = "save a trace"},
	[STILB_ENGINE_PICTURE - STILB_INPUT_ACTIONS] = {.name = "picture",
                                                    .keys = {STILB_WINDOW_KEY_F12},
                                                    .pad = STILB_INPUT_PAD(BACK),
                                                    .main = true,
                                                    .help = "save a picture"},
	[STILB_ENGINE_IMAGE - STILB_INPUT_ACTIONS] = {.name = "next image",
                                                  .typed = "i",
                                                  .help = "the next image of the frame, the one before"},
	[STILB_ENGINE_IMAGE_BACK - STILB_INPUT_ACTIONS] = {.name = "image before",
                                                       .typed = "I",
                                                       .help = "the next image of the frame, the one before"},
	[STILB_ENGINE_IMAGE_PART -
		STILB_INPUT_ACTIONS] = {.name = "next mip", .typed = "u", .help = "its next mip or layer, the one before"},
	[STILB_ENGINE_IMAGE_PART_BACK -
		STILB_INPUT_ACTIONS] = {.name = "mip before", .typed = "U", .help = "its next mip or layer, the one before"},
	[STILB_ENGINE_SHOW -
		STILB_INPUT_ACTIONS] = {.name = "next channel", .typed = "c", .help = "next, previous channel of materials"},
	[STILB_ENGINE_SHOW_BACK -
		STILB_INPUT_ACTIONS] = {.name = "channel before", .typed = "C", .help = "next, previous channel of materials"},
	[STILB_ENGINE_LIGHTING - STILB_INPUT_ACTIONS] = {.name = "next lighting",
                                                     .typed = "l",
                                                     .help = "the next way of lighting, the one before"},
	[STILB_ENGINE_LIGHTING_BACK - STILB_INPUT_ACTIONS] = {.name = "lighting before",
                                                          .typed = "L",
                                                          .help = "the next way of lighting, the one before"},
	[STILB_ENGINE_VALUE -
		STILB_INPUT_ACTIONS] = {.name = "value", .typed = "x", .help = "show or hide the light under the pointer"},
	[STILB_ENGINE_CLIPS - STILB_INPUT_ACTIONS] = {.name = "animation",
                                                  .kind = STILB_INPUT_SWITCH,
                                                  .keys = {STILB_WINDOW_KEY_F4},
                                                  .help = "open or close the animation's clips"},
	[STILB_ENGINE_LIGHTS - STILB_INPUT_ACTIONS] = {.name = "lights",
                                                   .kind = STILB_INPUT_SWITCH,
                                                   .keys = {STILB_WINDOW_KEY_F5},
                                                   .help = "open or close the list of lights"},
	[STILB_ENGINE_EFFECTS - STILB_INPUT_ACTIONS] = {.name = "effects",
                                                    .kind = STILB_INPUT_SWITCH,
                                                    .keys = {STILB_WINDOW_KEY_F6},
                                                    .help = "open or close the effects on the light"},
	[STILB_ENGINE_STEP -
		STILB_INPUT_ACTIONS] = {.name = "step", .typed = ".", .help = "a sixtieth of a second on, back"},
	[STILB_ENGINE_STEP_BACK -
		STILB_INPUT_ACTIONS] = {.name = "step back", .typed = ",", .help = "a sixtieth of a second on, back"},
};
static_assert(sizeof engine_actions / sizeof *engine_actions == STILB_ENGINE_ACTIONS - STILB_INPUT_ACTIONS, "all rows");

stilb_result stilb_engine_table(const stilb_engine_desc *desc, stilb_input_table *table)
{
	STILB_ASSERT(desc && table);
	STILB_ASSERT(desc->actions || desc->action_count == 0);
	stilb_input_action rows[STILB_ENGINE_ACTIONS - STILB_INPUT_ACTIONS];
	for (uint32_t i = 0; i < STILB_ENGINE_ACTIONS - STILB_INPUT_ACTIONS; i++) {
		bool saves = i == STILB_ENGINE_CAPTURE - STILB_INPUT_ACTIONS || i == STILB_ENGINE_PICTURE - STILB_INPUT_ACTIONS;
		rows[i] = saves && !desc->saves ? (stilb_input_action){.name = engine_actions[i].name} : engine_actions[i];
	}
	*table = stilb_input_table_camera();
	stilb_result result = stilb_input_table_add(table, rows, sizeof rows / sizeof *rows);
	STILB_ASSERT(result == STILB_OK && "the engine's own rows are sound");
	return result == STILB_OK ? stilb_input_table_add(table, desc->actions, desc->action_count) : result;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static int64_t engine_input_now_us(void)
{
	return (int64_t)(stilb_time_ns() / 1000u);
}

/* The camera's time, microseconds: the frame's number in sixtieths of a second if there is neither a window nor a
 * gamepad, the time since its first frame for a replay in a window, else the clock. */
static int64_t engine_input_time_us(stilb_engine *engine)
{
	engine_input *input = &engine->input;
	if (!engine->window && !engine->desc.surface && !input->pads)
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
	STILB_ASSERT_OWNER(engine->owner);
	if (!engine->scene)
		return (stilb_input_pose){0};
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

/* Creates the control, whose time begins now; a replay's at 0, with the first frame. */
static stilb_result engine_input_create(stilb_engine *engine)
{
	engine_input *input = &engine->input;
	input->focused = true;
	input->pose = stilb_engine_pose(engine);
	int64_t time_us = input->recording ? 0 : engine_input_time_us(engine);
	stilb_input_control_settings settings = engine->desc.control;
	settings.table = &engine->actions;
	return stilb_input_control_create(&settings, &input->pose, time_us, &input->control);
}

stilb_result engine_input_start(stilb_engine *engine)
{
	engine_input *input = &engine->input;
	const stilb_engine_desc *desc = &engine->desc;
	bool live = desc->gamepad == STILB_ENGINE_GAMEPAD_HIDRAW || desc->gamepad == STILB_ENGINE_GAMEPAD_HIDAPI ||
	            (desc->gamepad == STILB_ENGINE_GAMEPAD_AUTO && desc->window);
	bool replay = desc->gamepad == STILB_ENGINE_GAMEPAD_REPLAY;
	stilb_result result = STILB_OK;
	STILB_ASSERT(!input->control);
	if (!engine->window && !live && !replay)
		return STILB_OK;
	if (replay)
		result = stilb_input_recording_load(desc->gamepad_recording, &input->recording);
	if (live)
		result = engine_input_open_pads(input, desc);
	return result == STILB_OK ? engine_input_create(engine) : result;
}

void engine_input_finish(engine_input *input)
{
	stilb_input_pads_destroy(input->pads);
	stilb_input_recording_free(input->recording);
	stilb_input_control_destroy(input->control);
	*input = (engine_input){0};
}

/* ---- what the program gives -------------------------------------------------------------------------------------- */

stilb_result stilb_engine_input(stilb_engine *engine, const stilb_window_state *state)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(state);
	STILB_ASSERT(!engine->window && "the engine reads its own window");
	engine_input *input = &engine->input;
	stilb_result result = input->control ? STILB_OK : engine_input_create(engine);
	if (result != STILB_OK)
		return result;
	input->given = *state;
	input->is_given = true;
	return STILB_OK;
}

bool engine_input_take_given(stilb_engine *engine, stilb_window_state *state)
{
	engine_input *input = &engine->input;
	if (!input->is_given)
		return false;
	stilb_window_state *given = &input->given;
	*state = *given;
	state->lost = false;
	if (state->width == 0 || state->height == 0)
		stilb_render_size(engine->render, &state->width, &state->height);
	stilb_window_state stays = {.focused = given->focused,
	                            .mouse_captured = given->mouse_captured,
	                            .pointer = given->pointer,
	                            .pointer_x = given->pointer_x,
	                            .pointer_y = given->pointer_y,
	                            .button = given->button,
	                            .middle = given->middle};
	memcpy(stays.held, given->held, sizeof stays.held);
	*given = stays;
	return true;
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

/* How many reports of the pad of this number were refused; for pad = 0, of all pads together. */
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

/* Counts an event, shows or removes the notice for it, and hands it to the control. */
static void engine_input_take(stilb_engine *engine, const stilb_input_event *event)
{
	engine_input *input = &engine->input;
	STILB_ASSERT(event->kind != STILB_INPUT_PAD_DENIED || event->info);
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

/* Takes all events since the last frame. */
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

/* Takes the recording's events up to this time. At its end all pads are removed, so that no stick stays deflected. */
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
	/* The camera is not where the last frame's input left it: the program has moved it itself. */
	if (memcmp(&before, &input->pose, sizeof before) != 0)
		stilb_input_control_place(input->control, input->time_us, &before);
	if (input->recording)
		engine_input_take_replay(engine, time_us);
	else
		engine_input_take_live(engine, time_us);
	stilb_input_state keys = *state;
	stilb_input_control_frame(input->control, time_us, &keys, input->focused, state, &input->pose);
	input->pad_captures = state->actions[STILB_ENGINE_CAPTURE] > keys.actions[STILB_ENGINE_CAPTURE];
	input->time_us = time_us;
	if (engine->scene)
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

void stilb_engine_set_speed(stilb_engine *engine, float speed)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(speed >= 0.0f && isfinite(speed));
	engine_input *input = &engine->input;
	if (!input->control)
		return;
	stilb_input_control_set_speed(input->control, speed);
	stilb_input_control_place(input->control, input->time_us, &input->pose);
}

/* ---- gamepads and their counts ----------------------------------------------------------------------------------- */

uint32_t stilb_engine_gamepads(const stilb_engine *engine, stilb_input_control_pad pads[STILB_INPUT_PADS_MAX])
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(pads);
	return engine->input.control ? stilb_input_control_pads(engine->input.control, pads) : 0;
}

stilb_engine_gamepad_counts stilb_engine_gamepad_counts_get(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	const engine_input *input = &engine->input;
	if (!input->control)
		return (stilb_engine_gamepad_counts){0};
	return (stilb_engine_gamepad_counts){
		.reports = input->reports,
		.corrupt = input->corrupt + engine_input_corrupt(input, 0),
		.lost = input->pads ? stilb_input_pads_stats_get(input->pads).lost : 0,
	};
}
