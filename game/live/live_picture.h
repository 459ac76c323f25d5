/* live_picture: names for the pictures that are saved during a run. */
#ifndef STILB_LIVE_PICTURE_H
#define STILB_LIVE_PICTURE_H

#include "base/base.h"

/* Creates an empty file of the name path, or, if there is such a file, with "-2", "-3", ... before its extension, as
 * captures are numbered: no picture replaces an older one, and nobody else takes the name meanwhile. last, or NULL, is
 * the name of the picture that the run saves at its end, which is not taken either. The caller frees *name, which is
 * NULL after an error. STILB_ERROR_FILE: no file can be created. STILB_ERROR_MEMORY. [any-thread] */
stilb_result live_picture_reserve(const char *path, const char *last, char **name);

/* Finds a name for a series of count pictures, 1 or more: path, or, if there is a file of any of its numbered names,
 * path with "-2", "-3", ... before its extension. The caller frees *series, which is NULL after an error.
 * STILB_ERROR_MEMORY. [any-thread] */
stilb_result live_picture_series(const char *path, uint32_t count, char **series);

/* Creates an empty file of the series' name with "-001" and so on before its extension. The caller frees *name, which
 * is NULL after an error. STILB_ERROR_FILE: it cannot be created, also because there is one meanwhile.
 * STILB_ERROR_MEMORY. [any-thread] */
stilb_result live_picture_reserve_numbered(const char *series, uint32_t number, char **name);

#endif
