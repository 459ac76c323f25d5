/* The JSON cursor. */
#include "profiler/read/prof_read_json.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

bool prof_scan_fail(prof_scan *scan, const char *at, const char *expected)
{
	assert(at >= scan->begin && at <= scan->end && expected);
	if (!scan->failed) {
		scan->failed = at;
		scan->expected = expected;
	}
	return false;
}

/* ---- strings ----------------------------------------------------------------------------------------------------- */

/* A word with the highest bit set in each byte in which the given word has a zero byte. Only the lowest set bit is sure
 * to be right. Source: Mycroft 1987, in Warren, "Hacker's Delight", 6-1. */
static uint64_t prof_zero_bytes(uint64_t word)
{
	return (word - UINT64_C(0x0101010101010101)) & ~word & UINT64_C(0x8080808080808080);
}

/* The next byte that is a quote, a backslash or a control byte, or the end. */
static const char *prof_scan_plain(const char *at, const char *end)
{
	uint64_t ones = UINT64_C(0x0101010101010101);
	for (; end - at >= 8; at += 8) {
		uint64_t word;
		memcpy(&word, at, sizeof word);
		uint64_t control = (word - 0x20 * ones) & ~word & 0x80 * ones;
		uint64_t stop = prof_zero_bytes(word ^ '"' * ones) | prof_zero_bytes(word ^ '\\' * ones) | control;
		if (stop != 0)
			return at + __builtin_ctzll(stop) / 8;
	}
	while (at < end && *at != '"' && *at != '\\' && (unsigned char)*at >= 0x20)
		at++;
	return at;
}

static bool prof_is_hex(char c)
{
	return (c >= '0' && c <= '9') || ((c | 32) >= 'a' && (c | 32) <= 'f');
}

/* Reads what follows a backslash. */
static bool prof_scan_escape(prof_scan *scan)
{
	assert(scan->at > scan->begin && scan->at[-1] == '\\');
	const char *at = scan->at;
	if (at == scan->end || *at == '\0' || !strchr("\"\\/bfnrtu", *at))
		return prof_scan_fail(scan, at, "one of \"\\/bfnrtu after a backslash");
	scan->at++;
	if (*at != 'u')
		return true;
	for (int i = 0; i < 4; i++, scan->at++)
		if (scan->at == scan->end || !prof_is_hex(*scan->at))
			return prof_scan_fail(scan, scan->at, "four hex digits after \\u");
	return true;
}

bool prof_scan_string(prof_scan *scan, prof_span *string)
{
	if (!prof_scan_take(scan, '"'))
		return prof_scan_fail(scan, scan->at, "a string");
	*string = (prof_span){.text = scan->at};
	for (;;) {
		scan->at = prof_scan_plain(scan->at, scan->end);
		if (scan->at == scan->end)
			return prof_scan_fail(scan, scan->at, "the end of the string that begins before");
		if (*scan->at == '"')
			break;
		if (*scan->at != '\\')
			return prof_scan_fail(scan, scan->at, "no control byte in a string");
		scan->at++;
		string->escaped = true;
		if (!prof_scan_escape(scan))
			return false;
	}
	string->size = (size_t)(scan->at++ - string->text);
	return true;
}

static uint32_t prof_hex4(const char *at)
{
	uint32_t value = 0;
	assert(prof_is_hex(at[0]) && prof_is_hex(at[1]) && prof_is_hex(at[2]) && prof_is_hex(at[3]));
	for (int i = 0; i < 4; i++)
		value = value << 4 | (uint32_t)(at[i] <= '9' ? at[i] - '0' : (at[i] | 32) - 'a' + 10);
	return value;
}

static size_t prof_utf8(uint32_t c, char *to)
{
	assert(c < 0x110000);
	if (c < 0x80) {
		to[0] = (char)c;
		return 1;
	}
	size_t size = c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
	static const unsigned char first[] = {0, 0, 0xc0, 0xe0, 0xf0};
	for (size_t i = size - 1; i > 0; i--, c >>= 6)
		to[i] = (char)(0x80 | (c & 0x3f));
	to[0] = (char)(first[size] | c);
	return size;
}

/* Decodes the code point at *at, which is behind "\u", and moves *at behind it; it may be a pair of escapes (a
 * surrogate pair). */
static uint32_t prof_decode_unicode(const char **at, const char *end)
{
	uint32_t c = prof_hex4(*at);
	*at += 4;
	if (c >= 0xd800 && c < 0xdc00 && end - *at >= 6 && (*at)[0] == '\\' && (*at)[1] == 'u') {
		uint32_t low = prof_hex4(*at + 2);
		if (low >= 0xdc00 && low < 0xe000) {
			*at += 6;
			return 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00);
		}
	}
	return c == 0 || (c >= 0xd800 && c < 0xe000) ? 0xfffd : c;
}

/* to may be as small as the string, since an escape is never shorter than the bytes that it stands for. */
size_t prof_scan_decode(prof_span string, char *to)
{
	static const char from[] = "\"\\/bfnrt", meant[] = "\"\\/\b\f\n\r\t";
	const char *at = string.text, *end = at + string.size;
	size_t size = 0;
	while (at < end) {
		if (*at != '\\') {
			to[size++] = *at++;
		} else if (at[1] == 'u') {
			at += 2;
			size += prof_utf8(prof_decode_unicode(&at, end), to + size);
		} else {
			assert(at + 1 < end && strchr(from, at[1]) && "an escape that prof_scan_string has seen");
			to[size++] = meant[strchr(from, at[1]) - from];
			at += 2;
		}
	}
	assert(size <= string.size && "an escape is never shorter than what it stands for");
	return size;
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static bool prof_is_digit(char c)
{
	return c >= '0' && c <= '9';
}

static bool prof_scan_digits(prof_scan *scan)
{
	const char *begin = scan->at;
	while (scan->at < scan->end && prof_is_digit(*scan->at))
		scan->at++;
	return scan->at > begin || prof_scan_fail(scan, begin, "a digit");
}

bool prof_scan_number(prof_scan *scan, prof_span *number)
{
	prof_scan_space(scan);
	const char *begin = scan->at;
	if (scan->at < scan->end && *scan->at == '-')
		scan->at++;
	if (scan->at == scan->end || !prof_is_digit(*scan->at))
		return prof_scan_fail(scan, begin, "a number");
	if (!prof_scan_digits(scan))
		return false;
	if (scan->at < scan->end && *scan->at == '.') {
		scan->at++;
		if (!prof_scan_digits(scan))
			return false;
	}
	if (scan->at < scan->end && (*scan->at | 32) == 'e') {
		scan->at++;
		if (scan->at < scan->end && (*scan->at == '+' || *scan->at == '-'))
			scan->at++;
		if (!prof_scan_digits(scan))
			return false;
	}
	*number = (prof_span){.text = begin, .size = (size_t)(scan->at - begin)};
	return true;
}

bool prof_span_integer(prof_span number, uint64_t *value)
{
	if (number.size == 0 || number.size > 18)
		return false;
	*value = 0;
	for (size_t i = 0; i < number.size; i++) {
		if (!prof_is_digit(number.text[i]))
			return false;
		*value = 10 * *value + (uint64_t)(number.text[i] - '0');
	}
	return true;
}

/* The parts of a number. Its value is 0.digits * 10^point. */
typedef struct prof_decimal {
	const char *text, *end; /* the digits; one decimal point may be among them */
	int64_t point;
	bool negative;
} prof_decimal;

static prof_decimal prof_decimal_of(prof_span number)
{
	assert(number.size > 0 && "a number that prof_scan_number has seen");
	prof_decimal decimal = {.text = number.text, .end = number.text + number.size};
	const char *at = decimal.text;
	if ((decimal.negative = *at == '-'))
		decimal.text = ++at;
	while (at < decimal.end && prof_is_digit(*at))
		at++;
	decimal.point = at - decimal.text;
	while (at < decimal.end && (prof_is_digit(*at) || *at == '.'))
		at++;
	if (at < decimal.end) { /* *at is the e of an exponent */
		const char *digit = at + 1;
		bool less = *digit == '-';
		int64_t exponent = 0;
		for (digit += *digit == '-' || *digit == '+'; digit < decimal.end; digit++)
			exponent = exponent < 100000 ? 10 * exponent + (*digit - '0') : exponent;
		decimal.point += less ? -exponent : exponent;
		decimal.end = at;
	}
	return decimal;
}

#define PROF_NS_MAX (INT64_C(1) << 61) /* more than 70 years */
#define PROF_TIME_RANGE "a time below 2.3e15 microseconds (70 years)"

static prof_time prof_time_of(int64_t ns, int tenths, bool negative)
{
	assert(ns >= 0 && tenths >= 0 && tenths <= 9);
	prof_time time = tenths < 5 ? (prof_time){ns, tenths} : (prof_time){ns + 1, tenths - 10};
	return negative ? (prof_time){-time.ns, -time.tenths} : time;
}

/* Reads microseconds in any form of number. place is how many digits are still to be read up to that of nanoseconds. */
static bool prof_scan_us_slow(prof_scan *scan, bool is_signed, prof_time *time)
{
	prof_span number;
	if (!prof_scan_number(scan, &number))
		return false;
	prof_decimal decimal = prof_decimal_of(number);
	const char *at = decimal.text;
	int64_t value = 0, place = decimal.point + 3;
	int tenths = 0;
	for (; at < decimal.end && place >= 0; at++) {
		if (*at == '.')
			continue;
		if (place-- == 0) {
			tenths = *at - '0';
			break;
		}
		if (value > PROF_NS_MAX / 10 - 1)
			return prof_scan_fail(scan, number.text, PROF_TIME_RANGE);
		value = 10 * value + (*at - '0');
	}
	for (; place > 0 && value > 0; place--, value *= 10)
		if (value > PROF_NS_MAX / 10)
			return prof_scan_fail(scan, number.text, PROF_TIME_RANGE);
	*time = prof_time_of(value, tenths, decimal.negative);
	if (time->ns < 0 && !is_signed)
		return prof_scan_fail(scan, number.text, "a duration of 0 or more");
	return true;
}

/* The fast path reads the usual form: digits, a point, and three or four digits. */
bool prof_scan_us(prof_scan *scan, bool is_signed, prof_time *time)
{
	prof_scan_space(scan);
	const char *at = scan->at, *end = scan->end;
	int64_t value = 0;
	int decimals = 0;
	while (at < end && at - scan->at <= 15 && prof_is_digit(*at))
		value = 10 * value + (*at++ - '0');
	if (at == scan->at || at - scan->at > 15 || end - at < 5 || *at != '.')
		return prof_scan_us_slow(scan, is_signed, time);
	for (at++; decimals < 3 && prof_is_digit(*at); decimals++)
		value = 10 * value + (*at++ - '0');
	int tenths = decimals == 3 && prof_is_digit(*at) ? *at++ - '0' : 0;
	if (decimals < 3 || at == end || prof_is_digit(*at) || (*at | 32) == 'e')
		return prof_scan_us_slow(scan, is_signed, time);
	scan->at = at;
	*time = prof_time_of(value, tenths, false);
	return true;
}

/* Reads a double, correctly rounded, in any locale. */
bool prof_scan_double(prof_scan *scan, double *value)
{
	char copy[64];
	prof_span number;
	if (!prof_scan_number(scan, &number))
		return false;
	uint64_t integer;
	if (prof_span_integer(number, &integer) && integer <= UINT64_C(1) << 53) {
		*value = (double)integer;
		return true;
	}
	if (scan->c_locale == (locale_t)0 && (scan->c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0)) == (locale_t)0)
		return prof_scan_fail(scan, number.text, "memory to read a number");
	if (number.size >= sizeof copy)
		return prof_scan_fail(scan, number.text, "a number of less than 64 characters");
	memcpy(copy, number.text, number.size);
	copy[number.size] = '\0';
	*value = strtod_l(copy, NULL, scan->c_locale);
	return true;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

bool prof_scan_key(prof_scan *scan, bool *first, prof_span *key)
{
	bool is_first = *first;
	*first = false;
	if (prof_scan_take(scan, '}'))
		return false;
	if (!is_first && !prof_scan_take(scan, ','))
		return prof_scan_fail(scan, scan->at, "',' or '}'");
	if (!prof_scan_string(scan, key))
		return false;
	return prof_scan_take(scan, ':') || prof_scan_fail(scan, scan->at, "':'");
}

static bool prof_scan_word(prof_scan *scan)
{
	static const char *const words[] = {"true", "false", "null"};
	for (size_t i = 0; i < 3; i++) {
		size_t size = strlen(words[i]);
		if ((size_t)(scan->end - scan->at) >= size && memcmp(scan->at, words[i], size) == 0) {
			scan->at += size;
			return true;
		}
	}
	return prof_scan_fail(scan, scan->at, "a value");
}

static bool prof_scan_nested(prof_scan *scan, uint32_t depth)
{
	prof_span part;
	bool first = true;
	assert(depth <= PROF_SCAN_DEPTH_MAX);
	char next = prof_scan_next(scan);
	if (next == '"')
		return prof_scan_string(scan, &part);
	if (next == '-' || prof_is_digit(next))
		return prof_scan_number(scan, &part);
	if (next != '{' && next != '[')
		return prof_scan_word(scan);
	if (depth == PROF_SCAN_DEPTH_MAX)
		return prof_scan_fail(scan, scan->at, "objects and arrays less than 256 deep");
	scan->at++;
	if (next == '{') {
		while (prof_scan_key(scan, &first, &part))
			if (!prof_scan_nested(scan, depth + 1))
				return false;
		return !scan->failed;
	}
	if (prof_scan_take(scan, ']'))
		return true;
	do
		if (!prof_scan_nested(scan, depth + 1))
			return false;
	while (prof_scan_take(scan, ','));
	return prof_scan_take(scan, ']') || prof_scan_fail(scan, scan->at, "',' or ']'");
}

bool prof_scan_value(prof_scan *scan, prof_span *value)
{
	prof_scan_space(scan);
	const char *begin = scan->at;
	if (!prof_scan_nested(scan, 0))
		return false;
	*value = (prof_span){.text = begin, .size = (size_t)(scan->at - begin)};
	return true;
}
