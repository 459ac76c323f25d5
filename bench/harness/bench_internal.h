/*
 * bench_internal: shared by the files of the harness, and by suites that compute rows or print tables of their own.
 * [main-thread] throughout.
 */
#ifndef BENCH_INTERNAL_H
#define BENCH_INTERNAL_H

#include "base/base.h"
#include "bench/harness/bench.h"

#include <math.h>

/* The path of a subject's program, beside stilb-bench. False if there is no such executable: it was not built. */
bool bench_program_path(const char *program, char *path, size_t size);

/* One subject in one case, with the outcome of its runs. */
typedef struct bench_pair {
	const bench_case *on;
	const bench_subject *subject;
	uint32_t attempts, timeouts, failures; /* attempts >= timeouts + failures */
	bool skipped;                          /* its program exited with BENCH_CHILD_SKIP */
	char message[256];                     /* of the last run that failed, timed out or was skipped */
} bench_pair;

struct bench_results {
	const bench_suite *suite;
	const bench_options *options;
	uint32_t rounds;   /* begun so far, at most options->rounds */
	double seconds;    /* length of a run, before bench_case.length */
	double load;       /* the machine's load average over the minute before the first run */
	bench_pair *pairs; /* the limits' first, then case by case in the suite's order */
	size_t pair_count;
	bench_row *rows; /* in the order of the pairs' cases; in a case, metric by metric */
	size_t row_count, row_capacity;
};

#define BENCH_NO_NUMBER ((double)NAN)

/* Appends the row of a metric, all values NaN. STILB_OK or STILB_ERROR_MEMORY. */
stilb_result bench_add_row(bench_results *results, const bench_case *on, const bench_subject *subject,
                           const bench_metric *metric);

/* Computes runs, median, min and max of every row from its values. Call it again after bench_set_value. */
void bench_summarise(bench_results *results);

/* Sets the value of a row in a round below results->rounds. A metric that the case does not list is ignored: a program
 * may print more than its table shows. */
void bench_set_value(bench_results *results, const bench_case *on, const bench_subject *subject, const char *metric,
                     uint32_t round, double value);

/* Metrics that the harness itself measures for every pair: peak resident memory, MiB, and steal, percent. */
#define BENCH_METRIC_MEMORY "peak-memory"
#define BENCH_METRIC_STEAL "steal"

extern const bench_case bench_limits_case;
extern const bench_subject bench_limits_subject;

/* The row's median in units of a limit (ns): time / limit, or rate * limit for rates. NaN for other units. */
double bench_of_limit(const bench_row *row, const bench_row *limit);

/* Above either of them the report says that the machine was busy. */
#define BENCH_BUSY_LOAD 0.25 /* load average for each CPU */
#define BENCH_BUSY_STEAL 2.0 /* percent */

/* Prints the tables, and flushes. */
void bench_print(FILE *out, const bench_results *results);
/* Prints three sentences that sum the tables up, and flushes: how much ran, how Stilb compares with the best peers, and
 * how far the numbers can be trusted. */
void bench_print_words(FILE *out, const bench_results *results);
/* Write the results as JSON (path "-": stdout), and as a picture by gnuplot. EXIT_DONE, or EXIT_FAILED after a line on
 * stderr; a file is whole or not there. */
int bench_save_json(const bench_results *results, const char *path);
int bench_save_plot(const bench_results *results, const char *path);

/* Compiler and flags of this build: "GNU 12.2.0 -O3 -DNDEBUG, for C and C++ alike". */
const char *bench_build_flags(void);
/* The CPU's name, the number of CPUs that this process may use, and the kernel. */
void bench_machine(char *text, size_t size);
/* The number of CPUs that this process may use. */
uint32_t bench_cpu_count(void);

/* Digits after the point that give three significant ones: 0 from 100 on, 1 from 10 on, 2 from 1 on, else 3. */
int bench_digits(double value);
/* Prints a blank and the value in `width` columns, with bench_digits; "-" if it is not finite. */
void bench_print_number(FILE *out, int width, double value);
/* The same as "12.3 [10.1-14.2]": median, least, most. */
void bench_print_range(FILE *out, int width, double median, double least, double most);

#endif
