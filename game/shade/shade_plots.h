/* The tables of plots, one a topic, and plots of gi's catalogue. */
#ifndef STILB_SHADE_PLOTS_H
#define STILB_SHADE_PLOTS_H

#include "shade_plot.h"

extern const plot_topic shade_plots_brdf, shade_plots_light, shade_plots_sg, shade_plots_sh, shade_plots_color,
	shade_plots_sampling;

typedef struct row_plot {
	plot plot; /* refers to what is below */
	char title[64], formula[256];
} row_plot;

/* With '-' for each '_', as names are typed. */
void shade_plot_typed(char *out, size_t size, const char *words);

/* The row of gi's catalogue with that name ('-' or '_'); false: there is none. */
bool shade_plot_of_row(const char *name, row_plot *out);

#endif
