/* demo_gamepads: prints a line when a gamepad comes or goes while `stilb demo` runs. [main-thread] */
#ifndef STILB_DEMO_GAMEPADS_H
#define STILB_DEMO_GAMEPADS_H

#include "engine.h"

#include <stdio.h>

/* The gamepads that lines have been printed for; {0} at the start of the run. */
typedef struct demo_gamepads {
	struct {
		uint32_t pad; /* stilb_input_control_pad.pad */
		char name[64];
	} told[STILB_INPUT_PADS_MAX];
	uint32_t count;
	bool replayed; /* the end of the recording has been printed */
} demo_gamepads;

/* Prints the changes since the last call, for example "gamepad: Wireless Controller at /dev/hidraw3, known pad
 * 054c:05c4". A gamepad without permission is left out: the engine prints a line on it. replayed: the gamepad recording
 * has ended, which removes all its gamepads at once; one line says so. */
void demo_gamepads_say(demo_gamepads *gamepads, const stilb_engine *engine, bool replayed, FILE *out);

#endif
