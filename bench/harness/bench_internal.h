/*
 * bench_internal: shared by the files of the benchmark harness (bench.h introduces its terms: suite, subject, case,
 * round), and by suites that compute rows or print tables of their own. [main-thread] throughout.
 */
#ifndef BENCH_INTERNAL_H
#define BENCH_INTERNAL_H

#include "base/base.h"
#include "bench/harness/bench.h"

#include <math.h>

/* The path of a subject's program, beside stilb-bench. False if there is no such executable: it was not built. */
bool bench_program_path(const char *program, char *path, size_t size);

/* One subject (an implementation) in one case (a workload), with the outcome of its runs so far. */
typedef struct bench_pair {
	const bench_case *on; /* the case */
	const bench_subject *subject;
	uint32_t attempts, timeouts, failures; /* attempts >= timeouts + failures */
	bool skipped;                          /* its program exited with BENCH_CHILD_SKIP */
	char message[256];                     /* of the last run that failed, timed out or was skipped */
} bench_pair;

struct bench_results {
	const bench_suite *suite;
	const bench_options *options;
	uint32_t rounds;   /* begun so far, at most options->rounds */
	double seconds;    /* length of a run; bench_case.length is a factor of it */
	double load;       /* the machine's load average over the minute before the first run */
	bench_pair *pairs; /* [pair_count]: the machine's limits, then case by case in the suite's order */
	size_t pair_count;
	bench_row *rows; /* [row_count]: case by case as in pairs; in a case, metric by metric */
	size_t row_count, row_capacity;
};

#define BENCH_NO_NUMBER ((double)NAN)

/* Appends the row of a metric of a subject in a case, with a NaN for each round. STILB_OK or STILB_ERROR_MEMORY. */
stilb_result bench_add_row(bench_results *results, const bench_case *on, const bench_subject *subject,
                           const bench_metric *metric);

/* Computes runs, median, min and max of every row from its values. Call it again after bench_set_value. */
void bench_summarise(bench_results *results);

/* Sets the value of a row in a round below results->rounds. A metric that the case does not list is ignored: a program
 * may print more than its table shows. */
void bench_set_value(bench_results *results, const bench_case *on, const bench_subject *subject, const char *metric,
                     uint32_t round, double value);

/* Metrics that the harness itself measures for every pair: peak resident memory, MiB, and steal, the percentage of CPU
 * time that the hypervisor gave to other machines. */
#define BENCH_METRIC_MEMORY "peak-memory"
#define BENCH_METRIC_STEAL "steal"

/* The pair under which the machine's limits (BENCH_LIMIT_...) are measured. */
extern const bench_case bench_limits_case;
extern const bench_subject bench_limits_subject;

/* The row's median in units of one of the machine's limits, whose row is in ns: time / limit, or rate * limit for
 * rates; 1 is the machine's best. NaN for units that are neither time nor rate. */
double bench_of_limit(const bench_row *row, const bench_row *limit);

/* If the load average or the steal exceeds its bound, the report says that the machine was busy. */
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
/* Prints a median with the least and the largest value as "12.3 [10.1-14.2]"; width as in bench_print_number. */
void bench_print_range(FILE *out, int width, double median, double least, double most);

#endif
