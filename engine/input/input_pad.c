#include "input/input_pad_internal.h"

const char *const stilb_input_axis_names[STILB_INPUT_AXIS_COUNT] = {
	[STILB_INPUT_LEFT_X] = "left_x",
	[STILB_INPUT_LEFT_Y] = "left_y",
	[STILB_INPUT_RIGHT_X] = "right_x",
	[STILB_INPUT_RIGHT_Y] = "right_y",
	[STILB_INPUT_LEFT_TRIGGER] = "left_trigger",
	[STILB_INPUT_RIGHT_TRIGGER] = "right_trigger",
};

const char *const stilb_input_button_names[STILB_INPUT_BUTTON_COUNT] = {
	[STILB_INPUT_SOUTH] = "south",
	[STILB_INPUT_EAST] = "east",
	[STILB_INPUT_WEST] = "west",
	[STILB_INPUT_NORTH] = "north",
	[STILB_INPUT_LEFT_SHOULDER] = "left_shoulder",
	[STILB_INPUT_RIGHT_SHOULDER] = "right_shoulder",
	[STILB_INPUT_BACK] = "back",
	[STILB_INPUT_START] = "start",
	[STILB_INPUT_GUIDE] = "guide",
	[STILB_INPUT_LEFT_STICK] = "left_stick",
	[STILB_INPUT_RIGHT_STICK] = "right_stick",
	[STILB_INPUT_UP] = "up",
	[STILB_INPUT_DOWN] = "down",
	[STILB_INPUT_LEFT] = "left",
	[STILB_INPUT_RIGHT] = "right",
	[STILB_INPUT_EXTRA] = "extra",
};

bool input_pad_state_is_sound(const stilb_input_pad_state *state)
{
	for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++) {
		float least = i < STILB_INPUT_LEFT_TRIGGER ? -1.0f : 0.0f;
		if (!(state->axes[i] >= least && state->axes[i] <= 1.0f)) /* false for NaN too */
			return false;
	}
	return state->buttons >> STILB_INPUT_BUTTON_COUNT == 0;
}
