/*
 * input: what the user asked for in one frame, as plain numbers: where to fly, where to look, what to do. This header
 * reads keyboard and mouse; input_control.h adds the gamepads and moves the camera.
 *
 * Per frame.  stilb_input_from_window, then stilb_input_control_frame:
 *
 *     stilb_window_poll(window, &seen);
 *     stilb_input_state keys = stilb_input_from_window(&seen);
 *     if (a_text_field_has_the_keyboard)
 *         keys = stilb_input_without_keys(keys);
 *     stilb_input_control_frame(control, now_us, &keys, seen.focused, &all, &pose);
 *
 * Life cycle. None: a stilb_input_state is a value, {0} asks for nothing.
 * Threads.    Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_H
#define STILB_INPUT_H

#include "base/base.h"
#include "window/window.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* One frame's requests. A switch (overlay, inspector, freeze) is true if this frame flips it: a key pressed twice
 * between two frames changes nothing. */
typedef struct stilb_input_state {
	/* Right, up, forward; each in [-1, 1]. The camera normalises a vector longer than 1. */
	float move[3];
	/* Turn to the left and upwards, radians, at once. */
	float look[2];
	/* Fly STILB_INPUT_FAST times as fast. */
	bool fast;
	/* Write a trace (the profiler's recording of the last frames) to a file; write a picture to a file. */
	bool capture, screenshot;
	/* Open or close the profiler; open or close the materials' window. */
	bool overlay, inspector;
	/* Freeze the profiler, or let it run again. */
	bool freeze;
	/* Go on by so many views; the program decides what its views are. */
	uint32_t next_view;
	/* Add so many worker threads; negative: remove them. */
	int32_t workers;
	/* Turn about what is looked at, and move along with it: the pointer's movement with the left and with the middle
	 * button held, to the right and down, in heights of the window. Come closer by so many notches of the wheel. */
	float drag[2], pan[2], zoom;
	/* Show all of the scene; go back to the camera at the start. */
	bool frame, home;
	/* Go on by so many files; negative: back. */
	int32_t next_file;
	/* Give up what is under way. */
	bool cancel;
} stilb_input_state;

/* Speed with shift held, relative to the speed without. */
#define STILB_INPUT_FAST 6.0f

/* Radians for each pixel that the captured mouse moves. */
#define STILB_INPUT_TURN 0.0025f

/* The window's state as the program's keys read it: WASD and Q/E move, shift is fast, the captured mouse looks, P
 * writes a trace, F12 a picture, F1 opens and closes the profiler, space freezes it, F2 opens and closes the materials'
 * window, V shows the next view, - and + change the number of workers; F frames the scene, Home goes back, Page Down
 * and Page Up are the next and the previous file, Escape gives up. Keys held together that oppose each other cancel.
 * Asserts that window is not NULL. [any-thread] */
stilb_input_state stilb_input_from_window(const stilb_window_state *window);

/* Input without flying and freezing, and framing, which are the keys that a user interface with the keyboard's
 * focus takes (letters and space); the mouse and the other keys stay. [any-thread] */
stilb_input_state stilb_input_without_keys(stilb_input_state input);

/* Input without the visible pointer's drags and the wheel, which a user interface under it takes. [any-thread] */
stilb_input_state stilb_input_without_pointer(stilb_input_state input);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
