/* Names of files that are to become traces. */
#ifndef STILB_TRACE_PATH_H
#define STILB_TRACE_PATH_H

#include <stdbool.h>

/* False after a line that refuses path, the value of the flag of this name: its ending names none of the forms that
 * traces have. Standard output, devices and pipes may have any name. NULL is fine. */
bool trace_path_check(const char *flag, const char *path);

#endif
