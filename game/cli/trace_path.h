/* trace_path: checks, before a run, the name of the file that the run's trace (its profile) is to be written to. */
#ifndef STILB_TRACE_PATH_H
#define STILB_TRACE_PATH_H

#include <stdbool.h>

/* True if path may become a trace: it ends in .json, .folded or .csv, which selects the format, or it is standard
 * output ("-"), a device or a pipe, whose name may have any ending, or NULL (no trace is wanted). Else false, after a
 * line on stderr that names the flag, for example "--trace". [any-thread] */
bool trace_path_check(const char *flag, const char *path);

#endif
