#include "input/input_window.h"

#include "input/input_pad_internal.h"
#include "input/input_text_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FIRST_NUMBER 0x80000000u /* the library's pads are numbered from here on, those read directly from 1 */

/* ---- the library's gamepads -------------------------------------------------------------------------------------- */

/* GLFW's order of buttons (glfw3.h: GLFW_GAMEPAD_BUTTON_A = 0, ...). */
static const uint8_t button_order[] = {
	STILB_INPUT_SOUTH,          STILB_INPUT_EAST, STILB_INPUT_WEST,  STILB_INPUT_NORTH, STILB_INPUT_LEFT_SHOULDER,
	STILB_INPUT_RIGHT_SHOULDER, STILB_INPUT_BACK, STILB_INPUT_START, STILB_INPUT_GUIDE, STILB_INPUT_LEFT_STICK,
	STILB_INPUT_RIGHT_STICK,    STILB_INPUT_UP,   STILB_INPUT_RIGHT, STILB_INPUT_DOWN,  STILB_INPUT_LEFT,
};

static float clamped(float value)
{
	return fminf(fmaxf(value, -1.0f), 1.0f);
}

stilb_input_pad_state stilb_input_window_state(const stilb_window_gamepad *gamepad)
{
	STILB_ASSERT(gamepad);
	stilb_input_pad_state state = {0};
	state.axes[STILB_INPUT_LEFT_X] = clamped(gamepad->axes[0]);
	/* 0 - y, not -y, which for 0 is -0: states are compared byte by byte, and a pad at rest is {0}. */
	state.axes[STILB_INPUT_LEFT_Y] = 0.0f - clamped(gamepad->axes[1]);
	state.axes[STILB_INPUT_RIGHT_X] = clamped(gamepad->axes[2]);
	state.axes[STILB_INPUT_RIGHT_Y] = 0.0f - clamped(gamepad->axes[3]);
	state.axes[STILB_INPUT_LEFT_TRIGGER] = 0.5f * (clamped(gamepad->axes[4]) + 1.0f);
	state.axes[STILB_INPUT_RIGHT_TRIGGER] = 0.5f * (clamped(gamepad->axes[5]) + 1.0f);
	for (uint32_t b = 0; b < sizeof button_order; b++)
		state.buttons |= (gamepad->buttons >> b & 1u) << button_order[b];
	STILB_CHECK(input_pad_state_is_sound(&state));
	return state;
}

/* The 16-bit number at character `at` of a GUID: two bytes in hexadecimal, the lower one first. Source:
 * linux_joystick.c of GLFW 3.3, openJoystickDevice. */
static uint16_t guid_number(const char *guid, size_t at)
{
	STILB_ASSERT(at + 4 <= strlen(guid));
	unsigned low = 0, high = 0;
	return sscanf(guid + at, "%2x%2x", &low, &high) == 2 ? (uint16_t)(low | high << 8) : 0;
}

/* True if the GUID is "bbbb0000vvvv0000pppp0000eeee0000": bus, vendor, product, version. For a device that lacks one of
 * them GLFW puts the beginning of its name there instead. */
static bool guid_has_ids(const char *guid)
{
	return strlen(guid) == 32 && strncmp(guid + 12, "0000", 4) == 0 && strncmp(guid + 20, "0000", 4) == 0 &&
	       strcmp(guid + 28, "0000") == 0 && guid_number(guid, 8) != 0;
}

bool stilb_input_window_same(const char *guid, const char *name, const stilb_input_pad_info *info)
{
	STILB_ASSERT(guid && name && info);
	/* info has the name and product of the HID device; in its input device, which GLFW sees, the kernel may append to
	 * the name (hid-input.c: " Gamepad"), and a driver may change the product (xpadneo). */
	char clean[sizeof info->name];
	input_text_copy(clean, sizeof clean, name, strlen(name));
	bool same_name = info->name[0] && strncmp(clean, info->name, strlen(info->name)) == 0;
	if (!guid_has_ids(guid))
		return same_name;
	return guid_number(guid, 0) == info->bus && guid_number(guid, 8) == info->vendor &&
	       (guid_number(guid, 16) == info->product || same_name);
}

/* ---- as events --------------------------------------------------------------------------------------------------- */

static bool is_read_directly(const stilb_window_gamepad *gamepad, const stilb_input_control *control)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	uint32_t count = stilb_input_control_pads(control, pads);
	for (uint32_t i = 0; i < count; i++)
		if (!pads[i].denied && pads[i].pad < FIRST_NUMBER &&
		    stilb_input_window_same(gamepad->guid, gamepad->name, pads[i].info))
			return true;
	return false;
}

static void add_pad(stilb_input_window *window, int place, const stilb_window_gamepad *gamepad, int64_t time_us,
                    stilb_input_control *control)
{
	stilb_input_pad_info info = {0};
	snprintf(info.path, sizeof info.path, "window:%d", place);
	input_text_copy(info.name, sizeof info.name, gamepad->name, strlen(gamepad->name));
	if (guid_has_ids(gamepad->guid)) {
		info.bus = guid_number(gamepad->guid, 0);
		info.vendor = guid_number(gamepad->guid, 8);
		info.product = guid_number(gamepad->guid, 16);
	}
	window->places[place].pad = FIRST_NUMBER + window->told++ % FIRST_NUMBER;
	window->places[place].state = (stilb_input_pad_state){0};
	stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_ADDED,
	                                                        .pad = window->places[place].pad,
	                                                        .time_us = time_us,
	                                                        .info = &info});
}

static void remove_pad(stilb_input_window *window, int place, int64_t time_us, stilb_input_control *control)
{
	if (window->places[place].pad != 0)
		stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_REMOVED,
		                                                        .pad = window->places[place].pad,
		                                                        .time_us = time_us});
	window->places[place].pad = 0;
}

static void report_pad(stilb_input_window *window, int place, const stilb_window_gamepad *gamepad, int64_t time_us,
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
	STILB_ASSERT(window && gamepads && control);
	for (int place = 0; place < STILB_WINDOW_GAMEPADS; place++) {
		const stilb_window_gamepad *gamepad = &gamepads[place];
		STILB_ASSERT((!gamepad->name || gamepad->guid) && "a gamepad has a GUID");
		const char *guid = gamepad->name ? gamepad->guid : "";
		if (strcmp(window->places[place].guid, guid) != 0) { /* another gamepad than in the last frame, or none */
			remove_pad(window, place, time_us, control);
			snprintf(window->places[place].guid, sizeof window->places[place].guid, "%s", guid);
			window->places[place].since_us = time_us;
		}
		STILB_ASSERT(time_us >= window->places[place].since_us && "the time does not go back");
		if (!gamepad->name)
			continue;
		if (is_read_directly(gamepad, control)) {
			remove_pad(window, place, time_us, control);
			continue;
		}
		if (window->places[place].pad == 0 && time_us - window->places[place].since_us >= STILB_INPUT_WINDOW_WAIT_US)
			add_pad(window, place, gamepad, time_us, control);
		if (window->places[place].pad != 0)
			report_pad(window, place, gamepad, time_us, control);
	}
}
