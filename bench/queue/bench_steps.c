/*
 * The suite `queue --steps`: repeats the measurements of Herb Sutter, "Measuring Parallel Performance: Optimizing a
 * Concurrent Queue" (Dr. Dobb's Journal, December 2008): four steps of a two-lock queue, small and large items, every
 * number of producers and consumers up to twice the CPUs. Throughput rises until all CPUs are busy; with more threads
 * than CPUs it drops and scatters, so the report shows the slowest run of that region as well as the best.
 */
#include "bench/harness/bench.h"
#include "bench/harness/bench_internal.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define MAX_COUNTS 6 /* the most different numbers of producers, and of consumers */

static const bench_subject subjects[] = {
	{.name = "step1",
     .program = "stilb-bench-queue-steps",
     .note = "two locks; allocation and copies are done under them"},
	{.name = "step2", .program = "stilb-bench-queue-steps", .note = "allocation and copies are done outside the locks"},
	{.name = "step3", .program = "stilb-bench-queue-steps", .note = "consumers free the nodes that they emptied"},
	{.name = "step4",
     .program = "stilb-bench-queue-steps",
     .note = "both ends, locks and nodes lie on separate cache lines"},
};

static const bench_metric metrics[] = {
	{"throughput", "Mops/s", false, NULL},
	{BENCH_METRIC_ITEMS, "items", false, NULL},
};

static const char *const sizes[] = {"small", "large"};
static const char *const size_titles[] = {"small items: 10 strings of 26 characters",
                                          "large items: 100 strings of 26 characters"};

static uint32_t counts[MAX_COUNTS]; /* [count_count], ascending: numbers of producers, and of consumers */
static size_t count_count;

typedef struct combination {
	char name[32], title[80];
} combination;

static combination combinations[COUNT(sizes)][MAX_COUNTS][MAX_COUNTS];
static bench_case cases[COUNT(sizes) * MAX_COUNTS * MAX_COUNTS];

/* ---- best and worst ---------------------------------------------------------------------------------------------- */

static const bench_row *row_of(const bench_results *results, size_t size, size_t producers, size_t consumers,
                               const char *subject)
{
	return bench_find(results, combinations[size][producers][consumers].name, subject, metrics[0].name);
}

/* True if the threads outnumber the CPUs; producers and consumers are indices into counts. */
static bool threads_exceed_cpus(size_t producers, size_t consumers)
{
	return counts[producers] + counts[consumers] > bench_cpu_count();
}

typedef struct extremes {
	const bench_row *best;  /* largest median */
	const bench_row *worst; /* slowest single run with more threads than CPUs */
	const bench_row *one;   /* one producer, one consumer */
} extremes;

static extremes find_extremes(const bench_results *results, size_t size, const char *subject)
{
	extremes found = {.one = row_of(results, size, 0, 0, subject)};
	for (size_t p = 0; p < count_count; p++)
		for (size_t c = 0; c < count_count; c++) {
			const bench_row *row = row_of(results, size, p, c, subject);
			if (row && (!found.best || row->median > found.best->median))
				found.best = row;
			if (row && threads_exceed_cpus(p, c) && (!found.worst || row->min < found.worst->min))
				found.worst = row;
		}
	return found;
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void print_grid(FILE *out, const bench_results *results, size_t size, const char *subject)
{
	fprintf(out, "  %s, producers down, consumers across, Mops/s: median [least-most]\n%6s", subject, "");
	for (size_t c = 0; c < count_count; c++)
		fprintf(out, " %20uC", counts[c]);
	fputc('\n', out);
	for (size_t p = 0; p < count_count; p++) {
		fprintf(out, "%5uP", counts[p]);
		for (size_t c = 0; c < count_count; c++) {
			const bench_row *row = row_of(results, size, p, c, subject);
			char text[64] = "-";
			if (row)
				snprintf(text, sizeof text, "%.3f [%.3f-%.3f]", row->median, row->min, row->max);
			fprintf(out, " %21s", text);
		}
		fputc('\n', out);
	}
}

static void print_summary(FILE *out, const bench_results *results, size_t size)
{
	fprintf(out,
	        "\n%s; scalability: best / 1P1C; worst: the slowest run with more threads than CPUs (%u)\n"
	        "  %-8s %10s %10s %16s %12s %10s %16s %13s\n",
	        size_titles[size], bench_cpu_count(), "", "1P1C", "best", "at", "scalability", "worst", "at",
	        "worst / best");
	for (size_t s = 0; s < COUNT(subjects); s++) {
		extremes e = find_extremes(results, size, subjects[s].name);
		if (!e.best || !e.worst || !e.one)
			continue;
		fprintf(out, "  %-8s %10.3f %10.3f %16s %12.2f %10.3f %16s %13.2f\n", subjects[s].name, e.one->median,
		        e.best->median, e.best->on->name, e.best->median / e.one->median, e.worst->min, e.worst->on->name,
		        e.worst->min / e.best->median);
	}
}

static void report(FILE *out, const bench_results *results)
{
	for (size_t size = 0; size < COUNT(sizes); size++) {
		bool any = false;
		for (size_t s = 0; s < COUNT(subjects); s++)
			if (find_extremes(results, size, subjects[s].name).best) {
				fprintf(out, "%s%s\n", any ? "" : "\n", any ? "" : size_titles[size]);
				print_grid(out, results, size, subjects[s].name);
				any = true;
			}
		if (any)
			print_summary(out, results, size);
	}
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

typedef enum curve {
	CURVE_THROUGHPUT,  /* of N producers and N consumers */
	CURVE_SCALABILITY, /* the same divided by that of one producer and one consumer */
	CURVE_WORST,       /* the slowest run of any mix with that many threads */
	CURVE_COUNT
} curve;

/* Lines "threads median least most" for equal numbers of producers and consumers. */
static void write_equal_counts(FILE *out, const bench_results *results, size_t size, const char *subject, bool scaled)
{
	const bench_row *one = row_of(results, size, 0, 0, subject);
	double unit = scaled && one ? one->median : 1.0;
	for (size_t n = 0; n < count_count; n++) {
		const bench_row *row = row_of(results, size, n, n, subject);
		if (row)
			fprintf(out, "%u %.6g %.6g %.6g\n", 2 * counts[n], row->median / unit, row->min / unit, row->max / unit);
	}
}

static void write_worst(FILE *out, const bench_results *results, size_t size, const char *subject)
{
	for (uint32_t threads = 2; threads <= 2 * counts[count_count - 1]; threads++) {
		double worst = BENCH_NO_NUMBER;
		for (size_t p = 0; p < count_count; p++)
			for (size_t c = 0; c < count_count; c++) {
				const bench_row *row = row_of(results, size, p, c, subject);
				if (row && counts[p] + counts[c] == threads && !(row->min >= worst))
					worst = row->min;
			}
		if (isfinite(worst))
			fprintf(out, "%u %.6g %.6g %.6g\n", threads, worst, worst, worst);
	}
}

static void write_diagram(FILE *out, const bench_results *results, size_t size, curve which)
{
	static const char *const titles[] = {"throughput, as many producers as consumers",
	                                     "scalability: throughput / that of 1 producer and 1 consumer",
	                                     "slowest run of any mix of producers and consumers"};
	fprintf(out, "set title \"%s\\n%s\"\nset ylabel \"%s\"\n", size_titles[size], titles[which],
	        which == CURVE_SCALABILITY ? "times (more is better)" : "million items/s (more is better)");
	for (size_t s = 0; s < COUNT(subjects); s++) {
		fprintf(out, "$curve%zu << END\n", s);
		if (which == CURVE_WORST)
			write_worst(out, results, size, subjects[s].name);
		else
			write_equal_counts(out, results, size, subjects[s].name, which == CURVE_SCALABILITY);
		fprintf(out, "END\n");
	}
	fprintf(out, "plot ");
	for (size_t s = 0; s < COUNT(subjects); s++) {
		double shift = ((double)s - 1.5) * 0.06; /* in x, keeps the error bars of the four subjects apart */
		fprintf(out,
		        "%s$curve%zu using ($1%+.2f):2:3:4 with yerrorbars linestyle %zu notitle, "
		        "$curve%zu using ($1%+.2f):2 with linespoints linestyle %zu title \"%s: %s\"",
		        s ? ", " : "", s, shift, s + 1, s, shift, s + 1, subjects[s].name, subjects[s].note);
	}
	fputc('\n', out);
}

static void plot(FILE *out, const bench_results *results)
{
	static const char *const colours[] = {"#808080", "#e08000", "#0050b0", "#c00000"};
	for (size_t s = 0; s < COUNT(subjects); s++)
		fprintf(out, "set style line %zu linecolor rgb '%s' linewidth 2 pointtype %zu pointsize 1.3\n", s + 1,
		        colours[s], 2 * s + 5);
	fprintf(
		out,
		"set xlabel \"threads: producers + consumers\"\nset xrange [1.5:%u.5]\nset xtics 1\nset yrange [0:*]\n"
		"set key below vertical maxrows 2 Left reverse\n"
		"set object rectangle from %u.5, graph 0 to graph 1, graph 1 behind fillcolor rgb '#f2ece0' fillstyle solid "
		"noborder\nset label \"more threads than CPUs\" at graph 0.98, graph 0.95 right textcolor rgb '#806020'\n",
		2 * counts[count_count - 1], bench_cpu_count());
	for (curve which = CURVE_THROUGHPUT; which < CURVE_COUNT; which++)
		for (size_t size = 0; size < COUNT(sizes); size++)
			write_diagram(out, results, size, which);
}

/* ---- the suite --------------------------------------------------------------------------------------------------- */

/* Fills counts: 1 to twice the CPUs, evenly spread if those are more than MAX_COUNTS. */
static void choose_counts(void)
{
	uint32_t most = 2 * bench_cpu_count();
	count_count = most < MAX_COUNTS ? most : MAX_COUNTS;
	for (size_t i = 0; i < count_count; i++)
		counts[i] = count_count == most ? (uint32_t)i + 1 : 1 + (uint32_t)(i * (most - 1) / (count_count - 1));
}

/* Fills names, titles and cases of all combinations; returns their number. */
static size_t fill_cases(void)
{
	size_t filled = 0;
	for (size_t size = 0; size < COUNT(sizes); size++)
		for (size_t p = 0; p < count_count; p++)
			for (size_t c = 0; c < count_count; c++) {
				combination *at = &combinations[size][p][c];
				snprintf(at->name, sizeof at->name, "%s-%uP%uC", sizes[size], counts[p], counts[c]);
				snprintf(at->title, sizeof at->title, "%s, %u producers, %u consumers", size_titles[size], counts[p],
				         counts[c]);
				cases[filled++] = (bench_case){
					.name = at->name, .title = at->title, .metrics = metrics, .metric_count = COUNT(metrics)};
			}
	return filled;
}

const bench_suite *bench_steps_suite(void)
{
	static bench_suite suite = {.name = "queue --steps",
	                            .help = "a two-lock queue in four steps of optimization, after Herb Sutter",
	                            .subjects = subjects,
	                            .subject_count = COUNT(subjects),
	                            .cases = cases,
	                            .report = report,
	                            .report_alone = true,
	                            .plot = plot,
	                            .plot_rows = CURVE_COUNT};
	if (suite.case_count == 0) {
		choose_counts();
		suite.case_count = fill_cases();
	}
	return &suite;
}
