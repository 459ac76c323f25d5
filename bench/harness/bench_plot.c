/* The picture of a benchmark suite's results: writes a gnuplot script and lets gnuplot draw it. A panel is one diagram;
 * a subject is one of the implementations that it compares. */
#include "bench/harness/bench_internal.h"

#include "game/cli/flags.h"
#include "game/cli/gnuplot.h"

#include <string.h>

#define PANEL_WIDTH 1000
#define PANEL_HEIGHT 460
#define COLUMNS 2

/* ---- the script of a suite with panels --------------------------------------------------------------------------- */

/* A line style for each subject: strong colours and filled marks for Stilb's, pale ones and open marks for the others,
 * so that they can be told apart without colour too. */
static void write_styles(FILE *out, const bench_suite *suite)
{
	static const char *const strong[] = {"#c00000", "#0050b0", "#e08000", "#007030", "#7000a0"};
	static const char *const pale[] = {"#404040", "#808080", "#9a6a00", "#5070a0", "#508050", "#a05050", "#8060a0",
	                                   "#308080", "#b08050", "#606020", "#a04080", "#206040", "#b0b0b0"};
	static const int full[] = {7, 5, 9, 11, 13}, open[] = {6, 4, 8, 10, 12, 1, 2, 3};
	size_t our = 0, their = 0;
	for (size_t s = 0; s < suite->subject_count; s++) {
		bool ours = strncmp(suite->subjects[s].name, "stilb", 5) == 0;
		const char *colour = ours ? strong[our % 5] : pale[their % 13];
		int mark = ours ? full[our % 5] : open[their % 8];
		fprintf(out, "set style line %zu linecolor rgb '%s' linewidth %s pointtype %d pointsize %s\n", s + 1, colour,
		        ours ? "2" : "1.2", mark, ours ? "1.6" : "1.2");
		if (ours)
			our++;
		else
			their++;
	}
}

/* Sets in[s] for every subject that has a row in the panel; returns their number. */
static size_t subjects_in_panel(const bench_results *results, const bench_panel *panel, bool *in)
{
	size_t count = 0;
	for (size_t s = 0; s < results->suite->subject_count; s++) {
		in[s] = false;
		for (const char *const *name = panel->cases; *name; name++)
			if (bench_find(results, *name, results->suite->subjects[s].name, panel->metric))
				in[s] = true;
		count += in[s];
	}
	return count;
}

/* Writes gnuplot's data block $panelP_S for panel number P and each subject S, with a line "x median least most" for
 * each case. The subjects of case i lie side by side around x = i. */
static void write_data(FILE *out, const bench_results *results, const bench_panel *panel, size_t p, const bool *in,
                       size_t count)
{
	size_t place = 0;
	for (size_t s = 0; s < results->suite->subject_count; s++) {
		if (!in[s])
			continue;
		fprintf(out, "$panel%zu_%zu << END\n", p, s);
		double offset = 0.8 * ((double)place++ + 0.5) / (double)count - 0.4;
		int x = 0;
		for (const char *const *name = panel->cases; *name; name++, x++) {
			const bench_row *row = bench_find(results, *name, results->suite->subjects[s].name, panel->metric);
			if (row)
				fprintf(out, "%.3f %.6g %.6g %.6g\n", x + offset, row->median, row->min, row->max);
		}
		fprintf(out, "END\n");
	}
}

static const bench_row *any_row(const bench_results *results, const bench_panel *panel)
{
	for (const char *const *name = panel->cases; *name; name++)
		for (size_t s = 0; s < results->suite->subject_count; s++) {
			const bench_row *row = bench_find(results, *name, results->suite->subjects[s].name, panel->metric);
			if (row)
				return row;
		}
	return NULL;
}

/* A label of the x axis: the words of "batch16-4P4C" below each other, since cases lie close together. */
static void write_label(FILE *out, const char *name, int x)
{
	fprintf(out, "%s\"", x ? ", " : "");
	for (; *name; name++)
		if (*name == '-')
			fputs("\\n", out);
		else
			fputc(*name, out);
	fprintf(out, "\" %d", x);
}

static void write_panel(FILE *out, const bench_results *results, const bench_panel *panel, size_t p)
{
	bool in[BENCH_MAX_SUBJECTS];
	size_t count = subjects_in_panel(results, panel, in);
	const bench_row *row = any_row(results, panel);
	write_data(out, results, panel, p, in, count);
	fprintf(out, "set title \"%s\"\nset ylabel \"%s (%s is better)\"\n%s\nset xtics (", panel->title, row->unit,
	        row->less_is_better ? "less" : "more",
	        panel->logarithmic ? "set logscale y\nset yrange [*:*]" : "unset logscale y\nset yrange [0:*]");
	int x = 0;
	for (const char *const *name = panel->cases; *name; name++, x++)
		write_label(out, *name, x);
	fprintf(out, ")\nset xrange [-0.5:%d.5]\nunset arrow\n", x - 1);
	for (int line = 1; line < x; line++)
		fprintf(out, "set arrow from %d.5, graph 0 to %d.5, graph 1 nohead linecolor rgb '#c0c0c0'\n", line - 1,
		        line - 1);
	fprintf(out, "plot ");
	bool first = true;
	for (size_t s = 0; s < results->suite->subject_count; s++)
		if (in[s]) {
			fprintf(out, "%s$panel%zu_%zu using 1:2:3:4 with yerrorbars linestyle %zu title \"%s\"", first ? "" : ", ",
			        p, s, s + 1, results->suite->subjects[s].name);
			first = false;
		}
	fputc('\n', out);
}

static size_t panels_with_data(const bench_results *results)
{
	size_t count = 0;
	for (size_t p = 0; p < results->suite->panel_count; p++)
		if (any_row(results, &results->suite->panels[p]))
			count++;
	return count;
}

typedef struct plot_layout {
	size_t columns, rows;
} plot_layout;

static plot_layout plot_lay_out(const bench_results *results)
{
	size_t panels = results->suite->plot ? results->suite->plot_rows * COLUMNS : panels_with_data(results);
	size_t columns = panels > 1 ? COLUMNS : 1;
	return (plot_layout){columns, (panels + columns - 1) / columns};
}

static void write_script(FILE *out, const void *context)
{
	const bench_results *results = context;
	plot_layout layout = plot_lay_out(results);
	char machine[256];
	bench_machine(machine, sizeof machine);
	fprintf(
		out,
		"set multiplot layout %zu,%zu title \"stilb-bench %s: %s\\nmedian of %u runs of %.2f s; bars from the least "
		"to the most\" font ',13'\n"
		"set grid ytics linecolor rgb '#e0e0e0'\nset key outside right top Left reverse\nset bars 0.4\nset offsets 0, "
		"0, 0, 0\n",
		layout.rows, layout.columns, results->suite->name, machine, results->rounds, results->seconds);
	if (results->suite->plot) {
		results->suite->plot(out, results);
	} else {
		write_styles(out, results->suite);
		for (size_t p = 0; p < results->suite->panel_count; p++)
			if (any_row(results, &results->suite->panels[p]))
				write_panel(out, results, &results->suite->panels[p], p);
	}
	fprintf(out, "unset multiplot\n");
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

int bench_save_plot(const bench_results *results, const char *path)
{
	plot_layout layout = plot_lay_out(results);
	char terminal[128];
	snprintf(terminal, sizeof terminal, "pngcairo size %zu,%zu font 'sans,11' noenhanced", layout.columns * PANEL_WIDTH,
	         layout.rows * PANEL_HEIGHT + 50);
	if (gnuplot_save(path, terminal, NULL, write_script, results) == STILB_OK)
		return EXIT_DONE;
	stilb_log("%s", stilb_error_message());
	return EXIT_FAILED;
}
