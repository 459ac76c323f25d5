/*
 * gnuplot: pictures of curves. The caller writes a script, the program gnuplot draws it in a temporary folder, and the
 * picture is saved like every other output file (base_file.h): whole or not at all.
 *
 *   static void write_line(FILE *script, const void *context)
 *   {
 *       fprintf(script, "plot %s notitle\n", (const char *)context);
 *   }
 *
 *   if (gnuplot_found() && gnuplot_save("sine.png", "pngcairo size 800,600", NULL, write_line, "sin(x)") != STILB_OK)
 *       stilb_log("%s", stilb_error_message());
 *
 * Threads.  All functions are [any-thread]: each call has a process and a folder of its own.
 */
#ifndef STILB_GNUPLOT_H
#define STILB_GNUPLOT_H

#include "base/base.h"

#include <stdio.h>

/* Writes the commands that follow gnuplot's `set terminal` and `set output`. It need not check the stream for
 * errors: gnuplot_save does. */
typedef void gnuplot_script(FILE *script, const void *context);

/* True if the program gnuplot is installed and runs. Starts it, which takes some milliseconds. */
bool gnuplot_found(void);

/* The message for when gnuplot_found returns false; the caller puts the name of its command in front. */
#define GNUPLOT_MISSING "gnuplot is not installed, or does not run (Debian package gnuplot-nox)"

/* Draws the script on a terminal, for example "pngcairo size 800,600", and saves the picture as path. svg_title is the
 * <title> of a picture of the terminal svg, without '<' and '&'; NULL for every other terminal. context goes to script.
 * STILB_ERROR_FILE: gnuplot failed (its own message is on stderr), or the file cannot be written. */
stilb_result gnuplot_save(const char *path, const char *terminal, const char *svg_title, gnuplot_script *script,
                          const void *context);

#endif
