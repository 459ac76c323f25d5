/* The suite `shadows`: triangles of a sun's maps, recording of views of lights, and lamps of which some move. */
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric triangles_metrics[] = {
	{"main", "k", true, NULL},     {"maps", "k", true, NULL},           {"ratio", "x", true, NULL},
	{"main-off", "k", true, NULL}, {"maps-off", "k", true, NULL},       {"ratio-off", "x", true, NULL},
	{"casters", "", true, NULL},   {"frame-without", "ms", true, NULL}, {"frame-maps", "ms", true, NULL},
};

static const bench_metric record_metrics[] = {{"draw", "ns", true, NULL},
                                              {"caster", "ns", true, NULL},
                                              {"ratio", "x", true, NULL},
                                              {"two-10000", "x", false, NULL},
                                              {"two", "x", false, NULL}};

static const bench_metric lamps_metrics[] = {
	{"still", "", true, NULL},          {"moving", "", true, NULL}, {"of-8", "ms", true, NULL},
	{"of-64", "ms", true, NULL},        {"ratio", "x", true, NULL}, {"ratio-moving", "x", true, NULL},
	{"ratio-without", "x", true, NULL},
};

static const bench_metric views_metrics[] = {
	{"maps", "k", true, NULL}, {"frame", "ms", true, NULL}, {"record", "ms", true, NULL}};

static const bench_metric cube_metrics[] = {{"maps", "k", true, NULL},
                                            {"six", "ms", true, NULL},
                                            {"layered", "ms", true, NULL},
                                            {"record-six", "ms", true, NULL},
                                            {"record-layered", "ms", true, NULL},
                                            {"ratio", "x", true, NULL}};

static const bench_case cases[] = {
	{.name = "triangles-225",
     .title = "three cascades of 1024 texels, 225 spheres, 1280 x 720",
     .metrics = triangles_metrics,
     .metric_count = COUNT(triangles_metrics)},
	{.name = "triangles-1000",
     .title = "three cascades of 1024 texels, 1,000 spheres, 1280 x 720",
     .metrics = triangles_metrics,
     .metric_count = COUNT(triangles_metrics)},
	{.name = "triangles-10000",
     .title = "three cascades of 1024 texels, 10,000 spheres, 1280 x 720",
     .metrics = triangles_metrics,
     .metric_count = COUNT(triangles_metrics)},
	{.name = "views-225",
     .title = "drawing three cascades of 1024 texels, 225 spheres without levels of detail, a tenth moves",
     .metrics = views_metrics,
     .metric_count = COUNT(views_metrics)},
	{.name = "views-1000",
     .title = "the same, 1,000 spheres",
     .metrics = views_metrics,
     .metric_count = COUNT(views_metrics)},
	{.name = "cube-1000",
     .title = "six sides of a cube of 512 texels, 1,000 spheres: six views, or one recording with layers",
     .metrics = cube_metrics,
     .metric_count = COUNT(cube_metrics)},
	{.name = "record",
     .title = "recording of eight cascades, 10,000 spheres of which a tenth moves",
     .metrics = record_metrics,
     .metric_count = COUNT(record_metrics)},
	{.name = "lamps",
     .title = "64 lamps with shadows of which eight move, 640 x 360",
     .metrics = lamps_metrics,
     .metric_count = COUNT(lamps_metrics)},
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-shadows",
     .note =
         "main: triangles of the camera's view; maps: those of all maps, drawn anew; -off: with --lod off; casters: "
         "draws of the maps; frame: CPU time, without shadows and with all maps drawn; draw, caster: CPU time of "
         "recording and culling for each draw of the camera's view and of the maps; two: recording by two threads over "
         "one, 100,000 spheres; "
         "two-10000: likewise; "
         "still, moving: lights whose maps a frame draws under a camera that stands still and under one that moves, "
         "at most; of-8, of-64: CPU time of a frame with so many lamps, as many of them at a point; ratio-without: "
         "without shadows; of views: CPU time of a frame with maps less one without"},
	{.name = "vulkan_bare",
     .program = "stilb-bench-shadows-bare",
     .note = "a plain Vulkan program that draws the same maps, and nothing else; record: what its one thread does"},
};

typedef struct goal {
	const char *on, *metric, *words;
	double bound;
	bool least;
} goal;

/* Maps that a plain program draws, too. */
static void print_views(FILE *out, const bench_results *results)
{
	static const char *const cases_of[] = {"views-225", "views-1000"};
	for (size_t c = 0; c < COUNT(cases_of); c++) {
		const bench_row *ours = bench_find(results, cases_of[c], "stilb", "frame");
		const bench_row *bare = bench_find(results, cases_of[c], "vulkan_bare", "frame");
		if (ours && bare)
			fprintf(out, "goal: %s, over a plain Vulkan program: %.2f, 1.10: %s\n", cases_of[c],
			        ours->median / bare->median, ours->median <= 1.1 * bare->median ? "met" : "MISSED");
	}
}

static void print_goals(FILE *out, const bench_results *results)
{
	static const goal goals[] = {
		{"triangles-10000", "ratio", "triangles of maps over the view's", 1.0, false},
		{"triangles-10000", "ratio-off", "the same with --lod off", 0.4, false},
		{"record", "ratio", "a caster over a draw", 1.05, false},
		{"record", "two", "two threads", 1.8, true},
		{"lamps", "still", "lights drawn anew, eight moving", 8.0, false},
		{"lamps", "moving", "the same under a camera that moves", 12.0, false},
		{"lamps", "ratio", "a frame with 64 lamps over one with 8", 1.1, false},
	};
	fputc('\n', out);
	print_views(out, results);
	for (size_t i = 0; i < COUNT(goals); i++) {
		const goal *g = &goals[i];
		const bench_row *row = bench_find(results, g->on, "stilb", g->metric);
		if (!row)
			continue;
		bool met = g->least ? row->median >= g->bound : row->median <= g->bound;
		fprintf(out, "goal: %s: %.2f, %.2f: %s\n", g->words, row->median, g->bound, met ? "met" : "MISSED");
	}
}

const bench_suite bench_shadows_suite = {.name = "shadows",
                                         .help = "shadow maps: their triangles, their recording, lamps that move",
                                         .subjects = subjects,
                                         .subject_count = COUNT(subjects),
                                         .cases = cases,
                                         .case_count = COUNT(cases),
                                         .goals = print_goals};
