#include "input/input.h"

static float input_axis(const bool *held, stilb_window_key plus, stilb_window_key minus)
{
	return (float)held[plus] - (float)held[minus];
}

stilb_input_state stilb_input_from_window(const stilb_window_state *window)
{
	const bool *held = window->held;
	return (stilb_input_state){
		.move = {input_axis(held, STILB_WINDOW_KEY_D, STILB_WINDOW_KEY_A),
	             input_axis(held, STILB_WINDOW_KEY_E, STILB_WINDOW_KEY_Q),
	             input_axis(held, STILB_WINDOW_KEY_W, STILB_WINDOW_KEY_S)},
		.look = {-window->mouse_x * STILB_INPUT_TURN, -window->mouse_y * STILB_INPUT_TURN},
		.fast = held[STILB_WINDOW_KEY_SHIFT],
		.capture = window->pressed[STILB_WINDOW_KEY_P] > 0,
		.screenshot = window->pressed[STILB_WINDOW_KEY_F12] > 0,
		.overlay = window->pressed[STILB_WINDOW_KEY_F1] % 2 > 0,
		.inspector = window->pressed[STILB_WINDOW_KEY_F2] % 2 > 0,
		.freeze = window->pressed[STILB_WINDOW_KEY_SPACE] % 2 > 0,
		.next_view = window->pressed[STILB_WINDOW_KEY_V],
		.workers = window->pressed[STILB_WINDOW_KEY_PLUS] - window->pressed[STILB_WINDOW_KEY_MINUS],
	};
}

stilb_input_state stilb_input_without_keys(stilb_input_state input)
{
	input.move[0] = input.move[1] = input.move[2] = 0.0f;
	input.fast = input.freeze = false;
	return input;
}
