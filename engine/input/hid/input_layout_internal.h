/*
 * input_layout: what its files share: the rows of known pads, and the two ways to a layout.
 */
#ifndef STILB_INPUT_LAYOUT_INTERNAL_H
#define STILB_INPUT_LAYOUT_INTERNAL_H

#include "input/hid/input_layout.h"

/* What a numbered button of a descriptor can be besides a stilb_input_button. */
enum {
	INPUT_BUTTON_LEFT_TRIGGER = STILB_INPUT_BUTTON_COUNT, /* a trigger that is only on or off */
	INPUT_BUTTON_RIGHT_TRIGGER,
	INPUT_BUTTON_NONE
};

#define INPUT_BUTTONS_MAX 16u

/* What the buttons 1, 2, ... of a descriptor are. */
typedef struct input_button_order {
	const char *words; /* "in the usual order": what comes after the number of buttons */
	uint32_t count;
	uint8_t targets[INPUT_BUTTONS_MAX];
} input_button_order;

/* A row of the table of known pads (input_known.c). */
typedef struct input_known {
	const char *name;
	uint16_t bus; /* 0: any */
	uint16_t vendor, products[8];
	/* Its reports, ended by one of size 0, each one's sources by one of 0 bits. The row only counts where the
	 * descriptor has the first of them. NULL: what its descriptor says, with the buttons in this order, NULL: as they
	 * mostly are. */
	const stilb_input_layout_report *reports;
	const input_button_order *buttons;
	stilb_input_rumble_kind rumble;
	const stilb_input_hello *hello; /* ended by HELLO_END, or NULL */
} input_known;

/* The row of this pad; descriptor is its own, or NULL where it has none that can be read. NULL: there is no row. */
const input_known *input_known_find(const stilb_input_pad_info *info, const stilb_input_descriptor *descriptor);

/* Fills reports and rumble of the layout from a descriptor's fields, and says in words what was found. order NULL: the
 * most likely one. False: these are not the fields of a gamepad. */
bool input_layout_from_fields(const stilb_input_descriptor *descriptor, const input_button_order *order,
                              stilb_input_layout *out, char *found, size_t size);

#endif
