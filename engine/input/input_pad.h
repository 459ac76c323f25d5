/*
 * input_pad: one gamepad as all of them look alike: two sticks, two triggers, sixteen buttons; and what is known of the
 * thing that it is.
 *
 * Plain data. [any-thread]
 */
#ifndef STILB_INPUT_PAD_H
#define STILB_INPUT_PAD_H

#include "base/base.h"

/* Sticks are in [-1, 1], to the right and UP positive, 0 at rest; triggers are in [0, 1]. */
typedef enum stilb_input_axis {
	STILB_INPUT_LEFT_X,
	STILB_INPUT_LEFT_Y,
	STILB_INPUT_RIGHT_X,
	STILB_INPUT_RIGHT_Y,
	STILB_INPUT_LEFT_TRIGGER,
	STILB_INPUT_RIGHT_TRIGGER,
	STILB_INPUT_AXIS_COUNT
} stilb_input_axis;

/* By place, as the letters on them differ: SOUTH is a DualShock's cross, an Xbox pad's A, a Switch pad's B. */
typedef enum stilb_input_button {
	STILB_INPUT_SOUTH,
	STILB_INPUT_EAST,
	STILB_INPUT_WEST,
	STILB_INPUT_NORTH,
	STILB_INPUT_LEFT_SHOULDER,
	STILB_INPUT_RIGHT_SHOULDER,
	STILB_INPUT_BACK,  /* share, create, view, minus */
	STILB_INPUT_START, /* options, menu, plus */
	STILB_INPUT_GUIDE, /* PS, Xbox, home */
	STILB_INPUT_LEFT_STICK,
	STILB_INPUT_RIGHT_STICK,
	STILB_INPUT_UP, /* the cross of directions */
	STILB_INPUT_DOWN,
	STILB_INPUT_LEFT,
	STILB_INPUT_RIGHT,
	STILB_INPUT_EXTRA, /* touch pad, capture, share of newer Xbox pads */
	STILB_INPUT_BUTTON_COUNT
} stilb_input_button;

/* "left_x", ... and "south", ...; in the order of the enumerations. */
extern const char *const stilb_input_axis_names[STILB_INPUT_AXIS_COUNT];
extern const char *const stilb_input_button_names[STILB_INPUT_BUTTON_COUNT];

/* {0} is a pad at rest. */
typedef struct stilb_input_pad_state {
	float axes[STILB_INPUT_AXIS_COUNT];
	uint32_t buttons; /* bit 1 << stilb_input_button: is down */
} stilb_input_pad_state;

#define STILB_INPUT_BUS_USB 3u /* linux/input.h: BUS_USB, BUS_BLUETOOTH */
#define STILB_INPUT_BUS_BLUETOOTH 5u

#define STILB_INPUT_DESCRIPTOR_MAX 4096u /* bytes; HID_MAX_DESCRIPTOR_SIZE of linux/hidraw.h */
#define STILB_INPUT_REPORT_MAX 4096u     /* bytes, the id included; HID_MAX_BUFFER_SIZE is larger, no pad's report is */

/* What can be known of a pad without opening it. Texts are UTF-8 without control characters, cut where they are too
 * long. */
typedef struct stilb_input_pad_info {
	char path[64];    /* "/dev/hidraw3"; "window:0" for one that the window library reads */
	char name[128];   /* as it calls itself */
	char unique[64];  /* serial number or Bluetooth address, or "" */
	char device[256]; /* its folder in sysfs, links followed: where its driver and its other nodes are; or "" */
	uint16_t bus, vendor, product;
	uint16_t descriptor_size; /* 0: it has none */
	uint8_t descriptor[STILB_INPUT_DESCRIPTOR_MAX];
} stilb_input_pad_info;

/* What happened to a pad. */
typedef enum stilb_input_event_kind {
	STILB_INPUT_PAD_ADDED,   /* info; from now on it reports */
	STILB_INPUT_PAD_DENIED,  /* info; it is there and may not be opened: permission */
	STILB_INPUT_PAD_REMOVED, /* a pad of ADDED or DENIED is gone */
	STILB_INPUT_PAD_REPORT,  /* bytes */
	STILB_INPUT_PAD_STATE    /* state, already decoded (the window library does) */
} stilb_input_event_kind;

typedef struct stilb_input_event {
	stilb_input_event_kind kind;
	uint32_t pad;    /* its number, from 1; a pad that comes back has another */
	int64_t time_us; /* CLOCK_MONOTONIC, or a recording's own time, in whole microseconds: what a recording keeps */
	/* By kind; valid until the next event is asked for. */
	const stilb_input_pad_info *info;
	const uint8_t *bytes; /* the report as hidraw gives it: the id first where the pad numbers its reports */
	uint32_t size;
	stilb_input_pad_state state;
} stilb_input_event;

#endif
