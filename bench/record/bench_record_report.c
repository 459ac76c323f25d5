/* The suite `record`: its goals (bounds of the measured numbers), each met or missed, and its picture. */
#include "bench/record/bench_record.h"

#include "base/base.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* The median of a row, or the median ratio of two rows, that must be at most `bound` if less is better, else at least.
 * A row is named by its case (on), subject and metric. */
typedef struct goal {
	const char *what;
	const char *on, *subject, *metric;
	const char *of_on, *of_subject; /* case and subject of the denominator, with the same metric; NULL: no ratio */
	double bound;                   /* 0: the value is only printed */
	const char *note;
} goal;

static const goal goals[] = {
	{"record by hand, 1 thread", "draws", "stilb", "record", NULL, NULL, 6.0, "bgfx 2cdd66c87: 56, measured elsewhere"},
	{"record from a scene, 1 thread", "draws", "stilb-scene", "record", NULL, NULL, 6.0, NULL},
	{"  by hand / memory write", "draws", "stilb", "record", "draws", "write", 0.0, NULL},
	{"  by hand / non-temporal write", "draws", "stilb", "record", "draws", "write-non-temporal", 0.0, NULL},
	{"  by hand / an atomic a draw", "draws", "stilb", "record", "draws", "atomic", 0.0, NULL},
	{"  by hand / malloc a draw", "draws", "stilb", "record", "draws", "malloc", 0.0, NULL},
	{"bytes recorded", "draws", "stilb", "bytes", NULL, NULL, 96.0, NULL},
	{"1,000,000 draws / 20,000, by hand", "draws-1000000", "stilb", "record", "draws", "stilb", 1.5, NULL},
	{"1,000,000 draws / 20,000, scene", "draws-1000000", "stilb-scene", "record", "draws", "stilb-scene", 1.5, NULL},
	{"  memory write alone", "draws-1000000", "write", "record", "draws", "write", 0.0, NULL},
	{"  non-temporal write alone", "draws-1000000", "write-non-temporal", "record", "draws", "write-non-temporal", 0.0,
     NULL},
	{"  1,000,000 by hand / that write", "draws-1000000", "stilb", "record", "draws-1000000", "write-non-temporal", 0.0,
     NULL},
	{"2 threads / 1, in a phase, by hand", "phase", "stilb", "speed-up", NULL, NULL, 1.8, NULL},
	{"2 threads / 1, in a phase, scene", "phase", "stilb-scene", "speed-up", NULL, NULL, 1.8, NULL},
	{"2 threads, wake inside, by hand", "parked", "stilb", "of-best", NULL, NULL, 1.08, "of (T1 + wake + cost) / 2"},
	{"2 threads, wake inside, scene", "parked", "stilb-scene", "of-best", NULL, NULL, 1.08,
     "of (T1 + wake + cost) / 2"},
	{"6 views / 6 x 1 view, 1 thread", "views", "stilb-scene", "of-sum", NULL, NULL, 1.05, NULL},
	{"6 views, 2 threads / 1", "views", "stilb-scene", "speed-up", NULL, NULL, 1.8, NULL},
	{"6 views, bytes of a draw", "views", "stilb-scene", "bytes", NULL, NULL, 32.0, NULL},
	{"  6 views of 1,000 draws / 6 x 1", "views-small", "stilb-scene", "of-sum", NULL, NULL, 0.0, NULL},
	{"  of 1,000 draws, 2 threads / 1", "views-small", "stilb-scene", "speed-up", NULL, NULL, 0.0, NULL},
	{"order + replay, indirect", "replay-1", "stilb-indirect", "replay", NULL, NULL, 1.2, "bgfx sort + walk: 9 to 11"},
	{"order + replay, direct", "replay-1", "stilb-direct", "replay", NULL, NULL, 1.2, NULL},
	{"order + replay, secondary", "replay-1", "stilb-secondary", "replay", NULL, NULL, 1.2, NULL},
	{"  secondary, 2 threads", "replay-2", "stilb-secondary", "replay", NULL, NULL, 1.2, NULL},
	{"sort by key, indirect", "sort", "stilb-indirect", "sort", NULL, NULL, 0.0, "bgfx radix sort: 7.6"},
	{"  indirect / radix sort alone", "sort", "stilb-indirect", "sort", "sort", "radix", 0.0, NULL},
	{"cull + record + replay, 1 thread", "frame-1", "stilb-indirect", "frame", NULL, NULL, 0.15,
     "the article: 50 (2009)"},
	{"cull + record + replay, 2 threads", "frame-2", "stilb-indirect", "frame", NULL, NULL, 0.09,
     "the article: 30 (2009)"},
	{"lavapipe frame / bare Vulkan", "picture", "stilb-indirect", "frame", "picture", "vulkan-bare", 1.02, NULL},
	{"  the least of each run", "picture", "stilb-indirect", "least", "picture", "vulkan-bare", 0.0, NULL},
	{"  CPU time of all threads", "picture", "stilb-indirect", "cpu", "picture", "vulkan-bare", 0.0, NULL},
	{"  direct / indirect", "picture", "stilb-direct", "frame", "picture", "stilb-indirect", 0.0, NULL},
	{"  secondary / indirect", "picture", "stilb-secondary", "frame", "picture", "stilb-indirect", 0.0, NULL},
};

/* The goal's median or ratio with its range, and its row; false if it was not measured. */
static bool measured(const bench_results *results, const goal *g, bench_ratio *value, const bench_row **row)
{
	*row = bench_find(results, g->on, g->subject, g->metric);
	if (!*row)
		return false;
	*value = (bench_ratio){(*row)->median, (*row)->min, (*row)->max};
	if (!g->of_on)
		return true;
	const bench_row *of = bench_find(results, g->of_on, g->of_subject, g->metric);
	return of && bench_paired_ratio(results, *row, of, value);
}

static void print_goal(FILE *out, const bench_results *results, const goal *g)
{
	const bench_row *row;
	bench_ratio value;
	if (!measured(results, g, &value, &row))
		return;
	char range[32];
	snprintf(range, sizeof range, "[%.3g-%.3g]", value.min, value.max);
	fprintf(out, "  %-36s %8.4g %-14s %-8s", g->what, value.median, range, g->of_on ? "x" : row->unit);
	if (g->bound > 0.0) {
		bool met = row->less_is_better ? value.median <= g->bound : value.median >= g->bound;
		fprintf(out, " goal %s %-6.4g %-6s", row->less_is_better ? "<=" : ">=", g->bound, met ? "met" : "MISSED");
	}
	if (g->note)
		fprintf(out, " (%s)", g->note);
	fputc('\n', out);
}

void bench_record_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoals, set on the CPU named in docs/benchmarks.md; median [least-most] of the rounds\n");
	for (size_t i = 0; i < COUNT(goals); i++)
		print_goal(out, results, &goals[i]);
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

/* A box of the diagram: its place on the x axis, and the case, subject and metric whose median it shows. */
typedef struct box {
	double x;
	const char *on, *subject, *metric;
} box;

/* Writes a data block "x median least most" of the boxes that were measured; false if none was. */
static bool write_boxes(FILE *out, const bench_results *results, const char *name, const box *boxes, size_t count)
{
	bool any = false;
	fprintf(out, "$%s << END\n", name);
	for (size_t i = 0; i < count; i++) {
		const bench_row *row = bench_find(results, boxes[i].on, boxes[i].subject, boxes[i].metric);
		if (row)
			fprintf(out, "%.2f %.6g %.6g %.6g\n", boxes[i].x, row->median, row->min, row->max);
		if (row)
			any = true;
	}
	fprintf(out, "END\n");
	return any;
}

/* Begins the diagram number `place`; diagrams lie in two columns, row by row. */
static void begin_diagram(FILE *out, int place, const char *title, const char *unit, const char *ticks, double most_x)
{
	double height = 0.94 / BENCH_RECORD_PLOT_ROWS;
	fprintf(out,
	        "set origin %.2f,%.4f\nset size 0.5,%.4f\nset title \"%s\"\nset ylabel '%s'\nset yrange [0:*]\nset xrange "
	        "[-0.7:%.2f]\nset xtics (%s) norotate\nset key inside left top horizontal\nset bmargin 3\n"
	        "set style fill solid 0.75 border rgb '#404040'\nset grid ytics\nset offsets 0, 0, graph 0.14, 0\n",
	        0.5 * (place % 2), height * (BENCH_RECORD_PLOT_ROWS - 1 - place / 2), height, title, unit, most_x, ticks);
}

/* Boxes of one colour. */
typedef struct layer {
	const char *name, *title, *color;
	const box *boxes;
	size_t count;
} layer;

static void plot_layers(FILE *out, const bench_results *results, const layer *layers, size_t count, double width,
                        const char *lines)
{
	bool any[8];
	for (size_t i = 0; i < count; i++)
		any[i] = write_boxes(out, results, layers[i].name, layers[i].boxes, layers[i].count);
	fprintf(out, "plot NaN notitle");
	for (size_t i = 0; i < count; i++)
		if (any[i])
			fprintf(out, ", $%s using 1:2:3:4:(%.2f) with boxerrorbars linecolor rgb '%s' title \"%s\"", layers[i].name,
			        width, layers[i].color, layers[i].title);
	fprintf(out, "%s\n", lines);
}

#define GOAL(VALUE, TITLE) ", " VALUE " with lines dashtype 2 linewidth 1.5 linecolor rgb '#c00000' title '" TITLE "'"

static void plot_draws(FILE *out, const bench_results *results)
{
	static const box usual[] = {
		{-0.2, "draws", "write", "record"}, {0.8, "draws", "write-non-temporal", "record"},
		{1.8, "draws", "stilb", "record"},  {2.8, "draws", "stilb-scene", "record"},
		{3.8, "draws", "atomic", "record"}, {4.8, "draws", "malloc", "record"},
	};
	static const box many[] = {
		{0.2, "draws-1000000", "write", "record"},  {1.2, "draws-1000000", "write-non-temporal", "record"},
		{2.2, "draws-1000000", "stilb", "record"},  {3.2, "draws-1000000", "stilb-scene", "record"},
		{4.2, "draws-1000000", "atomic", "record"}, {5.2, "draws-1000000", "malloc", "record"},
	};
	static const layer layers[] = {
		{"usual", "20,000 draws", "#5080c0", usual, COUNT(usual)},
		{"many", "1,000,000 draws", "#e0a030", many, COUNT(many)},
	};
	begin_diagram(out, 0, "recording a draw on one thread, and what the machine takes for less", "ns/draw",
	              "\"write\\n96 bytes\" 0, \"write,\\nnon-temporal\" 1, \"stilb,\\nby hand\" 2, \"stilb,\\nscene\" 3, "
	              "\"one\\natomic\" 4, \"one\\nmalloc\" 5",
	              5.7);
	plot_layers(out, results, layers, COUNT(layers), 0.36, GOAL("6", "goal for 20,000"));
}

static void plot_threads(FILE *out, const bench_results *results)
{
	static const box one[] = {
		{-0.2, "phase", "stilb", "one"},
		{0.8, "phase", "stilb-scene", "one"},
		{1.8, "parked", "stilb", "one"},
		{2.8, "parked", "stilb-scene", "one"},
	};
	static const box two[] = {
		{0.2, "phase", "stilb", "two"},
		{1.2, "phase", "stilb-scene", "two"},
		{2.2, "parked", "stilb", "two"},
		{3.2, "parked", "stilb-scene", "two"},
	};
	static const layer layers[] = {
		{"one", "1 thread", "#5080c0", one, COUNT(one)},
		{"two", "2 threads", "#50a060", two, COUNT(two)},
	};
	begin_diagram(out, 1, "recording 20,000 draws on two threads", "us",
	              "\"in a phase,\\nby hand\" 0, \"in a phase,\\nscene\" 1, \"worker asleep,\\nby hand\" 2, "
	              "\"worker asleep,\\nscene\" 3",
	              3.7);
	plot_layers(out, results, layers, COUNT(layers), 0.36, "");
}

/* Stacked boxes: the stage `record` begins at the top of `cull`, and `replay` at the top of `record`. */
static void plot_stages(FILE *out, const bench_results *results)
{
	static const char *const frames[] = {"frame-1", "frame-2"};
	static const char *const replays[] = {"stilb-indirect", "stilb-direct", "stilb-secondary"};
	static const char *const stages[] = {"cull", "record", "replay"};
	static const char *const colors[] = {"#808080", "#5080c0", "#e0a030"};
	begin_diagram(out, 2, "a frame's stages on the null device, 20,000 draws", "us",
	              "\"indirect,\\n1 thread\" 0, \"direct\" 1, \"secondary\" 2, \"indirect,\\n2 threads\" 3, "
	              "\"direct\" 4, \"secondary\" 5",
	              5.7);
	fprintf(out, "$stages << END\n");
	for (int i = 0; i < 6; i++) {
		fprintf(out, "%d", i);
		for (int s = 0; s < 3; s++) {
			const bench_row *row = bench_find(results, frames[i / 3], replays[i % 3], stages[s]);
			fprintf(out, " %.6g", row ? row->median : 0.0);
		}
		fprintf(out, "\n");
	}
	fprintf(out, "END\nset boxwidth 0.6\nplot ");
	for (int s = 2; s >= 0; s--) /* the tallest box first, since later boxes are drawn over earlier ones */
		fprintf(out, "$stages using 1:(%s) with boxes linecolor rgb '%s' title '%s', ",
		        s == 0   ? "$2"
		        : s == 1 ? "$2+$3"
		                 : "$2+$3+$4",
		        colors[s], stages[s]);
	fprintf(out, "x < 2.5 ? 150 : 90 with steps dashtype 2 linewidth 1.5 linecolor rgb '#c00000' title 'goal'\n");
}

static void plot_pictures(FILE *out, const bench_results *results)
{
	static const box index[] = {
		{-0.27, "picture", "vulkan-bare", "frame"},
		{0.73, "picture", "stilb-indirect", "frame"},
		{1.73, "picture", "stilb-direct", "frame"},
		{2.73, "picture", "stilb-secondary", "frame"},
	};
	static const box bind[] = {
		{1.0, "picture-bind", "stilb-indirect", "frame"},
		{2.0, "picture-bind", "stilb-direct", "frame"},
		{3.0, "picture-bind", "stilb-secondary", "frame"},
	};
	static const box pipeline[] = {
		{1.27, "picture-pipeline", "stilb-indirect", "frame"},
		{2.27, "picture-pipeline", "stilb-direct", "frame"},
		{3.27, "picture-pipeline", "stilb-secondary", "frame"},
	};
	static const layer layers[] = {
		{"index", "an index a draw", "#5080c0", index, COUNT(index)},
		{"bind", "a material bound a draw", "#e0a030", bind, COUNT(bind)},
		{"pipeline", "a pipeline a draw", "#a05050", pipeline, COUNT(pipeline)},
	};
	begin_diagram(out, 3, "frames of 20,000 draws on lavapipe, 640x360, by how materials are given", "ms",
	              "\"bare Vulkan\" 0, \"indirect\" 1, \"direct\" 2, \"secondary\" 3", 3.7);
	plot_layers(out, results, layers, COUNT(layers), 0.25, "");
}

void bench_record_plot(FILE *out, const bench_results *results)
{
	plot_draws(out, results);
	plot_threads(out, results);
	plot_stages(out, results);
	plot_pictures(out, results);
}
