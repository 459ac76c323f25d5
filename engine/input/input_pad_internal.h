/* input_pad_internal: what must hold for every state of a pad, for asserts. */
#ifndef STILB_INPUT_PAD_INTERNAL_H
#define STILB_INPUT_PAD_INTERNAL_H

#include "input/input_pad.h"

/* True if every axis is a number in its range, and no bit beyond the last button is set. [any-thread] */
bool input_pad_state_is_sound(const stilb_input_pad_state *state);

#endif
