/* JSON (RFC 8259), read in place by a cursor over the text. The first error is kept: its place, and what was expected
 * there. */
#ifndef STILB_PROF_READ_JSON_H
#define STILB_PROF_READ_JSON_H

#include <assert.h>
#include <locale.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROF_SCAN_DEPTH_MAX 256 /* nesting of objects and arrays */

typedef struct prof_scan {
	const char *begin, *at, *end;
	const char *failed;   /* place of the first error; NULL: none yet */
	const char *expected; /* what was expected at failed */
	locale_t c_locale;    /* "C", for reading numbers; made when first needed */
} prof_scan;

/* A part of the text: a string without its quotes, a number, an object. */
typedef struct prof_span {
	const char *text; /* NULL: absent */
	size_t size;
	bool escaped; /* a string that contains escapes */
} prof_span;

/* prof_scan_fail stores an error, if it is the first, and returns false. Each of the others reads one item at the
 * cursor and returns false after an error. */
bool prof_scan_fail(prof_scan *scan, const char *at, const char *expected);
bool prof_scan_string(prof_scan *scan, prof_span *string);
bool prof_scan_number(prof_scan *scan, prof_span *number);
bool prof_scan_value(prof_scan *scan, prof_span *value); /* of any kind */
bool prof_scan_double(prof_scan *scan, double *value);

/* A time of ns * 10 + tenths tenths of a nanosecond; ns is the nearest nanosecond. Finer digits are cut off. */
typedef struct prof_time {
	int64_t ns;
	int tenths; /* -5..5 */
} prof_time;

/* Reads decimal microseconds; negative ones only if is_signed. */
bool prof_scan_us(prof_scan *scan, bool is_signed, prof_time *time);

/* Decodes the escapes of a string to to[0..string.size). Invalid code points become U+FFFD. Returns the decoded
 * size. */
size_t prof_scan_decode(prof_span string, char *to);

/* Reads a number that consists of at most 18 digits; false: it does not. */
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

/* The next byte that is not space; 0 at the end. */
static inline char prof_scan_next(prof_scan *scan)
{
	prof_scan_space(scan);
	return scan->at < scan->end ? *scan->at : '\0';
}

/* Reads the next key of an object, and its ':'. The '{' has been taken; *first is true before the first call, which
 * clears it. False: at the end of the object, whose '}' is taken, or after an error. */
bool prof_scan_key(prof_scan *scan, bool *first, prof_span *key);

#endif
