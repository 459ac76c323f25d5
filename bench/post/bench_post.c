/* The suite `post`: what effects on the light of a frame cost. */
#include "bench/harness/bench.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

static const bench_metric placed_metrics[] = {{"frame", "ms", true, NULL},     {"gpu", "ms", true, NULL},
                                              {"gpu-pixel", "ns", true, NULL}, {"cpu", "ms", true, NULL},
                                              {"cpu-pixel", "ns", true, NULL}, {"ratio", "x", true, NULL}};

static const bench_case cases[] = {
	{.name = "bloom",
     .title = "bloom, 225 spheres, 640 x 360",
     .metrics = placed_metrics,
     .metric_count = COUNT(placed_metrics)},
	{.name = "bloom-large",
     .title = "bloom, 225 spheres, 1920 x 1080",
     .metrics = placed_metrics,
     .metric_count = COUNT(placed_metrics)},
	{.name = "ao",
     .title = "ambient occlusion, 225 spheres, 640 x 360",
     .metrics = placed_metrics,
     .metric_count = COUNT(placed_metrics)},
};

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-post",
     .note = "CPU time of a frame, all threads: without the effect; what the effect adds, by programs of the device "
             "(gpu) and by the CPU's threads (cpu), also for each pixel; ratio: cpu over gpu. A software device, "
             "whose work is the CPU's, is needed"},
};

const bench_suite bench_post_suite = {.name = "post",
                                      .help = "effects on the light of a frame: bloom, occlusion",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .start_seconds = 2.0,
                                      .quick_cpu_seconds = 40.0};
