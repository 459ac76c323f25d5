/*
 * input: what the user wants, once a frame, as plain numbers: where to fly, where to look, what to do; here from the
 * keyboard and the mouse, to which input_control adds the gamepads.
 *
 * Per frame.  stilb_input_from_window, then stilb_input_control_frame.
 * Threads.    Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_H
#define STILB_INPUT_H

#include "base/base.h"
#include "window/window.h"

/* One frame's wishes. */
typedef struct stilb_input_state {
	float move[3];      /* right, up, forward; each in [-1, 1]; more than 1 long flies like 1 */
	float look[2];      /* turn to the left and upwards, radians */
	bool fast;          /* fly at STILB_INPUT_FAST times the speed */
	bool capture;       /* write a trace */
	bool screenshot;    /* write a picture */
	bool overlay;       /* open or close the profiler */
	bool inspector;     /* open or close the materials' window */
	bool freeze;        /* let it stand still, or go on */
	uint32_t next_view; /* how many views further */
	int32_t workers;    /* change of the worker count */
} stilb_input_state;

#define STILB_INPUT_FAST 6.0f    /* times, with shift */
#define STILB_INPUT_TURN 0.0025f /* radians a pixel of the mouse */

/* WASD and Q/E move, shift is fast, the captured mouse looks, P captures, F12 takes a picture, F1 opens and closes the
 * profiler, space freezes it, F2 opens and closes the materials' window, V shows the next view, - and + change workers. */
stilb_input_state stilb_input_from_window(const stilb_window_state *window);

/* The same without flying and freezing: the keys belong to a user interface. */
stilb_input_state stilb_input_without_keys(stilb_input_state input);

#endif
