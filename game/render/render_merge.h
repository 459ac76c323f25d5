/* offline_merge: `stilb render --merge PARTS... -o FILE`: a picture from the parts that --part made. [main-thread] */
#ifndef STILB_RENDER_MERGE_H
#define STILB_RENDER_MERGE_H

#include <stdbool.h>

/* True if --merge is among the arguments of `stilb render`. */
bool offline_merge_is_asked(int argc, char **argv);

/* Runs it, and returns the exit code. */
int offline_merge(int argc, char **argv);

#endif
