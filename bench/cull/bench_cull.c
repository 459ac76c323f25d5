/* The suite `cull`: flat culling, the octree and the automatic choice, by number of models and visible share, beside a
 * read of all bounds. The cases are in cull_cases.h. */
#include "bench/cull/bench_cull.h"
#include "bench/cull/cull_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const bench_metric metrics[] = {
	{"per-model", "ns", true, NULL}, /* p50 / number of models in the scene, visible or not */
	{"p50", "us", true, NULL},
	{"p99", "us", true, NULL},
	{"visible", "%", true, NULL},
};

/* Bits of bench_subject.abilities and bench_case.needs. */
enum {
	LOOK = 1, /* the subject can cull a scene in which nothing moves */
	MOVE = 2  /* it can update its octree in each frame, as models move */
};

static const bench_case cases[] = {
#define CASE(NAME, TITLE, MODELS, SHARE, BACK, MOVES)                                                                  \
	{.name = NAME, .title = TITLE, .metrics = metrics, .metric_count = COUNT(metrics), .needs = MOVES ? MOVE : LOOK},
	CULL_CASES(CASE)
#undef CASE
};

#define PROGRAM "stilb-bench-cull"

static const bench_subject subjects[] = {
	{.name = "stilb-flat-scalar",
     .program = PROGRAM,
     .note = "tests every bounding sphere, plain C",
     .abilities = LOOK},
	{.name = "stilb-flat-avx2",
     .program = PROGRAM,
     .note = "tests every bounding sphere, eight at a time with AVX2",
     .abilities = LOOK},
	{.name = "stilb-flat-avx512",
     .program = PROGRAM,
     .note = "tests every bounding sphere, sixteen at a time with AVX-512",
     .abilities = LOOK},
	{.name = "stilb-octree", .program = PROGRAM, .note = "a loose octree", .abilities = LOOK | MOVE},
	{.name = "stilb-auto",
     .program = PROGRAM,
     .note = "flat or octree, chosen by the frame before",
     .abilities = LOOK | MOVE},
	{.name = "stilb-flat-2",
     .program = PROGRAM,
     .note = "flat on two threads that stay awake between frames",
     .abilities = LOOK},
	{.name = "stilb-octree-2",
     .program = PROGRAM,
     .note = "octree on two threads that stay awake between frames",
     .abilities = LOOK},
	{.name = "stilb-auto-2",
     .program = PROGRAM,
     .note = "auto on two threads that stay awake between frames",
     .abilities = LOOK},
	{.name = "rebuild",
     .program = PROGRAM,
     .note = "builds a new octree in each frame",
     .abilities = MOVE,
     .reference = true},
	{.name = "stream",
     .program = PROGRAM,
     .note = "only reads 16 bytes of each model: a lower bound for flat culling",
     .abilities = LOOK,
     .reference = true},
};

const bench_suite bench_cull_suite = {.name = "cull",
                                      .help = "frustum culling: flat, octree and the automatic choice",
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
