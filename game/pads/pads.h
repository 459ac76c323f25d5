/*
 * stilb pads: gamepads as the engine sees them. pads.c has the command and its flags, pads_list.c lists what is plugged
 * in, pads_describe.c explains report descriptors (in which a device describes its reports), pads_follow.c follows
 * events, live or recorded, pads_view.c draws them in a terminal, and pads_common.c has what these share.
 */
#ifndef STILB_PADS_H
#define STILB_PADS_H

#include "base/base_json.h"
#include "input/device/input_pads.h"
#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "input/input_look.h"

#include <signal.h>
#include <stdio.h>

#define PADS_RUMBLE_MS 500
#define PADS_COLUMNS 80

typedef struct pads_options {
	const char *describe, *id, *record, *replay, *json; /* NULL: not given */
	int bus, backend;                                   /* index into the names that the flag accepts */
	bool watch, rumble;
	float seconds; /* 0: until Ctrl-C */
} pads_options;

extern const char *const pads_backends[];

/* The command runs one of these; each returns an exit code. */
int pads_list(const pads_options *o);
int pads_describe(const pads_options *o);
int pads_follow(const pads_options *o);

/* The stream for text: standard error if a recording goes to standard output, NULL (no text) if JSON goes there, else
 * standard output. */
FILE *pads_message_stream(const pads_options *o);

/* Starts looking for pads. */
stilb_result pads_open(const pads_options *o, stilb_input_pads **pads);

/* 1 after SIGINT, SIGTERM or SIGHUP, once pads_catch_signals was called. A second signal ends the program. */
extern volatile sig_atomic_t pads_interrupted;
void pads_catch_signals(void);

/* Returns the name of a bus number of Linux: "USB", "Bluetooth" or, written into text, "bus 0x18". */
const char *pads_bus_text(uint16_t bus, char text[16]);

/* Writes the names of the pressed buttons, one for each bit that is set: "south,left_shoulder"; "-" for none. */
#define PADS_BUTTONS_SIZE 256
const char *pads_buttons_text(uint32_t buttons, char text[PADS_BUTTONS_SIZE]);

/* Prints the title and the text, wrapped at blanks to PADS_COLUMNS; further lines are indented by the title's width. */
void pads_print_wrapped(FILE *out, const char *title, const char *text);

/* Writes the name of the pad's layout (the mapping of its reports to axes and buttons) and how it was recognised:
 * "DualShock 4, USB: known pad 054c:05c4". The layout's name is left out if it only repeats the pad's. */
#define PADS_RECOGNISED_SIZE 512
const char *pads_recognised_text(const stilb_input_control_pad *pad, char text[PADS_RECOGNISED_SIZE]);

/* True if the pad has motors that can be driven. */
bool pads_has_rumble(const stilb_input_pad_info *info);

/* Prints the udev rule that a pad without permission needs, and the file to put it into. */
void pads_print_rule(FILE *out, const stilb_input_pad_info *info);

/* Writes the members path, name, bus, vendor and product into the open JSON object. */
void pads_json_info(stilb_json *json, const stilb_input_pad_info *info);

/* ---- the terminal ------------------------------------------------------------------------------------------------ */

typedef struct pads_view {
	int lines;        /* number of lines that pads_view_draw wrote last */
	uint64_t rate_ns; /* time at which the rates were last measured */
	struct {
		uint32_t pad;
		uint64_t reports; /* of the pad until rate_ns */
		double rate;      /* reports a second */
	} rates[STILB_INPUT_PADS_MAX];
} pads_view;

/* begin hides the cursor, finish shows it again. */
void pads_view_begin(pads_view *view);
void pads_view_finish(void);

/* Draws all pads over the lines that it wrote last. time_us is the present time on the clock of the events. */
void pads_view_draw(pads_view *view, const stilb_input_control *control, int64_t time_us);

#endif
