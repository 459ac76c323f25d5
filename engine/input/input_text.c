#include "input/input_text_internal.h"

#include "base/base.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Number of bytes of the character at the beginning of from; *code becomes its code point. 0: it is not valid UTF-8, by
 * RFC 3629: the shortest form, no surrogates, at most U+10FFFF. */
static size_t text_character(const uint8_t *from, size_t length, uint32_t *code)
{
	static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
	STILB_ASSERT(length > 0);
	*code = from[0];
	if (from[0] < 0x80)
		return 1;
	size_t bytes = from[0] >= 0xf0 ? 4 : from[0] >= 0xe0 ? 3 : 2;
	if (from[0] < 0xc0 || from[0] > 0xf4 || bytes > length)
		return 0;
	*code = from[0] & (0xffu >> (bytes + 1));
	for (size_t i = 1; i < bytes; i++) {
		if ((from[i] & 0xc0) != 0x80)
			return 0;
		*code = *code << 6 | (from[i] & 0x3fu);
	}
	return *code < least[bytes] || *code > 0x10ffff || (*code >= 0xd800 && *code <= 0xdfff) ? 0 : bytes;
}

static bool text_is_control(uint32_t code)
{
	return code < 0x20 || (code >= 0x7f && code < 0xa0);
}

void input_text_copy(char *to, size_t size, const char *from, size_t length)
{
	STILB_ASSERT(to && size > 0 && (from || length == 0));
	size_t used = 0;
	for (size_t i = 0; i < length;) {
		uint32_t code;
		size_t bytes = text_character((const uint8_t *)from + i, length - i, &code);
		bool shown = bytes > 0 && !text_is_control(code);
		size_t room = shown ? bytes : 1;
		if (used + room >= size)
			break;
		if (shown)
			memcpy(to + used, from + i, bytes);
		else
			to[used] = '?';
		used += room;
		i += bytes > 0 ? bytes : 1;
	}
	STILB_ASSERT(used < size);
	to[used] = '\0';
}
