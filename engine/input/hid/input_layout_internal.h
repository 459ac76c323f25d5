/*
 * input_layout_internal: a row of the table of known pads, and the two ways to a layout: by the table, by the
 * descriptor.
 */
#ifndef STILB_INPUT_LAYOUT_INTERNAL_H
#define STILB_INPUT_LAYOUT_INTERNAL_H

#include "input/hid/input_layout.h"

/* Meanings of a descriptor's numbered button besides those of stilb_input_button. */
enum {
	INPUT_BUTTON_LEFT_TRIGGER = STILB_INPUT_BUTTON_COUNT, /* a trigger that is only on or off */
	INPUT_BUTTON_RIGHT_TRIGGER,
	INPUT_BUTTON_NONE
};

#define INPUT_BUTTONS_MAX 16u

/* Meaning of the buttons 1, 2, ... of a descriptor. */
typedef struct input_button_order {
	const char *words; /* "in the usual order": follows the number of buttons in stilb_input_layout.recognised */
	uint32_t count;
	uint8_t targets[INPUT_BUTTONS_MAX]; /* [count] of button 1, 2, ...: stilb_input_button or INPUT_BUTTON_... */
} input_button_order;

/* A row of the table of known pads (input_known.c). */
typedef struct input_known {
	const char *name;
	uint16_t bus; /* 0: pads on any bus */
	uint16_t vendor, products[8];
	/* Its reports, ended by one of size 0; the sources of each are ended by one of 0 bits. A pad whose descriptor lacks
	 * the first of these reports is not of this row. NULL: the reports are found by the descriptor's fields. */
	const stilb_input_layout_report *reports;
	/* Order of the buttons if reports is NULL; NULL: the most likely one. */
	const input_button_order *buttons;
	stilb_input_rumble_kind rumble;
	const stilb_input_hello *hello; /* ended by STILB_INPUT_HELLO_END, or NULL */
} input_known;

/* The row of the table for this pad, or NULL. descriptor is the pad's own, NULL if it has none or a broken one. */
const input_known *input_known_find(const stilb_input_pad_info *info, const stilb_input_descriptor *descriptor);

/* Fills reports and rumble of the layout from a descriptor's fields, and writes into `found`, of size bytes, what was
 * found in words. order NULL: the most likely one. False: these are not the fields of a gamepad. */
bool input_layout_from_fields(const stilb_input_descriptor *descriptor, const input_button_order *order,
                              stilb_input_layout *out, char *found, size_t size);

/* True if every source has a target that exists, and its bits are within its report. [any-thread] */
bool input_layout_is_sound(const stilb_input_layout *layout);

#endif
