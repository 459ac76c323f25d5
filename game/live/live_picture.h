/* live_picture: names for the pictures that are saved during a run. */
#ifndef STILB_LIVE_PICTURE_H
#define STILB_LIVE_PICTURE_H

#include <stdint.h>

/* Returns path if no file has that name yet, else path with "-2", "-3", ... before its extension, as captures are
 * numbered: no picture replaces an older one. last, or NULL, is the name of the picture that the run saves at its end,
 * which is not returned either. The caller frees the result; NULL: out of memory. [any-thread] */
char *live_picture_name(const char *path, const char *last);

/* Returns path with "-001" and so on before its extension, for pictures of a series, which replace those of an earlier
 * run. The caller frees the result; NULL: out of memory. [any-thread] */
char *live_picture_numbered(const char *path, uint32_t number);

#endif
