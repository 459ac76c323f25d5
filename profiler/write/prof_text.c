#include "profiler/write/prof_text.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

prof_text *prof_text_create(stilb_prof_sink sink)
{
	assert(sink.write);
	prof_text *text = malloc(sizeof *text);
	if (text) {
		text->sink = sink;
		text->error = 0;
		text->used = 0;
	}
	return text;
}

int prof_text_flush(prof_text *text)
{
	if (text->error == 0 && text->used > 0)
		text->error = text->sink.write(text->sink.user, text->bytes, text->used);
	text->used = 0;
	return text->error;
}

int prof_text_finish(prof_text *text, int error)
{
	if (!text)
		return -ENOMEM;
	if (error == 0)
		error = prof_text_flush(text);
	free(text);
	return error;
}

void prof_text_bytes(prof_text *text, const void *bytes, size_t size)
{
	assert(bytes || size == 0);
	const char *from = bytes;
	while (size > PROF_TEXT_SIZE - text->used) {
		uint32_t part = PROF_TEXT_SIZE - text->used;
		memcpy(text->bytes + text->used, from, part);
		text->used += part;
		from += part;
		size -= part;
		prof_text_flush(text);
	}
	memcpy(text->bytes + text->used, from, size);
	text->used += (uint32_t)size;
}

void prof_text_add(prof_text *text, const char *string)
{
	prof_text_bytes(text, string, strlen(string));
}

void prof_text_u64(prof_text *text, uint64_t value)
{
	prof_text_fill(text, prof_put_u64(prof_text_room(text, PROF_PUT_U64_MAX), value));
}

void prof_text_ms(prof_text *text, uint64_t ns)
{
	char *at = prof_put_u64(prof_text_room(text, PROF_PUT_U64_MAX + 7), ns / 1000000);
	uint64_t rest = ns % 1000000;
	*at = '.';
	for (int i = 6; i > 0; i--, rest /= 10)
		at[i] = (char)('0' + rest % 10);
	prof_text_fill(text, at + 7);
}

/* snprintf writes the decimal point of the locale, which may be several bytes: a row of bytes that cannot be part of a
 * number otherwise becomes one '.'. */
void prof_text_double(prof_text *text, double value)
{
	assert(isfinite(value) && "neither JSON nor CSV has others");
	char printed[64], plain[64];
	size_t used = 0;
	for (int digits = 15; digits <= 17; digits++) {
		snprintf(printed, sizeof printed, "%.*g", digits, value);
		if (strtod(printed, NULL) == value)
			break;
	}
	for (const char *c = printed; *c != 0; c++)
		if (strchr("+-0123456789e", *c))
			plain[used++] = *c;
		else if (used == 0 || plain[used - 1] != '.')
			plain[used++] = '.';
	assert(used > 0 && used < sizeof plain);
	prof_text_bytes(text, plain, used);
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static const char prof_digit_pairs[] =
	"00010203040506070809101112131415161718192021222324252627282930313233343536373839"
	"40414243444546474849505152535455565758596061626364656667686970717273747576777879"
	"8081828384858687888990919293949596979899";

char *prof_put_u64(char *at, uint64_t value)
{
	assert(at);
	char digits[PROF_PUT_U64_MAX];
	size_t first = sizeof digits;
	while (value >= 100) {
		memcpy(digits + (first -= 2), prof_digit_pairs + 2 * (value % 100), 2);
		value /= 100;
	}
	if (value >= 10)
		memcpy(digits + (first -= 2), prof_digit_pairs + 2 * value, 2);
	else
		digits[--first] = (char)('0' + value);
	size_t count = sizeof digits - first;
	memcpy(at, digits + first, count);
	return at + count;
}

char *prof_put_us(char *at, uint64_t tenths)
{
	size_t rest = tenths % 10000, ns = rest / 10;
	at = prof_put_u64(at, tenths / 10000);
	at[0] = '.';
	at[1] = (char)('0' + ns / 100);
	memcpy(at + 2, prof_digit_pairs + 2 * (ns % 100), 2);
	at[4] = (char)('0' + rest % 10);
	return at + (rest % 10 != 0 ? 5 : 4);
}

/* ---- strings ----------------------------------------------------------------------------------------------------- */

/* The length of the well-formed UTF-8 sequence at s; 0: there is none. Source: the Unicode Standard, table 3-7. */
static size_t prof_utf8_length(const unsigned char *s)
{
	size_t length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
	unsigned char low = s[0] == 0xe0 ? 0xa0 : s[0] == 0xf0 ? 0x90 : 0x80;
	unsigned char high = s[0] == 0xed ? 0x9f : s[0] == 0xf4 ? 0x8f : 0xbf;
	if (length >= 2 && (s[1] < low || s[1] > high))
		return 0;
	for (size_t i = 2; i < length; i++) /* the 0 at the end of the string stops it */
		if (s[i] < 0x80 || s[i] > 0xbf)
			return 0;
	return length;
}

/* Writes the character at *s for a JSON string, at most 6 bytes, and moves *s past it. */
static char *prof_put_character(char *at, const unsigned char **s)
{
	static const char hex[] = "0123456789abcdef", replacement[] = "\xef\xbf\xbd";
	size_t length = prof_utf8_length(*s);
	unsigned char c = **s;
	bool escaped = c < 0x20 || c == 0x7f;
	const char *from = length == 0 ? replacement : (const char *)*s;
	*s += length > 0 ? length : 1;
	if (escaped) {
		at = prof_put(at, "\\u00", 4);
		*at++ = hex[c >> 4];
		*at++ = hex[c & 15];
		return at;
	}
	if (c == '"' || c == '\\')
		*at++ = '\\';
	size_t size = length == 0 ? sizeof replacement - 1 : length;
	memcpy(at, from, size);
	return at + size;
}

char *prof_put_json(char *at, const char *string)
{
	assert(at && string);
	*at++ = '"';
	for (const unsigned char *s = (const unsigned char *)string; *s != 0;)
		at = prof_put_character(at, &s);
	*at++ = '"';
	return at;
}

void prof_text_escaped(prof_text *text, const char *string)
{
	for (const unsigned char *s = (const unsigned char *)string; *s != 0;)
		prof_text_fill(text, prof_put_character(prof_text_room(text, 6), &s));
}

void prof_text_json(prof_text *text, const char *string)
{
	prof_text_add(text, "\"");
	prof_text_escaped(text, string);
	prof_text_add(text, "\"");
}
