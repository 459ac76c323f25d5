/* bench_internal: what the files of the harness share. */
#ifndef BENCH_INTERNAL_H
#define BENCH_INTERNAL_H

#include "base/base.h"
#include "bench/harness/bench.h"

#include <math.h>

/* Where a program lies; false: it was not built. */
bool bench_program_path(const char *program, char *path, size_t size);

/* One (case, subject) that runs, with what came of it. */
typedef struct bench_pair {
	const bench_case *on;
	const bench_subject *subject;
	uint32_t attempts, timeouts, failures;
	bool skipped;      /* the subject said that it has no such case */
	char message[256]; /* of the last failure or time-out, or why it was skipped */
} bench_pair;

struct bench_results {
	const bench_suite *suite;
	const bench_options *options;
	uint32_t rounds; /* begun */
	double seconds;  /* of a run */
	double load;     /* of the machine before the first run: processes that want a CPU, over a minute */
	bench_pair *pairs;
	size_t pair_count;
	bench_row *rows; /* the limits first, then case by case, metric by metric */
	size_t row_count, row_capacity;
};

#define BENCH_NO_NUMBER ((double)NAN)

/* Adds the row of a metric, without numbers yet. STILB_OK, or out of memory. */
stilb_result bench_add_row(bench_results *results, const bench_case *on, const bench_subject *subject,
                           const bench_metric *metric);

/* Median, least and largest of every row; again after rows have got more values. */
void bench_summarise(bench_results *results);

/* For a suite's finish: a value that follows from others. */
void bench_set_value(bench_results *results, const bench_case *on, const bench_subject *subject, const char *metric,
                     uint32_t round, double value);

/* The names of rows that the harness measures itself, for every pair. */
#define BENCH_METRIC_MEMORY "peak-memory"
#define BENCH_METRIC_STEAL "steal"

extern const bench_case bench_limits_case;
extern const bench_subject bench_limits_subject;

/* The row's median divided by the limit that bounds it, a time in ns; NaN when it does not know the row's unit. */
double bench_of_limit(const bench_row *row, const bench_row *limit);

#define BENCH_BUSY_LOAD 0.25 /* of others, a CPU: more disturbs */
#define BENCH_BUSY_STEAL 2.0 /* percent */

/* Tables; flushed. */
void bench_print(FILE *out, const bench_results *results);
/* Three sentences for who does not read tables: what ran, how ours compares, what the numbers are worth. Flushed. */
void bench_print_words(FILE *out, const bench_results *results);
int bench_save_json(const bench_results *results, const char *path); /* exit code */
int bench_save_plot(const bench_results *results, const char *path); /* exit code */

/* "gcc 12.2.0 -O3 -DNDEBUG, C++ the same". */
const char *bench_build_flags(void);
/* The CPU's name and how many of them this process may use. */
void bench_machine(char *text, size_t size);
uint32_t bench_cpu_count(void);

#endif
