/* What the tests of stilb-bench's suites share: the rows of its JSON (in `stats`), and programs made up by a test. */
#ifndef BENCH_PROGRAM_H
#define BENCH_PROGRAM_H

#include "support/stilb_program.h"

#include <math.h>

static inline const char *row_text(int row, const char *key)
{
	char path[64];
	snprintf(path, sizeof path, "rows[%d].%s", row, key);
	const json_flat_value *value = json_flat_find(&stats, path);
	return value ? value->text : NULL;
}

/* The median of a row; NaN: there is none. */
static inline double row_median(const char *case_name, const char *subject, const char *metric)
{
	for (int i = 0; row_text(i, "case"); i++)
		if (strcmp(row_text(i, "case"), case_name) == 0 && strcmp(row_text(i, "subject"), subject) == 0 &&
		    strcmp(row_text(i, "metric"), metric) == 0)
			return strtod(row_text(i, "median"), NULL);
	return (double)NAN;
}

/* The median of a row, which must exist and be above 0. */
static inline double some(const char *case_name, const char *subject, const char *metric)
{
	double median = row_median(case_name, subject, metric);
	if (!(median > 0.0))
		print_error("%s %s %s: %g\n", case_name, subject, metric, median);
	assert_true(median > 0.0);
	return median;
}

/* A shell script in the current folder. */
static inline void write_program(const char *name, const char *script)
{
	FILE *file = fopen(name, "w");
	assert_non_null(file);
	fprintf(file, "#!/bin/sh\n%s\n", script);
	fclose(file);
	assert_int_equal(chmod(name, 0755), 0);
}

#define GOOD_LIMITS                                                                                                    \
	"echo clock 1; echo uncontended-atomic 2; echo contended-atomic 3; echo futex-wake-p50 4; echo futex-wake-p99 5"

static inline void copy_program(const char *from, const char *to)
{
	char command[2 * PATH_MAX + 16];
	snprintf(command, sizeof command, "cp '%s' '%s'", from, to);
	assert_int_equal(system(command), 0);
}

/* A copy of stilb-bench in the current folder, which finds the made-up programs beside it, and limits for it. */
static inline void copy_bench(void)
{
	copy_program(stilb_path, "stilb-bench");
	write_program("stilb-bench-limits", GOOD_LIMITS);
}

/* Runs the copy of stilb-bench in the current folder. */
static inline int copy_code(const char *const *environment, const char *line)
{
	char home[PATH_MAX];
	memcpy(home, stilb_path, sizeof home);
	assert_non_null(realpath("stilb-bench", stilb_path));
	int code = stilb_code(environment, line);
	memcpy(stilb_path, home, sizeof home);
	return code;
}

#endif
