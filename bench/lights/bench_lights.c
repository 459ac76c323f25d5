/* The suite `lights`: which lights reach which cells of a view (engine/light), on one thread and on two, beside a test
 * of as many spheres against a frustum. */
#include "bench/harness/bench.h"
#include "bench/lights/lights_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"one", "ms", true, NULL},  {"two", "ms", true, NULL},    {"speedup", "x", false, NULL},
	{"pairs", "", true, NULL},  {"pair", "ns", true, NULL},   {"peer", "ns", true, NULL},
	{"ratio", "x", true, NULL}, {"stream", "ns", true, NULL}, {"memory", "MiB", true, NULL},
	{"room", "x", true, NULL},
};

static const bench_metric octree_metrics[] = {
	{"chosen", "ms", true, NULL}, {"models", "ms", true, NULL}, {"ratio", "x", true, NULL},
	{"one", "ms", true, NULL},    {"linear", "ms", true, NULL}, {"seen", "%", true, NULL},
};

static const bench_metric frames_metrics[] = {
	{"list", "", true, NULL},
	{"eight", "ms", true, NULL},
	{"mean_forward", "ms", true, NULL},
	{"clustered", "ms", true, NULL},
	{"by_compute", "ms", true, NULL},
	{"lists", "ms", true, NULL},
	{"tiled_forward", "ms", true, NULL},
	{"indexed", "ms", true, NULL},
	{"deferred", "ms", true, NULL},
	{"tiled_deferred", "ms", true, NULL},
	{"prelight", "ms", true, NULL},
	{"to_eight", "x", true, NULL},
	{"to_mean", "x", true, NULL},
};

static const bench_metric floor_metrics[] = {
	{"cut", "us", true, NULL},
	{"triangles", "", true, NULL},
	{"draws", "", true, NULL},
	{"reach", "", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, LIGHTS) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	LIGHTS_CASES(CASE)
#undef CASE
		{.name = LIGHTS_OCTREE,
         .title = "100,000 lamps in a loose octree, a tenth of them moving",
         .metrics = octree_metrics,
         .metric_count = COUNT(octree_metrics)},
	{.name = LIGHTS_FRAMES,
     .title = "frames of a floor under 1,000 lamps, eight at a point, 640 x 360",
     .metrics = frames_metrics,
     .metric_count = COUNT(frames_metrics)},
	{.name = LIGHTS_FLOOR,
     .title = "a floor of two triangles, cut at the bounds of 18 lamps",
     .metrics = floor_metrics,
     .metric_count = COUNT(floor_metrics)},
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-lights",
     .note = "1920 x 1080 pixels, tiles of 32, 24 slices; one, two: a build by one thread and by two, CPU time of the "
             "busier one; pairs: of light and cell; pair: one over pairs; peer: each pair's sphere against the six "
             "planes of its cell, eight at a time with AVX2, from arrays in memory in the order of the lists; ratio: "
             "pair / peer; stream: the same tests against one frustum; memory: of the lists; room: that over what they "
             "hold; chosen: lights moved in the octree and the view's marked; models: the stress test with as many, "
             "moved and culled; one: the "
             "lists of the chosen ones; linear: to find without the octree that a view has none; seen: share of the "
             "lights; list: lights in a pixel's list, on average; eight, "
             "mean_forward: each pixel asks eight lights, and as many as that; the others: a frame under the lamps, so "
             "lit, by_compute: clustered with lists by compute; lists: what these take; to_eight, to_mean: clustered "
             "over these; triangles, draws: that cuts add; reach: lights at a piece at "
             "most"},
};

#define RATIO_GOAL 2.0
#define SPEEDUP_GOAL 1.8
#define ROOM_GOAL 1.5
#define OCTREE_GOAL 1.5
#define EIGHT_GOAL 1.3
#define MEAN_GOAL 1.1

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *ratio = bench_find(results, "lists-10000", "stilb", "ratio");
	const bench_row *speedup = bench_find(results, "lists-10000", "stilb", "speedup");
	const bench_row *room = bench_find(results, "lists-10000", "stilb", "room");
	fputc('\n', out);
	if (ratio && speedup)
		fprintf(out,
		        "goal: lists of 10,000 lights take %.2f times as long as tests of their pairs, %.1f: %s; two "
		        "threads %.2f times as fast, %.1f: %s\n",
		        ratio->median, RATIO_GOAL, ratio->median <= RATIO_GOAL ? "met" : "MISSED", speedup->median,
		        SPEEDUP_GOAL, speedup->median >= SPEEDUP_GOAL ? "met" : "MISSED");
	const bench_row *octree = bench_find(results, LIGHTS_OCTREE, "stilb", "ratio");
	if (octree)
		fprintf(out, "goal: lights in an octree take %.2f times as long as as many models, %.1f: %s\n", octree->median,
		        OCTREE_GOAL, octree->median <= OCTREE_GOAL ? "met" : "MISSED");
	const bench_row *eight = bench_find(results, LIGHTS_FRAMES, "stilb", "to_eight");
	const bench_row *mean = bench_find(results, LIGHTS_FRAMES, "stilb", "to_mean");
	if (eight && mean)
		fprintf(
			out,
			"goal: a frame under 1,000 lamps, eight a pixel, takes %.2f times as long as under eight lights, %.1f: %s; "
			"and %.2f times as long as under as many as its lists have, %.1f: %s\n",
			eight->median, EIGHT_GOAL, eight->median <= EIGHT_GOAL ? "met" : "MISSED", mean->median, MEAN_GOAL,
			mean->median <= MEAN_GOAL ? "met" : "MISSED");
	if (room)
		fprintf(out, "goal: lists have %.2f times the memory of what they hold, %.1f: %s\n", room->median, ROOM_GOAL,
		        room->median <= ROOM_GOAL ? "met" : "MISSED");
}

const bench_suite bench_lights_suite = {.name = "lights",
                                        .help = "lists of the lights that reach each part of a view",
                                        .subjects = subjects,
                                        .subject_count = COUNT(subjects),
                                        .cases = cases,
                                        .case_count = COUNT(cases),
                                        .goals = print_goals};
