/* The suite `profiler`: compares the cost of recording a zone (a named span of code) with that of reading the clock,
 * for Stilb's profiler and others, and measures captures, files and snapshots of recorded events. The cases are in
 * profiler_cases.h. */
#include "bench/harness/bench.h"
#include "bench/profiler/profiler_cases.h"

#define COUNT(ARRAY) (sizeof(ARRAY) / sizeof *(ARRAY))

/* ---- metrics ----------------------------------------------------------------------------------------------------- */

/* pair: two bare reads of the clock; zone: the subject's zone; of-pair: zone / pair. Both loops take turns in one
 * process, so that disturbances of the machine cancel in the ratio. */
static const bench_metric ratio_metrics[] = {
	{"pair", "ns", true, NULL},
	{"zone", "ns", true, NULL},
	{"of-pair", "x", true, NULL},
};
static const bench_metric added_metrics[] = {
	{"without", "ns", true, NULL},
	{"with", "ns", true, NULL},
	{"added", "ns", true, NULL},
};
static const bench_metric two_metrics[] = {
	{"one", "ns", true, NULL},
	{"two", "ns", true, NULL},
	{"of-one", "x", true, NULL},
};
static const bench_metric worst_metrics[] = {
	{"p50", "ns", true, NULL},
	{"p99.99", "ns", true, NULL},
	{"p99.999", "ns", true, NULL},
	{"worst", "ns", true, NULL},
};
static const bench_metric frame_metrics[] = {
	{"mark", "ns", true, NULL},
};
static const bench_metric capture_metrics[] = {
	{"frame", "us", true, NULL}, /* median frame time before the capture */
	{"worst-before", "us", true, NULL}, {"worst-during", "us", true, NULL},
	{"stall", "us", true, NULL}, /* worst-during minus frame */
	{"mark", "us", true, NULL},  /* the longest frame mark during the capture */
	{"captured", "ms", true, NULL},
};
static const bench_metric file_metrics[] = {
	{"snapshot", "ms", true, NULL}, {"json", "MB/s", false, NULL}, {"file", "MB/s", false, NULL},
	{"read", "MB/s", false, NULL},  {"size", "MB", true, NULL},
};
static const bench_metric live_metrics[] = {
	{"snapshot", "us", true, NULL},
};
static const bench_metric switches_metrics[] = {
	{"kernel", "switches", false, NULL},
	{"seen", "switches", false, NULL},
	{"of-kernel", "x", false, NULL},
};

#define METRICS_ZONE ratio_metrics
#define METRICS_NEXT ratio_metrics
#define METRICS_PRECISE ratio_metrics
#define METRICS_WORK added_metrics
#define METRICS_OFF added_metrics
#define METRICS_TWO two_metrics
#define METRICS_WORST worst_metrics
#define METRICS_FRAME frame_metrics
#define METRICS_CAPTURE capture_metrics
#define METRICS_FILE file_metrics
#define METRICS_LIVE live_metrics
#define METRICS_SWITCHES switches_metrics

#define CAN(KIND) (1u << PROFILER_##KIND)

static const bench_case cases[] = {
#define CASE(NAME, TITLE, KIND)                                                                                        \
	{.name = NAME,                                                                                                     \
	 .title = TITLE,                                                                                                   \
	 .metrics = METRICS_##KIND,                                                                                        \
	 .metric_count = COUNT(METRICS_##KIND),                                                                            \
	 .needs = CAN(KIND)},
	PROFILER_CASES(CASE)
#undef CASE
};

/* ---- subjects ---------------------------------------------------------------------------------------------------- */

#define LOOPS (CAN(ZONE) | CAN(WORK) | CAN(TWO) | CAN(WORST))

static const bench_subject subjects[] = {
	{.name = "stilb",
     .program = "stilb-bench-profiler-own",
     .note = "PROFILE with a ring of 65,536 events for each thread, recording unless the case says otherwise",
     .abilities = ~0u},
	{.name = "microprofile",
     .program = "stilb-bench-profiler-microprofile",
     .package = "libmicroprofile-dev",
     .note = "MICROPROFILE_SCOPEI with all groups enabled, MicroProfileFlip between turns",
     .abilities = LOOPS | CAN(OFF)},
	{.name = "rdtsc",
     .program = "stilb-bench-profiler-limits",
     .note = "two bare reads of the time-stamp counter; next: one read; precise: the second is rdtscp",
     .abilities = LOOPS | CAN(NEXT) | CAN(PRECISE),
     .reference = true},
	{.name = "clock_gettime",
     .program = "stilb-bench-profiler-limits",
     .note = "two bare reads of CLOCK_MONOTONIC",
     .abilities = LOOPS,
     .reference = true},
};

/* ---- goals ------------------------------------------------------------------------------------------------------- */

typedef struct goal {
	const char *what, *on, *subject, *metric;
	double bound; /* bound of the median; 0: it is only printed */
	bool at_least;
	const char *note;
} goal;

static const goal goals[] = {
	{"empty zone / two rdtsc", "zone", "stilb", "of-pair", 1.02, false, "measured elsewhere: Tracy 1.15, Optick 2.84"},
	{"  microprofile", "zone", "microprofile", "of-pair", 0, false, NULL},
	{"PROFILE_NEXT / two rdtsc", "next", "stilb", "of-pair", 0.55, false, NULL},
	{"PROFILE_PRECISE / two rdtsc", "precise", "stilb", "of-pair", 0, false, NULL},
	{"zone around 41 ns of work, added time", "work", "stilb", "added", 1.0, false, NULL},
	{"  microprofile", "work", "microprofile", "added", 0, false, NULL},
	{"added while off", "off", "stilb", "added", 0.10, false, NULL},
	{"  microprofile", "off", "microprofile", "added", 0, false, NULL},
	{"zone on two threads / on one", "two", "stilb", "of-one", 1.05, false, NULL},
	{"p99.999 of 10 million zones", "worst", "stilb", "p99.999", 0, false, NULL},
	{"  two rdtsc alone", "worst", "rdtsc", "p99.999", 0, false, NULL},
	{"slowest of 10 million zones", "worst", "stilb", "worst", 0, false, NULL},
	{"  two rdtsc alone", "worst", "rdtsc", "worst", 0, false, NULL},
	{"frame mark", "frame", "stilb", "mark", 0, false, NULL},
	{"capture: stall of the frame thread", "capture", "stilb", "stall", 1000.0, false, NULL},
	{"capture: longest frame mark", "capture", "stilb", "mark", 0, false, NULL},
	{"converting to JSON", "file", "stilb", "json", 300.0, true, NULL},
	{"converting to JSON, writing a file", "file", "stilb", "file", 300.0, true, NULL},
	{"reading the JSON back", "file", "stilb", "read", 0, true, NULL},
	{"snapshot for an overlay", "live", "stilb", "snapshot", 100.0, false, NULL},
	{"context switches seen", "switches", "stilb", "of-kernel", 1.0, true, NULL},
};

static void print_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoals, set on the CPU named in docs/benchmarks.md; median [least-most] of the rounds\n");
	for (size_t i = 0; i < COUNT(goals); i++) {
		const goal *g = &goals[i];
		const bench_row *row = bench_find(results, g->on, g->subject, g->metric);
		if (!row)
			continue;
		char range[32];
		snprintf(range, sizeof range, "[%.4g-%.4g]", row->min, row->max);
		fprintf(out, "  %-36s %8.4g %-16s %-9s", g->what, row->median, range, row->unit);
		if (g->bound > 0.0) {
			bool met = g->at_least ? row->median >= g->bound : row->median <= g->bound;
			fprintf(out, " goal %s %-6.4g %-6s", g->at_least ? ">=" : "<=", g->bound, met ? "met" : "MISSED");
		}
		if (g->note)
			fprintf(out, " (%s)", g->note);
		fputc('\n', out);
	}
}

/* ---- the suite --------------------------------------------------------------------------------------------------- */

static const char *const loop_cases[] = {"zone", "next", "precise", NULL};
static const char *const work_cases[] = {"work", "off", NULL};
static const char *const two_cases[] = {"two", NULL};
static const char *const worst_cases[] = {"worst", NULL};

static const bench_panel panels[] = {
	{"an empty zone", loop_cases, "zone", false},
	{"time that a zone adds: to 41 ns of work, and to a loop while recording is off", work_cases, "added", false},
	{"an empty zone on two threads at once", two_cases, "two", false},
	{"the slowest of ten million empty zones", worst_cases, "worst", true},
};

const bench_suite bench_profiler_suite = {.name = "profiler",
                                          .help = "cost of a profiler zone, captures, trace files, context switches",
                                          .subjects = subjects,
                                          .subject_count = COUNT(subjects),
                                          .cases = cases,
                                          .case_count = COUNT(cases),
                                          .panels = panels,
                                          .panel_count = COUNT(panels),
                                          .goals = print_goals,
                                          .quick_cpu_seconds = 10.0};
