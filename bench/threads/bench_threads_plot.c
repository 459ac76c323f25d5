/* The picture of the suite `threads`: gnuplot commands for four rows of two diagrams. */
#include "bench/harness/bench_internal.h"
#include "bench/threads/bench_threads.h"

#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define BAR 0.8 /* width of a bar; the distance of two bars is 1 */

static const char *const views[] = {"all", "half", "few"};

static const bench_row *row_of(const bench_results *results, const char *device, size_t view, size_t count,
                               const char *metric)
{
	char on[32];
	snprintf(on, sizeof on, "%s-%s", device, views[view]);
	return bench_find(results, on, bench_threads_name(bench_threads_counts[count]), metric);
}

static double median_of(const bench_results *results, const char *on, const char *subject, const char *metric)
{
	const bench_row *row = bench_find(results, on, subject, metric);
	return row ? row->median : 0.0;
}

/* Begins a diagram; resets all of gnuplot's settings that the diagram before it may have changed. */
static void begin(FILE *out, const char *title, const char *y)
{
	fprintf(out,
	        "set title \"%s\"\nset ylabel \"%s\"\nunset xlabel\nunset arrow\nunset label\nunset logscale\nset xtics "
	        "norotate autofreq font ',11'\nset ytics autofreq\nset xrange [*:*]\nset yrange [0:*]\nset style fill "
	        "solid 0.9 noborder\n"
	        "set boxwidth %g\nset key above horizontal Left reverse\nset tmargin 5\nset bmargin\n"
	        "set offsets 0, 0, graph 0.05, 0\n", /* keeps lines off the frame */
	        title, y, BAR);
}

/* An empty diagram, for cases that were not run. */
static void plot_nothing(FILE *out)
{
	fprintf(out, "set label \"not measured\" at graph 0.5, graph 0.5 center textcolor rgb '#808080'\n"
	             "set xrange [0:1]\nset yrange [0:1]\nunset xtics\nplot NaN notitle\n");
}

/* ---- stages as stacked bars -------------------------------------------------------------------------------------- */

static const struct {
	const char *metric, *colour;
} stages[] = {{"cull", "#228833"}, {"record", "#4477aa"}, {"replay", "#ee6677"}, {"rest", "#bbbbbb"}};

/* Writes a line "x top top ..." for each stacked bar: the heights at which its stages end, lowest first. Returns the
 * number of bars. */
static size_t write_stages(FILE *out, const bench_results *results, const char *device)
{
	size_t written = 0;
	fprintf(out, "$stages << END\n");
	for (size_t v = 0; v < COUNT(views); v++)
		for (size_t n = 0; n < bench_threads_count; n++) {
			double top = 0.0;
			if (!row_of(results, device, v, n, "frame"))
				continue;
			fprintf(out, "%zu", v * (bench_threads_count + 1) + n);
			for (size_t s = 0; s < COUNT(stages); s++)
				fprintf(out, " %.6g", top += row_of(results, device, v, n, stages[s].metric)->median);
			fprintf(out, "\n");
			written++;
		}
	fprintf(out, "END\n");
	return written;
}

static void plot_stages(FILE *out, const bench_results *results, const char *device, const char *title)
{
	begin(out, title, "ms of the main thread (less is better)");
	if (write_stages(out, results, device) == 0) {
		plot_nothing(out);
		return;
	}
	fprintf(out, "set xlabel \"workers, for each view\"\nset xrange [-1:%zu]\nset xtics (",
	        COUNT(views) * (bench_threads_count + 1) - 1);
	for (size_t v = 0; v < COUNT(views); v++)
		for (size_t n = 0; n < bench_threads_count; n++)
			fprintf(out, "%s\"%u\" %zu", v + n ? ", " : "", bench_threads_counts[n], v * (bench_threads_count + 1) + n);
	fprintf(out, ")\n");
	for (size_t v = 0; v < COUNT(views); v++) {
		const bench_row *visible = row_of(results, device, v, 0, "visible");
		if (visible)
			fprintf(out, "set label \"%s: %.0f models\" at %g, graph 0.96 center\n", views[v], visible->median,
			        (double)(v * (bench_threads_count + 1)) + ((double)bench_threads_count - 1.0) / 2.0);
	}
	fprintf(out, "set offsets 0, 0, graph 0.15, 0\nplot ");
	for (size_t s = COUNT(stages); s-- > 0;)
		fprintf(out, "$stages using 1:%zu with boxes linecolor rgb '%s' title \"%s\", ", s + 2, stages[s].colour,
		        stages[s].metric);
	fprintf(out, "$stages using 1:%zu:(number($%zu)) with labels offset 0,0.6 font ',10' notitle\n", COUNT(stages) + 1,
	        COUNT(stages) + 1);
}

/* ---- speed-up ---------------------------------------------------------------------------------------------------- */

static bool write_gain(FILE *out, const bench_results *results, const char *device, size_t view)
{
	bool any = false;
	fprintf(out, "$gain%zu << END\n", view);
	for (size_t n = 0; n < bench_threads_count; n++) {
		const bench_row *gain = row_of(results, device, view, n, "speed-up");
		double x = bench_threads_counts[n] + 0.06 * ((double)view - 1.0); /* keeps the views' error bars apart */
		if (gain)
			fprintf(out, "%g %.6g %.6g %.6g\n", x, gain->median, gain->min, gain->max);
		any |= !!gain;
	}
	fprintf(out, "END\n");
	return any;
}

/* Writes two upper bounds of the speed-up: the number of CPUs, and Amdahl's law, since workers share only culling and
 * recording. */
static void write_bounds(FILE *out, const bench_results *results, const char *device)
{
	const bench_row *frame = row_of(results, device, 0, 0, "frame"), *cull = row_of(results, device, 0, 0, "cull"),
					*record = row_of(results, device, 0, 0, "record");
	double shared = frame ? (cull->median + record->median) / frame->median : 1.0;
	fprintf(out, "$bounds << END\n");
	for (uint32_t n = 0; n <= bench_threads_too_many(); n++) {
		double cpus = n + 1 < bench_cpu_count() ? n + 1 : bench_cpu_count();
		fprintf(out, "%u %.6g %.6g\n", n, cpus, 1.0 / (1.0 - shared + shared / cpus));
	}
	fprintf(out, "END\n");
}

static void plot_gain(FILE *out, const bench_results *results, const char *device, const char *title)
{
	static const char *const styles[] = {"linecolor rgb '#0050b0' pointtype 7", "linecolor rgb '#c00000' pointtype 5",
	                                     "linecolor rgb '#e08000' pointtype 9"};
	bool any[COUNT(views)], some = false;
	begin(out, title, "times as fast as without workers (more is better)");
	for (size_t v = 0; v < COUNT(views); v++)
		some |= any[v] = write_gain(out, results, device, v);
	write_bounds(out, results, device);
	if (!some) {
		plot_nothing(out);
		return;
	}
	fprintf(
		out,
		"set xlabel \"workers beside the main thread\"\nset xtics 1\nset xrange [-0.3:%u.3]\n"
		"plot $bounds using 1:2 with lines linewidth 1.5 dashtype 2 linecolor rgb '#808080' title \"as many as CPUs\", "
		"$bounds using 1:3 with lines linewidth 1.5 dashtype 3 linecolor rgb '#404040' title \"all in view: cull "
		"and record shared\"",
		bench_threads_too_many());
	for (size_t v = 0; v < COUNT(views); v++)
		if (any[v])
			fprintf(out,
			        ", $gain%zu using 1:2:3:4 with yerrorbars linewidth 2 pointsize 1.5 %s notitle, $gain%zu using 1:2 "
			        "with linespoints linewidth 2 pointsize 1.5 %s title \"%s in view\"",
			        v, styles[v], v, styles[v], views[v]);
	fputc('\n', out);
}

/* ---- frames of the experiments ----------------------------------------------------------------------------------- */

/* A place on the x axis, at which the frame times of one subject (an implementation, such as a worker pool) in one case
 * (a workload) are drawn. */
typedef struct place {
	const char *on, *subject;        /* names of the case and the subject */
	const char *usual, *p99, *worst; /* names of the metrics drawn; worst may be NULL */
	const char *label;               /* "\n" is a new line to gnuplot */
	bool apart;                      /* a vertical line separates it from the place before */
} place;

#define USUAL_METRICS "frame", "p99", "worst"

static size_t write_places(FILE *out, const bench_results *results, const place *places, size_t count)
{
	size_t written = 0;
	fprintf(out, "$places << END\n");
	for (size_t i = 0; i < count; i++) {
		const place *at = &places[i];
		const bench_row *usual = bench_find(results, at->on, at->subject, at->usual);
		const bench_row *p99 = bench_find(results, at->on, at->subject, at->p99);
		const bench_row *worst = at->worst ? bench_find(results, at->on, at->subject, at->worst) : p99;
		if (usual && p99 && worst) {
			fprintf(out, "%zu %.6g %.6g %.6g\n", i, usual->median, p99->median, worst->max);
			written++;
		}
	}
	fprintf(out, "END\n");
	return written;
}

static void plot_places(FILE *out, const bench_results *results, const char *title, const place *places, size_t count)
{
	begin(out, title, "ms of a frame (less is better)");
	if (write_places(out, results, places, count) == 0) {
		plot_nothing(out);
		return;
	}
	fprintf(out, "set logscale y\nset yrange [*:*]\nset xrange [-0.6:%zu.8]\nset xtics (", count - 1);
	for (size_t i = 0; i < count; i++)
		fprintf(out, "%s\"%s\" %zu", i ? ", " : "", places[i].label, i);
	fprintf(out, ")\nset xtics nomirror font ',10'\nset bmargin 5\nset offsets 0, 0, 0, graph 0.05\n");
	for (size_t i = 1; i < count; i++)
		if (places[i].apart)
			fprintf(out, "set arrow from %zu.5, graph 0 to %zu.5, graph 1 nohead linecolor rgb '#808080'\n", i - 1,
			        i - 1);
	fprintf(
		out,
		"plot $places using 1:2:(0):($4-$2) with vectors nohead linewidth 1.5 linecolor rgb '#a0a0a0' notitle, "
		"$places using 1:4 with points pointtype 2 pointsize 1.4 linewidth 2 linecolor rgb '#c00000' title \"worst of "
		"all\", $places using 1:3 with points pointtype 9 pointsize 1.5 linecolor rgb '#e08000' title \"99 of 100 take "
		"less\", $places using 1:2 with points pointtype 7 pointsize 1.8 linecolor rgb '#0050b0' title \"median\", "
		"$places using 1:2:(number($2)) with labels left offset 1.2,0 font ',10' notitle\n");
}

static void plot_patterns(FILE *out, const bench_results *results)
{
	char names[2][32], labels[5][64];
	uint32_t fitting = bench_threads_fitting(), most = bench_threads_too_many();
	snprintf(names[0], sizeof names[0], "sutter-%u", fitting);
	snprintf(names[1], sizeof names[1], "sutter-%u", most);
	for (size_t i = 0; i < COUNT(labels); i++)
		snprintf(labels[i], sizeof labels[i], "%s\\n%u worker%s", i < 3 ? "engine" : "article's\\npool, 2009",
		         i % 2 ? fitting : most, (i % 2 ? fitting : most) == 1 ? "" : "s");
	const place places[] = {
		{"dedicated", bench_threads_name(0), USUAL_METRICS, "engine\\n0 workers", false},
		{"dedicated", bench_threads_name(fitting), USUAL_METRICS, labels[1], false},
		{"dedicated", "dedicated", USUAL_METRICS, "dedicated\\nrender thread", false},
		{"one-vs-four", bench_threads_name(fitting), USUAL_METRICS, labels[1], true},
		{"one-vs-four", bench_threads_name(most), USUAL_METRICS, labels[2], false},
		{"one-vs-four", names[0], USUAL_METRICS, labels[3], false},
		{"one-vs-four", names[1], USUAL_METRICS, labels[4], false},
		{"white-bar", "stilb-direct", "replay", "replay", NULL, "direct", true},
		{"white-bar", "stilb-secondary", "replay", "replay", NULL, "secondary", false},
		{"white-bar", "stilb-indirect", "replay", "replay", NULL, "indirect", false},
	};
	plot_places(out, results, "dedicated | one-vs-four | white-bar: replay alone, Vulkan", places, COUNT(places));
}

static void plot_stolen(FILE *out, const bench_results *results)
{
	const uint32_t counts[] = {0, bench_threads_fitting(), bench_threads_too_many()};
	place places[2 * COUNT(counts)];
	char labels[2 * COUNT(counts)][48];
	for (size_t i = 0; i < COUNT(places); i++) {
		const char *name = bench_threads_name(counts[i / 2]);
		snprintf(labels[i], sizeof labels[i], "%u workers\\n%s", counts[i / 2], i % 2 ? "and a thief" : "undisturbed");
		places[i] = i % 2 ? (place){"stolen", name, "during", "during-p99", "worst", labels[i], false}
		                  : (place){"stolen", name, "before", "before-p99", NULL, labels[i], i > 0};
	}
	plot_places(out, results, "stolen: another process burns a core", places, COUNT(places));
}

/* ---- mutex-vs-lowlock -------------------------------------------------------------------------------------------- */

static const struct {
	const char *on, *title;
} queue_cases[] = {{"mutex-vs-lowlock", "a draw an item"},
                   {"mutex-vs-lowlock-2009", "a draw of 2009 an item"},
                   {"mutex-vs-lowlock-segments", "512 draws an item"}};

static const struct {
	const char *subject, *label;
} queues[] = {{"no-queue", "none"}, {"kernel-mutex", "kernel\\nmutex"}, {"mutex", "mutex"},
              {"sutter", "sutter"}, {"stilb-low-lock", "low-\\nlock"},  {"stilb-lock-free", "lock-\\nfree"}};

static const struct {
	const char *metric, *colour, *title;
} parts[] = {{"recording", "#4477aa", "recording"},
             {"waiting", "#ee6677", "in the queue"},
             {"no-work", "#cccccc", "nothing to do, or asleep"}};

/* Writes a line "x top top ... waiting" for each stacked bar: the heights at which its parts end, lowest first, and the
 * share of waiting for the queue. */
static size_t write_shares(FILE *out, const bench_results *results)
{
	size_t written = 0;
	fprintf(out, "$shares << END\n");
	for (size_t c = 0; c < COUNT(queue_cases); c++)
		for (size_t q = 1; q < COUNT(queues); q++) {
			double top = 0.0;
			if (!bench_find(results, queue_cases[c].on, queues[q].subject, parts[0].metric))
				continue;
			fprintf(out, "%zu", c * COUNT(queues) + q);
			for (size_t p = 0; p < COUNT(parts); p++)
				fprintf(out, " %.6g", top += median_of(results, queue_cases[c].on, queues[q].subject, parts[p].metric));
			fprintf(out, " %.6g\n", median_of(results, queue_cases[c].on, queues[q].subject, "waiting"));
			written++;
		}
	fprintf(out, "END\n");
	return written;
}

static void plot_shares(FILE *out, const bench_results *results)
{
	begin(out, "mutex-vs-lowlock: what the workers did with their time", "% of it; above the bars: in the queue");
	if (write_shares(out, results) == 0) {
		plot_nothing(out);
		return;
	}
	fprintf(out, "set yrange [0:118]\nset ytics 0, 20, 100\nset xrange [0:%zu]\nset xtics nomirror\nset xtics (",
	        COUNT(queue_cases) * COUNT(queues));
	for (size_t c = 0; c < COUNT(queue_cases); c++)
		for (size_t q = 1; q < COUNT(queues); q++)
			fprintf(out, "%s\"%s\" %zu", c + q > 1 ? ", " : "", queues[q].label, c * COUNT(queues) + q);
	fprintf(out, ")\nset bmargin 5\n");
	for (size_t c = 0; c < COUNT(queue_cases); c++)
		fprintf(out, "set label \"%s\" at %zu, 112 center\n", queue_cases[c].title,
		        c * COUNT(queues) + (COUNT(queues) + 1) / 2);
	fprintf(out, "plot ");
	for (size_t p = COUNT(parts); p-- > 0;)
		fprintf(out, "$shares using 1:%zu with boxes linecolor rgb '%s' title \"%s\", ", p + 2, parts[p].colour,
		        parts[p].title);
	fprintf(out, "$shares using 1:4:(number($5)) with labels offset 0,0.6 font ',10' notitle\n");
}

static void plot_queues(FILE *out, const bench_results *results)
{
	place places[COUNT(queue_cases) * COUNT(queues)];
	for (size_t i = 0; i < COUNT(places); i++) {
		size_t c = i / COUNT(queues), q = i % COUNT(queues);
		places[i] = (place){queue_cases[c].on, queues[q].subject, USUAL_METRICS, queues[q].label, q == 0 && c > 0};
	}
	plot_places(out, results, "mutex-vs-lowlock: a draw an item | a draw of 2009 an item | 512 draws an item", places,
	            COUNT(places));
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

void bench_threads_plot(FILE *out, const bench_results *results)
{
	fprintf(out, "number(x) = sprintf(x < 0.01 ? '%%.4f' : x < 1 ? '%%.3f' : x < 10 ? '%%.2f' : x < 100 ? '%%.1f' : "
	             "'%%.0f', x)\n");
	plot_stages(out, results, "null", "the frame's stages, null device: the CPU's side alone");
	plot_gain(out, results, "null", "speed-up, null device");
	plot_stages(out, results, "vulkan", "the frame's stages, Vulkan (rest: waiting for the device)");
	plot_gain(out, results, "vulkan", "speed-up, Vulkan");
	plot_patterns(out, results);
	plot_stolen(out, results);
	plot_shares(out, results);
	plot_queues(out, results);
}
