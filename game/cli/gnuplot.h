/*
 * gnuplot: pictures of curves. A script is written, the program gnuplot draws it, and the picture is saved as every
 * output file is (base_file.h): whole or not at all.
 */
#ifndef STILB_GNUPLOT_H
#define STILB_GNUPLOT_H

#include "base/base.h"

#include <stdio.h>

/* Writes what comes after gnuplot's `set terminal` and `set output`. */
typedef void gnuplot_script(FILE *script, const void *context);

/* Whether the program is installed. */
bool gnuplot_found(void);

/* What to say when it is not. */
#define GNUPLOT_MISSING "gnuplot is not installed, or does not run (Debian package gnuplot-nox)"

/* Draws the script on a terminal, for example "pngcairo size 800,600", and saves the picture as path. svg_title: what a
 * picture of the terminal svg is called, free of '<' and '&'; NULL for other terminals.
 * STILB_ERROR_FILE: gnuplot failed (it has said why on stderr), or the file cannot be written. */
stilb_result gnuplot_save(const char *path, const char *terminal, const char *svg_title, gnuplot_script *script,
                          const void *context);

#endif
