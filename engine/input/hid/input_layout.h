/*
 * input_layout: where in a pad's reports its sticks, triggers and buttons are, whether a report is sound, what to say
 * to the pad at first, and how it is made to shake.
 *
 *   descriptor, bus, vendor, product -> layout   the table of known pads (input_known.c), else the descriptor's fields
 *   layout, report -> state
 *
 * A layout is plain data: the table's rows and what is found by the descriptor are the same kind of thing.
 * Pure functions of their arguments. [any-thread]
 */
#ifndef STILB_INPUT_LAYOUT_H
#define STILB_INPUT_LAYOUT_H

#include "input/hid/input_descriptor.h"

/* What a value means, by low and high:
 *   AXIS     target: stilb_input_axis; the ends of its range, low may be the greater. A stick rests in the middle, of
 *            an even number of values at the upper of both (128 of 0..255), a trigger at low
 *   BUTTON   target: stilb_input_button; down where the value is in [low, high], of any of its sources
 *   HAT      low is up, the following go clockwise, evenly around, to high; any other value: centred */
typedef enum stilb_input_source_kind {
	STILB_INPUT_SOURCE_AXIS,
	STILB_INPUT_SOURCE_BUTTON,
	STILB_INPUT_SOURCE_HAT
} stilb_input_source_kind;

/* A few bits of one report. */
typedef struct stilb_input_source {
	uint8_t kind, target;
	uint8_t bits; /* 1..32 */
	bool is_signed;
	uint32_t bit; /* from the start of the report, id included */
	int64_t low, high;
} stilb_input_source;

#define STILB_INPUT_SOURCES_MAX 40u
#define STILB_INPUT_LAYOUT_REPORTS_MAX 4u

/* One of the reports that carry state. */
typedef struct stilb_input_layout_report {
	uint8_t id;      /* 0: the reports have no numbers */
	uint16_t size;   /* bytes of a whole one; shorter ones keep the old state of what they lack */
	uint16_t crc;    /* offset of a CRC-32, little endian, over 0xa1 and all bytes before it; 0: none */
	uint16_t absent; /* where this bit is set no pad is there, and all is at rest: a wireless adaptor's; 0: none */
	uint32_t source_count;
	stilb_input_source sources[STILB_INPUT_SOURCES_MAX];
} stilb_input_layout_report;

typedef enum stilb_input_rumble_kind {
	STILB_INPUT_RUMBLE_NONE,
	STILB_INPUT_RUMBLE_DS4_USB,
	STILB_INPUT_RUMBLE_DS4_BLUETOOTH,
	STILB_INPUT_RUMBLE_DUALSENSE_USB,
	STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH,
	STILB_INPUT_RUMBLE_XBOX_BLUETOOTH,
	STILB_INPUT_RUMBLE_SWITCH
} stilb_input_rumble_kind;

/* What is said to a pad when it is opened, in order; all of it may fail, the pad is read all the same. */
typedef struct stilb_input_hello {
	enum { STILB_INPUT_HELLO_END, STILB_INPUT_HELLO_GET_FEATURE, STILB_INPUT_HELLO_WRITE } kind;
	uint8_t size;      /* bytes to get (id included) or to write */
	uint16_t pause_ms; /* after it */
	uint8_t bytes[64]; /* what to write; the feature's id first */
} stilb_input_hello;

#define STILB_INPUT_HELLO_MAX 8u

typedef struct stilb_input_layout {
	char name[64];       /* "DualShock 4, Bluetooth" */
	char recognised[96]; /* how: "known pad 054c:05c4", "its descriptor: two sticks, ..." */
	bool known;          /* by the table */
	uint32_t report_count;
	stilb_input_layout_report reports[STILB_INPUT_LAYOUT_REPORTS_MAX];
	stilb_input_rumble_kind rumble;
	stilb_input_hello hello[STILB_INPUT_HELLO_MAX];
} stilb_input_layout;

/* STILB_ERROR_ARGUMENT: it is no gamepad (a keyboard, a mouse, ...) or its descriptor is broken; the message says
 * which. */
stilb_result stilb_input_layout_find(const stilb_input_pad_info *info, stilb_input_layout *out);

typedef enum stilb_input_decoded {
	STILB_INPUT_DECODED, /* *state is new */
	STILB_INPUT_OTHER,   /* a sound report without state: battery, answers */
	STILB_INPUT_CORRUPT  /* a wrong CRC, or shorter than anything of it; *state is unchanged */
} stilb_input_decoded;

/* *state is the pad's last one, and becomes the new one. */
stilb_input_decoded stilb_input_decode(const stilb_input_layout *layout, const uint8_t *report, size_t size,
                                       stilb_input_pad_state *state);

/* The report that makes it shake: the heavy and the light motor, 0..1. sequence counts the reports sent. Returns its
 * size, 0: it cannot shake. */
#define STILB_INPUT_OUTPUT_MAX 128u
size_t stilb_input_rumble_report(const stilb_input_layout *layout, float heavy, float light, uint32_t sequence,
                                 uint8_t report[STILB_INPUT_OUTPUT_MAX]);

/* CRC-32 of IEEE 802.3 (reflected 0xedb88320), continued from crc; 0 at first. */
uint32_t stilb_input_crc32(uint32_t crc, const void *data, size_t size);

#endif
