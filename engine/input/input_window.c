#include "input/input_window.h"

#include <stdio.h>
#include <string.h>

#define WINDOW_PAD 0x80000000u /* numbers from here on; those of directly read pads count from 1 */

/* ---- what the library says ----------------------------------------------------------------------------------------- */

/* GLFW's order, which is that of its SDL-style mappings (glfw3.h: GLFW_GAMEPAD_BUTTON_A = 0, ...). */
static const uint8_t window_buttons[] = {
	STILB_INPUT_SOUTH,          STILB_INPUT_EAST, STILB_INPUT_WEST,  STILB_INPUT_NORTH, STILB_INPUT_LEFT_SHOULDER,
	STILB_INPUT_RIGHT_SHOULDER, STILB_INPUT_BACK, STILB_INPUT_START, STILB_INPUT_GUIDE, STILB_INPUT_LEFT_STICK,
	STILB_INPUT_RIGHT_STICK,    STILB_INPUT_UP,   STILB_INPUT_RIGHT, STILB_INPUT_DOWN,  STILB_INPUT_LEFT,
};

stilb_input_pad_state stilb_input_window_state(const stilb_window_gamepad *gamepad)
{
	stilb_input_pad_state state = {0};
	state.axes[STILB_INPUT_LEFT_X] = gamepad->axes[0];
	state.axes[STILB_INPUT_LEFT_Y] = 0.0f - gamepad->axes[1]; /* no -0: a pad at rest is {0} */
	state.axes[STILB_INPUT_RIGHT_X] = gamepad->axes[2];
	state.axes[STILB_INPUT_RIGHT_Y] = 0.0f - gamepad->axes[3];
	state.axes[STILB_INPUT_LEFT_TRIGGER] = 0.5f * (gamepad->axes[4] + 1.0f);
	state.axes[STILB_INPUT_RIGHT_TRIGGER] = 0.5f * (gamepad->axes[5] + 1.0f);
	for (uint32_t b = 0; b < sizeof window_buttons; b++)
		state.buttons |= (gamepad->buttons >> b & 1u) << window_buttons[b];
	return state;
}

/* The number at a place of the GUID: two bytes, the lower one first (linux_joystick.c of GLFW 3.3, openJoystickDevice). */
static uint16_t window_guid_number(const char *guid, size_t at)
{
	unsigned low = 0, high = 0;
	return sscanf(guid + at, "%2x%2x", &low, &high) == 2 ? (uint16_t)(low | high << 8) : 0;
}

/* "bbbb0000vvvv0000pppp0000eeee0000": bus, vendor, product, version. A device that lacks one of them has its name instead. */
static bool window_guid_has_ids(const char *guid)
{
	return strlen(guid) == 32 && strncmp(guid + 12, "0000", 4) == 0 && strncmp(guid + 20, "0000", 4) == 0 &&
	       strcmp(guid + 28, "0000") == 0 && window_guid_number(guid, 8) != 0;
}

bool stilb_input_window_same(const char *guid, const char *name, const stilb_input_pad_info *info)
{
	/* The kernel may append to the name (hid-input.c: " Gamepad"), and a driver may change the product (xpadneo). */
	bool same_name = info->name[0] && strncmp(name, info->name, strlen(info->name)) == 0;
	if (!window_guid_has_ids(guid))
		return same_name;
	return window_guid_number(guid, 0) == info->bus && window_guid_number(guid, 8) == info->vendor &&
	       (window_guid_number(guid, 16) == info->product || same_name);
}

/* ---- what becomes of it -------------------------------------------------------------------------------------------- */

static bool window_is_read_directly(const stilb_window_gamepad *gamepad, const stilb_input_control *control)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_input_control_pads(control, pads);
	for (uint32_t i = 0; i < count; i++)
		if (!pads[i].denied && pads[i].pad < WINDOW_PAD &&
		    stilb_input_window_same(gamepad->guid, gamepad->name, pads[i].info))
			return true;
	return false;
}

static void window_add(stilb_input_window *window, int place, const stilb_window_gamepad *gamepad, int64_t time_us,
                       stilb_input_control *control)
{
	stilb_input_pad_info info = {0};
	snprintf(info.path, sizeof info.path, "window:%d", place);
	snprintf(info.name, sizeof info.name, "%s", gamepad->name);
	if (window_guid_has_ids(gamepad->guid)) {
		info.bus = window_guid_number(gamepad->guid, 0);
		info.vendor = window_guid_number(gamepad->guid, 8);
		info.product = window_guid_number(gamepad->guid, 16);
	}
	window->places[place].pad = WINDOW_PAD + window->told++ % WINDOW_PAD;
	window->places[place].state = (stilb_input_pad_state){0};
	stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_ADDED,
	                                                        .pad = window->places[place].pad,
	                                                        .time_us = time_us,
	                                                        .info = &info});
}

static void window_remove(stilb_input_window *window, int place, int64_t time_us, stilb_input_control *control)
{
	if (window->places[place].pad != 0)
		stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_REMOVED,
		                                                        .pad = window->places[place].pad,
		                                                        .time_us = time_us});
	window->places[place].pad = 0;
}

static void window_report(stilb_input_window *window, int place, const stilb_window_gamepad *gamepad, int64_t time_us,
                          stilb_input_control *control)
{
	stilb_input_pad_state state = stilb_input_window_state(gamepad);
	if (memcmp(&state, &window->places[place].state, sizeof state) == 0)
		return;
	window->places[place].state = state;
	stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_STATE,
	                                                        .pad = window->places[place].pad,
	                                                        .time_us = time_us,
	                                                        .state = state});
}

void stilb_input_window_feed(stilb_input_window *window, const stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS],
                             int64_t time_us, stilb_input_control *control)
{
	for (int place = 0; place < STILB_WINDOW_GAMEPADS; place++) {
		const stilb_window_gamepad *gamepad = &gamepads[place];
		const char *guid = gamepad->name ? gamepad->guid : "";
		if (strcmp(window->places[place].guid, guid) != 0) { /* another one than before, or none */
			window_remove(window, place, time_us, control);
			snprintf(window->places[place].guid, sizeof window->places[place].guid, "%s", guid);
			window->places[place].since_us = time_us;
		}
		if (!gamepad->name)
			continue;
		if (window_is_read_directly(gamepad, control)) {
			window_remove(window, place, time_us, control);
			continue;
		}
		if (window->places[place].pad == 0 && time_us - window->places[place].since_us >= STILB_INPUT_WINDOW_WAIT_US)
			window_add(window, place, gamepad, time_us, control);
		if (window->places[place].pad != 0)
			window_report(window, place, gamepad, time_us, control);
	}
}
