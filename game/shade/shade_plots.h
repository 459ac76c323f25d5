/* The plots of `stilb shade plot`: a table of them for each topic, and one for each row, which is a formula, of
 * numeric's catalogue (numeric_catalog.h). [main-thread] */
#ifndef STILB_SHADE_PLOTS_H
#define STILB_SHADE_PLOTS_H

#include "shade_plot.h"

extern const plot_topic shade_plots_brdf, shade_plots_light, shade_plots_sg, shade_plots_sh, shade_plots_color,
	shade_plots_sampling;

typedef struct row_plot {
	plot plot; /* points to the texts below, so a row_plot must not be copied or moved */
	char title[64], formula[256];
} row_plot;

/* Copies a name as users type it, with '-' for each '_', cut to size. */
void shade_plot_typed(char *out, size_t size, const char *words);

/* Makes the plot of the row of numeric's catalogue with that name, in which '-' and '_' are the same. False: there is
 * no such row. */
bool shade_plot_of_row(const char *name, row_plot *out);

#endif
