/* JSON text in blocks. Numbers are made by hand, so the locale cannot change them. */
#include "profiler/prof_internal.h"

#include <string.h>

int prof_json_flush(prof_json *json)
{
	if (json->error == 0 && json->used > 0)
		json->error = json->write(json->user, json->bytes, json->used);
	json->used = 0;
	return json->error;
}

static void prof_json_bytes(prof_json *json, const char *bytes, size_t size)
{
	while (size > 0) {
		if (json->used == sizeof json->bytes)
			prof_json_flush(json);
		const size_t room = sizeof json->bytes - json->used;
		const size_t part = size < room ? size : room;
		memcpy(json->bytes + json->used, bytes, part);
		json->used += (uint32_t)part;
		bytes += part;
		size -= part;
	}
}

void prof_json_text(prof_json *json, const char *text)
{
	prof_json_bytes(json, text, strlen(text));
}

/* Bytes of the well-formed UTF-8 sequence at s, 0 if there is none. Source: the Unicode Standard, table 3-7. */
static size_t prof_utf8_length(const unsigned char *s)
{
	const size_t length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
	const unsigned char low = s[0] == 0xe0 ? 0xa0 : s[0] == 0xf0 ? 0x90 : 0x80;
	const unsigned char high = s[0] == 0xed ? 0x9f : s[0] == 0xf4 ? 0x8f : 0xbf;
	if (length >= 2 && (s[1] < low || s[1] > high))
		return 0;
	for (size_t i = 2; i < length; i++) /* the terminating zero stops it */
		if (s[i] < 0x80 || s[i] > 0xbf)
			return 0;
	return length;
}

static void prof_json_escape(prof_json *json, unsigned char c)
{
	const char *hex = "0123456789abcdef";
	if (c == '"' || c == '\\')
		prof_json_bytes(json, (const char[]){'\\', (char)c}, 2);
	else
		prof_json_bytes(json, (const char[]){'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]}, 6);
}

void prof_json_string(prof_json *json, const char *string)
{
	prof_json_text(json, "\"");
	for (const unsigned char *s = (const unsigned char *)string; *s != 0;) {
		const size_t length = prof_utf8_length(s);
		if (length == 0)
			prof_json_text(json, "\xef\xbf\xbd");
		else if (*s < 0x20 || *s == '"' || *s == '\\' || *s == 0x7f)
			prof_json_escape(json, *s);
		else
			prof_json_bytes(json, (const char *)s, length);
		s += length > 0 ? length : 1;
	}
	prof_json_text(json, "\"");
}

void prof_json_u64(prof_json *json, uint64_t value)
{
	char digits[20];
	size_t at = sizeof digits;
	do
		digits[--at] = (char)('0' + value % 10);
	while ((value /= 10) > 0);
	prof_json_bytes(json, digits + at, sizeof digits - at);
}

void prof_json_us(prof_json *json, uint64_t ns)
{
	const unsigned rest = (unsigned)(ns % 1000);
	prof_json_u64(json, ns / 1000);
	prof_json_bytes(
		json, (const char[]){'.', (char)('0' + rest / 100), (char)('0' + rest / 10 % 10), (char)('0' + rest % 10)}, 4);
}
