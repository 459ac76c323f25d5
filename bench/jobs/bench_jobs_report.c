/* The suite `jobs`: Stilb beside the best peer and the machine's limits, as text and as a picture. */
#include "bench/jobs/bench_jobs.h"

#include <math.h>
#include <string.h>

#define OURS "stilb"
#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* The peer with the best median in a case; NULL if none ran. */
static const bench_row *best_peer(const bench_results *results, const char *case_name, const char *metric)
{
	const bench_row *best = NULL;
	for (size_t i = 0; i < bench_suite_of(results)->subject_count; i++) {
		const bench_subject *subject = &bench_suite_of(results)->subjects[i];
		if (subject->reference || strncmp(subject->name, OURS, strlen(OURS)) == 0)
			continue;
		const bench_row *row = bench_find(results, case_name, subject->name, metric);
		if (row && (!best || (row->less_is_better ? row->median < best->median : row->median > best->median)))
			best = row;
	}
	return best;
}

/* ---- text ---------------------------------------------------------------------------------------------------- */

/* The ratio of Stilb's median to another subject's must be at most `ratio` for times, at least `ratio` for rates; 0: it
 * is only printed. on: the case. */
typedef struct goal {
	const char *on, *metric;
	const char *subject;  /* the other subject; NULL: the best peer */
	const char *their_on; /* the other subject's case; NULL: the same */
	double ratio;
} goal;

static const goal goals[] = {
	{"spawn", "rate", NULL, NULL, 1.5},
	{"spawn-pinned", "rate", NULL, NULL, 1.5},
	{"batch", "rate", NULL, "spawn", 5.0},
	{"batch-pinned", "rate", NULL, "spawn-pinned", 5.0},
	{"array", "rate", NULL, "spawn", 5.0},
	{"array-pinned", "rate", NULL, "spawn-pinned", 5.0},
	{"array", "rate", NULL, NULL, 0.0},
	{"array-pinned", "rate", NULL, NULL, 0.0},
	{"join2", "p50", NULL, NULL, 0.9},
	{"join8", "p50", NULL, NULL, 0.98},
	{"join64", "p50", NULL, NULL, 1.0},
	{"join64", "p50", "ideal", NULL, 1.03},
	{"join2-pinned", "p50", NULL, NULL, 0.9},
	{"join8-pinned", "p50", NULL, NULL, 0.98},
	{"join64-pinned", "p50", NULL, NULL, 1.0},
	{"join64-pinned", "p50", "ideal", NULL, 1.03},
	{"join8-phase", "p50", NULL, NULL, 1.0},
	{"join8-idle", "p50", "serial", NULL, 1.02},
	{"join64-idle", "p50", "serial", NULL, 0.0},
	{"join8-idle-phase", "p50", NULL, NULL, 1.0},
	{"join64-idle-phase", "p50", NULL, NULL, 1.0},
	{"loop-2", "p50", NULL, NULL, 0.97},
	{"loop-4", "p50", NULL, NULL, 0.97},
	{"loop-8", "p50", NULL, NULL, 0.97},
	{"loop-2", "p50", "ideal", NULL, 1.04},
	{"loop-4", "p50", "ideal", NULL, 1.04},
	{"loop-8", "p50", "ideal", NULL, 1.04},
	{"late-2", "p97", "ideal", NULL, 1.1},
	{"late-8", "p97", "ideal", NULL, 1.1},
	{"late-2-other", "p97", "ideal", NULL, 1.1},
	{"late-8-other", "p97", "ideal", NULL, 1.1},
	{"fib", "p50", NULL, NULL, 0.0},
	{"graph-chain", "p50", NULL, NULL, 0.6},
	{"graph-fan", "p50", NULL, NULL, 0.6},
	{"graph-1", "p50", NULL, NULL, 0.6},
	{"graph", "p50", NULL, NULL, 0.6},
	{"graph-us", "p50", NULL, NULL, 0.0},
	{"range", "p50", NULL, NULL, 0.0},
	{"tiles-1", "p50", NULL, NULL, 0.0},
	{"tiles", "p50", NULL, NULL, 0.0},
	{"reduce-1", "p50", NULL, NULL, 0.0},
	{"reduce", "p50", NULL, NULL, 0.0},
	{"sort-1", "p50", "serial", NULL, 0.0},
	{"sort-1", "p50", "std", NULL, 0.0},
	{"sort", "p50", NULL, NULL, 0.0},
	{"sort-10000", "p50", NULL, NULL, 0.0},
	{"sort-ordered", "p50", NULL, NULL, 0.0},
	{"wake-pinned", "start-p50", "futex", NULL, 0.0},
	{"wake-pinned", "start-p99", "futex", NULL, 1.3},
	{"steal", "start-p50", NULL, NULL, 0.0},
	{"steal", "taken-mean", "counter", NULL, 0.0},
};

static void print_goal(FILE *out, const bench_results *results, const goal *g)
{
	const char *their_on = g->their_on ? g->their_on : g->on;
	const bench_row *our = bench_find(results, g->on, OURS, g->metric);
	const bench_row *their =
		g->subject ? bench_find(results, their_on, g->subject, g->metric) : best_peer(results, their_on, g->metric);
	bench_ratio ratio;
	if (!our || !their || !bench_paired_ratio(results, our, their, &ratio))
		return;
	char theirs[64];
	snprintf(theirs, sizeof theirs, "%s%s%s", their->name, g->their_on ? " in " : "", g->their_on ? g->their_on : "");
	fprintf(out, "  %-18s %-10s %9.4g %-8s %-24s %9.4g %7.2f [%.2f-%.2f]", g->on, g->metric, our->median, our->unit,
	        theirs, their->median, ratio.median, ratio.min, ratio.max);
	bool met = our->less_is_better ? ratio.median <= g->ratio : ratio.median >= g->ratio;
	if (g->ratio > 0.0)
		fprintf(out, ", goal %s %.2f%s", our->less_is_better ? "<=" : ">=", g->ratio, met ? "  met" : "  MISSED");
	fputc('\n', out);
}

/* Prints Stilb's median of the case `idle`, which must be at most `most`. */
static void print_most(FILE *out, const bench_results *results, const char *metric, double most)
{
	const bench_row *our = bench_find(results, "idle", OURS, metric);
	if (our)
		fprintf(out, "  %-18s %-10s %9.4g %-8s [%.4g-%.4g], goal <= %.4g%s\n", "idle", metric, our->median, our->unit,
		        our->min, our->max, most, our->median <= most ? "  met" : "  MISSED");
}

void bench_jobs_goals(FILE *out, const bench_results *results)
{
	fprintf(out,
	        "\ngoals, set on the CPU named in docs/benchmarks.md; ratio: %s / the other in each round, median "
	        "[least-most]\n"
	        "  %-18s %-10s %9s %-8s %-24s %9s %7s\n",
	        OURS, "case", "metric", OURS, "", "the other", "", "ratio");
	for (size_t i = 0; i < COUNT(goals); i++)
		print_goal(out, results, &goals[i]);
	print_most(out, results, "burnt", 0.1);
	print_most(out, results, "idle", 0.02);
}

/* ---- picture ------------------------------------------------------------------------------------------------- */

/* A place on the x axis: a case (a workload), and the metric of it that is shown. */
typedef struct place {
	const char *on, *metric;
} place;

static const place usual[] = {
	{"spawn", "rate"},
	{"spawn-pinned", "rate"},
	{"array", "rate"},
	{"array-pinned", "rate"},
	{"join2", "p50"},
	{"join2-pinned", "p50"},
	{"join8", "p50"},
	{"join8-pinned", "p50"},
	{"join64", "p50"},
	{"join64-pinned", "p50"},
	{"join8-phase", "p50"},
	{"join8-idle", "p50"},
	{"join64-idle", "p50"},
	{"join8-idle-phase", "p50"},
	{"join64-idle-phase", "p50"},
	{"loop-2", "p50"},
	{"loop-4", "p50"},
	{"loop-8", "p50"},
	{"fib", "p50"},
	{"graph-chain", "p50"},
	{"graph-fan", "p50"},
	{"graph", "p50"},
	{"graph-us", "p50"},
	{"wake-pinned", "start-p50"},
	{"steal", "start-p50"},
};
static const place tails[] = {
	{"spawn", "slowest"},
	{"spawn-pinned", "slowest"},
	{"array", "slowest"},
	{"array-pinned", "slowest"},
	{"join2", "p99"},
	{"join2-pinned", "p99"},
	{"join8", "p99"},
	{"join8-pinned", "p99"},
	{"join64", "p99"},
	{"join64-pinned", "p99"},
	{"join8-phase", "p99"},
	{"join8-idle", "p99"},
	{"join64-idle", "p99"},
	{"join8-idle-phase", "p99"},
	{"join64-idle-phase", "p99"},
	{"loop-2", "worst"},
	{"loop-4", "worst"},
	{"loop-8", "worst"},
	{"fib", "worst"},
	{"graph-chain", "p99"},
	{"graph-fan", "p99"},
	{"graph", "p99"},
	{"graph-us", "p99"},
	{"wake-pinned", "start-p99"},
	{"steal", "start-p99"},
};

/* Line styles of the subjects: Stilb's in strong colours with filled marks, references with crosses. */
static const struct {
	const char *subject, *style;
} marks[] = {
	{"openmp", "linecolor rgb '#9a6a00' linewidth 1.2 pointtype 8 pointsize 1.3"},
	{"openmp-static", "linecolor rgb '#5070a0' linewidth 1.2 pointtype 10 pointsize 1.3"},
	{"tbb", "linecolor rgb '#404040' linewidth 1.2 pointtype 6 pointsize 1.2"},
	{"tbb-static", "linecolor rgb '#508050' linewidth 1.2 pointtype 4 pointsize 1.2"},
	{"serial", "linecolor rgb '#808080' linewidth 1.2 pointtype 2 pointsize 1.0"},
	{"ideal", "linecolor rgb '#00a0a0' linewidth 1.6 pointtype 1 pointsize 1.4"},
	{"futex", "linecolor rgb '#8060a0' linewidth 1.2 pointtype 3 pointsize 1.2"},
	{"counter", "linecolor rgb '#a05050' linewidth 1.2 pointtype 3 pointsize 1.2"},
	{"stilb-lock-free", "linecolor rgb '#0050b0' linewidth 2 pointtype 5 pointsize 1.4"},
	{"stilb-over-sutter", "linecolor rgb '#e08000' linewidth 2 pointtype 9 pointsize 1.4"},
	{"stilb-over-mutex", "linecolor rgb '#007030' linewidth 2 pointtype 11 pointsize 1.4"},
	{"stilb", "linecolor rgb '#c00000' linewidth 2 pointtype 7 pointsize 1.6"},
};

/* A value of the row as a time, in units of the peer's median time: less than 1 is faster than the peer. Rates are
 * inverted. */
static double relative(const bench_row *row, const bench_row *peer, double value)
{
	return row->less_is_better ? value / peer->median : peer->median / value;
}

/* Writes a line "x ratio least most" for each place: the times of subject marks[mark] in units of the best peer's.
 * Returns the number of lines. */
static size_t write_relative(FILE *out, const bench_results *results, const place *places, size_t count, size_t mark)
{
	size_t written = 0;
	for (size_t i = 0; i < count; i++) {
		const bench_row *row = bench_find(results, places[i].on, marks[mark].subject, places[i].metric);
		const bench_row *peer = best_peer(results, places[i].on, places[i].metric);
		if (!row || !peer)
			continue;
		double x = (double)i + 0.7 * ((double)mark + 0.5) / (double)COUNT(marks) - 0.35;
		double a = relative(row, peer, row->min), b = relative(row, peer, row->max);
		fprintf(out, "%.3f %.6g %.6g %.6g\n", x, relative(row, peer, row->median), fmin(a, b), fmax(a, b));
		written++;
	}
	return written;
}

/* A diagram over the whole width: all subjects relative to the best peer. */
static void plot_relative(FILE *out, const bench_results *results, const char *name, const char *title,
                          const place *places, size_t count, int row)
{
	bool any[COUNT(marks)];
	for (size_t m = 0; m < COUNT(marks); m++) {
		fprintf(out, "$%s%zu << END\n", name, m);
		any[m] = write_relative(out, results, places, count, m) > 0;
		fprintf(out, "END\n");
	}
	fprintf(
		out,
		"set origin 0,%.4f\nset size 1,%.4f\nset title \"%s\"\nset ylabel 'time / best peer (less is better)'\n"
		"set logscale y 2\nset yrange [1.0/16:8]\nset xrange [-0.5:%zu.5]\nunset arrow\n"
		"set arrow from graph 0, first 1 to graph 1, first 1 nohead linewidth 1.5 linecolor rgb '#606060'\nset xtics (",
		0.96 * (BENCH_JOBS_PLOT_ROWS - 1 - row) / BENCH_JOBS_PLOT_ROWS, 0.96 / BENCH_JOBS_PLOT_ROWS, title, count - 1);
	for (size_t i = 0; i < count; i++)
		fprintf(out, "%s\"%s\" %zu", i ? ", " : "", places[i].on, i);
	fprintf(out, ") rotate by -25\n");
	for (size_t i = 1; i < count; i++)
		fprintf(out, "set arrow from %zu.5, graph 0 to %zu.5, graph 1 nohead linecolor rgb '#e0e0e0'\n", i - 1, i - 1);
	fprintf(out, "plot ");
	const char *comma = "";
	for (size_t m = 0; m < COUNT(marks); m++)
		if (any[m]) {
			fprintf(out, "%s$%s%zu using 1:2:3:4 with yerrorbars %s title \"%s\"", comma, name, m, marks[m].style,
			        marks[m].subject);
			comma = ", ";
		}
	fprintf(out, "%s1 with lines linecolor rgb '#606060' notitle\n", comma);
}

/* A diagram of half the width: medians of one metric in its own unit. */
static void plot_plain(FILE *out, const bench_results *results, const char *name, const char *title,
                       const char *const *cases, const char *metric, const char *unit, int column)
{
	fprintf(out,
	        "set origin %.2f,0\nset size 0.5,%.4f\nset title \"%s\"\nset ylabel '%s'\nunset logscale y\nset yrange "
	        "[0:*]\nunset arrow\nset xtics (",
	        0.5 * column, 0.96 / BENCH_JOBS_PLOT_ROWS, title, unit);
	int count = 0;
	for (const char *const *on = cases; *on; on++, count++)
		fprintf(out, "%s\"%s\" %d", count ? ", " : "", *on, count);
	fprintf(out, ") norotate\nset xrange [-0.5:%d.5]\n", count - 1);
	char plot[2048] = "plot NaN notitle";
	for (size_t m = 0; m < COUNT(marks); m++) {
		fprintf(out, "$%s%zu << END\n", name, m);
		bool any = false;
		for (int i = 0; i < count; i++) {
			const bench_row *row = bench_find(results, cases[i], marks[m].subject, metric);
			if (!row)
				continue;
			fprintf(out, "%.3f %.6g %.6g %.6g\n", i + 0.7 * ((double)m + 0.5) / (double)COUNT(marks) - 0.35,
			        row->median, row->min, row->max);
			any = true;
		}
		fprintf(out, "END\n");
		size_t length = strlen(plot);
		if (any)
			snprintf(plot + length, sizeof plot - length, ", $%s%zu using 1:2:3:4 with yerrorbars %s title \"%s\"",
			         name, m, marks[m].style, marks[m].subject);
	}
	fprintf(out, "%s\n", plot);
}

void bench_jobs_plot(FILE *out, const bench_results *results)
{
	static const char *const loops[] = {"loop-1", "loop-2", "loop-4", "loop-8", NULL};
	static const char *const outside[] = {"outside", "outside-4", NULL};
	plot_relative(out, results, "usual", "median", usual, COUNT(usual), 0);
	plot_relative(out, results, "tail", "99th percentile (jobs, loops and fib: the slowest of a run)", tails,
	              COUNT(tails), 1);
	plot_plain(out, results, "loop", "loop over 20,000 items of 200 ns on 1 to 8 threads", loops, "p50",
	           "ms (less is better)", 0);
	plot_plain(out, results, "outside", "empty jobs submitted by threads outside of the pool, with several queues",
	           outside, "rate", "Mjobs/s (more is better)", 1);
}
