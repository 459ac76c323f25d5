/* The table of `stilb shade table`. */
#ifndef STILB_SHADE_TABLE_H
#define STILB_SHADE_TABLE_H

#include "base/base.h"

/* Measures, and saves Markdown as path. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result shade_table_save(const char *path);

#endif
