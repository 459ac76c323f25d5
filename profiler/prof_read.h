/*
 * prof_read: reads a trace file back into a snapshot: files written by prof_trace.h exactly, and Chrome trace JSON of
 * other programs. Source of the format: Google, "Trace Event Format".
 *
 * What is read.   An object with traceEvents, or a bare array, whose end may be missing. The phases X, B, E, i, I, C,
 *                 s, t, f and M; others are ignored. One lane for each pid and tid that has zones or a name. Times are
 *                 decimal microseconds, rounded to the nearest nanosecond; they are never converted to double.
 * What is mended. Zones may come in any order; B and E of one thread must be in order of time. A zone that extends
 *                 beyond its parent is cut to it. If times are negative, all times are moved up until the earliest is
 *                 0.
 * Hostile files.  Any bytes give a snapshot, or an error that names the byte and what was expected there. Memory use is
 *                 bounded by the size of the file.
 * Example.
 *                     stilb_prof_snapshot snapshot = {0};
 *                     char error[256];
 *                     if (stilb_prof_trace_read("trace.json", &snapshot, error, sizeof error) != 0)
 *                         fprintf(stderr, "%s\n", error);
 *                     ...                                  // as after stilb_prof_snapshot_take
 *                     stilb_prof_snapshot_finish(&snapshot);
 *
 * Threads.        [any-thread], one thread at a time per snapshot.
 */
#ifndef STILB_PROF_READ_H
#define STILB_PROF_READ_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the trace text[0..size), which need not end in a 0 byte and is not needed afterwards. name stands for the file
 * in error messages. snapshot is {0} or an earlier one, whose contents are freed first. After an error snapshot is
 * empty and error holds one line without a newline, cut to error_size bytes including its 0 byte; error may be NULL if
 * error_size is 0. The other pointers are not NULL, text only if size is 0 (asserted).
 * Returns 0; -EBADMSG: not a trace, and error says where and why; -ENOMEM: no memory. [any-thread] */
int stilb_prof_trace_parse(const char *text, size_t size, const char *name, stilb_prof_snapshot *snapshot, char *error,
                           size_t error_size);

/* stilb_prof_trace_parse for the regular file at path; "-" is standard input, which may also be a pipe or a device.
 * Also returns the negative errno of the call that failed; -ESPIPE: path is a pipe or a device, which might never end.
 * error then says so in words. [any-thread] */
int stilb_prof_trace_read(const char *path, stilb_prof_snapshot *snapshot, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif
#endif
