/* The suite `furnace`: the path integrator and several random number generators inside a ball whose radiance is known.
 * After R. Driscoll, "What's wrong with this picture?" (2010): error by number of bounces, mean error and variance by
 * survival probability. */
#include "bench/furnace/furnace_cases.h"
#include "bench/harness/bench.h"

#include <math.h>
#include <string.h>

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

#define BOUNCES_METRIC(N) {"error-" #N, "%", true, NULL},
#define SURVIVAL_METRICS(P)                                                                                            \
	{"error-" #P, "%", true, NULL}, {"bias-" #P, "%", true, NULL}, {"variance-" #P, "(W/sr/m2)^2", true, NULL},
#define EQUAL_METRIC(N) {"montecarlo-" #N, "%", true, NULL},
static const bench_metric bounces_metrics[] = {FURNACE_BOUNCES(BOUNCES_METRIC)};
static const bench_metric survival_metrics[] = {FURNACE_SURVIVALS(SURVIVAL_METRICS)};
static const bench_metric equal_metrics[] = {{"path", "%", true, NULL}, FURNACE_BRANCHES(EQUAL_METRIC)};

#define LIST(N) N,
static const unsigned bounces[] = {FURNACE_BOUNCES(LIST)};
static const unsigned survivals[] = {FURNACE_SURVIVALS(LIST)};

/* Bits of bench_subject.abilities and bench_case.needs: sources of random numbers, integrators that make pictures. */
#define NUMBERS 1u
#define PICTURES 2u

static const bench_case cases[] = {
	{.name = FURNACE_CASE_BOUNCES,
     .title = "light lost if paths end after n bounces, mean of 1,000 paths",
     .metrics = bounces_metrics,
     .metric_count = COUNT(bounces_metrics),
     .needs = NUMBERS,
     .length = 0.1},
	{.name = FURNACE_CASE_SURVIVAL,
     .title = "Russian roulette: mean error of 1,000 paths, and variance of a path",
     .metrics = survival_metrics,
     .metric_count = COUNT(survival_metrics),
     .needs = NUMBERS},
	{.name = FURNACE_CASE_EQUAL_TIME,
     .title = "the integrators path and montecarlo in equal time",
     .metrics = equal_metrics,
     .metric_count = COUNT(equal_metrics),
     .needs = PICTURES,
     .length = 4.0},
};

#define PROGRAM "stilb-bench-furnace"
static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = PROGRAM,
     .note = "Owen-scrambled Sobol points; an experiment is a pixel, a path one of its samples",
     .abilities = NUMBERS | PICTURES},
	{.name = "pcg", .program = PROGRAM, .note = "PCG-XSH-RR 64/32", .abilities = NUMBERS},
	{.name = "rand", .program = PROGRAM, .note = "rand() of the C library of this system", .abilities = NUMBERS},
	{.name = "rand-15-bit",
     .program = PROGRAM,
     .note = "rand() of Microsoft's C library: 15 bits of a linear congruential generator",
     .abilities = NUMBERS},
};

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static const bench_row *row_of(const bench_results *results, const char *on, const char *subject, const char *metric,
                               unsigned number)
{
	char name[32];
	snprintf(name, sizeof name, "%s-%u", metric, number);
	return bench_find(results, on, subject, name);
}

/* The expected error, in percent, of the mean of 1,000 independent paths with survival probability `percent`, if the
 * mean is normally distributed. Just above the probability at which the variance becomes infinite it is not: with so
 * few paths most experiments miss the rare bright ones. */
static double expected_error(unsigned percent)
{
	return 100.0 * sqrt(2.0 / M_PI * furnace_variance(percent / 100.0) / FURNACE_RUNS) / FURNACE_RADIANCE;
}

static void print_cell(FILE *out, const bench_row *row)
{
	if (row)
		fprintf(out, " %12.4g", row->median);
	else
		fprintf(out, " %12s", "-");
}

static void print_heads(FILE *out, const char *first, const char *theory)
{
	fprintf(out, "  %-10s", first);
	for (size_t s = 0; s < COUNT(subjects); s++)
		fprintf(out, " %12s", subjects[s].name);
	fprintf(out, " %12s\n", theory);
}

static bool has(const bench_results *results, const char *on, const char *metric, unsigned number)
{
	for (size_t s = 0; s < COUNT(subjects); s++)
		if (row_of(results, on, subjects[s].name, metric, number))
			return true;
	return false;
}

static void report_bounces(FILE *out, const bench_results *results)
{
	if (!has(results, FURNACE_CASE_BOUNCES, "error", 0))
		return;
	fprintf(out, "\nlight lost by paths of at most n bounces, %% of the exact radiance\n\n");
	print_heads(out, "bounces", "series");
	for (size_t i = 0; i < COUNT(bounces); i++) {
		fprintf(out, "  %-10u", bounces[i]);
		for (size_t s = 0; s < COUNT(subjects); s++)
			print_cell(out, row_of(results, FURNACE_CASE_BOUNCES, subjects[s].name, "error", bounces[i]));
		fprintf(out, " %12.4g\n", 100.0 * pow(FURNACE_REFLECTANCE, bounces[i] + 1));
	}
	fputc('\n', out);
}

static void report_survival(FILE *out, const bench_results *results, const char *metric, const char *title,
                            double (*theory)(unsigned percent))
{
	if (!has(results, FURNACE_CASE_SURVIVAL, metric, survivals[0]))
		return;
	fprintf(out, "%s\n\n", title);
	print_heads(out, "survival", theory ? "theory" : "");
	for (size_t i = 0; i < COUNT(survivals); i++) {
		fprintf(out, "  %3u %%     ", survivals[i]);
		for (size_t s = 0; s < COUNT(subjects); s++)
			print_cell(out, row_of(results, FURNACE_CASE_SURVIVAL, subjects[s].name, metric, survivals[i]));
		if (theory)
			fprintf(out, " %12.4g", theory(survivals[i]));
		fputc('\n', out);
	}
	fputc('\n', out);
}

static double theory_variance(unsigned percent)
{
	return furnace_variance(percent / 100.0);
}

static void report_equal(FILE *out, const bench_results *results)
{
	const bench_row *path = bench_find(results, FURNACE_CASE_EQUAL_TIME, "stilb", "path");
	if (!path)
		return;
	fprintf(out, "Cornell box with at most %u bounces, equal time: error of a pixel, %% of the mean radiance\n\n",
	        FURNACE_EQUAL_DEPTH);
	for (size_t m = 0; m < COUNT(equal_metrics); m++) {
		const bench_row *row = bench_find(results, FURNACE_CASE_EQUAL_TIME, "stilb", equal_metrics[m].name);
		bench_ratio ratio = {0};
		if (row && bench_paired_ratio(results, row, path, &ratio))
			fprintf(out,
			        "  %-14s %8.2f [%.2f-%.2f]   for the error of path it needs %.1f [%.1f-%.1f] x the time of path\n",
			        equal_metrics[m].name, row->median, row->min, row->max, ratio.median * ratio.median,
			        ratio.min * ratio.min, ratio.max * ratio.max);
	}
	fputc('\n', out);
}

static void report(FILE *out, const bench_results *results)
{
	report_bounces(out, results);
	report_survival(out, results, "error", "mean error of 1,000 paths, % of the exact radiance", expected_error);
	report_survival(out, results, "variance", "variance of a path, (W/sr/m2)^2", theory_variance);
	report_survival(out, results, "bias", "bias: error of the mean of all paths, % of the exact radiance", NULL);
	report_equal(out, results);
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

static const struct {
	const char *color;
	int point;
} looks[COUNT(subjects)] = {{"#c00000", 7}, {"#0050b0", 4}, {"#e08000", 8}, {"#606060", 2}};

/* Writes data blocks "x median least most", one for each subject; apart: distance in x between two subjects. */
static void write_block(FILE *out, const bench_results *results, const char *name, const char *on, const char *metric,
                        const unsigned *numbers, size_t count, double apart)
{
	for (size_t s = 0; s < COUNT(subjects); s++) {
		fprintf(out, "$%s%zu << END\n", name, s);
		bool any = false;
		for (size_t i = 0; i < count; i++) {
			const bench_row *row = row_of(results, on, subjects[s].name, metric, numbers[i]);
			if (row)
				fprintf(out, "%g %.6g %.6g %.6g\n", numbers[i] + apart * ((double)s - 1.5), row->median, row->min,
				        row->max);
			if (row)
				any = true;
		}
		fprintf(out, "%sEND\n", any ? "" : "NaN NaN NaN NaN\n");
	}
}

static void begin(FILE *out, const char *title, const char *x, const char *y)
{
	fprintf(out,
	        "set title \"%s\"\nset xlabel \"%s\"\nset ylabel \"%s\"\nunset logscale\nset xrange [*:*]\n"
	        "set yrange [*:*]\nset xtics autofreq\nunset arrow\nunset label\nset key above horizontal Left reverse\n",
	        title, x, y);
}

/* Adds the points of all subjects to the plot command that the caller has begun, and ends the command. */
static void plot_block(FILE *out, const char *name)
{
	for (size_t s = 0; s < COUNT(subjects); s++)
		fprintf(
			out,
			", $%s%zu using 1:2:3:4 with yerrorbars linecolor rgb '%s' pointtype %d pointsize 1.1 linewidth 1.3 title "
			"\"%s\"",
			name, s, looks[s].color, looks[s].point, subjects[s].name);
	fputc('\n', out);
}

/* Marks in the diagram the survival probability, in percent, below which the variance is infinite. */
static void mark_limit(FILE *out)
{
	double limit = 100.0 * FURNACE_REFLECTANCE * FURNACE_REFLECTANCE;
	fprintf(out,
	        "set arrow from %g, graph 0 to %g, graph 1 nohead linewidth 1.5 dashtype 2 linecolor rgb '#a0a0a0'\n"
	        "set label \"infinite variance\\nto the left\" at %g, graph 0.95 right textcolor rgb '#707070'\n",
	        limit, limit, limit - 1.0);
}

#define THEORY "with lines linewidth 1.5 linecolor rgb '#000000'"

static void plot(FILE *out, const bench_results *results)
{
	double rho = FURNACE_REFLECTANCE;
	fprintf(out, "set samples 1000\nvariance(p) = p > %g ? %g / (1 - %g / p) - %g : NaN\n", rho * rho,
	        (1.0 + rho) / (1.0 - rho), rho * rho, FURNACE_RADIANCE * FURNACE_RADIANCE);

	write_block(out, results, "cut", FURNACE_CASE_BOUNCES, "error", bounces, COUNT(bounces), 0.0);
	begin(out, "paths end after n bounces: equal for all generators", "bounces", "light lost, % of the exact radiance");
	fprintf(out,
	        "set logscale y\nset xrange [-0.8:16.8]\nset xtics 2\nplot 100 * %g ** (x + 1) " THEORY " title \"series\"",
	        rho);
	plot_block(out, "cut");

	write_block(out, results, "error", FURNACE_CASE_SURVIVAL, "error", survivals, COUNT(survivals), 0.5);
	begin(out, "mean error of 1,000 paths", "survival, %", "% of the exact radiance");
	mark_limit(out);
	fprintf(
		out,
		"set logscale y\nset xrange [2:98]\nset xtics 10\nplot 100 * sqrt(2 / pi * variance(x / 100) / %u) / %g " THEORY
		" title \"theory\"",
		FURNACE_RUNS, FURNACE_RADIANCE);
	plot_block(out, "error");

	write_block(out, results, "variance", FURNACE_CASE_SURVIVAL, "variance", survivals, COUNT(survivals), 0.5);
	begin(out, "variance of a path", "survival, %", "(W sr^-1 m^-2)^2");
	mark_limit(out);
	fprintf(out, "set logscale y\nset xrange [2:98]\nset xtics 10\nplot variance(x / 100) " THEORY " title \"theory\"");
	plot_block(out, "variance");

	write_block(out, results, "bias", FURNACE_CASE_SURVIVAL, "bias", survivals, COUNT(survivals), 0.5);
	begin(out, "bias where the variance is finite", "survival, %", "% of the exact radiance");
	fprintf(out, "set xrange [27:98]\nset yrange [-2:2]\nset xtics 10\nplot 0 " THEORY " notitle");
	plot_block(out, "bias");
}

const bench_suite bench_furnace_suite = {
	.name = "furnace",
	.help = "path tracing where the exact radiance is known: bounces, roulette, rand()",
	.subjects = subjects,
	.subject_count = COUNT(subjects),
	.cases = cases,
	.case_count = COUNT(cases),
	.report = report,
	.report_alone = true,
	.plot = plot,
	.plot_rows = 2};
