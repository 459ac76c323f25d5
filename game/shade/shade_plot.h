/*
 * shade_plot: diagrams of the shading formulas, drawn by gnuplot. A plot is a row in the table of its topic
 * (shade_plots_<topic>.c). Its function `draw` fills the panels of the page one after another, from left to right and
 * from top to bottom, with curves whose values come from the functions of engine/shading:
 *
 *   static void draw(plot_page *page, const void *subject)
 *   {
 *       plot_panel_begin(page, &(plot_panel){.title = "Schlick", .x_label = "angle (degrees)"});
 *       plot_curve(page, schlick, subject, 0.0, 90.0, 181, NULL, "F0 = %g", 0.04);
 *       plot_panel_end(page);
 *   }
 *
 * Colours.  A curve without a style gets the next of eight colours that people with any kind of colour blindness can
 *           tell apart.
 * Threads.  [main-thread].
 */
#ifndef STILB_SHADE_PLOT_H
#define STILB_SHADE_PLOT_H

#include "base/base.h"

#include <stdio.h>

typedef struct plot_page plot_page;

/* Texts are UTF-8 with gnuplot's markup for x_i and x^2. */
typedef struct plot {
	const char *name; /* as `stilb shade plot` takes it */
	const char *title;
	const char *formula;    /* one or two lines below the title */
	const char *source;     /* the paper, below that */
	uint32_t columns, rows; /* of panels; each 1 or more */
	void (*draw)(plot_page *page, const void *subject);
	const void *subject;
	uint32_t panel_width, panel_height; /* pixels; 0: the default */
	bool cloud;                         /* it has thousands of points, so that .png is smaller than .svg */
} plot;

typedef struct plot_topic {
	const char *name; /* "reflection" */
	const plot *plots;
	uint32_t count;
} plot_topic;

#define PLOT_COUNT(plots) ((uint32_t)(sizeof(plots) / sizeof *(plots)))

/* STILB_ERROR_ARGUMENT if path ends neither in .svg nor in .png, or cannot become a file. Writes nothing. */
stilb_result plot_path_check(const char *path);

/* Draws a plot and saves it as path, which plot_path_check accepted. STILB_ERROR_FILE: see gnuplot_save. */
stilb_result plot_save(const plot *p, const char *path);

/* ---- for the functions that draw ------------------------------------------------------------------------------- */

typedef enum plot_kind {
	PLOT_CURVES, /* y over x */
	PLOT_LOBES,  /* a length over a direction, around a point on a surface; x of a curve is the angle, see plot_lobe */
	PLOT_MAP,    /* points in the plane: equal scales, no axes */
} plot_kind;

typedef struct plot_panel {
	plot_kind kind;
	const char *title;
	const char *x_label, *y_label;
	const char *x_range, *y_range; /* "[0:90]"; NULL: the range of the data */
	const char *logarithmic;       /* "x", "y", "xy" or NULL */
	const char *key;               /* position of the legend, "top right"; NULL: none */
	const char *extra;             /* more gnuplot commands, or NULL */
} plot_panel;

/* Every panel is begun, filled and ended before the next. *panel is copied, its texts must stay until the end. */
void plot_panel_begin(plot_page *page, const plot_panel *panel);
void plot_panel_end(plot_page *page);

typedef struct plot_point {
	double x, y;
} plot_point;

/* Returns the point of a curve at the parameter t. A NaN interrupts the curve. */
typedef plot_point plot_function(double t, const void *context);

/* Draws the curve f(t, context) for t in [from, to], computed at `points` points, 2..1024, which are spaced evenly in
 * t, or in log t if the x axis is logarithmic. style is gnuplot's, or NULL for a line in the next colour. words, with
 * the arguments after it as printf takes them, is the entry in the legend; "" for none. */
void plot_curve(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
                const char *style, const char *words, ...) __attribute__((format(printf, 8, 9)));

/* Draws a curve of directions around the middle of a panel of any kind: the x of its points is an angle in radians from
 * the upward direction to the right, y a length. */
void plot_lobe(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
               const char *style);

/* Leaves the next `count` panels of the page empty. */
void plot_panel_skip(plot_page *page, int count);

/* Draws given points, or the lines between them: style says which. */
void plot_points(plot_page *page, const plot_point *points, uint32_t count, const char *style, const char *words);

/* Draws an arrow for the light in a panel of the kind PLOT_LOBES. The light comes from the left of the normal, by
 * `angle` radians. color is "#rrggbb". */
#define PLOT_LIGHT_COLOR "#303030"
void plot_light(plot_page *page, double angle, const char *color);

/* A plot_panel.extra: a dashed line at y = 1. */
#define PLOT_LINE_AT_ONE "set arrow from graph 0,first 1 to graph 1,first 1 nohead dashtype 2 linecolor rgb '#606060'"

/* The colour of curve `index` of a panel, from 0, as "#rrggbb". */
const char *plot_color(uint32_t index);

/* A style: a dashed line in the colour of curve `index` of a panel, from 0. */
const char *plot_dashed(uint32_t index);

#endif
