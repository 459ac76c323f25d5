/*
 * bench: the harness of stilb-bench. A suite is a table of subjects (implementations: a queue, a job system) and cases
 * (workloads: 4 producers and 4 consumers; a fork-join of 8). The harness runs every subject in every case that it can
 * do, several times, and reports.
 *
 *   static const bench_metric metrics[] = {{"throughput", "Mops/s", false, BENCH_LIMIT_CONTENDED}};
 *   static const bench_case cases[] = {{.name = "1P1C", .title = "1 producer, 1 consumer", .metrics = metrics,
 *                                       .metric_count = 1}};
 *   static const bench_subject subjects[] = {{.name = "stilb", .program = "stilb-bench-queue-own"}};
 *   const bench_suite bench_queue_suite = {.name = "queue", .help = "concurrent queues", .subjects = subjects,
 *                                          .subject_count = 1, .cases = cases, .case_count = 1};
 *
 * To add a suite, put such a table into bench/<name>/bench_<name>.c, declare it below, list it in main.c, and write the
 * programs that its subjects name.
 *
 * Runs.     Each run of a subject in a case is a process of its own: a program beside stilb-bench, one for each library
 *           that is measured, so no subject shares an address space with another. bench_child.h is the program's side:
 *           its command line and its output. The program measures, verifies its own result and fails if that is wrong.
 *           A run that exceeds its bench_limit is killed and reported as timed out.
 * Rounds.   A round runs every subject in every case once. The subjects of a case run one after the other, and each
 *           round starts with the next subject, so that a disturbance of the machine hits all of them alike.
 * Missing.  A subject whose program was not built, because its library is not installed, is named and skipped.
 * Limits.   Each round also measures the machine: an atomic add with and without contention, a futex wake, a read of
 *           the clock. A metric may name the limit that bounds it.
 * Report.   Tables on stdout, three sentences that sum them up, JSON, a picture drawn by gnuplot.
 * Traces.   A suite that draws frames may keep a timeline of each subject's slowest frame.
 *
 * Threads: stilb-bench has one thread, and every function here is [main-thread].
 */
#ifndef BENCH_H
#define BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* ---- suites ------------------------------------------------------------------------------------------------------ */

/* One number that a run prints. */
typedef struct bench_metric {
	const char *name; /* no white space; as the program prints it; shorter than 48 characters */
	const char *unit; /* "Mops/s" and "Mjobs/s" (10^6 a second), "ns", "us", "ms", "%", ... */
	bool less_is_better;
	const char *limit; /* BENCH_LIMIT_..., ns: no time can be less, and no rate more than 1 / limit; NULL: none */
} bench_metric;

/* A metric of this name is the number of items (passed through a queue, for example) that a run verified. It has no
 * table of its own, but is a column of the other metrics' tables. */
#define BENCH_METRIC_ITEMS "items"

/* The machine's limits, in ns for each operation; contended: elapsed time / operations of all threads together. */
#define BENCH_LIMIT_UNCONTENDED "uncontended-atomic" /* fetch_add by one thread */
#define BENCH_LIMIT_CONTENDED "contended-atomic"     /* fetch_add on one cache line by one thread for each CPU */
/* WAKE: from a thread's call of futex to the first instruction of the thread that it wakes, both pinned to CPUs. */
#define BENCH_LIMIT_WAKE "futex-wake-p50" /* median */
#define BENCH_LIMIT_WAKE_P99                                                                                           \
	"futex-wake-p99"              /* 99th percentile; the woken thread has slept for more than 100 us before */
#define BENCH_LIMIT_CLOCK "clock" /* one read of the time-stamp counter */

typedef struct bench_case {
	const char *name;            /* no white space; the word for --case and for the program */
	const char *title;           /* one line for the tables */
	const bench_metric *metrics; /* [metric_count], at least one */
	size_t metric_count;
	/* A set of bits that the suite defines; a subject runs the case if its abilities include all of them. */
	uint32_t needs;
	double length; /* a run lasts this many times --seconds; 0 means 1 */
} bench_case;

typedef struct bench_subject {
	const char *name;    /* no white space; Stilb's own start with "stilb", the others are peers or references */
	const char *program; /* file name, in the folder of stilb-bench */
	const char *package; /* Debian package that the build needs for it, or NULL */
	const char *note;    /* one line printed below the tables: how it was used; or NULL */
	uint32_t abilities;  /* see bench_case.needs */
	bool reference;      /* a bound or baseline (a bare counter, a serial loop), never "the best peer" */
} bench_subject;

/* One diagram of the picture, and one table of ratios: medians of all subjects in these cases, side by side. */
typedef struct bench_panel {
	const char *title;
	const char *const *cases; /* names, NULL-terminated */
	const char *metric;       /* its name; all of these cases have it */
	bool logarithmic;
} bench_panel;

typedef struct bench_options bench_options;
typedef struct bench_results bench_results;

typedef struct bench_suite {
	const char *name;
	const char *help;              /* one line */
	const bench_subject *subjects; /* [subject_count]; at most BENCH_MAX_SUBJECTS */
	size_t subject_count;
	const bench_case *cases; /* [case_count] */
	size_t case_count;
	/* All members below may be NULL, 0 or false. */
	const bench_panel *panels; /* [panel_count] */
	size_t panel_count;
	/* Called once before the first run. Returns the last argument of every program of the suite, for example a
	 * calibration or a reference result; it must live until bench_run returns. NULL: failed, after a line on stderr. */
	const char *(*prepare)(const bench_options *options);
	/* Called once after the last run: computes metrics from measured ones (a speed-up from two times) and stores them
	 * with bench_set_value. */
	void (*finish)(bench_results *results);
	/* Prints the suite's own tables after those of the harness. */
	void (*report)(FILE *out, const bench_results *results);
	/* With --goals: prints bounds, set on the CPU that docs/benchmarks.md names, each with "met" or "MISSED". */
	void (*goals)(FILE *out, const bench_results *results);
	bool report_alone; /* true: only `report` prints tables, since there are too many cases for one each */
	/* Replaces the panels: writes gnuplot commands for plot_rows rows of two diagrams each. */
	void (*plot)(FILE *out, const bench_results *results);
	size_t plot_rows;
	bool traces;           /* true: the programs can write timelines, for --traces */
	uint32_t quick_rounds; /* rounds with --quick; 0: the harness' own number */
	double start_seconds;  /* from a program's start until it measures, if more than some milliseconds */
	/* CPU time, in s, that a run with --quick may use on each CPU beyond 1.5 times its length, before it is killed; 0:
	 * the harness' own number. */
	double quick_cpu_seconds;
} bench_suite;

#define BENCH_MAX_SUBJECTS 256

extern const bench_suite bench_queue_suite, bench_jobs_suite, bench_cull_suite, bench_record_suite,
	bench_profiler_suite, bench_shade_suite, bench_gi_suite, bench_furnace_suite, bench_input_suite, bench_import_suite,
	bench_gltf_suite, bench_simplify_suite, bench_clusters_suite, bench_lod_suite, bench_pop_suite, bench_plan_suite,
	bench_bake_suite, bench_prefilter_suite, bench_upload_suite, bench_animate_suite, bench_textured_suite,
	bench_lights_suite, bench_shadows_suite, bench_post_suite;
/* Suites whose cases or subjects depend on the number of CPUs; filled by the first call. */
const bench_suite *bench_steps_suite(void);
const bench_suite *bench_threads_suite(void);

/* ---- running one ------------------------------------------------------------------------------------------------- */

struct bench_options {
	const char *only;        /* subjects: names or shell patterns, separated by commas; NULL: all */
	const char *cases;       /* the same for cases */
	const char *json, *plot; /* files to write, or NULL; json "-" is stdout, and the tables then go to stderr */
	const char *traces;      /* folder for timelines, or NULL; only if suite->traces */
	uint32_t rounds;         /* at least 1 */
	double seconds;          /* length of a run; 0: chosen so that the suite ends in time with --quick */
	bool quick;              /* the whole suite in less than 30 s */
	bool list;               /* print subjects and cases, run nothing */
	bool goals;              /* call suite->goals */
	uint32_t give_up;        /* seconds of wall-clock time after which a run is killed, at least 1 */
};

/* Runs a suite and reports. The suite's tables must be sound: distinct names without white space, panels that name
 * existing cases and metrics. Returns the program's exit code: 0; 1: a run failed, its result was wrong, one of Stilb's
 * subjects timed out, or a file was not written; 2: refused before the first run. Errors are lines on stderr. */
int bench_run(const bench_suite *suite, const bench_options *options);

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* The values of one metric of one subject in one case, one value for each round. */
typedef struct bench_row {
	const bench_case *on; /* the case */
	const bench_subject *subject;
	const char *name; /* the subject's */
	const char *metric, *unit;
	bool less_is_better;
	uint32_t runs; /* rounds that have a value */
	double median, min, max;
	const double *values; /* [rounds]; NaN in a round without a value */
} bench_row;

/* The suite that was run. */
const bench_suite *bench_suite_of(const bench_results *results);

/* The row of a case, a subject and a metric; NULL if no run gave a value. For the machine's limits case_name and
 * subject_name are NULL and metric is a BENCH_LIMIT_.... */
const bench_row *bench_find(const bench_results *results, const char *case_name, const char *subject_name,
                            const char *metric);

/* The ratio of two rows in each round in which both have a value: its median, least and largest. False if there is no
 * such round; *ratio is then unchanged. */
typedef struct bench_ratio {
	double median, min, max;
} bench_ratio;
bool bench_paired_ratio(const bench_results *results, const bench_row *numerator, const bench_row *denominator,
                        bench_ratio *ratio);

/* ---- one child process, for a suite's prepare -------------------------------------------------------------------- */

typedef enum bench_child_state {
	BENCH_CHILD_DONE,
	BENCH_CHILD_SKIPPED, /* the subject does not have this case */
	BENCH_CHILD_FAILED,  /* wrong result, crash, or output that is not "metric value" lines */
	BENCH_CHILD_TIMED_OUT
} bench_child_state;

#define BENCH_CHILD_VALUES 64 /* the most that a run may print */

typedef struct bench_child_result {
	bench_child_state state;
	char message[256]; /* why it was skipped, failed or timed out: its last line on stderr, or the signal */
	struct {
		char metric[48];
		double value;
	} values[BENCH_CHILD_VALUES]; /* [value_count], in the order printed */
	size_t value_count;
	double seconds; /* wall-clock time from start to end */
	double peak_mb; /* largest resident set, MiB */
	double steal;   /* percent of the machine's CPU time during the run that the hypervisor gave to other machines */
} bench_child_result;

/* When a run is killed. CPU time tells an endless run from one on a busy machine; wall-clock time only ends a run that
 * waits for ever, so it should be generous. Both are greater than 0. */
typedef struct bench_limit {
	double cpu_seconds; /* of all threads together; rounded up to whole seconds */
	double seconds;
} bench_limit;

/* Runs PROGRAM SUBJECT CASE SECONDS ROUND [ARGUMENT] within the limit and waits for its end. program is a file name in
 * the folder of stilb-bench; seconds >= 0; argument may be NULL. result->state is the outcome, and also tells that the
 * program could not be started. */
void bench_child_run(const char *program, const char *subject, const char *case_name, double seconds, uint32_t round,
                     const char *argument, bench_limit limit, bench_child_result *result);

#endif
