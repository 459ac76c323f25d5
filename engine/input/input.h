/*
 * input: what the user asked for in one frame, as plain numbers: where to fly, where to look, what to do. This header
 * reads keyboard and mouse by a table of actions (input_actions.h); input_control.h adds the gamepads and moves the
 * camera.
 *
 * Per frame.  stilb_input_from_window, then stilb_input_control_frame:
 *
 *     stilb_window_poll(window, &seen);
 *     stilb_input_state keys = stilb_input_from_window(&table, &seen);
 *     if (a_text_field_has_the_keyboard)
 *         keys = stilb_input_without_keys(&table, keys);
 *     stilb_input_control_frame(control, now_us, &keys, seen.focused, &all, &pose);
 *
 * Life cycle. None: a stilb_input_state is a value, {0} asks for nothing.
 * Threads.    Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_H
#define STILB_INPUT_H

#include "base/base.h"
#include "input/input_actions.h"
#include "window/window.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* One frame's requests. */
typedef struct stilb_input_state {
	/* Right, up, forward; each in [-1, 1]. The camera normalises a vector longer than 1. */
	float move[3];
	/* Turn to the left and upwards, radians, at once. */
	float look[2];
	/* Turn about what is looked at, and move along with it: the pointer's movement with the left and with the middle
	 * button held, to the right and down, in heights of the window. Come closer by so many notches of the wheel. */
	float drag[2], pan[2], zoom;
	/* Of each row of the table: what its stilb_input_kind says. */
	uint8_t actions[STILB_INPUT_ACTIONS_MAX];
} stilb_input_state;

/* Speed while STILB_INPUT_FASTER is held, relative to the speed without. */
#define STILB_INPUT_FAST 6.0f

/* Radians for each pixel that the captured mouse moves. */
#define STILB_INPUT_TURN 0.0025f

/* The window's state as the table reads it. Keys held together that oppose each other cancel. Asserts that the table
 * has the camera's rows. [any-thread] */
stilb_input_state stilb_input_from_window(const stilb_input_table *table, const stilb_window_state *window);

/* Input without what a user interface with the keyboard's focus takes: flying, everything else that is held, and rows
 * with one of the keys by which it is used (stilb_input_table_panels). The mouse and the other rows stay.
 * [any-thread] */
stilb_input_state stilb_input_without_keys(const stilb_input_table *table, stilb_input_state input);

/* Input without the visible pointer's drags and the wheel, which a user interface under it takes. [any-thread] */
stilb_input_state stilb_input_without_pointer(stilb_input_state input);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
