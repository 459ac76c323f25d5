/* The suite `animate`: poses of figures (engine/scene/play): clips sampled, skins carried along. */
#include "bench/animate/animate_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"channel", "ns", true, NULL}, {"joint", "ns", true, NULL}, {"two", "x", false, NULL},
	{"nodes", "ns", true, NULL},   {"frame", "ms", true, NULL}, {"vertex", "ns", true, NULL},
	{"copy", "ns", true, NULL},    {"share", "x", false, NULL}, {"still", "us", true, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES)                                                                   \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .length = 2.0},
	ANIMATE_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-animate",
     .note =
         "channel, joint: sampling on one thread, joint: its three channels; two: of two threads beside one; nodes: "
         "their places, a joint; frame: all of it on two threads; vertex: posing on two threads; copy: a copy of as "
         "many bytes into the same meshes, a vertex; share: copy / vertex; still: a frame in which nothing moves"},
};

#define CHANNEL_GOAL 15.0
#define TWO_GOAL 1.9
#define SHARE_GOAL 0.5

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *channel = bench_find(results, "clips", "stilb", "channel");
	const bench_row *two = bench_find(results, "clips", "stilb", "two");
	const bench_row *share = bench_find(results, "skin", "stilb", "share");
	fputc('\n', out);
	if (channel && two)
		fprintf(out,
		        "goal: a channel is sampled in %.1f ns, at most %.0f: %s; two threads %.2f times as fast, %.1f: %s\n",
		        channel->median, CHANNEL_GOAL, channel->median <= CHANNEL_GOAL ? "met" : "MISSED", two->median,
		        TWO_GOAL, two->median >= TWO_GOAL ? "met" : "MISSED");
	if (share)
		fprintf(out, "goal: skins at %.2f of the speed of a copy, %.1f: %s\n", share->median, SHARE_GOAL,
		        share->median >= SHARE_GOAL ? "met" : "MISSED");
}

const bench_suite bench_animate_suite = {.name = "animate",
                                         .help = "figures: clips, skins, hordes",
                                         .subjects = subjects,
                                         .subject_count = COUNT(subjects),
                                         .cases = cases,
                                         .case_count = COUNT(cases),
                                         .goals = print_goals};
