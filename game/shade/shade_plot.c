/* Writes the panels and curves of a plot as commands of gnuplot, and saves the picture that it draws. */
#include "shade_plot.h"

#include "game/cli/gnuplot.h"

#include "base/base_file.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <strings.h>

#define PANEL_WIDTH 520
#define NARROW_PANEL_WIDTH 400 /* of plots with three columns of panels or more */
#define PANEL_HEIGHT 380
#define TITLE_HEIGHT 76

struct plot_page {
	FILE *script;
	plot_panel panel;
	bool open;           /* between plot_panel_begin and plot_panel_end */
	uint32_t blocks;     /* number of data blocks, each the points of a curve, so far */
	uint32_t curves;     /* number of curves in this panel that have taken a colour */
	char clauses[16384]; /* arguments of the panel's `plot` command */
};

/* Colours that people with any kind of colour blindness can tell apart.
 * Source: Okabe and Ito, "Color Universal Design" (2002). */
#define COLORS(X)                                                                                                      \
	X("#0072B2") X("#D55E00") X("#009E73") X("#CC79A7") X("#E69F00") X("#56B4E9") X("#222222") X("#8a8a8a")
#define FULL_LINE(color) "lines linewidth 2 linecolor rgb '" color "'",
#define COLOR(color) color,
#define DASHED_LINE(color) "lines dashtype 2 linewidth 1.6 linecolor rgb '" color "'",

static const char *const full_lines[] = {COLORS(FULL_LINE)};
static const char *const dashed_lines[] = {COLORS(DASHED_LINE)};
static const char *const colors[] = {COLORS(COLOR)};
#define COLOR_COUNT (sizeof full_lines / sizeof *full_lines)

const char *plot_color(uint32_t index)
{
	return colors[index % COLOR_COUNT];
}

const char *plot_dashed(uint32_t index)
{
	return dashed_lines[index % COLOR_COUNT];
}

/* Adds a clause to the panel's plot command. */
static void add_clause(plot_page *page, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add_clause(plot_page *page, const char *format, ...)
{
	size_t length = strlen(page->clauses);
	va_list arguments;
	if (length > 0)
		length += (size_t)snprintf(page->clauses + length, sizeof page->clauses - length, ", ");
	va_start(arguments, format);
	vsnprintf(page->clauses + length, sizeof page->clauses - length, format, arguments);
	va_end(arguments);
}

/* ---- panels ------------------------------------------------------------------------------------------------------ */

static void axis(FILE *script, const char *name, const char *label, const char *range)
{
	fprintf(script, "set %slabel \"%s\"\nset %srange %s\n", name, label ? label : "", name, range ? range : "[*:*]");
}

static void commands_curves(plot_page *page)
{
	fprintf(page->script,
	        "set size noratio\nset border 3 linecolor rgb '#606060'\nset xtics nomirror out textcolor rgb "
	        "'#303030'\nset ytics nomirror out textcolor rgb '#303030'\nset grid linecolor rgb '#e6e6e6' "
	        "linetype 1\n");
}

/* Draws the surface and the normal. The half circles that show the lengths 1/2 and 1 are curves, which plot_panel_begin
 * adds. */
static void commands_lobes(plot_page *page)
{
	fprintf(
		page->script,
		"set size ratio -1\nunset border\nunset tics\nunset grid\nset parametric\nset trange [0:pi]\nset samples 61\n"
		"set arrow from -1.12,0 to 1.12,0 nohead linewidth 1.5 linecolor rgb '#707070' back\n"
		"set arrow from 0,0 to 0,1.16 head filled size 0.04,20 linewidth 1 linecolor rgb '#707070' back\n"
		"set label 'n' at 0.04,1.14 textcolor rgb '#505050'\n");
}

void plot_panel_begin(plot_page *page, const plot_panel *panel)
{
	STILB_ASSERT(!page->open && "the panel before has not been ended");
	FILE *script = page->script;
	page->open = true;
	page->panel = *panel;
	page->curves = 0;
	page->clauses[0] = '\0';
	fprintf(script, "reset\nset encoding utf8\nset title \"%s\" font ',13' offset 0,-0.4\n",
	        panel->title ? panel->title : "");
	if (panel->kind == PLOT_LOBES)
		commands_lobes(page);
	else if (panel->kind == PLOT_MAP)
		fprintf(script, "set size ratio -1\nunset border\nunset tics\nunset grid\n");
	else
		commands_curves(page);
	bool lobes = panel->kind == PLOT_LOBES;
	axis(script, "x", panel->x_label, panel->x_range ? panel->x_range : lobes ? "[-1.15:1.15]" : NULL);
	axis(script, "y", panel->y_label, panel->y_range ? panel->y_range : lobes ? "[-0.45:1.2]" : NULL);
	if (panel->logarithmic)
		fprintf(script, "set logscale %s\nset format %s '10^{%%L}'\n", panel->logarithmic, panel->logarithmic);
	if (panel->key)
		fprintf(script, "set key %s Left reverse spacing 1.15 samplen 2 font ',11' opaque width 0\n", panel->key);
	else
		fprintf(script, "unset key\n");
	if (panel->extra)
		fprintf(script, "%s\n", panel->extra);
	if (lobes) {
		add_clause(page, "cos(t),sin(t) with lines linecolor rgb '#dcdcdc' notitle");
		add_clause(page, "0.5*cos(t),0.5*sin(t) with lines linecolor rgb '#e8e8e8' notitle");
	}
}

void plot_panel_end(plot_page *page)
{
	STILB_ASSERT(page->open && page->clauses[0]);
	page->open = false;
	fprintf(page->script, "plot %s\n", page->clauses);
}

void plot_panel_skip(plot_page *page, int count)
{
	STILB_ASSERT(!page->open && count >= 0);
	for (int i = 0; i < count; i++)
		fprintf(page->script, "set multiplot next\n");
}

/* ---- curves ------------------------------------------------------------------------------------------------------ */

static void add_block(plot_page *page, const char *style, const char *words)
{
	if (!style)
		style = full_lines[page->curves++ % COLOR_COUNT];
	add_clause(page, "$block%u using 1:2 with %s %s%s%s", page->blocks, style, words[0] ? "title \"" : "notitle", words,
	           words[0] ? "\"" : "");
}

/* ---- fewer points ------------------------------------------------------------------------------------------------ */

#define CURVE_POINTS_MAX 1024
#define STRAIGHT 4e-4 /* largest distance from a straight line, as a share of the panel: a tenth of a pixel */

/* The points of a curve, in units in which the part of an axis that the panel shows is [0, 1]; kept: to be written. */
typedef struct trace {
	double x[CURVE_POINTS_MAX], y[CURVE_POINTS_MAX];
	bool kept[CURVE_POINTS_MAX];
} trace;

/* The distance of point i from the line segment between two others. */
static double distance_from_line(const trace *t, uint32_t i, uint32_t from, uint32_t to)
{
	double x = t->x[i] - t->x[from], y = t->y[i] - t->y[from];
	double dx = t->x[to] - t->x[from], dy = t->y[to] - t->y[from], square = dx * dx + dy * dy;
	double share = square > 0.0 ? fmin(fmax((x * dx + y * dy) / square, 0.0), 1.0) : 0.0;
	return hypot(x - share * dx, y - share * dy);
}

/* Marks the points between first and last without which the drawn curve would change by more than STRAIGHT.
 * Source: Douglas and Peucker, "Algorithms for the Reduction of the Number of Points Required to Represent a Digitized
 * Line" (1973). */
static void keep_corners(trace *t, uint32_t first, uint32_t last)
{
	double farthest = STRAIGHT;
	uint32_t corner = first;
	for (uint32_t i = first + 1; i < last; i++) {
		double distance = distance_from_line(t, i, first, last);
		if (distance > farthest) {
			farthest = distance;
			corner = i;
		}
	}
	if (corner == first)
		return;
	t->kept[corner] = true;
	keep_corners(t, first, corner);
	keep_corners(t, corner, last);
}

/* Scales values so that [0, 1] is the part that the axis shows: its range as far as that is given, else all values. */
static void scale_axis(double *values, uint32_t count, bool logarithmic, const char *range)
{
	double low = (double)INFINITY, high = (double)-INFINITY, ends[2];
	for (uint32_t i = 0; i < count; i++) {
		low = isfinite(values[i]) && (values[i] > 0.0 || !logarithmic) ? fmin(low, values[i]) : low;
		high = isfinite(values[i]) ? fmax(high, values[i]) : high;
	}
	int given = range ? sscanf(range, "[%lf:%lf", &ends[0], &ends[1]) : 0;
	low = given > 0 ? ends[0] : low;
	high = given > 1 ? ends[1] : high;
	for (uint32_t i = 0; i < count && high > low; i++)
		values[i] = logarithmic ? log(values[i] / low) / log(high / low) : (values[i] - low) / (high - low);
}

static bool is_logarithmic(const plot_page *page, char axis)
{
	return page->panel.logarithmic && strchr(page->panel.logarithmic, axis);
}

/* Chooses the points to write. Most of the computed ones lie on a line between others: about a fifth is enough. */
static void choose_points(const plot_page *page, trace *t, uint32_t count)
{
	if (page->panel.kind == PLOT_CURVES) {
		scale_axis(t->x, count, is_logarithmic(page, 'x'), page->panel.x_range);
		scale_axis(t->y, count, is_logarithmic(page, 'y'), page->panel.y_range);
	}
	uint32_t first = 0; /* first point of the present part without a gap */
	for (uint32_t i = 0; i < count; i++) {
		bool gap = !isfinite(t->x[i] + t->y[i]);
		t->kept[i] = gap || i == first || i + 1 == count;
		if (gap && i > first)
			t->kept[i - 1] = true;
		if (i > first && (gap || i + 1 == count))
			keep_corners(t, first, gap ? i - 1 : i);
		if (gap)
			first = i + 1;
	}
}

/* A NaN or an infinity becomes an empty line, which interrupts the curve. */
static void write_point(FILE *script, plot_point at)
{
	if (isfinite(at.x) && isfinite(at.y))
		fprintf(script, "%.6g %.6g\n", at.x, at.y);
	else
		fprintf(script, "\n");
}

void plot_points(plot_page *page, const plot_point *points, uint32_t count, const char *style, const char *words)
{
	STILB_ASSERT(page->open && "points belong into a panel");
	fprintf(page->script, "$block%u << END\n", ++page->blocks);
	for (uint32_t i = 0; i < count; i++)
		write_point(page->script, points[i]);
	fprintf(page->script, "END\n");
	add_block(page, style, words);
}

/* The parameter at a share in [0, 1] of a curve: spaced evenly, or in the logarithm if the x axis is logarithmic. */
static double parameter(const plot_page *page, double from, double to, double share)
{
	if (is_logarithmic(page, 'x'))
		return from * pow(to / from, share);
	return from + (to - from) * share;
}

/* Writes the points of the curve f as a data block. angles: f gives an angle and a length, as for plot_lobe. line: the
 * points are joined by lines, so those that make no difference are left out. */
static void write_block(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
                        bool angles, bool line)
{
	plot_point at[CURVE_POINTS_MAX];
	trace t;
	STILB_ASSERT(page->open && "curves belong into a panel");
	STILB_ASSERT(points >= 2 && points <= CURVE_POINTS_MAX);
	STILB_ASSERT(from > 0.0 || !is_logarithmic(page, 'x'));
	for (uint32_t i = 0; i < points; i++) {
		at[i] = f(parameter(page, from, to, (double)i / (points - 1)), context);
		if (angles)
			at[i] = (plot_point){at[i].y * sin(at[i].x), at[i].y * cos(at[i].x)};
		t.x[i] = at[i].x;
		t.y[i] = at[i].y;
	}
	choose_points(page, &t, points);
	fprintf(page->script, "$block%u << END\n", ++page->blocks);
	for (uint32_t i = 0; i < points; i++)
		if (!line || t.kept[i])
			write_point(page->script, at[i]);
	fprintf(page->script, "END\n");
}

void plot_curve(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
                const char *style, const char *words, ...)
{
	char title[128];
	va_list arguments;
	va_start(arguments, words);
	vsnprintf(title, sizeof title, words, arguments);
	va_end(arguments);
	bool line = !style || !strstr(style, "points");
	write_block(page, f, context, from, to, points, page->panel.kind == PLOT_LOBES, line);
	add_block(page, style, title);
}

void plot_lobe(plot_page *page, plot_function *f, const void *context, double from, double to, uint32_t points,
               const char *style)
{
	write_block(page, f, context, from, to, points, true, true);
	add_block(page, style, "");
}

void plot_light(plot_page *page, double angle, const char *color)
{
	fprintf(page->script,
	        "set arrow from %.4f,%.4f to %.4f,%.4f head filled size 0.05,20 linewidth 2.5 linecolor rgb '%s' front\n",
	        -1.08 * sin(angle), 1.08 * cos(angle), -0.03 * sin(angle), 0.03 * cos(angle), color);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *path, const char *extension)
{
	const char *dot = strrchr(path, '.');
	return dot && strcasecmp(dot, extension) == 0;
}

stilb_result plot_path_check(const char *path)
{
	if (!ends_with(path, ".svg") && !ends_with(path, ".png"))
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot draw '%s': give a name that ends in .svg or .png", path);
	return stilb_file_check(path);
}

/* Writes a text for use inside of double quotes. */
static void write_quoted(FILE *script, const char *words)
{
	for (; *words; words++) {
		if (*words == '"')
			fputc('\\', script);
		fputc(*words, script);
	}
}

static void write_script(FILE *script, const void *context)
{
	const plot *p = context;
	plot_page page = {.script = script};
	fprintf(script, "set encoding utf8\nset multiplot layout %u,%u title \"{/:Bold=16 %s}\\n{/=12 %s}\\n{/=9 ", p->rows,
	        p->columns, p->title, p->formula);
	write_quoted(script, p->source);
	fprintf(script, "}\"\n");
	p->draw(&page, p->subject);
	fprintf(script, "unset multiplot\n");
}

stilb_result plot_save(const plot *p, const char *path)
{
	uint32_t width = p->panel_width ? p->panel_width : p->columns > 2 ? NARROW_PANEL_WIDTH : PANEL_WIDTH;
	uint32_t height = p->panel_height ? p->panel_height : PANEL_HEIGHT;
	STILB_ASSERT(p->columns > 0 && p->rows > 0 && p->draw);
	bool svg = ends_with(path, ".svg");
	char terminal[160];
	snprintf(terminal, sizeof terminal, "%s size %u,%u enhanced font 'DejaVu Sans,12' background '#ffffff'",
	         svg ? "svg fontscale 1.15" : "pngcairo", width * p->columns, height * p->rows + TITLE_HEIGHT);
	return gnuplot_save(path, terminal, svg ? p->title : NULL, write_script, p);
}
