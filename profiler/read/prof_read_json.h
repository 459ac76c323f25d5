/* JSON (RFC 8259) read in place: a cursor over the text. What is wrong is remembered once: where, and what was
 * expected. */
#ifndef STILB_PROF_READ_JSON_H
#define STILB_PROF_READ_JSON_H

#include <assert.h>
#include <locale.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROF_SCAN_DEPTH_MAX 256 /* of objects and arrays in one another */

typedef struct prof_scan {
	const char *begin, *at, *end;
	const char *failed;   /* where; NULL: not yet */
	const char *expected; /* what */
	locale_t c_locale;    /* of numbers; made when first needed */
} prof_scan;

/* A part of the text: a string without its quotes, a number, an object. */
typedef struct prof_span {
	const char *text; /* NULL: absent */
	size_t size;
	bool escaped; /* a string with backslashes */
} prof_span;

/* All of these return false after an error. */
bool prof_scan_fail(prof_scan *scan, const char *at, const char *expected);
bool prof_scan_string(prof_scan *scan, prof_span *string);
bool prof_scan_number(prof_scan *scan, prof_span *number);
bool prof_scan_value(prof_scan *scan, prof_span *value); /* of any kind */
bool prof_scan_double(prof_scan *scan, double *value);

/* A time, exactly: tenths of nanoseconds are ns * 10 + tenths, of which ns alone is the nearest; what is finer is cut
 * off. */
typedef struct prof_time {
	int64_t ns;
	int tenths; /* -5..5 */
} prof_time;

/* Decimal microseconds. Below 0 only where is_signed. */
bool prof_scan_us(prof_scan *scan, bool is_signed, prof_time *time);

/* Decodes a string's escapes; to has room for span.size bytes. What has no meaning becomes U+FFFD. Returns the size. */
size_t prof_scan_decode(prof_span string, char *to);

/* A number of digits alone that is below 2^63. */
bool prof_span_integer(prof_span number, uint64_t *value);

static inline bool prof_span_is(prof_span string, const char *word, size_t size)
{
	assert(string.text || string.size == 0);
	return string.size == size && __builtin_memcmp(string.text, word, size) == 0;
}

#define PROF_SPAN_IS(span, literal) prof_span_is(span, literal, sizeof literal - 1)

static inline void prof_scan_space(prof_scan *scan)
{
	assert(scan->at >= scan->begin && scan->at <= scan->end);
	while (scan->at < scan->end && (*scan->at == ' ' || *scan->at == '\n' || *scan->at == '\r' || *scan->at == '\t'))
		scan->at++;
}

static inline bool prof_scan_take(prof_scan *scan, char c)
{
	prof_scan_space(scan);
	if (scan->at == scan->end || *scan->at != c)
		return false;
	scan->at++;
	return true;
}

/* What comes next, 0 at the end. */
static inline char prof_scan_next(prof_scan *scan)
{
	prof_scan_space(scan);
	return scan->at < scan->end ? *scan->at : '\0';
}

/* The next key of an object whose '{' was taken, and its ':'. False at the '}', which is taken, and after an error:
 * first says whether it is the first one, and is changed. */
bool prof_scan_key(prof_scan *scan, bool *first, prof_span *key);

#endif
