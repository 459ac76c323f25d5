/* input_recording_internal: the limits that writer and reader of recordings share, and reading one from any stream. */
#ifndef STILB_INPUT_RECORDING_INTERNAL_H
#define STILB_INPUT_RECORDING_INTERNAL_H

#include "input/input_recording.h"

#include <stdio.h>

#define INPUT_RECORDING_PADS_MAX 4096u
#define INPUT_RECORDING_REPORTS_MAX (1u << 24) /* more than four hours of 1000 reports a second */

/* stilb_input_recording_load from an open stream, which stays open; error messages call it `name`. [any-thread] */
stilb_result input_recording_read(FILE *stream, const char *name, stilb_input_recording **recording);

#endif
