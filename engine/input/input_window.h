/*
 * input_window: the gamepads that the window library (GLFW) reads: pads without a hidraw node, like Xbox pads over USB,
 * and pads whose node may not be opened.
 *
 * A pad that input_pads.h reads directly is left out here, so that no pad appears twice. The library does not say which
 * device it opened; it gives bus, vendor, product and name, which the kernel copies from the HID device to its input
 * device. So among several equal pads all of the library's are left out as soon as one of them is read directly. A new
 * pad of the library's has to be there for STILB_INPUT_WINDOW_WAIT_US before it counts, because the library may find it
 * before it could be opened directly.
 *
 * Life cycle.  A stilb_input_window of {0} -> feed once a frame, before stilb_input_control_frame:
 *
 *     stilb_window_gamepads(window, gamepads);
 *     stilb_input_window_feed(&from_window, gamepads, now_us, control);
 *
 * Threads.  feed: [owner-thread] of the control; the others [any-thread]. No I/O.
 */
#ifndef STILB_INPUT_WINDOW_H
#define STILB_INPUT_WINDOW_H

#include "input/input_control.h"
#include "window/window.h"

/* Microseconds for which a pad may be opened directly before the library's counts. */
#define STILB_INPUT_WINDOW_WAIT_US 500000

/* The library's gamepads as the control knows them; {0} at first. */
typedef struct stilb_input_window {
	struct {
		/* Its number as an event; 0: the control does not know it. */
		uint32_t pad;
		/* Time at which it was first seen. */
		int64_t since_us;
		/* "": there is none here. */
		char guid[33];
		stilb_input_pad_state state;
	} places[STILB_WINDOW_GAMEPADS];
	/* Pads added to the control so far: the next number. */
	uint32_t told;
} stilb_input_window;

/* Tells the control what changed since the last frame, as events at time_us: pads that came and went, and new states.
 * Pads of the control that were not added here count as read directly. Time must not go back. [owner-thread] */
void stilb_input_window_feed(stilb_input_window *window, const stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS],
                             int64_t time_us, stilb_input_control *control);

/* The library's axes and buttons in the engine's order and ranges; values beyond a range become its end.
 * [any-thread] */
stilb_input_pad_state stilb_input_window_state(const stilb_window_gamepad *gamepad);

/* True if the library's gamepad of this GUID and name could be this device: equal bus and vendor, and an equal product
 * or name; by name alone if the GUID has no numbers. [any-thread] */
bool stilb_input_window_same(const char *guid, const char *name, const stilb_input_pad_info *info);

#endif
