/* The suite `shade`: evaluating a BRDF with the shading headers, beside the same formula fused by hand and the headers'
 * functions on eight points at a time. The cases are in shade_cases.h. */
#include "bench/harness/bench.h"
#include "bench/shade/shade_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"scalar", "ns", true, NULL}, {"hand", "ns", true, NULL},        {"wide", "ns", true, NULL},
	{"of-hand", "x", true, NULL}, {"of-wide", "x", false, NULL},     {"limit", "ns", true, NULL},
	{"error", "ppm", true, NULL}, {"hand-error", "ppm", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, ...) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	SHADE_BENCH_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-shade",
     .note = "three channels; every evaluation has its own normal, light, viewer, roughness and F0; one thread"},
};

#define GOAL_CASE "ggx"
#define GOAL 1.1

static double value(const bench_results *results, const bench_case *on, const char *metric)
{
	const bench_row *row = bench_find(results, on->name, "stilb", metric);
	return row ? row->median : 0.0;
}

static void report(FILE *out, const bench_results *results)
{
	fprintf(out, "\nns for each evaluation, medians; ratio to hand-fused code: median [least-most]\n\n");
	fprintf(out, "  %-22s %7s %7s %7s %7s   %-22s %8s   %7s %7s\n", "", "limit", "hand", "stilb", "8 wide",
	        "stilb / hand", "/ 8 wide", "error", "hand's");
	for (size_t i = 0; i < COUNT(cases); i++) {
		const bench_row *ratio = bench_find(results, cases[i].name, "stilb", "of-hand");
		if (!ratio)
			continue;
		char range[40];
		snprintf(range, sizeof range, "%.3f [%.3f-%.3f]", ratio->median, ratio->min, ratio->max);
		fprintf(out, "  %-22s %7.2f %7.2f %7.2f %7.2f   %-22s %7.1fx   %7.2f %7.2f\n", cases[i].name,
		        value(results, &cases[i], "limit"), value(results, &cases[i], "hand"),
		        value(results, &cases[i], "scalar"), value(results, &cases[i], "wide"), range,
		        value(results, &cases[i], "of-wide"), value(results, &cases[i], "error"),
		        value(results, &cases[i], "hand-error"));
	}
	fprintf(out, "\n  limit: only the divisions, square roots and powers, at their throughput\n"
	             "  hand: the formula fused in plain floats; powers are powf of a cosine, fast but imprecise\n"
	             "  stilb: the functions of engine/shading; / 8 wide: its time / that of 8 wide\n"
	             "  8 wide: the functions of engine/shading on eight points at a time\n"
	             "  error: the largest relative error of stilb, in millionths; hand's: of hand\n");
}

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *goal = bench_find(results, GOAL_CASE, "stilb", "of-hand");
	if (goal)
		fprintf(out, "\ngoal: %s within %.1f x of hand-fused code: %.3f, %s\n", GOAL_CASE, GOAL, goal->median,
		        goal->median <= GOAL ? "met" : "MISSED");
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

typedef struct bar {
	const char *metric, *title, *color;
} bar;

static const bar times[] = {
	{"limit", "only divisions, roots and powers", "#c8c8c8"},
	{"hand", "fused by hand", "#90b0d8"},
	{"scalar", "engine/shading", "#0040a0"},
	{"wide", "engine/shading, eight wide", "#c06000"},
};
static const bar errors[] = {
	{"hand-error", "fused by hand", "#90b0d8"},
	{"error", "engine/shading", "#0040a0"},
};

/* Plots the bars, each the median of one metric, side by side for every case that ran. name: gnuplot's data block. */
static void plot_bars(FILE *out, const bench_results *results, const char *name, const bar *bars, size_t count)
{
	size_t ran = 0;
	fprintf(out, "$%s << END\n", name);
	for (size_t i = 0; i < COUNT(cases); i++) {
		if (!bench_find(results, cases[i].name, "stilb", bars[0].metric))
			continue;
		fprintf(out, "\"%s\"", cases[i].name);
		for (size_t k = 0; k < count; k++) {
			const bench_row *row = bench_find(results, cases[i].name, "stilb", bars[k].metric);
			if (row)
				fprintf(out, " %.6g %.6g %.6g", row->median, row->min, row->max);
			else
				fprintf(out, " NaN NaN NaN");
		}
		fputc('\n', out);
		ran++;
	}
	fprintf(out, "END\nset xrange [-0.6:%.1f]\nplot", (double)ran - 0.4);
	for (size_t k = 0; k < count; k++)
		fprintf(out, "%s $%s using %zu:%zu:%zu:xtic(1) title '%s' linecolor rgb '%s'", k ? "," : "", name, 3 * k + 2,
		        3 * k + 3, 3 * k + 4, bars[k].title, bars[k].color);
	fputc('\n', out);
}

static void plot(FILE *out, const bench_results *results)
{
	fprintf(out, "set style data histograms\nset style histogram errorbars gap 1 linewidth 1\nset errorbars linecolor "
	             "rgb '#404040'\nset style fill solid 1 noborder\n"
	             "set xtics rotate by -25 scale 0\nset key inside top left noreverse\nset logscale y\n"
	             "set yrange [0.1:1000]\nset origin 0,0\nset size 0.5,0.9\n"
	             "set title 'ns for each evaluation of three channels'\n");
	plot_bars(out, results, "times", times, COUNT(times));
	fprintf(out, "set origin 0.5,0\nset size 0.5,0.9\nset yrange [0.01:10000]\n"
	             "set title 'largest error, relative to the formula in double, in millionths'\n");
	plot_bars(out, results, "errors", errors, COUNT(errors));
}

const bench_suite bench_shade_suite = {.name = "shade",
                                       .help =
                                           "evaluating BRDFs: the shading headers, hand-fused code, eight at a time",
                                       .subjects = subjects,
                                       .subject_count = COUNT(subjects),
                                       .cases = cases,
                                       .case_count = COUNT(cases),
                                       .report = report,
                                       .goals = print_goals,
                                       .plot = plot,
                                       .plot_rows = 1,
                                       .report_alone = true};
