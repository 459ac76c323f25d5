/*
 * input_layout: for one kind of pad: the bits of its reports that are sticks, triggers and buttons, how to tell a
 * damaged report, what to send when it is opened, and how to make it rumble.
 *
 *   descriptor, bus, vendor, product -> layout   a row of the table of known pads, else from the descriptor's fields
 *   layout, report                   -> state
 *
 * Life cycle.  A layout is a plain value, whichever way it was found:
 *
 *     static stilb_input_layout layout;
 *     stilb_input_pad_state state = {0};
 *     if (stilb_input_layout_find(&info, &layout) == STILB_OK &&
 *         stilb_input_decode(&layout, report, size, &state) == STILB_INPUT_DECODED)
 *         fly(state.axes[STILB_INPUT_LEFT_X], state.axes[STILB_INPUT_LEFT_Y]);
 *
 * Threads.     Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_LAYOUT_H
#define STILB_INPUT_LAYOUT_H

#include "input/hid/input_descriptor.h"

/* Meaning of a source's value, with its low and high:
 *   AXIS     target is a stilb_input_axis; low and high are the ends of the range, low may be the larger one. A stick
 *            is at rest in the middle, of an even number of values at the upper of the two middle ones (128 of 0..255);
 *            a trigger is at rest at low
 *   BUTTON   target is a stilb_input_button, which is down while the value of any of its sources is in [low, high]
 *   HAT      low is up, larger values follow clockwise, evenly spaced up to high; any other value is centred */
typedef enum stilb_input_source_kind {
	STILB_INPUT_SOURCE_AXIS,
	STILB_INPUT_SOURCE_BUTTON,
	STILB_INPUT_SOURCE_HAT
} stilb_input_source_kind;

/* A few adjacent bits of a report that give an axis, a button or the d-pad its value. */
typedef struct stilb_input_source {
	/* kind: a stilb_input_source_kind. target: the stilb_input_axis or stilb_input_button that gets the value. */
	uint8_t kind, target;
	/* Number of bits, 1..32; is_signed: the value is in two's complement. */
	uint8_t bits;
	bool is_signed;
	/* Number of the first bit, counted from the start of the report, whose first byte is the id if it has one. */
	uint32_t bit;
	/* See stilb_input_source_kind. */
	int64_t low, high;
} stilb_input_source;

/* Most sources of a report, and most reports of a layout; further ones are left out. */
#define STILB_INPUT_SOURCES_MAX 40u
#define STILB_INPUT_LAYOUT_REPORTS_MAX 4u

/* One of the reports that carry state. */
typedef struct stilb_input_layout_report {
	/* The report's id; 0: the pad's reports have no ids. */
	uint8_t id;
	/* Bytes of a whole report, id included. A shorter one leaves the state of the missing sources as it was. */
	uint16_t size;
	/* Byte of the report at which a little-endian CRC-32 begins, computed over Bluetooth's header byte 0xa1 and all
	 * bytes of the report before the CRC; 0: there is none. */
	uint16_t crc;
	/* Number of a bit, counted as in stilb_input_source. While it is set no pad is connected (to a wireless adaptor),
	 * and everything is at rest; 0: there is no such bit. */
	uint16_t absent;
	uint32_t source_count;
	stilb_input_source sources[STILB_INPUT_SOURCES_MAX];
} stilb_input_layout_report;

/* The format of the output report that makes the pad rumble. */
typedef enum stilb_input_rumble_kind {
	STILB_INPUT_RUMBLE_NONE,
	STILB_INPUT_RUMBLE_DS4_USB,
	STILB_INPUT_RUMBLE_DS4_BLUETOOTH,
	STILB_INPUT_RUMBLE_DUALSENSE_USB,
	STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH,
	STILB_INPUT_RUMBLE_XBOX_BLUETOOTH,
	STILB_INPUT_RUMBLE_SWITCH
} stilb_input_rumble_kind;

/* One step of what is said to a pad when it is opened. A step that fails does not matter: the pad is read anyway. */
typedef struct stilb_input_hello {
	enum { STILB_INPUT_HELLO_END, STILB_INPUT_HELLO_GET_FEATURE, STILB_INPUT_HELLO_WRITE } kind;
	/* Bytes to get, id included, or to write; 1..64. */
	uint8_t size;
	/* Milliseconds to wait after it. */
	uint16_t pause_ms;
	/* The report to write; the id of the feature to get. */
	uint8_t bytes[64];
} stilb_input_hello;

/* Steps, the last one being STILB_INPUT_HELLO_END. */
#define STILB_INPUT_HELLO_MAX 8u

typedef struct stilb_input_layout {
	/* Name for the user, like "DualShock 4, Bluetooth". */
	char name[64];
	/* The way it was found: "known pad 054c:05c4", "its descriptor: two sticks, ...". */
	char recognised[96];
	/* Found in the table of known pads. */
	bool known;
	uint32_t report_count;
	stilb_input_layout_report reports[STILB_INPUT_LAYOUT_REPORTS_MAX];
	stilb_input_rumble_kind rumble;
	stilb_input_hello hello[STILB_INPUT_HELLO_MAX];
} stilb_input_layout;

/* Finds the layout of a device. STILB_ERROR_ARGUMENT: it is not a gamepad (a keyboard, a mouse, ...), it has no report
 * descriptor, or a broken one; the message says which. [any-thread] */
stilb_result stilb_input_layout_find(const stilb_input_pad_info *info, stilb_input_layout *out);

/* DECODED: the state is new. OTHER: a valid report without state, like a battery's or an answer. CORRUPT: the CRC is
 * wrong, or the report is too short for any of its sources; the state is unchanged. */
typedef enum stilb_input_decoded { STILB_INPUT_DECODED, STILB_INPUT_OTHER, STILB_INPUT_CORRUPT } stilb_input_decoded;

/* Decodes a report of size bytes, as hidraw gives it. *state is the pad's last state, {0} at first, and becomes the new
 * one. Values outside a range count as its end. [any-thread] */
stilb_input_decoded stilb_input_decode(const stilb_input_layout *layout, const uint8_t *report, size_t size,
                                       stilb_input_pad_state *state);

/* Bytes of the longest output report. */
#define STILB_INPUT_OUTPUT_MAX 128u

/* Makes the output report that sets the strength of the heavy (left) and the light (right) motor; values outside [0, 1]
 * count as its ends. sequence is the number of rumble reports sent to this pad before. Returns the report's size in
 * bytes; 0: the pad has no known motors. [any-thread] */
size_t stilb_input_rumble_report(const stilb_input_layout *layout, float heavy, float light, uint32_t sequence,
                                 uint8_t report[STILB_INPUT_OUTPUT_MAX]);

/* CRC-32 of size bytes (reflected polynomial 0xedb88320), continued from crc, which is 0 at first. Source: IEEE 802.3,
 * section 3.2.9. [any-thread] */
uint32_t stilb_input_crc32(uint32_t crc, const void *data, size_t size);

#endif
