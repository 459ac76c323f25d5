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

/* There is such a row, and it is more than nothing. */
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

#endif
