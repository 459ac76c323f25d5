/*
 * stilb pads: gamepads, as the engine sees them. pads.c has the flags, pads_list.c what is plugged in, pads_describe.c
 * report descriptors, pads_follow.c what happens to pads, live or recorded, and pads_view.c how that looks in a terminal.
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
	int bus, backend;                                   /* indices of their choices */
	bool watch, rumble;
	float seconds; /* 0: without end */
} pads_options;

extern const char *const pads_backends[];

/* The parts. Each returns an exit code. */
int pads_list(const pads_options *o);
int pads_describe(const pads_options *o);
int pads_follow(const pads_options *o);

/* Where words go: standard output, or, where a recording goes there, standard error. NULL: JSON goes there, which says it
 * all. */
FILE *pads_words(const pads_options *o);

/* Starts looking for pads. */
stilb_result pads_open(const pads_options *o, stilb_input_pads **pads);

/* From here on SIGINT and its like set pads_interrupted; a second one kills. */
extern volatile sig_atomic_t pads_interrupted;
void pads_catch_signals(void);

/* "USB", "Bluetooth", "bus 0x18". */
const char *pads_bus_text(uint16_t bus, char text[16]);

/* "south, left_shoulder", or "-". */
#define PADS_BUTTONS_SIZE 256
const char *pads_buttons_text(uint32_t buttons, char text[PADS_BUTTONS_SIZE]);

/* Text after a title, broken at blanks; what comes after the first line stands below it. */
void pads_print_wrapped(FILE *out, const char *title, const char *text);

/* "DualShock 4, USB: known pad 054c:05c4"; without the name of its layout where that is only the pad's own. */
#define PADS_RECOGNISED_SIZE 512
const char *pads_recognised_text(const stilb_input_control_pad *pad, char text[PADS_RECOGNISED_SIZE]);

/* Whether it is of those that can be made to shake. */
bool pads_shakes(const stilb_input_pad_info *info);

/* Says which rule a pad without permission wants, and where it goes. */
void pads_print_rule(FILE *out, const stilb_input_pad_info *info);

/* The members that tell a pad: path, name, bus, vendor, product. */
void pads_json_info(stilb_json *json, const stilb_input_pad_info *info);

/* ---- the terminal -------------------------------------------------------------------------------------------------- */

typedef struct pads_view {
	int lines;        /* of the last picture */
	uint64_t rate_ns; /* when the rates were taken */
	struct {
		uint32_t pad;
		uint64_t reports; /* then */
		double rate;      /* reports a second */
	} rates[STILB_INPUT_PADS_MAX];
} pads_view;

/* Hides the cursor; finish shows it again. */
void pads_view_begin(pads_view *view);
void pads_view_finish(void);

/* Draws all pads over the last picture. time_us is the time of the events. */
void pads_view_draw(pads_view *view, const stilb_input_control *control, int64_t time_us);

#endif
