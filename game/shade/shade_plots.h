/* The plots: a table for each topic, and a plot for each row of numeric's catalogue. [main-thread] */
#ifndef STILB_SHADE_PLOTS_H
#define STILB_SHADE_PLOTS_H

#include "shade_plot.h"

extern const plot_topic shade_plots_brdf, shade_plots_light, shade_plots_sg, shade_plots_sh, shade_plots_color,
	shade_plots_sampling;

typedef struct row_plot {
	plot plot; /* its texts are the arrays below: not to be copied or moved */
	char title[64], formula[256];
} row_plot;

/* Copies a name as it is typed, with '-' for each '_', cut to size. */
void shade_plot_typed(char *out, size_t size, const char *words);

/* Makes the plot of the row of numeric's catalogue with that name, in which '-' and '_' are the same. False: there is
 * no such row. */
bool shade_plot_of_row(const char *name, row_plot *out);

#endif
