/* The suite `cull`: its table, its goals (bounds of the measured times), each met or missed, and its picture. */
#include "bench/cull/bench_cull.h"

#include <string.h>

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))
#define FLAT "stilb-flat-avx512"
#define OCTREE "stilb-octree"

/* ---- table ------------------------------------------------------------------------------------------------------- */

static void print_case(FILE *out, const bench_results *results, const char *on)
{
	char line[512];
	int length = snprintf(line, sizeof line, "  %-10s", on);
	bool any = false;
	for (size_t s = 0; s < bench_suite_of(results)->subject_count; s++) {
		const bench_row *row = bench_find(results, on, bench_suite_of(results)->subjects[s].name, "per-model");
		int width = (int)sizeof line - length;
		if (row)
			length += snprintf(line + length, (size_t)width, " %*.3f", 17, row->median);
		else
			length += snprintf(line + length, (size_t)width, " %*s", 17, "-");
		if (row)
			any = true;
	}
	if (any)
		fprintf(out, "%s\n", line);
}

static void print_table(FILE *out, const bench_results *results)
{
	fprintf(out, "\nculling time / number of models in the scene, ns, medians\n  %-10s", "models-%");
	for (size_t s = 0; s < bench_suite_of(results)->subject_count; s++)
		fprintf(out, " %17s", bench_suite_of(results)->subjects[s].name);
	fputc('\n', out);
	for (size_t c = 0; c < bench_suite_of(results)->case_count; c++)
		print_case(out, results, bench_suite_of(results)->cases[c].name);
}

/* ---- goals ------------------------------------------------------------------------------------------------------- */

/* In the case `on` the time of subject `theirs` divided by that of `ours` must be at least `least`; 0: only printed. */
typedef struct ratio_goal {
	const char *on, *ours, *theirs;
	double least;
} ratio_goal;

static const ratio_goal ratio_goals[] = {
	{"10k-1", OCTREE, FLAT, 2.0},
	{"10k-10", OCTREE, FLAT, 0.0},
	{"10k-50", OCTREE, FLAT, 0.0},
	{"10k-100", OCTREE, FLAT, 2.0},
	{"100k-1", OCTREE, FLAT, 0.0},
	{"100k-10", OCTREE, FLAT, 0.0},
	{"100k-50", OCTREE, FLAT, 0.0},
	{"100k-100", OCTREE, FLAT, 2.0},
	{"1M-1", OCTREE, FLAT, 6.0},
	{"1M-10", OCTREE, FLAT, 0.0},
	{"1M-50", OCTREE, FLAT, 0.0},
	{"1M-100", OCTREE, FLAT, 2.0},
	{"10k-move", OCTREE, "rebuild", 10.0},
	{"100k-move", OCTREE, "rebuild", 10.0},
	{"1M-move", OCTREE, "rebuild", 10.0},
	{"10k-50", "stilb-flat-avx2", "stilb-flat-scalar", 0.0},
	{"10k-50", FLAT, "stilb-flat-avx2", 0.0},
	{"100k-50", "stilb-flat-2", FLAT, 0.0},
	{"1M-50", "stilb-flat-2", FLAT, 0.0},
	{"1M-1", "stilb-octree-2", OCTREE, 0.0},
	{"1M-10", "stilb-octree-2", OCTREE, 0.0},
	{"10k-50", "stream", FLAT, 0.0},
	{"100k-50", "stream", FLAT, 0.0},
	{"1M-50", "stream", FLAT, 0.0},
};

static const char *verdict(bool met)
{
	return met ? "met" : "MISSED";
}

/* The times of a subject in a case; of FLAT on a CPU without AVX-512 those of the widest that there is. NULL: none. */
static const bench_row *times_of(const bench_results *results, const char *on, const char *subject)
{
	static const char *const narrower[] = {"stilb-flat-avx2", "stilb-flat-scalar"};
	const bench_row *row = bench_find(results, on, subject, "p50");
	for (size_t i = 0; i < COUNT(narrower) && !row && strcmp(subject, FLAT) == 0; i++)
		row = bench_find(results, on, narrower[i], "p50");
	return row;
}

static void print_ratio(FILE *out, const bench_results *results, const ratio_goal *g)
{
	const bench_row *our = times_of(results, g->on, g->ours), *their = times_of(results, g->on, g->theirs);
	bench_ratio ratio;
	if (!our || !their || our == their || !bench_paired_ratio(results, their, our, &ratio))
		return;
	fprintf(out, "  %-10s %-18s %9.4g us, %-18s / this %7.3g [%.3g-%.3g]", g->on, our->name, our->median, their->name,
	        ratio.median, ratio.min, ratio.max);
	if (g->least > 0.0)
		fprintf(out, ", goal >= %.3g  %s", g->least, verdict(ratio.median >= g->least));
	fputc('\n', out);
}

/* The automatic choice may take at most a tenth longer than the better of flat and octree. */
static void print_choice(FILE *out, const bench_results *results, const char *on)
{
	const bench_row *our = times_of(results, on, "stilb-auto"), *flat = times_of(results, on, FLAT),
					*octree = times_of(results, on, OCTREE);
	bench_ratio ratio;
	if (!our || !flat || !octree)
		return;
	const bench_row *better = octree->median < flat->median ? octree : flat;
	if (bench_paired_ratio(results, our, better, &ratio))
		fprintf(out, "  %-10s %-18s %9.4g us, this / %-18s %7.3g [%.3g-%.3g], goal <= 1.1  %s\n", on, our->name,
		        our->median, better->name, ratio.median, ratio.min, ratio.max, verdict(ratio.median <= 1.1));
}

/* The median time of a subject in a case must be at most `most`, in microseconds. */
static const struct {
	const char *on, *subject;
	double most;
} time_goals[] = {
	{"10k-1", FLAT, 2.0}, {"10k-10", FLAT, 2.0}, {"10k-50", FLAT, 2.0}, {"10k-100", FLAT, 2.0}, {"1M-1", OCTREE, 60.0},
};

void bench_cull_report(FILE *out, const bench_results *results)
{
	print_table(out, results);
}

void bench_cull_goals(FILE *out, const bench_results *results)
{
	fprintf(
		out,
		"\ngoals, set on the CPU named in docs/benchmarks.md; ratios of times, median [least-most] of the rounds\n");
	for (size_t c = 0; c < bench_suite_of(results)->case_count; c++)
		print_choice(out, results, bench_suite_of(results)->cases[c].name);
	for (size_t i = 0; i < COUNT(ratio_goals); i++)
		print_ratio(out, results, &ratio_goals[i]);
	for (size_t i = 0; i < COUNT(time_goals); i++) {
		const bench_row *row = times_of(results, time_goals[i].on, time_goals[i].subject);
		if (row)
			fprintf(out, "  %-10s %-18s %9.4g us [%.4g-%.4g], goal <= %.3g us  %s\n", time_goals[i].on, row->name,
			        row->median, row->min, row->max, time_goals[i].most, verdict(row->median <= time_goals[i].most));
	}
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

/* A diagram: cases from left to right, at most 4, NULL-terminated. */
typedef struct diagram {
	const char *title, *ticks, *x_label;
	const char *cases[5];
} diagram;

#define SHARES "'1 %%' 0, '10 %%' 1, '50 %%' 2, 'all' 3" /* gnuplot formats them: %% is % */

static const diagram diagrams[2 * BENCH_CULL_PLOT_ROWS] = {
	{"10,000 models", SHARES, "visible", {"10k-1", "10k-10", "10k-50", "10k-100"}},
	{"100,000 models", SHARES, "visible", {"100k-1", "100k-10", "100k-50", "100k-100"}},
	{"1,000,000 models", SHARES, "visible", {"1M-1", "1M-10", "1M-50", "1M-100"}},
	{"a tenth moves in each frame, 10 % visible",
     "'10,000' 0, '100,000' 1, '1,000,000' 2",
     "models",
     {"10k-move", "100k-move", "1M-move"}},
};

/* Line styles: the octree red, flat blue, references grey; one thread solid, two dashed. */
static const struct {
	const char *subject, *style;
} lines[] = {
	{"stilb-flat-scalar", "linecolor rgb '#90b0d8' pointtype 9"},
	{"stilb-flat-avx2", "linecolor rgb '#4080c8' pointtype 11"},
	{"stilb-flat-avx512", "linecolor rgb '#0040a0' pointtype 5"},
	{"stilb-flat-2", "linecolor rgb '#0040a0' dashtype 2 pointtype 4"},
	{"stilb-octree", "linecolor rgb '#c00000' pointtype 7"},
	{"stilb-octree-2", "linecolor rgb '#c00000' dashtype 2 pointtype 6"},
	{"stilb-auto", "linecolor rgb '#007030' linewidth 3 pointtype 1"},
	{"rebuild", "linecolor rgb '#808080' pointtype 8"},
	{"stream", "linecolor rgb '#808080' dashtype 3 pointtype 2"},
};

/* Writes a data block "x median least most" of a subject's cases; false if none ran. */
static bool write_line(FILE *out, const bench_results *results, size_t place, size_t line)
{
	bool any = false;
	fprintf(out, "$line%zu_%zu << END\n", place, line);
	for (int x = 0; diagrams[place].cases[x]; x++) {
		const bench_row *row = bench_find(results, diagrams[place].cases[x], lines[line].subject, "per-model");
		if (row)
			fprintf(out, "%d %.6g %.6g %.6g\n", x, row->median, row->min, row->max);
		if (row)
			any = true;
	}
	fprintf(out, "END\n");
	return any;
}

static void plot_diagram(FILE *out, const bench_results *results, size_t place)
{
	bool any[COUNT(lines)];
	for (size_t i = 0; i < COUNT(lines); i++)
		any[i] = write_line(out, results, place, i);
	double height = 0.94 / BENCH_CULL_PLOT_ROWS;
	fprintf(out,
	        "set origin %.2f,%.4f\nset size 0.5,%.4f\nset title \"%s\"\nset ylabel 'ns for each model of the scene'\n"
	        "set xlabel '%s'\nset logscale y\nset yrange [*:*]\nset xrange [-0.2:%d.2]\nset xtics (%s)\n"
	        "set grid ytics mytics linecolor rgb '#d0d0d0'\nplot NaN notitle",
	        0.5 * (double)(place % 2), height * (double)(BENCH_CULL_PLOT_ROWS - 1 - place / 2), height,
	        diagrams[place].title, diagrams[place].x_label, diagrams[place].cases[3] ? 3 : 2, diagrams[place].ticks);
	for (size_t i = 0; i < COUNT(lines); i++)
		if (any[i])
			fprintf(out,
			        ", $line%zu_%zu using 1:2 with linespoints %s title '%s', $line%zu_%zu using 1:2:3:4 with "
			        "yerrorbars %s notitle",
			        place, i, lines[i].style, lines[i].subject, place, i, lines[i].style);
	fputc('\n', out);
}

void bench_cull_plot(FILE *out, const bench_results *results)
{
	for (size_t place = 0; place < COUNT(diagrams); place++)
		plot_diagram(out, results, place);
}
