/* A table of actions for tests of input: one row of each kind that keys and buttons have. */
#ifndef TESTS_INPUT_ACTIONS_H
#define TESTS_INPUT_ACTIONS_H

#include "input/input_actions.h"

enum {
	CAPTURE = STILB_INPUT_ACTIONS,
	SCREENSHOT,
	OVERLAY,
	INSPECTOR,
	FREEZE,
	NEXT_VIEW,
	MORE,
	FEWER,
	FRAME,
	CANCEL,
	GRAB,
	END
};
static const stilb_input_action action_rows[] = {
	{.name = "capture", .keys = {STILB_WINDOW_KEY_P}, .pad = STILB_INPUT_PAD(WEST), .help = "save a trace"},
	{.name = "screenshot",
     .keys = {STILB_WINDOW_KEY_F12},
     .pad = STILB_INPUT_PAD(BACK),
     .main = true,
     .help = "save a picture"},
	{.name = "overlay",
     STILB_INPUT_SWITCH,
     {STILB_WINDOW_KEY_F1},
     .pad = STILB_INPUT_PAD(NORTH) | STILB_INPUT_PAD(EXTRA),
     .help = "the profiler"},
	{.name = "inspector",
     STILB_INPUT_SWITCH,
     {STILB_WINDOW_KEY_F2},
     .pad = STILB_INPUT_PAD(START),
     .help = "the materials"},
	{.name = "freeze", STILB_INPUT_SWITCH, {STILB_WINDOW_KEY_SPACE}, .pad = STILB_INPUT_PAD(SOUTH), .help = "freeze"},
	{.name = "next view",
     .keys = {STILB_WINDOW_KEY_V},
     .pad = STILB_INPUT_PAD(EAST) | STILB_INPUT_PAD(RIGHT),
     .help = "next view"},
	{.name = "more", .typed = "+=", .pad = STILB_INPUT_PAD(UP), .help = "workers"},
	{.name = "fewer", .typed = "-", .pad = STILB_INPUT_PAD(DOWN), .help = "workers"},
	{.name = "frame", .keys = {STILB_WINDOW_KEY_F, STILB_WINDOW_KEY_HOME}, .help = "frame"},
	{.name = "cancel", .keys = {STILB_WINDOW_KEY_ESCAPE}, .help = "give up"},
	{.name = "grab", STILB_INPUT_HELD, {STILB_WINDOW_KEY_G}, .pad = STILB_INPUT_PAD(LEFT), .help = "grab"},
};

static inline stilb_input_table action_table(void)
{
	stilb_input_table table = stilb_input_table_camera();
	stilb_input_table_add(&table, action_rows, END - STILB_INPUT_ACTIONS);
	return table;
}

#endif
