/* The suite `cull`: flat culling and the octree, by number of models and visible share, beside the machine's limit.
 * What a case is: cull_cases.h. */
#include "bench/cull/bench_cull.h"
#include "bench/cull/cull_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const bench_metric metrics[] = {
	{"per-model", "ns", true, NULL}, /* the p50, for each model of the scene, visible or not */
	{"p50", "us", true, NULL},
	{"p99", "us", true, NULL},
	{"visible", "%", true, NULL},
};

/* What a subject must be able to do. */
enum {
	LOOK = 1, /* see a scene in which nothing moves */
	MOVE = 2  /* keep up with one that moves */
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, MODELS, SHARE, BACK, MOVES)                                                                  \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .needs = MOVES ? MOVE : LOOK},
	CULL_CASES(CASE)
#undef CASE
};

#define PROGRAM "stilb-bench-cull"

static const bench_subject subjects[] = {
	{.name = "stilb-flat-scalar", .program = PROGRAM, .note = "every sphere, plain C", .abilities = LOOK},
	{.name = "stilb-flat-avx2", .program = PROGRAM, .note = "every sphere, eight at a time", .abilities = LOOK},
	{.name = "stilb-flat-avx512", .program = PROGRAM, .note = "every sphere, sixteen at a time", .abilities = LOOK},
	{.name = "stilb-octree", .program = PROGRAM, .note = "the loose octree", .abilities = LOOK | MOVE},
	{.name = "stilb-auto", .program = PROGRAM, .note = "whichever the frame before suggests", .abilities = LOOK | MOVE},
	{.name = "stilb-flat-2", .program = PROGRAM, .note = "flat on two threads, in a phase", .abilities = LOOK},
	{.name = "stilb-octree-2", .program = PROGRAM, .note = "octree on two threads, in a phase", .abilities = LOOK},
	{.name = "stilb-auto-2", .program = PROGRAM, .note = "auto on two threads, in a phase", .abilities = LOOK},
	{.name = "rebuild",
     .program = PROGRAM,
     .note = "the octree built anew in each frame",
     .abilities = MOVE,
     .reference = true},
	{.name = "stream",
     .program = PROGRAM,
     .note = "reads 16 bytes a model and does nothing with them",
     .abilities = LOOK,
     .reference = true},
};

const bench_suite bench_cull_suite = {.name = "cull",
                                      .help = "culling: flat, octree and the choice between them",
                                      .subjects = subjects,
                                      .subject_count = COUNT(subjects),
                                      .cases = cases,
                                      .case_count = COUNT(cases),
                                      .report = bench_cull_report,
                                      .goals = bench_cull_goals,
                                      .report_alone = true,
                                      .plot = bench_cull_plot,
                                      .plot_rows = BENCH_CULL_PLOT_ROWS,
                                      .start_seconds = 0.06};
