/*
 * bench: how stilb-bench measures. A suite is a table: subjects (a queue, a job system) times cases (4 producers and 4
 * consumers; fork-join of 8). This harness runs all of it and reports.
 *
 * Runs.     Every run of a subject in a case is a process of its own: a small program beside stilb-bench, one for each
 *           library that is measured, so that nothing of one subject is in the address space of another. bench_child.h
 *           is the other side of this: what such a program is given and what it prints. The program measures, verifies
 *           its own result and fails when that is wrong. A run that takes too long is killed and reported as timed out.
 * Rounds.   A round runs every subject in every case once, subjects of a case next to each other, starting with another
 *           one each round. What disturbs the machine for a while so falls on all of them alike.
 * Missing.  A subject whose program was not built (its library is not installed) is named and left out.
 * Limits.   The machine's own limits (a contended and an uncontended atomic, a futex wake, the clock) are measured in
 *           every round too, and every metric may name the one that bounds it.
 * Report.   A table for each case and metric on stdout; JSON; a picture drawn by gnuplot.
 * Traces.   A suite that draws frames can keep a timeline of the worst frame of each subject in each case.
 *
 * To add a suite: fill a bench_suite in bench_<name>.c, declare it below, add it to the table in main.c, and write its
 * programs. Threads: all of it is [main-thread].
 */
#ifndef BENCH_H
#define BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* ---- what a suite is --------------------------------------------------------------------------------------------- */

/* One number that a run prints. */
typedef struct bench_metric {
	const char *name; /* without white space; as the program prints it */
	const char *unit; /* "Mops/s", "Mjobs/s" (per second, more is better), "ns", "us", "ms" (less is better), ... */
	bool less_is_better;
	const char *limit; /* metric of the limits that bounds it, or NULL; a rate is compared with 1 / that time */
} bench_metric;

/* A metric of this name, "how many items were verified", is shown as a column beside the others. */
#define BENCH_METRIC_ITEMS "items"

/* The limits, in ns: time of one operation, over all threads where contended. */
#define BENCH_LIMIT_UNCONTENDED "uncontended-atomic" /* fetch_add, one thread */
#define BENCH_LIMIT_CONTENDED "contended-atomic"     /* fetch_add on one line from as many threads as there are CPUs */
#define BENCH_LIMIT_WAKE "futex-wake-p50"     /* from the call of the waker to the first instruction of the sleeper, */
#define BENCH_LIMIT_WAKE_P99 "futex-wake-p99" /* both pinned, the sleeper parked for more than 100 us */
#define BENCH_LIMIT_CLOCK "clock"             /* reading the time-stamp counter */

typedef struct bench_case {
	const char *name;  /* without white space: what --case and the program take */
	const char *title; /* what it is, in words, for the table */
	const bench_metric *metrics;
	size_t metric_count;
	uint32_t needs; /* bits of the suite's own: runs with the subjects that have all of them among their abilities */
	double length;  /* runs last this times --seconds; 0 is 1 */
} bench_case;

typedef struct bench_subject {
	const char *name;    /* ours start with "stilb": they are no peers of each other */
	const char *program; /* file name of the program, beside stilb-bench */
	const char *package; /* Debian package that the build wants for it, or NULL */
	const char *note;    /* printed under the tables: how it was used; or NULL */
	uint32_t abilities;  /* bits of the suite's own, see bench_case.needs */
	bool reference;      /* neither ours nor a peer: a bare counter, the serial loop; never "the best peer" */
} bench_subject;

/* One diagram of the picture: subjects' medians with their ranges, cases side by side. */
typedef struct bench_panel {
	const char *title;
	const char *const *cases; /* NULL-terminated */
	const char *metric;
	bool logarithmic;
} bench_panel;

typedef struct bench_options bench_options;
typedef struct bench_results bench_results;

typedef struct bench_suite {
	const char *name;
	const char *help; /* one line */
	const bench_subject *subjects;
	size_t subject_count;
	const bench_case *cases;
	size_t case_count;
	const bench_panel *panels;
	size_t panel_count;
	/* All below may be NULL. */
	/* Called once before the first run, for what all runs must have alike (a calibration); the string, which must live
	 * until the end, is given to every program. NULL: could not, and has said why. */
	const char *(*prepare)(const bench_options *options);
	/* Called once after the last run: adds what follows from the values of a round. */
	void (*finish)(bench_results *results);
	void (*report)(FILE *out, const bench_results *results); /* prints more, after the tables */
	/* With --goals: the numbers beside bounds that hold for one CPU (docs/benchmarks.md names it), met or missed. */
	void (*goals)(FILE *out, const bench_results *results);
	bool report_alone; /* there are too many cases for a table each */
	/* In place of the panels: writes gnuplot commands that draw plot_rows rows of two diagrams each. */
	void (*plot)(FILE *out, const bench_results *results);
	size_t plot_rows;
	bool traces;              /* its runs can write timelines of frames, as --traces says */
	uint32_t quick_rounds;    /* with --quick; 0: the usual number */
	double start_seconds;     /* what a program takes to begin, where that is not next to nothing */
	double quick_cpu_seconds; /* a CPU, beyond a run's length, that it is given with --quick; 0: the usual */
} bench_suite;

extern const bench_suite bench_queue_suite, bench_jobs_suite, bench_cull_suite, bench_record_suite,
	bench_profiler_suite, bench_shade_suite, bench_gi_suite, bench_furnace_suite, bench_input_suite;
/* These depend on the number of CPUs: filled at the first call. */
const bench_suite *bench_steps_suite(void);
const bench_suite *bench_threads_suite(void);

/* ---- running it -------------------------------------------------------------------------------------------------- */

struct bench_options {
	const char *only;        /* subjects, "a,b"; shell patterns; NULL: all */
	const char *cases;       /* the same for cases */
	const char *json, *plot; /* files, or NULL */
	const char *traces;      /* a folder, or NULL */
	uint32_t rounds;
	double seconds;   /* length of a run; 0: what fits (--quick) */
	bool quick;       /* the whole suite takes less than 30 s */
	bool list;        /* print subjects and cases, run nothing */
	bool goals;       /* print the suite's goals too */
	uint32_t give_up; /* seconds after which a run that has not ended is taken for hanging */
};

/* Runs and reports. Returns the exit code: 0; 1: a run failed or was wrong, or a file was not written; 2: refused. */
int bench_run(const bench_suite *suite, const bench_options *options);

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* All runs of one (case, subject, metric). */
typedef struct bench_row {
	const bench_case *on; /* NULL for the limits */
	const bench_subject *subject;
	const char *name; /* of the subject */
	const char *metric, *unit;
	bool less_is_better;
	uint32_t runs;
	double median, min, max;
	const double *values; /* one for each round, NaN where there is none */
} bench_row;

/* The suite that the results are of. */
const bench_suite *bench_suite_of(const bench_results *results);

/* NULL: it did not run. case_name NULL: one of the limits (subject_name NULL too). */
const bench_row *bench_find(const bench_results *results, const char *case_name, const char *subject_name,
                            const char *metric);

/* A ratio of two rows: that of each round in which both ran, and of these the median, least and largest. false:
 * none. */
typedef struct bench_ratio {
	double median, min, max;
} bench_ratio;
bool bench_paired_ratio(const bench_results *results, const bench_row *numerator, const bench_row *denominator,
                        bench_ratio *ratio);

/* ---- one child process, for a suite's prepare -------------------------------------------------------------------- */

typedef enum bench_child_state {
	BENCH_CHILD_DONE,
	BENCH_CHILD_SKIPPED, /* this subject has no such case */
	BENCH_CHILD_FAILED,  /* wrong result, crash, bad output */
	BENCH_CHILD_TIMED_OUT
} bench_child_state;

#define BENCH_CHILD_VALUES 64

typedef struct bench_child_result {
	bench_child_state state;
	char message[256]; /* why it failed or timed out: the last line on stderr, or the signal */
	struct {
		char metric[48];
		double value;
	} values[BENCH_CHILD_VALUES]; /* in the order printed */
	size_t value_count;
	double seconds; /* it took */
	double peak_mb; /* resident memory, MiB */
	double steal;   /* percent of the machine's CPU time that the hypervisor took meanwhile */
} bench_child_result;

/* When a run is killed. CPU time is what tells a run that never ends from one on a busy machine; the clock only guards
 * against one that waits for ever, and is generous. */
typedef struct bench_limit {
	double cpu_seconds; /* of all its threads together, rounded up to whole seconds */
	double seconds;
} bench_limit;

/* Runs PROGRAM SUBJECT CASE SECONDS ROUND [ARGUMENT] (argument may be NULL) within the limit. */
void bench_child_run(const char *program, const char *subject, const char *case_name, double seconds, uint32_t round,
                     const char *argument, bench_limit limit, bench_child_result *result);

#endif
