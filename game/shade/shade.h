/* What the parts of `stilb shade` share. */
#ifndef STILB_SHADE_H
#define STILB_SHADE_H

#include "game/cli/flags.h"

/* The parts, as in commands.h. */
int shade_list_command(int argc, char **argv);
int shade_plot_command(int argc, char **argv);
int shade_table_command(int argc, char **argv);
int shade_spheres_command(int argc, char **argv);
int shade_catalog_command(int argc, char **argv);

/* stilb_error_message on stderr; returns code. */
int shade_complain(int code);

#endif
