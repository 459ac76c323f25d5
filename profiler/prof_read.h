/*
 * prof_read: a trace file back into a snapshot: those that prof_trace.h writes, exactly, and Chrome trace JSON of other
 * programs. Source of the format: Google, "Trace Event Format".
 *
 * What is read.   An object with traceEvents, or a bare array, which may lack its end; phases X, B, E, i, I, C, s, t, f
 *                 and M. One lane for each pid and tid with zones or a name. Other phases are left out. Times are
 *                 decimal microseconds, never doubles: to the nearest nanosecond.
 * What is mended. Zones may come in any order, B and E of a thread in that of time. A zone that sticks out of its
 *                 parent is cut to it. Times before 0 move all others up.
 * Hostile files.  Any bytes give a snapshot or an error that names the byte and what was expected there. Memory is
 *                 bounded by the size of the file.
 * Threads.        [any-thread], one thread at a time per snapshot.
 */
#ifndef STILB_PROF_READ_H
#define STILB_PROF_READ_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a trace of size bytes. name stands for the file in error, one line without its newline and at most error_size
 * bytes with the 0 at its end; error may be NULL. Returns 0, -EBADMSG (no trace: error says where and why) or -ENOMEM.
 * The snapshot is {0} or one of before, stilb_prof_snapshot_finish frees it, and after an error it is empty. */
int stilb_prof_trace_parse(const char *text, size_t size, const char *name, stilb_prof_snapshot *snapshot, char *error,
                           size_t error_size);

/* The same from a regular file; "-" is standard input, whatever that is. Also the negative errno of what failed, and
 * error says so in words; -ESPIPE: a pipe or a device. */
int stilb_prof_trace_read(const char *path, stilb_prof_snapshot *snapshot, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif
#endif
