/* Which gamepads come and go while `stilb demo` runs, in words. */
#ifndef STILB_DEMO_GAMEPADS_H
#define STILB_DEMO_GAMEPADS_H

#include "engine.h"

#include <stdio.h>

/* Those that were told of; {0} at first. */
typedef struct demo_gamepads {
	struct {
		uint32_t pad; /* its number */
		char name[64];
	} told[STILB_INPUT_PADS_MAX];
	uint32_t count;
	bool replayed; /* the end of the recording was told of */
} demo_gamepads;

/* A line for each that came or went since it was last called. Those that may not be opened the engine tells of.
 * replayed: the recording is over, which lets go of all its pads and is one line. */
void demo_gamepads_say(demo_gamepads *gamepads, const stilb_engine *engine, bool replayed, FILE *out);

#endif
