/* info_materials: what frames and rays show of materials. [any-thread] */
#ifndef STILB_INFO_MATERIALS_H
#define STILB_INFO_MATERIALS_H

#include <stdio.h>

/* Prints a table of Markdown. */
void info_print_materials(FILE *out);

#endif
