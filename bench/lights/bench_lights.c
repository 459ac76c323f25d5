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
	{"one", "ms", true, NULL},    {"seen", "%", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, LIGHTS) {.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics)},
	LIGHTS_CASES(CASE)
#undef CASE
		{.name = LIGHTS_OCTREE,
         .title = "100,000 lamps in a loose octree, a tenth of them moving",
         .metrics = octree_metrics,
         .metric_count = COUNT(octree_metrics)},
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
             "lists of the chosen ones; seen: share of the lights"},
};

#define RATIO_GOAL 2.0
#define SPEEDUP_GOAL 1.8
#define ROOM_GOAL 1.5
#define OCTREE_GOAL 1.5

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
