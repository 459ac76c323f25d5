/*
 * prof_trace: writes a snapshot as a file that other programs read.
 *
 * Chrome trace JSON  for ui.perfetto.dev, speedscope and chrome://tracing: zones, frames, counters, instants, flows and
 *                    context switches. prof_read.h reads it back, exact to the nanosecond.
 * Folded stacks      for flame graphs: lines "lane;zone;zone inside NANOSECONDS" of self times.
 * CSV                one row per frame: number, begin, length, the time in the zones of each name, and counters.
 *
 * Example.  After stilb_prof_snapshot_take:
 *               int error = stilb_prof_trace_save(&snapshot, "my program", "trace.json"); // or .folded, or .csv
 *
 * Threads.  [any-thread]. The snapshot is only read; several threads may write the same one.
 * Errors.   0 or a negative errno. Nothing here prints.
 */
#ifndef STILB_PROF_TRACE_H
#define STILB_PROF_TRACE_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Receives the text in pieces of up to 256 KiB. write returns 0, or any other value to stop; the writers below return
 * that value. write is not NULL (asserted). */
typedef struct stilb_prof_sink {
	int (*write)(void *user, const void *data, size_t size);
	void *user; /* the first argument of write */
} stilb_prof_sink;

/* Writes Chrome trace JSON (Google, "Trace Event Format") as both Perfetto and speedscope need it:
 *  - threads in the order of the lanes; "frames" is the first, with one slice and one mark for each frame;
 *  - zones are X events, parents before children; zones that are still open are B events without an E. Times are in
 *    microseconds with three decimals, so exact nanoseconds. Viewers that add ts and dur as doubles lose zones that
 *    touch: therefore an end that touches the next zone or the end of the parent is written a tenth of a nanosecond
 *    earlier, and one more tenth for each level that touches; a zone without length gets a tenth where there is space.
 *    Rounded to the nearest nanosecond all are exact again, if at most four levels touch;
 *  - counters are C events, instants i; context switches are slices "sleeping" and "preempted" of a thread
 *    "<lane>: off the CPU";
 *  - flows are s and f events, if both ends are in the snapshot: a job that has not run yet has no arrow;
 *  - otherData holds the clock, its errors and the numbers of events, and how many flows lack an end (flows_cut).
 * process_name is shown by viewers; NULL stands for the program's name. Returns 0, the value of write, or -ENOMEM.
 * [any-thread] */
int stilb_prof_trace_write_chrome(const stilb_prof_snapshot *snapshot, const char *process_name, stilb_prof_sink sink);

/* Writes folded stacks (Brendan Gregg, "FlameGraph"): self times in nanoseconds, added up over all frames. A ';' in a
 * name becomes ','. Returns 0, the value of write, or -ENOMEM. [any-thread] */
int stilb_prof_trace_write_folded(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink);

/* Writes CSV (RFC 4180), times in milliseconds with six decimals. A column of zones holds the time in zones of that
 * name charged to the frame, added up over all lanes, so it may be longer than the frame; a zone inside another of its
 * name does not count again. A column of a counter holds its last value in the frame; it is empty if there was none.
 * Returns 0, the value of write, or -ENOMEM. [any-thread] */
int stilb_prof_trace_write_frames_csv(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink);

/* The formats above. */
typedef enum stilb_prof_form {
	STILB_PROF_FORM_CHROME,
	STILB_PROF_FORM_FOLDED,
	STILB_PROF_FORM_FRAMES_CSV,
} stilb_prof_form;

/* The format that the extension of path names, in lower or upper case: .folded, .csv; any other stands for Chrome trace
 * JSON. [any-thread] */
stilb_prof_form stilb_prof_trace_form(const char *path);

/* True if the extension of path is .json, .folded or .csv: for programs that refuse names which promise another format
 * than would be written. [any-thread] */
bool stilb_prof_trace_is_named(const char *path);

/* Checks if a file can be written at path now, without creating anything. Returns 0 or the reason why not: -ENOENT (no
 * such folder), -EISDIR, -EACCES and others. [any-thread] */
int stilb_prof_trace_check(const char *path);

/* Writes the format that the extension of path names. A regular or new file is written under a temporary name in its
 * folder, "<path>.<pid>.tmp", synced and renamed; links are followed. After an error the old file is unchanged and
 * there is no new one. Temporary files left by a process that was killed are removed the next time. A device, a pipe
 * and "-" (stdout) are written directly. Returns 0 or a negative errno. [any-thread] */
int stilb_prof_trace_save(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);

#ifdef __cplusplus
}
#endif
#endif
