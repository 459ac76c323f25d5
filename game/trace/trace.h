/* What the parts of `stilb trace` share. */
#ifndef STILB_TRACE_H
#define STILB_TRACE_H

#include "base/base_json.h"
#include "profiler/prof_snapshot.h"

#include <stdio.h>

/* The parts, as in commands.h. */
int trace_top_command(int argc, char **argv);
int trace_diff_command(int argc, char **argv);
int trace_show_command(int argc, char **argv);

typedef struct trace_files {
	const char *path[2];
	int wanted, count;
} trace_files;

/* The files stand first; argc and argv are left with the rest, which are flags. wanted: 1 or 2. */
trace_files trace_take_files(int wanted, int *argc, char ***argv);

/* The files are all named, and output (may be NULL) is none of them and can become a file; else says why not. command:
 * the part's name. */
bool trace_check(const char *command, const trace_files *files, const char *output);

/* Reads a trace; false: it has said why not. */
bool trace_load(const char *path, stilb_prof_snapshot *trace);

/* text: a frame's number as the file counts them, or "slowest". False: it has said what there is. file: for that. */
bool trace_choose_frame(const stilb_prof_snapshot *trace, const char *file, const char *text, uint32_t *frame);

/* A line or two on what the file holds. */
void trace_print_what(FILE *out, const char *path, const stilb_prof_snapshot *trace);

/* The end of a table's line. Names come from the file: nothing in them moves the cursor of a terminal. */
void trace_print_name(FILE *out, const char *name, stilb_prof_lane_kind kind);

uint64_t trace_zones(const stilb_prof_snapshot *trace);
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
