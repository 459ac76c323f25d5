/* shade_table: measures the formulas of numeric's catalogue (numeric_catalog.h). [main-thread] */
#ifndef STILB_SHADE_TABLE_H
#define STILB_SHADE_TABLE_H

#include "base/base.h"

/* Measures, which takes seconds, and saves the table in Markdown as path. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result shade_table_save(const char *path);

#endif
