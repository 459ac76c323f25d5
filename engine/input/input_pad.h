/*
 * input_pad: one gamepad as the engine sees every gamepad: two sticks, two triggers, sixteen buttons; what is known of
 * the device; and the events that tell of it.
 *
 * Life cycle.  Plain data. A stilb_input_pad_state of {0} is a pad at rest. Events come from input_pads.h (plugged in),
 *              input_recording.h (a file) or input_window.h (the window library) and go to input_control.h:
 *
 *     for (stilb_input_event event; stilb_input_pads_next(pads, now_us, &event);)
 *         if (event.kind == STILB_INPUT_PAD_ADDED)
 *             printf("%s came\n", event.info->name);
 *
 * Threads.     [any-thread]
 */
#ifndef STILB_INPUT_PAD_H
#define STILB_INPUT_PAD_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A stick is in [-1, 1], positive to the right and UP, 0 at rest. A trigger is in [0, 1], 0 at rest. */
typedef enum stilb_input_axis {
	STILB_INPUT_LEFT_X,
	STILB_INPUT_LEFT_Y,
	STILB_INPUT_RIGHT_X,
	STILB_INPUT_RIGHT_Y,
	STILB_INPUT_LEFT_TRIGGER,
	STILB_INPUT_RIGHT_TRIGGER,
	STILB_INPUT_AXIS_COUNT
} stilb_input_axis;

/* Named by position, because the letters differ: SOUTH is a DualShock's cross, an Xbox pad's A, a Switch pad's B. BACK
 * is also called share, create, view, minus; START options, menu, plus; GUIDE PS, Xbox, home. UP to RIGHT are the
 * d-pad. EXTRA is a touch pad's click, capture, or the share button of newer Xbox pads. */
typedef enum stilb_input_button {
	STILB_INPUT_SOUTH,
	STILB_INPUT_EAST,
	STILB_INPUT_WEST,
	STILB_INPUT_NORTH,
	STILB_INPUT_LEFT_SHOULDER,
	STILB_INPUT_RIGHT_SHOULDER,
	STILB_INPUT_BACK,
	STILB_INPUT_START,
	STILB_INPUT_GUIDE,
	STILB_INPUT_LEFT_STICK,
	STILB_INPUT_RIGHT_STICK,
	STILB_INPUT_UP,
	STILB_INPUT_DOWN,
	STILB_INPUT_LEFT,
	STILB_INPUT_RIGHT,
	STILB_INPUT_EXTRA,
	STILB_INPUT_BUTTON_COUNT
} stilb_input_button;

/* "left_x", ... and "south", ..., indexed by the enumerations. [any-thread] */
extern const char *const stilb_input_axis_names[STILB_INPUT_AXIS_COUNT];
extern const char *const stilb_input_button_names[STILB_INPUT_BUTTON_COUNT];

typedef struct stilb_input_pad_state {
	float axes[STILB_INPUT_AXIS_COUNT];
	/* Bit 1 << stilb_input_button is set while the button is down. */
	uint32_t buttons;
} stilb_input_pad_state;

/* Values of stilb_input_pad_info.bus. Source: BUS_USB and BUS_BLUETOOTH of linux/input.h. */
#define STILB_INPUT_BUS_USB 3u
#define STILB_INPUT_BUS_BLUETOOTH 5u

/* Bytes of the longest report descriptor. Source: HID_MAX_DESCRIPTOR_SIZE of linux/hidraw.h. */
#define STILB_INPUT_DESCRIPTOR_MAX 4096u

/* Bytes of the longest report, its id included. The kernel allows longer ones (HID_MAX_BUFFER_SIZE); no known pad has a
 * report nearly as long as this. */
#define STILB_INPUT_REPORT_MAX 4096u

/* All that can be known of a device without opening it. Texts are UTF-8 without control characters, end with a zero,
 * and are cut after the last whole character that fits. */
typedef struct stilb_input_pad_info {
	/* "/dev/hidraw3"; "window:0" for a pad that the window library reads; "" if a recording does not say it. */
	char path[64];
	/* The name that the device reports. */
	char name[128];
	/* Serial number or Bluetooth address, or "". */
	char unique[64];
	/* The device's folder in sysfs, links resolved, which also holds links to its driver and other nodes; or "". */
	char device[256];
	uint16_t bus, vendor, product;
	/* Bytes of the descriptor; 0: the pad has none. */
	uint16_t descriptor_size;
	uint8_t descriptor[STILB_INPUT_DESCRIPTOR_MAX];
} stilb_input_pad_info;

/* ADDED: a pad was opened and sends reports from now on. DENIED: a pad is plugged in but may not be opened (no
 * permission). Both have info. REMOVED: a pad that was ADDED or DENIED is gone. REPORT: bytes as the pad sent them.
 * STATE: sticks and buttons that the window library has decoded. */
typedef enum stilb_input_event_kind {
	STILB_INPUT_PAD_ADDED,
	STILB_INPUT_PAD_DENIED,
	STILB_INPUT_PAD_REMOVED,
	STILB_INPUT_PAD_REPORT,
	STILB_INPUT_PAD_STATE
} stilb_input_event_kind;

/* Pointers are valid until the next event is asked for. */
typedef struct stilb_input_event {
	stilb_input_event_kind kind;
	/* The pad's number, from 1. A pad that is unplugged and plugged in again gets another. */
	uint32_t pad;
	/* CLOCK_MONOTONIC, or a recording's own time; whole microseconds, as recordings keep no more. */
	int64_t time_us;
	/* Set for ADDED and DENIED; with other kinds it is NULL or the same as in the pad's ADDED. */
	const stilb_input_pad_info *info;
	/* For REPORT: size bytes as hidraw (Linux's interface to raw HID reports) gives them, 1..STILB_INPUT_REPORT_MAX;
	 * the first is the report's id if the pad numbers its reports. */
	const uint8_t *bytes;
	uint32_t size;
	/* For STATE: the sticks, triggers and buttons as the window library has decoded them. */
	stilb_input_pad_state state;
} stilb_input_event;

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
