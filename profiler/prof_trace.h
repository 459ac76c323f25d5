/*
 * prof_trace: a snapshot as a file that other programs read.
 *
 * Chrome trace JSON  for ui.perfetto.dev, speedscope, chrome://tracing: zones, frames, counters, instants, flows,
 *                    context switches. prof_read.h reads it back, exact to the nanosecond.
 * Folded stacks      for flame graphs: "lane;zone;zone inside NANOSECONDS" lines, self times.
 * CSV                one row a frame: its number, begin and length, the time in zones of each name, counters.
 *
 * Threads.  [any-thread]. The snapshot is only read.
 * Errors.   0 or a negative errno. Nothing here prints.
 */
#ifndef STILB_PROF_TRACE_H
#define STILB_PROF_TRACE_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where text goes, in pieces. write returns 0, or anything else to stop: the writers return that. */
typedef struct stilb_prof_sink {
	int (*write)(void *user, const void *data, size_t size);
	void *user;
} stilb_prof_sink;

/* Chrome trace JSON (Google, "Trace Event Format"), as both Perfetto and speedscope need it:
 *  - threads in the order of the lanes, "frames" first, with one slice and one mark for each frame;
 *  - zones are X events, parents before children, zones that are still open B events without an E; times in
 *    microseconds, three decimals, so exact nanoseconds. Viewers that add ts and dur as doubles lose zones that
 *    touch: an end that touches the next zone or the end of the parent is written a tenth of a nanosecond earlier, a
 *    tenth more for each level that touches; what has no length gets a tenth where there is room. Rounded to the
 *    nearest nanosecond all are exact again, if not more than four levels touch;
 *  - counters C, instants i, context switches as slices "sleeping" and "preempted" of a thread "<lane>: off the CPU";
 *  - flows s and f, those of which both ends are held: a job that has not run yet has no arrow;
 *  - otherData: the clock, its errors, and the accounts, with the number of flows that lack an end (flows_cut).
 * process_name NULL: the program's. Returns 0, what write returned, or -ENOMEM. */
int stilb_prof_trace_write_chrome(const stilb_prof_snapshot *snapshot, const char *process_name, stilb_prof_sink sink);

/* Folded stacks (Brendan Gregg, "FlameGraph"): self times in nanoseconds. ';' in names becomes ','. */
int stilb_prof_trace_write_folded(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink);

/* CSV (RFC 4180), times in milliseconds with six decimals. A column of zones holds the time in zones of that name
 * charged to the frame, over all lanes, so it may be longer than the frame; a zone inside another of its name does
 * not count again. A column of a counter holds its last value in the frame and is empty when there was none. */
int stilb_prof_trace_write_frames_csv(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink);

typedef enum stilb_prof_form {
	STILB_PROF_FORM_CHROME,
	STILB_PROF_FORM_FOLDED,
	STILB_PROF_FORM_FRAMES_CSV,
} stilb_prof_form;

/* By the ending of path, in small letters or capitals: .folded, .csv, anything else is Chrome trace JSON. */
stilb_prof_form stilb_prof_trace_form(const char *path);

/* True if the ending of path names a form: .json, .folded or .csv. For programs that refuse a name that says something
 * else than what would be written. */
bool stilb_prof_trace_is_named(const char *path);

/* 0 when path can become a file now, else why not: -ENOENT (no such folder), -EISDIR, -EACCES, ... Creates nothing. */
int stilb_prof_trace_check(const char *path);

/* Writes the form that path's ending names. A regular or new file is written under a temporary name in the same
 * folder, "<path>.<pid>.tmp", synced and renamed, links followed: after an error the old file is still there and
 * nothing new is, and what a killed process left behind is removed the next time. A device, a pipe and "-" (stdout) are
 * written directly. */
int stilb_prof_trace_save(const stilb_prof_snapshot *snapshot, const char *process_name, const char *path);

#ifdef __cplusplus
}
#endif
#endif
