/* live_gamepads: prints a line when a gamepad comes or goes during a live run. [main-thread] */
#ifndef STILB_LIVE_GAMEPADS_H
#define STILB_LIVE_GAMEPADS_H

#include "engine.h"

#include <stdio.h>

/* The gamepads that lines have been printed for; {0} at the start of the run. */
typedef struct live_gamepads {
	struct {
		uint32_t pad; /* stilb_input_control_pad.pad */
		char name[64];
	} told[STILB_INPUT_PADS_MAX];
	uint32_t count;
	bool replayed; /* the end of the recording has been printed */
} live_gamepads;

/* Prints the changes since the last call, for example "gamepad: Wireless Controller at /dev/hidraw3, known pad
 * 054c:05c4". A gamepad without permission is left out: the engine prints a line on it. replayed: the gamepad recording
 * has ended, which removes all its gamepads at once; one line says so. */
void live_gamepads_say(live_gamepads *gamepads, const stilb_engine *engine, bool replayed, FILE *out);

#endif
