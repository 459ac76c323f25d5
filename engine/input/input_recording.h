/*
 * input_recording: pads' events in a file and back: the text format of hid-recorder (hid-tools), which other programs read
 * and write too:
 *
 *   D: 0                         the pad's number in this file, from 0; lines that follow are about it. None: 0
 *   R: 507 05 01 09 05 ...       its report descriptor
 *   N: Wireless Controller       its name (optional)
 *   P: /dev/hidraw3              its path (optional)
 *   I: 3 054c 05c4               bus, vendor, product, hexadecimal
 *   E: 000001.250000 64 01 80 .. a report: time, size, bytes
 *   # ...                        a remark, which others skip. Two of them mean something here: "# added 000001.250000" is
 *                                when the pad whose description follows came, "# removed 000009.500000" when the pad of
 *                                the last D went. Without: the time of the line before
 *
 * Events come back with the same numbers, times and bytes as were written, times beginning at 0; a time before the one
 * above it counts as that, unless it is more than a second before one of the same pad: that is refused. Of a pad's info, `unique` and `device` are not kept.
 * Threads.  One thread's.
 */
#ifndef STILB_INPUT_RECORDING_H
#define STILB_INPUT_RECORDING_H

#include "input/input_pad.h"

typedef struct stilb_input_recorder stilb_input_recorder;

/* The file is written beside path and takes its name in close; "-" is standard output. STILB_ERROR_FILE. */
stilb_result stilb_input_recorder_create(const char *path, stilb_input_recorder **recorder);

/* DENIED and STATE events are left out, pads without a descriptor too, and what is said of pads that were not added here.
 * STILB_ERROR_FILE: the recording has failed; close will say so again. */
stilb_result stilb_input_recorder_add(stilb_input_recorder *recorder, const stilb_input_event *event);

/* Also after errors: then nothing is left, and what was there before stays. Without a report, too: STILB_ERROR_FILE. NULL
 * is fine. */
stilb_result stilb_input_recorder_close(stilb_input_recorder *recorder);

typedef struct stilb_input_recording stilb_input_recording;

/* Reads and checks all of it; "-" is standard input. STILB_ERROR_FILE names the line and what is wrong, or
 * says that there is no report. */
stilb_result stilb_input_recording_load(const char *path, stilb_input_recording **recording);
void stilb_input_recording_free(stilb_input_recording *recording);

/* The next event until `until_us`, the recording's time; false: none. */
bool stilb_input_recording_next(stilb_input_recording *recording, int64_t until_us, stilb_input_event *event);

/* Time of its last event. */
int64_t stilb_input_recording_end_us(const stilb_input_recording *recording);

#endif
