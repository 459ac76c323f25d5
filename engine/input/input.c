#include "input/input.h"

/* 1 if only the key `plus` is held, -1 if only `minus` is, 0 if both or neither are. */
static float axis_of_keys(const bool *held, stilb_window_key plus, stilb_window_key minus)
{
	return (float)held[plus] - (float)held[minus];
}

/* True if a key that switches something on and off has an effect in this frame: after an even number of presses since
 * the last frame the switch is where it was. */
static bool pressed_odd(const stilb_window_state *window, stilb_window_key key)
{
	return window->pressed[key] % 2 > 0;
}

stilb_input_state stilb_input_from_window(const stilb_window_state *window)
{
	STILB_ASSERT(window);
	STILB_ASSERT(!window->held[STILB_WINDOW_KEY_MINUS] && !window->held[STILB_WINDOW_KEY_PLUS] &&
	             "typed characters are never held");
	const bool *held = window->held;
	float height = (float)(window->height > 0 ? window->height : 1);
	float x = window->moved_x / height, y = window->moved_y / height;
	return (stilb_input_state){
		.move = {axis_of_keys(held, STILB_WINDOW_KEY_D, STILB_WINDOW_KEY_A),
	             axis_of_keys(held, STILB_WINDOW_KEY_E, STILB_WINDOW_KEY_Q),
	             axis_of_keys(held, STILB_WINDOW_KEY_W, STILB_WINDOW_KEY_S)},
		.look = {-window->mouse_x * STILB_INPUT_TURN, -window->mouse_y * STILB_INPUT_TURN},
		.fast = held[STILB_WINDOW_KEY_SHIFT],
		.capture = window->pressed[STILB_WINDOW_KEY_P] > 0,
		.screenshot = window->pressed[STILB_WINDOW_KEY_F12] > 0,
		.overlay = pressed_odd(window, STILB_WINDOW_KEY_F1),
		.inspector = pressed_odd(window, STILB_WINDOW_KEY_F2),
		.freeze = pressed_odd(window, STILB_WINDOW_KEY_SPACE),
		.next_view = window->pressed[STILB_WINDOW_KEY_V],
		.workers = window->pressed[STILB_WINDOW_KEY_PLUS] - window->pressed[STILB_WINDOW_KEY_MINUS],
		.drag = {window->button ? x : 0.0f, window->button ? y : 0.0f},
		.pan = {window->middle ? x : 0.0f, window->middle ? y : 0.0f},
		.zoom = window->wheel,
		.frame = window->pressed[STILB_WINDOW_KEY_F] > 0,
		.home = window->pressed[STILB_WINDOW_KEY_HOME] > 0,
		.next_file = window->pressed[STILB_WINDOW_KEY_PAGE_DOWN] - window->pressed[STILB_WINDOW_KEY_PAGE_UP],
		.cancel = window->pressed[STILB_WINDOW_KEY_ESCAPE] > 0,
	};
}

stilb_input_state stilb_input_without_keys(stilb_input_state input)
{
	input.move[0] = input.move[1] = input.move[2] = 0.0f;
	input.fast = input.freeze = input.frame = false;
	return input;
}

stilb_input_state stilb_input_without_pointer(stilb_input_state input)
{
	input.drag[0] = input.drag[1] = input.pan[0] = input.pan[1] = input.zoom = 0.0f;
	return input;
}
