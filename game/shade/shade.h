/*
 * stilb shade: shows the formulas of engine/shading. Its parts are `list`, `plot` and `catalog` (shade_draw.c), `table`
 * (shade_table.c) and `spheres` (shade_spheres.c); shade.c runs the one that the user names. shade_plot.h makes
 * diagrams, shade_plots.h lists them, shade_strip.h draws rows of spheres. All [main-thread].
 */
#ifndef STILB_SHADE_H
#define STILB_SHADE_H

#include "game/cli/flags.h"

/* The parts of the command, with arguments and results as in commands.h. */
int shade_list_command(int argc, char **argv);
int shade_plot_command(int argc, char **argv);
int shade_table_command(int argc, char **argv);
int shade_spheres_command(int argc, char **argv);
int shade_catalog_command(int argc, char **argv);

/* Prints stilb_error_message on stderr. Returns code. */
int shade_complain(int code);

#endif
