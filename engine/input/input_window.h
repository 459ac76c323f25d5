/*
 * input_window: the gamepads that the window library reads, for pads without a hidraw node (Xbox pads over USB) and for
 * those whose node may not be opened.
 *
 * A pad that is read directly is left out here: one pad never appears twice. The library does not say which device it has
 * opened, only bus, vendor and product of it, which the kernel copies from the HID device to its input device, and the
 * name. So of several equal pads the library's are left out as soon as one of them is read directly. As the library may be
 * quicker to see a pad than it can be opened directly, a new one has to be there for STILB_INPUT_WINDOW_WAIT_US first.
 *
 * Threads.  The control's; no I/O.
 */
#ifndef STILB_INPUT_WINDOW_H
#define STILB_INPUT_WINDOW_H

#include "input/input_control.h"
#include "window/window.h"

#define STILB_INPUT_WINDOW_WAIT_US 500000

/* {0} at first. */
typedef struct stilb_input_window {
	struct {
		uint32_t pad;     /* its number; 0: not told of */
		int64_t since_us; /* first seen */
		char guid[33];    /* "": there is none */
		stilb_input_pad_state state;
	} places[STILB_WINDOW_GAMEPADS];
	uint32_t told; /* pads so far */
} stilb_input_window;

/* Tells the control what has changed, once a frame: pads that came and went, and what they do, as events of time_us. Those
 * of the control that are not from here are read directly. */
void stilb_input_window_feed(stilb_input_window *window, const stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS],
                             int64_t time_us, stilb_input_control *control);

/* The pad as all of them are. [any-thread] */
stilb_input_pad_state stilb_input_window_state(const stilb_window_gamepad *gamepad);

/* Whether the gamepad of this GUID and name is the pad, or its equal. [any-thread] */
bool stilb_input_window_same(const char *guid, const char *name, const stilb_input_pad_info *info);

#endif
