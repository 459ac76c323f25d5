#include "input/input_control.h"

#include "base/base_contract.h"
#include "input/hid/input_layout.h"
#include "input/input_pad_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CONTROL_TRIGGER_INNER 0.05f /* dead zone: worn triggers do not return to 0 */
#define CONTROL_TOUCH_MIN 0.1f      /* least movement that counts as a touch, also without a dead zone */
#define CONTROL_DRIFT 0.1f          /* axis units per second: an axis that moves more slowly is drift, not a touch */

typedef struct control_pad {
	uint32_t number; /* 0: this entry is free */
	bool denied;
	bool readable;    /* `layout` was found, so reports can be decoded */
	char unread[160]; /* the reason if it was not found */
	stilb_input_pad_info info;
	stilb_input_layout layout;
	stilb_input_pad_state state;
	/* The axes' values at the last touch, moved since towards the present ones at the speed CONTROL_DRIFT. An axis that
	 * is farther from its value here than the dead zone is a touch. */
	float rest[STILB_INPUT_AXIS_COUNT];
	uint64_t reports, corrupt;
	int64_t last_us;
} control_pad;

struct stilb_input_control {
	stilb_owner owner;
	stilb_input_control_settings settings;
	stilb_input_table own; /* the table if the settings have none */
	stilb_input_camera camera;
	bool focused;
	stilb_input_wish keys;                    /* the movement that the keys held in the last frame ask for */
	int64_t keys_until_us;                    /* the time from which those keys count as released */
	uint8_t actions[STILB_INPUT_ACTIONS_MAX]; /* presses on the leading pad since the last frame */
	uint32_t leader;
	control_pad pads[STILB_INPUT_PADS_MAX];
};

stilb_input_control_settings stilb_input_control_settings_default(void)
{
	return (stilb_input_control_settings){
		.camera = stilb_input_camera_settings_default(),
		.inner = 0.12f,
		.outer = 0.95f,
		.curve = 2.0f,
		.sensitivity = {1.0f, 1.0f, 1.0f, 1.0f},
		.boost = 3.0f,
	};
}

static bool control_settings_are_sound(const stilb_input_control_settings *settings)
{
	bool sound = settings->inner >= 0.0f && settings->outer > 0.0f && settings->curve > 0.0f &&
	             settings->boost >= 0.0f && settings->boost <= 8.0f;
	for (int i = 0; i < 4; i++)
		sound = sound && settings->sensitivity[i] >= 0.0f && settings->sensitivity[i] <= 10.0f;
	return sound;
}

/* For STILB_CHECK: no pad has two entries, and the leading pad, if any, has one. */
static bool control_is_sound(const stilb_input_control *control)
{
	bool leader_is_there = control->leader == 0;
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++) {
		uint32_t number = control->pads[i].number;
		leader_is_there = leader_is_there || number == control->leader;
		for (uint32_t k = 0; k < i; k++)
			if (number != 0 && control->pads[k].number == number)
				return false;
	}
	return leader_is_there;
}

stilb_result stilb_input_control_create(const stilb_input_control_settings *settings, const stilb_input_pose *pose,
                                        int64_t time_us, stilb_input_control **out)
{
	STILB_ASSERT(settings && control_settings_are_sound(settings) && "the settings are in their ranges");
	STILB_ASSERT(pose && out);
	*out = NULL;
	stilb_input_control *control = calloc(1, sizeof *control);
	if (!control)
		return stilb_fail(STILB_ERROR_MEMORY, "input: out of memory");
	stilb_owner_take(&control->owner);
	control->settings = *settings;
	if (!settings->table) {
		control->own = stilb_input_table_camera();
		control->settings.table = &control->own;
	}
	control->focused = true;
	control->keys_until_us = time_us;
	control->camera = stilb_input_camera_make(&settings->camera, pose, time_us);
	*out = control;
	return STILB_OK;
}

void stilb_input_control_destroy(stilb_input_control *control)
{
	if (!control)
		return;
	STILB_ASSERT_OWNER(control->owner);
	free(control);
}

/* ---- what is wanted ---------------------------------------------------------------------------------------------- */

/* The entry of the pad of this number; for the number 0 a free entry. NULL if there is none. */
static control_pad *control_find(stilb_input_control *control, uint32_t number)
{
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++)
		if (control->pads[i].number == number)
			return &control->pads[i];
	return NULL;
}

static float control_trigger(float value)
{
	float out[2];
	stilb_input_stick((const float[2]){value, 0.0f}, CONTROL_TRIGGER_INNER, 1.0f, 1.0f, out);
	return out[0];
}

/* 1 while a button of the row is down, else 0. */
static uint8_t control_held(const stilb_input_control_settings *settings, const stilb_input_pad_state *state,
                            uint32_t row)
{
	static_assert(STILB_INPUT_BUTTON_COUNT == 16, "the bits of a row that are no axes");
	return (settings->table->rows[row].pad & 0xffffu & state->buttons) != 0;
}

/* 1 while only a button of the row `plus` is down, -1 while only one of `minus` is, else 0. */
static float control_axis(const stilb_input_control_settings *settings, const stilb_input_pad_state *state,
                          uint32_t plus, uint32_t minus)
{
	return (float)control_held(settings, state, plus) - (float)control_held(settings, state, minus);
}

static stilb_input_wish control_pad_wish(const stilb_input_control_settings *settings,
                                         const stilb_input_pad_state *state)
{
	const float *axes = state->axes, *sensitivity = settings->sensitivity;
	float left[2], right[2];
	stilb_input_stick(&axes[STILB_INPUT_LEFT_X], settings->inner, settings->outer, settings->curve, left);
	stilb_input_stick(&axes[STILB_INPUT_RIGHT_X], settings->inner, settings->outer, settings->curve, right);
	return (stilb_input_wish){
		.move = {left[0] * sensitivity[0] + control_axis(settings, state, STILB_INPUT_RIGHTWARD, STILB_INPUT_LEFTWARD),
	             control_axis(settings, state, STILB_INPUT_UPWARD, STILB_INPUT_DOWNWARD),
	             left[1] * sensitivity[1] + control_axis(settings, state, STILB_INPUT_FORWARD, STILB_INPUT_BACKWARD)},
		.turn = {-right[0] * sensitivity[2], right[1] * sensitivity[3] * (settings->invert_y ? -1.0f : 1.0f)},
		.boost = settings->boost *
	             (control_trigger(axes[STILB_INPUT_RIGHT_TRIGGER]) - control_trigger(axes[STILB_INPUT_LEFT_TRIGGER])),
	};
}

static stilb_input_wish control_keys_wish(const stilb_input_state *keys)
{
	return (stilb_input_wish){
		.move = {keys->move[0], keys->move[1], keys->move[2]},
		.boost = keys->actions[STILB_INPUT_FASTER] ? log2f(STILB_INPUT_FAST) : 0.0f,
	};
}

/* Tells the camera what the leading pad and the keys want together. */
static void control_steer(stilb_input_control *control, int64_t time_us)
{
	stilb_input_wish wish = {0};
	if (control->focused)
		wish = control->keys;
	const control_pad *leader = control->leader ? control_find(control, control->leader) : NULL;
	if (control->focused && leader) {
		stilb_input_wish pad = control_pad_wish(&control->settings, &leader->state);
		for (int i = 0; i < 3; i++)
			wish.move[i] += pad.move[i];
		for (int i = 0; i < 2; i++)
			wish.turn[i] += pad.turn[i];
		wish.boost += pad.boost;
	}
	stilb_input_camera_steer(&control->camera, time_us, &wish);
}

/* If time_us is past keys_until_us, the keys are released as of keys_until_us, so that the camera does not fly on while
 * the program is stalled. */
static void control_forget_keys(stilb_input_control *control, int64_t time_us)
{
	if (time_us <= control->keys_until_us)
		return;
	control->keys = (stilb_input_wish){0};
	control_steer(control, control->keys_until_us);
}

/* ---- pads -------------------------------------------------------------------------------------------------------- */

static void control_recognise(control_pad *pad)
{
	pad->readable = pad->info.descriptor_size > 0 && stilb_input_layout_find(&pad->info, &pad->layout) == STILB_OK;
	if (!pad->readable)
		snprintf(pad->unread, sizeof pad->unread, "%s",
		         pad->info.descriptor_size > 0 ? stilb_error_message() : "by the window library");
}

static void control_add(stilb_input_control *control, const stilb_input_event *event)
{
	STILB_ASSERT(event->info && "ADDED and DENIED say what the pad is");
	STILB_ASSERT(!control_find(control, event->pad) && "a pad is added once");
	control_pad *pad = control_find(control, 0);
	if (!pad)
		return;
	memset(pad, 0, sizeof *pad);
	pad->number = event->pad;
	pad->denied = event->kind == STILB_INPUT_PAD_DENIED;
	pad->info = *event->info;
	pad->last_us = event->time_us;
	control_recognise(pad);
}

static void control_remove(stilb_input_control *control, control_pad *pad, int64_t time_us)
{
	bool led = pad->number == control->leader;
	pad->number = 0;
	if (!led)
		return;
	control->leader = 0;
	stilb_input_camera_stop(&control->camera, time_us);
	control_steer(control, time_us); /* keys that are still held go on to move the camera */
}

/* True if the pad's new state is a touch, as input_control.h defines it. */
static bool control_touched(control_pad *pad, const stilb_input_pad_state *state, float dead_zone, int64_t time_us)
{
	STILB_ASSERT(time_us >= pad->last_us && "a pad's events come in time order");
	float drift = CONTROL_DRIFT * (float)(1e-6 * ((double)time_us - (double)pad->last_us));
	bool touched = (state->buttons & ~pad->state.buttons) != 0;
	for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++) {
		pad->rest[i] = stilb_input_step_towards(pad->rest[i], pad->state.axes[i], drift);
		touched = touched || fabsf(state->axes[i] - pad->rest[i]) > dead_zone;
	}
	if (touched)
		memcpy(pad->rest, state->axes, sizeof pad->rest);
	return touched;
}

/* Counts the buttons that were pressed at once, by the table. */
static void control_act(stilb_input_control *control, uint32_t pressed)
{
	const stilb_input_table *table = control->settings.table;
	for (uint32_t row = 0; row < table->count; row++) {
		uint8_t *state = &control->actions[row];
		unsigned presses = (unsigned)__builtin_popcount(table->rows[row].pad & 0xffffu & pressed);
		if (table->rows[row].kind == STILB_INPUT_SWITCH)
			*state ^= presses % 2 > 0;
		if (table->rows[row].kind == STILB_INPUT_PRESS)
			*state = (uint8_t)(*state + presses < UINT8_MAX ? *state + presses : UINT8_MAX);
	}
}

static void control_state(stilb_input_control *control, control_pad *pad, const stilb_input_pad_state *state,
                          int64_t time_us)
{
	STILB_CHECK(input_pad_state_is_sound(state));
	/* A pad's first state is its rest position: a pad plugged in with a stick pushed does not take the lead by that. */
	if (pad->reports == 0 && control->leader) {
		pad->state = *state;
		memcpy(pad->rest, state->axes, sizeof pad->rest);
	}
	uint32_t pressed = state->buttons & ~pad->state.buttons;
	if (control_touched(pad, state, fmaxf(control->settings.inner, CONTROL_TOUCH_MIN), time_us))
		control->leader = pad->number;
	pad->state = *state;
	pad->last_us = time_us;
	pad->reports++;
	if (control->focused)
		control_act(control, pressed); /* a press is a touch, so this pad leads */
	control_steer(control, time_us);
}

static void control_report(stilb_input_control *control, control_pad *pad, const stilb_input_event *event)
{
	STILB_ASSERT(event->bytes || event->size == 0);
	if (!pad->readable)
		return;
	stilb_input_pad_state state = pad->state;
	switch (stilb_input_decode(&pad->layout, event->bytes, event->size, &state)) {
	case STILB_INPUT_DECODED:
		control_state(control, pad, &state, event->time_us);
		break;
	case STILB_INPUT_CORRUPT:
		pad->corrupt++;
		break;
	case STILB_INPUT_OTHER:
		break;
	}
}

void stilb_input_control_event(stilb_input_control *control, const stilb_input_event *event)
{
	STILB_ASSERT(control && event);
	STILB_ASSERT_OWNER(control->owner);
	STILB_ASSERT(event->pad != 0 && "pads are numbered from 1");
	control_forget_keys(control, event->time_us);
	if (event->kind == STILB_INPUT_PAD_ADDED || event->kind == STILB_INPUT_PAD_DENIED) {
		control_add(control, event);
		return;
	}
	control_pad *pad = control_find(control, event->pad);
	if (!pad)
		return;
	if (event->kind == STILB_INPUT_PAD_REMOVED)
		control_remove(control, pad, event->time_us);
	else if (event->kind == STILB_INPUT_PAD_REPORT)
		control_report(control, pad, event);
	else
		control_state(control, pad, &event->state, event->time_us);
	STILB_CHECK(control_is_sound(control));
}

uint32_t stilb_input_control_pads(const stilb_input_control *control,
                                  stilb_input_control_pad pads[STILB_INPUT_PADS_MAX])
{
	STILB_ASSERT(control && pads);
	STILB_ASSERT_OWNER(control->owner);
	uint32_t count = 0;
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++) {
		const control_pad *pad = &control->pads[i];
		if (pad->number == 0)
			continue;
		pads[count++] = (stilb_input_control_pad){
			.pad = pad->number,
			.info = &pad->info,
			.name = pad->readable ? pad->layout.name : pad->info.name,
			.recognised = pad->readable ? pad->layout.recognised : pad->unread,
			.denied = pad->denied,
			.leads = pad->number == control->leader,
			.state = pad->state,
			.reports = pad->reports,
			.corrupt = pad->corrupt,
			.last_us = pad->last_us,
		};
	}
	return count;
}

uint32_t stilb_input_control_leader(const stilb_input_control *control, int64_t *last_us)
{
	STILB_ASSERT(control);
	STILB_ASSERT_OWNER(control->owner);
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX && last_us; i++)
		if (control->leader && control->pads[i].number == control->leader)
			*last_us = control->pads[i].last_us;
	return control->leader;
}

/* ---- the frame --------------------------------------------------------------------------------------------------- */

static void control_look(stilb_input_control *control, int64_t time_us, const float look[2])
{
	if (look[0] != 0.0f || look[1] != 0.0f)
		stilb_input_camera_turn(&control->camera, time_us, look[0], look[1]);
}

/* The actions of the keys together with those of the pads' buttons: what the leader holds, and presses since the last
 * frame, which are thereby used up. */
static stilb_input_state control_take(stilb_input_control *control, stilb_input_state state)
{
	const stilb_input_table *table = control->settings.table;
	const control_pad *leader = control->leader && control->focused ? control_find(control, control->leader) : NULL;
	memcpy(state.move, control->camera.wish.move, sizeof state.move);
	for (uint32_t row = 0; row < table->count; row++) {
		unsigned both = (unsigned)state.actions[row] + control->actions[row];
		if (table->rows[row].kind == STILB_INPUT_SWITCH)
			state.actions[row] = both % 2 > 0;
		if (table->rows[row].kind == STILB_INPUT_PRESS)
			state.actions[row] = (uint8_t)(both < UINT8_MAX ? both : UINT8_MAX);
		if (table->rows[row].kind == STILB_INPUT_HELD && leader)
			state.actions[row] |= control_held(&control->settings, &leader->state, row);
	}
	memset(control->actions, 0, sizeof control->actions);
	return state;
}

void stilb_input_control_frame(stilb_input_control *control, int64_t time_us, const stilb_input_state *keys,
                               bool focused, stilb_input_state *out, stilb_input_pose *pose)
{
	STILB_ASSERT(control && keys && out && pose);
	STILB_ASSERT_OWNER(control->owner);
	control_forget_keys(control, time_us);
	if (control->focused && !focused)
		stilb_input_camera_stop(&control->camera, time_us);
	control->focused = focused;
	control->keys = control_keys_wish(keys);
	control->keys_until_us = time_us + STILB_INPUT_KEYS_US;
	control_steer(control, time_us);
	if (focused)
		control_look(control, time_us, keys->look);
	stilb_input_camera_advance(&control->camera, time_us);
	*out = control_take(control, *keys);
	*pose = stilb_input_camera_at(&control->camera, time_us);
}

void stilb_input_control_place(stilb_input_control *control, int64_t time_us, const stilb_input_pose *pose)
{
	STILB_ASSERT(control && pose);
	STILB_ASSERT_OWNER(control->owner);
	control_forget_keys(control, time_us);
	control->camera = stilb_input_camera_make(&control->settings.camera, pose, time_us);
	control_steer(control, time_us);
}

void stilb_input_control_set_speed(stilb_input_control *control, float speed)
{
	STILB_ASSERT(control);
	STILB_ASSERT(speed >= 0.0f && isfinite(speed));
	STILB_ASSERT_OWNER(control->owner);
	control->settings.camera.speed = speed;
}
