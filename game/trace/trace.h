/*
 * stilb trace: analyses trace files, each the profile of a run: zones (named spans of time) on lanes (a thread or a
 * device each), and the frames of the run. trace.c has the command, trace_top.c the table of zones, trace_diff.c the
 * comparison of two files, trace_show.c the window, and trace_common.c the functions that these share, which are
 * declared here.
 *
 *   trace_files files = trace_take_files(1, &argc, &argv);
 *   stilb_prof_snapshot trace = {0};
 *   if (trace_check("top", &files, NULL) && trace_load(files.path[0], &trace))
 *       trace_print_summary(stdout, files.path[0], &trace);
 *   stilb_prof_snapshot_finish(&trace);
 *
 * Errors.   A function that returns false has printed one line on stderr that says why.
 * Threads.  All [main-thread].
 */
#ifndef STILB_TRACE_H
#define STILB_TRACE_H

#include "base/base_json.h"
#include "profiler/prof_snapshot.h"

#include <stdio.h>

/* The parts of the command, with arguments and results as in commands.h. */
int trace_top_command(int argc, char **argv);
int trace_diff_command(int argc, char **argv);
int trace_show_command(int argc, char **argv);

typedef struct trace_files {
	const char *path[2];
	int wanted, count; /* how many files the part needs, 1 or 2; how many the arguments name */
} trace_files;

/* Takes up to `wanted` files, 1 or 2, from the front of the arguments; argc and argv are left with the rest, which are
 * flags. */
trace_files trace_take_files(int wanted, int *argc, char ***argv);

/* True if all wanted files are named, and output, unless it is NULL, is none of them and can become a file. command is
 * the name of the part, for the message. */
bool trace_check(const char *command, const trace_files *files, const char *output);

/* Reads a trace, which must have zones. The caller finishes *trace (stilb_prof_snapshot_finish), also after an
 * error. */
bool trace_load(const char *path, stilb_prof_snapshot *trace);

/* Finds the frame that text names: its number in the file, or "slowest". *frame becomes its index in trace->frames.
 * file is the name of the trace, for the message. */
bool trace_choose_frame(const stilb_prof_snapshot *trace, const char *file, const char *text, uint32_t *frame);

/* Prints one line on the size of the trace, and one for each kind of data that it lacks. */
void trace_print_summary(FILE *out, const char *path, const stilb_prof_snapshot *trace);

/* Prints a zone's name, "(device)" if its lane is one, and the end of the line. Control characters become '?': the name
 * comes from the file, and must not control the terminal. */
void trace_print_name(FILE *out, const char *name, stilb_prof_lane_kind kind);

/* The number of zones on all lanes. */
uint64_t trace_zone_count(const stilb_prof_snapshot *trace);

/* Writes nanoseconds as a whole number; a larger one than 2^63 - 1 becomes 2^63 - 1. */
void trace_json_ns(stilb_json *json, const char *key, uint64_t ns);

static inline uint64_t trace_frame_ns(const stilb_prof_frame *frame)
{
	return frame->end_ns - frame->begin_ns;
}

static inline double trace_ms(uint64_t ns)
{
	return (double)ns * 1e-6;
}

static inline double trace_us(uint64_t ns)
{
	return (double)ns * 1e-3;
}

#endif
