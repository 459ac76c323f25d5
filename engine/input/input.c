#include "input/input.h"

#include <string.h>

static float held_axis(const stilb_input_state *input, uint32_t plus, uint32_t minus)
{
	return (float)input->actions[plus] - (float)input->actions[minus];
}

/* How often the row's keys were pressed, or repeated if that counts, and its characters typed since the last frame. */
static unsigned row_presses(const stilb_input_action *row, const stilb_window_state *window)
{
	unsigned presses = 0;
	for (size_t i = 0; i < sizeof row->keys / sizeof *row->keys; i++)
		if (row->keys[i] != STILB_WINDOW_KEY_NONE)
			presses += (unsigned)window->pressed[row->keys[i]] +
			           (row->kind == STILB_INPUT_REPEAT ? window->repeated[row->keys[i]] : 0u);
	for (uint32_t i = 0; row->typed && i < window->typed_count; i++)
		presses += window->typed[i] > 0 && window->typed[i] < 0x80 && strchr(row->typed, (int)window->typed[i]);
	return presses;
}

static uint8_t row_state(const stilb_input_action *row, const stilb_window_state *window)
{
	unsigned presses = row_presses(row, window);
	bool held = false;
	for (size_t i = 0; i < sizeof row->keys / sizeof *row->keys; i++)
		held = held || (row->keys[i] != STILB_WINDOW_KEY_NONE && window->held[row->keys[i]]);
	switch (row->kind) {
	case STILB_INPUT_PRESS:
	case STILB_INPUT_REPEAT:
		return (uint8_t)(presses < UINT8_MAX ? presses : UINT8_MAX);
	case STILB_INPUT_SWITCH:
		return presses % 2 > 0;
	case STILB_INPUT_HELD:
		return held;
	default:
		return 0;
	}
}

stilb_input_state stilb_input_from_window(const stilb_input_table *table, const stilb_window_state *window)
{
	STILB_ASSERT(table && window);
	STILB_ASSERT(table->count >= STILB_INPUT_ACTIONS && "the camera's rows are there");
	STILB_ASSERT(table->count <= STILB_INPUT_ACTIONS_MAX);
	float height = (float)(window->height > 0 ? window->height : 1);
	float x = window->moved_x / height, y = window->moved_y / height;
	stilb_input_state input = {
		.look = {-window->mouse_x * STILB_INPUT_TURN, -window->mouse_y * STILB_INPUT_TURN},
		.drag = {window->button ? x : 0.0f, window->button ? y : 0.0f},
		.pan = {window->middle ? x : 0.0f, window->middle ? y : 0.0f},
		.zoom = window->wheel,
	};
	for (uint32_t row = 0; row < table->count; row++)
		input.actions[row] = row_state(&table->rows[row], window);
	input.move[0] = held_axis(&input, STILB_INPUT_RIGHTWARD, STILB_INPUT_LEFTWARD);
	input.move[1] = held_axis(&input, STILB_INPUT_UPWARD, STILB_INPUT_DOWNWARD);
	input.move[2] = held_axis(&input, STILB_INPUT_FORWARD, STILB_INPUT_BACKWARD);
	return input;
}

/* True if a panel with the keyboard is used by this key. */
static bool is_key_of_panels(const stilb_input_table *panels, stilb_window_key key)
{
	for (uint32_t row = STILB_INPUT_ACTIONS; key != STILB_WINDOW_KEY_NONE && row < panels->count; row++)
		for (size_t i = 0; i < sizeof panels->rows[row].keys / sizeof *panels->rows[row].keys; i++)
			if (panels->rows[row].keys[i] == key)
				return true;
	return false;
}

stilb_input_state stilb_input_without_keys(const stilb_input_table *table, stilb_input_state input)
{
	STILB_ASSERT(table);
	stilb_input_table panels = stilb_input_table_panels();
	input.move[0] = input.move[1] = input.move[2] = 0.0f;
	for (uint32_t r = 0; r < table->count; r++) {
		const stilb_input_action *row = &table->rows[r];
		bool taken = row->kind == STILB_INPUT_HELD;
		for (size_t i = 0; i < sizeof row->keys / sizeof *row->keys; i++)
			taken = taken || is_key_of_panels(&panels, row->keys[i]);
		if (taken)
			input.actions[r] = 0;
	}
	return input;
}

stilb_input_state stilb_input_without_pointer(stilb_input_state input)
{
	input.drag[0] = input.drag[1] = input.pan[0] = input.pan[1] = input.zoom = 0.0f;
	return input;
}
