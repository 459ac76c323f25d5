/* The suite `animate`: poses of figures (engine/scene/play): clips sampled, skins carried along. */
#include "bench/animate/animate_cases.h"
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric metrics[] = {
	{"channel", "ns", true, NULL}, {"joint", "ns", true, NULL}, {"two", "x", false, NULL},
	{"nodes", "ns", true, NULL},   {"frame", "ms", true, NULL}, {"still", "us", true, NULL},
	{"vertex", "ns", true, NULL},  {"copy", "ns", true, NULL},  {"jobs", "ns", true, NULL},
	{"cpu", "ns", true, NULL},     {"limit", "ns", true, NULL}, {"share", "x", false, NULL},
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES, TORN)                                                             \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .length = 2.0},
	ANIMATE_CASES(CASE)
#undef CASE
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-animate",
     .note = "CPU times of the busier of the threads, but for frame and still; channel, joint: sampling on one "
             "thread, joint: its three channels; two: of two threads beside one; nodes: their places, a joint; "
             "frame: all of it on two threads, by the clock; still: a frame in which nothing moves; vertex: posing "
             "on one thread; copy: a copy of a vertex's 32 bytes into the same meshes; jobs: a vertex on two "
             "threads, cpu: of both together; limit: that in which two threads copy as many bytes as a pose reads "
             "and writes; share: limit / cpu"},
	{.name = "device",
     .program = "stilb-bench-animate-device",
     .note = "cpu: the same vertices by a compute shader on the device that the engine would take, until they "
             "are in its memory; 100 of the figures"},
	{.name = "trees",
     .program = "stilb-bench-animate-trees",
     .note = "frame: the trees that rays need after 1,000 of the figures were posed, on two threads; two: of these "
             "beside one"},
};

#define CHANNEL_GOAL 15.0
#define TWO_GOAL 1.9
#define SHARE_GOAL 0.5

static void print_goals(FILE *out, const bench_results *results)
{
	const bench_row *channel = bench_find(results, "clips", "stilb", "channel");
	const bench_row *two = bench_find(results, "clips", "stilb", "two");
	const bench_row *share = bench_find(results, "skin", "stilb", "share");
	const bench_row *jobs = bench_find(results, "skin", "stilb", "cpu");
	const bench_row *device = bench_find(results, "skin", "device", "cpu");
	fputc('\n', out);
	if (channel && two)
		fprintf(out,
		        "goal: a channel is sampled in %.1f ns, at most %.0f: %s; two threads %.2f times as fast, %.1f: %s\n",
		        channel->median, CHANNEL_GOAL, channel->median <= CHANNEL_GOAL ? "met" : "MISSED", two->median,
		        TWO_GOAL, two->median >= TWO_GOAL ? "met" : "MISSED");
	if (share)
		fprintf(out,
		        "goal: skins on two threads at %.2f of the speed of a copy of all bytes that they read and write, "
		        "%.1f: %s\n",
		        share->median, SHARE_GOAL, share->median >= SHARE_GOAL ? "met" : "MISSED");
	if (jobs && device)
		fprintf(out, "told: a vertex takes %.1f ns of CPU time on jobs, %.1f ns by the device's way\n", jobs->median,
		        device->median);
}

const bench_suite bench_animate_suite = {.name = "animate",
                                         .help = "figures: clips, skins, hordes",
                                         .subjects = subjects,
                                         .subject_count = COUNT(subjects),
                                         .cases = cases,
                                         .case_count = COUNT(cases),
                                         .goals = print_goals};
