/*
 * input_recording: events of pads in a file and back, in the text format of hid-recorder (hid-tools), which other
 * programs read and write too:
 *
 *   D: 0                         the following lines are about pad 0 of this file, which is event.pad - 1; without a D
 *                                line they are about pad 0
 *   R: 507 05 01 09 05 ...       its report descriptor: size, bytes
 *   N: Wireless Controller       its name (optional)
 *   P: /dev/hidraw3              its path (optional)
 *   I: 3 054c 05c4               bus, vendor, product, hexadecimal
 *   E: 000001.250000 64 01 80 .. a report: time in seconds, size, bytes
 *   # ...                        a remark. Other programs skip all of them; here two have a meaning:
 *                                "# added 000001.250000" is the time at which the pad described next came, "# removed
 *                                000009.500000" the time at which the pad of the last D line went. Without a time they
 *                                are at the time of the line before.
 *
 * Events are read back with the numbers, times and bytes that were written, times beginning at 0. Of a pad's info,
 * `unique` and `device` are not kept. A time earlier than one before it in the file counts as equal to that one. If it
 * is more than a second before the last time of the same pad, the file is refused, because it is probably several
 * recordings in one.
 *
 * Life cycle.  recorder: create -> add for each event -> close. recording: load -> next until false -> free.
 *
 *     stilb_input_recorder_create("flight.rec", &recorder);
 *     while (stilb_input_pads_next(pads, now_us, &event))
 *         stilb_input_recorder_add(recorder, &event);
 *     if (stilb_input_recorder_close(recorder) != STILB_OK)
 *         fprintf(stderr, "%s\n", stilb_error_message());
 *
 * Threads.  [owner-thread]: all calls from the thread that created the recorder or loaded the recording; asserted.
 */
#ifndef STILB_INPUT_RECORDING_H
#define STILB_INPUT_RECORDING_H

#include "input/input_pad.h"

typedef struct stilb_input_recorder stilb_input_recorder;

/* Begins a temporary file beside path, which close renames to path; "-" is standard output. STILB_ERROR_FILE: no file
 * can be written there. STILB_ERROR_MEMORY. *recorder is NULL after an error. */
stilb_result stilb_input_recorder_create(const char *path, stilb_input_recorder **recorder);

/* Writes one event. Left out are DENIED and STATE, pads without a report descriptor, and events of pads whose ADDED was
 * not given to this recorder. STILB_ERROR_FILE: the recording has failed (disk full, more than 4096 pads or 2^24
 * reports); nothing more is written and close will return the same error. Asserts that a pad is added once.
 * [owner-thread] */
stilb_result stilb_input_recorder_add(stilb_input_recorder *recorder, const stilb_input_event *event);

/* Completes the file and frees the recorder. STILB_ERROR_FILE: writing failed, or there was no report, without which
 * the file could not be loaded; then no new file is left, and an older file at path stays. NULL is allowed.
 * [owner-thread] */
stilb_result stilb_input_recorder_close(stilb_input_recorder *recorder);

typedef struct stilb_input_recording stilb_input_recording;

/* Reads and checks the whole file; "-" is standard input. STILB_ERROR_FILE: it cannot be read, a line is wrong (the
 * message names line and reason), a pad lacks its R or I line, or there is no report. STILB_ERROR_MEMORY. *recording is
 * NULL after an error. */
stilb_result stilb_input_recording_load(const char *path, stilb_input_recording **recording);

/* NULL is allowed. [owner-thread] */
void stilb_input_recording_free(stilb_input_recording *recording);

/* The next event, if its time is at most until_us, microseconds from the recording's begin; false: there is none.
 * Events come in time order, each pad's ADDED first. What the event points to is valid until the recording is freed.
 * [owner-thread] */
bool stilb_input_recording_next(stilb_input_recording *recording, int64_t until_us, stilb_input_event *event);

/* Time of the last event, microseconds. [owner-thread] */
int64_t stilb_input_recording_end_us(const stilb_input_recording *recording);

#endif
