/* The suite `post`: what effects on the light of a frame cost. */
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* The first ones of all effects, and those of effects that the CPU's threads can compute. */
static const bench_metric metrics[] = {{"frame", "ms", true, NULL},     {"gpu", "ms", true, NULL},
                                       {"gpu-pixel", "ns", true, NULL}, {"bare", "ms", true, NULL},
                                       {"over-bare", "x", true, NULL},  {"cpu", "ms", true, NULL},
                                       {"cpu-pixel", "ns", true, NULL}, {"ratio", "x", true, NULL}};
#define GPU_METRICS 5

static const bench_case cases[] = {
	{.name = "bloom", .title = "bloom, 225 spheres, 640 x 360", .metrics = metrics, .metric_count = COUNT(metrics)},
	{.name = "bloom-large",
     .title = "bloom, 225 spheres, 1920 x 1080",
     .metrics = metrics,
     .metric_count = COUNT(metrics)},
	{.name = "ao",
     .title = "ambient occlusion, 225 spheres, 640 x 360",
     .metrics = metrics,
     .metric_count = COUNT(metrics)},
	{.name = "temporal",
     .title = "temporal antialiasing, 225 spheres, 640 x 360",
     .metrics = metrics,
     .metric_count = GPU_METRICS},
	{.name = "motion", .title = "motion blur, 225 spheres, 640 x 360", .metrics = metrics, .metric_count = GPU_METRICS},
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-post",
     .note = "CPU time of a frame, all threads: without the effect; what the effect adds, by programs of the device "
             "(gpu) and by the CPU's threads (cpu), also for each pixel; ratio: cpu over gpu; bare: what programs "
             "add that read and write the same and compute nothing. A software device, whose work is the CPU's, is "
             "needed"},
};

const bench_suite bench_post_suite = {
	.name = "post",
	.help = "effects on the light of a frame: bloom, occlusion, temporal antialiasing, motion blur",
	.subjects = subjects,
	.subject_count = COUNT(subjects),
	.cases = cases,
	.case_count = COUNT(cases),
	.start_seconds = 2.0,
	.quick_cpu_seconds = 40.0};
