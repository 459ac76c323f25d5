/*
 * input_window: the gamepads that the window library (GLFW) reads: pads without a hidraw node, like Xbox pads over USB,
 * and pads whose node may not be opened.
 *
 * A pad that input_pads.h reads directly is left out here, so that no pad appears twice. The library does not say which
 * device it opened; it gives bus, vendor, product and name, which the kernel copies from the HID device to its input
 * device. So of several pads of one model the library's are all left out as soon as one of them is read directly. A new
 * pad of the library's has to be there for STILB_INPUT_WINDOW_WAIT_US before it is used, because the library may find
 * it before it could be opened directly.
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

/* Microseconds that a pad of the library's waits before it is used, so that input_pads.h may open it first. */
#define STILB_INPUT_WINDOW_WAIT_US 500000

/* The library's gamepads, one for each of its places, as the control was told of them; {0} at first. */
typedef struct stilb_input_window {
	struct {
		/* The number under which its events go to the control; 0: the control was not told of it. */
		uint32_t pad;
		/* Time at which this gamepad was first seen in this place. */
		int64_t since_us;
		/* The gamepad's GUID as GLFW gives it; "": there is no gamepad in this place. */
		char guid[33];
		stilb_input_pad_state state;
	} places[STILB_WINDOW_GAMEPADS];
	/* Number of pads added to the control so far, from which the next pad gets its number. */
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
