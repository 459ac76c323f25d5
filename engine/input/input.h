/*
 * input: what the user wants, once a frame, as plain numbers: where to fly, where to look, what to do. Today from the
 * keyboard and the mouse.
 *
 * Per frame.  stilb_input_from_window, then stilb_input_fly.
 * Threads.    Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_H
#define STILB_INPUT_H

#include "base/base.h"
#include "window/window.h"

/* One frame's wishes. */
typedef struct stilb_input_state {
	float move[3];   /* right, up, forward; each in [-1, 1]; more than 1 long flies like 1 */
	float look[2];   /* turn to the left and upwards, radians */
	bool fast;       /* fly at STILB_INPUT_FAST times the speed */
	bool capture;    /* write a trace */
	bool screenshot; /* write a picture */
	bool overlay;    /* open or close the profiler */
	bool inspector;  /* open or close the materials' window */
	bool freeze;     /* let it stand still, or go on */
	int32_t workers; /* change of the worker count */
} stilb_input_state;

#define STILB_INPUT_SPEED 12.0f       /* m/s */
#define STILB_INPUT_FAST 6.0f         /* times, with shift */
#define STILB_INPUT_TURN 0.0025f      /* radians a pixel of the mouse */
#define STILB_INPUT_PITCH_LIMIT 1.55f /* radians: short of straight up and down */

/* WASD and Q/E move, shift is fast, the captured mouse looks, P captures, F12 takes a picture, F1 opens and closes the
 * profiler, space freezes it, F2 opens and closes the materials' window, - and + change workers. */
stilb_input_state stilb_input_from_window(const stilb_window_state *window);

/* The same without flying and freezing: the keys belong to a user interface. */
stilb_input_state stilb_input_without_keys(stilb_input_state input);

/* Position and direction of what flies; yaw 0 looks along -Z and grows to the left. */
typedef struct stilb_input_pose {
	float position[3];
	float yaw, pitch;
} stilb_input_pose;

/* The pose after `seconds` of input: the look turns first, then it moves along its own axes, upwards along +Y. The roll
 * stays zero and the pitch within STILB_INPUT_PITCH_LIMIT. */
stilb_input_pose stilb_input_fly(stilb_input_pose pose, const stilb_input_state *input, float seconds);

#endif
