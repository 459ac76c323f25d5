/*
 * shade_plot: diagrams of the shading formulas, drawn by gnuplot. A plot is a row of its topic's table
 * (shade_plots_<topic>.c): a function that fills its panels with curves, each made of a C function of engine/shading.
 */
#ifndef STILB_SHADE_PLOT_H
#define STILB_SHADE_PLOT_H

#include "base/base.h"

#include <stdio.h>

typedef struct plot_page plot_page;

/* Words are UTF-8 with gnuplot's x_i and x^2. */
typedef struct plot {
	const char *name;
	const char *title;
	const char *formula; /* a line or two */
	const char *source;
	uint32_t columns, rows; /* of panels; each 1 or more */
	void (*draw)(plot_page *page, const void *subject);
	const void *subject;
	uint32_t panel_width, panel_height; /* pixels; 0: as usual */
	bool cloud;                         /* thousands of points: smaller as .png than as .svg */
} plot;

typedef struct plot_topic {
	const char *name; /* "reflection" */
	const plot *plots;
	uint32_t count;
} plot_topic;

#define PLOT_COUNT(plots) ((uint32_t)(sizeof(plots) / sizeof *(plots)))

/* STILB_ERROR_ARGUMENT: path is neither .svg nor .png, or cannot become a file. */
stilb_result plot_path_check(const char *path);

/* STILB_ERROR_FILE as gnuplot_save. */
stilb_result plot_save(const plot *p, const char *path);

/* ---- for the tables: what draws panels --------------------------------------------------------------------------- */

typedef enum plot_kind {
	PLOT_CURVES, /* x and y */
	PLOT_LOBES,  /* directions and lengths, around a point on the ground; equal scales */
	PLOT_MAP,    /* equal scales, no axes */
} plot_kind;

typedef struct plot_panel {
	plot_kind kind;
	const char *title;
	const char *x_label, *y_label;
	const char *x_range, *y_range; /* "[0:90]"; NULL: as the data is */
	const char *logarithmic;       /* "x", "y", "xy" or NULL */
	const char *key;               /* where the key is, "top right"; NULL: there is none */
	const char *extra;             /* more gnuplot commands, or NULL */
} plot_panel;

void plot_panel_begin(plot_page *page, const plot_panel *panel);
void plot_panel_end(plot_page *page);

typedef struct plot_point {
	double x, y;
} plot_point;

/* The point of a curve at t. */
typedef plot_point plot_function(double t, const void *context);

/* A curve over t in [from, to], computed at so many points, 1024 at most; its style is gnuplot's, NULL for a line in
 * the next colour. words, for the key, may be empty. */
void plot_curve(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
                const char *style, const char *words, ...) __attribute__((format(printf, 8, 9)));

/* The same around the middle of a panel: x is an angle from the up direction to the right, y a length. */
void plot_lobe(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
               const char *style);

/* Leaves places for panels empty. */
void plot_panel_skip(plot_page *page, int count);

/* Single points, or a polyline. */
void plot_points(plot_page *page, const plot_point *points, uint32_t count, const char *style, const char *words);

/* Of a PLOT_LOBES panel: the direction that light comes from, polar angle from the normal to the left, radians. */
#define PLOT_LIGHT_COLOR "#303030"
void plot_light(plot_page *page, double angle, const char *color);

#define PLOT_LINE_AT_ONE "set arrow from graph 0,first 1 to graph 1,first 1 nohead dashtype 2 linecolor rgb '#606060'"

/* The colour of the panel's curve `index`, from 0, as "#rrggbb". */
const char *plot_color(uint32_t index);

/* A dashed line in the colour of the panel's curve `index`, from 0, as a style. */
const char *plot_dashed(uint32_t index);

#endif
