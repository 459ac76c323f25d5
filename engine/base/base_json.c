#include "base/base_json.h"

#include "base/base_file.h"

#include <inttypes.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The text ends with a 0 byte and fits into its capacity; if there is no text, nothing has been written yet. */
static bool json_is_sound(const stilb_json *json)
{
	if (!json->text)
		return json->length == 0 && json->capacity == 0;
	return json->length < json->capacity && json->text[json->length] == '\0';
}

static void json_append(stilb_json *json, const char *text, size_t length)
{
	if (json->length + length + 1 > json->capacity) {
		size_t capacity = (json->length + length + 1) * 2;
		char *grown = realloc(json->text, capacity);
		if (!grown) {
			json->failed = true;
			return;
		}
		json->text = grown;
		json->capacity = capacity;
	}
	memcpy(json->text + json->length, text, length);
	json->length += length;
	json->text[json->length] = '\0';
	STILB_ASSERT(json_is_sound(json));
}

static void json_put(stilb_json *json, const char *text)
{
	json_append(json, text, strlen(text));
}

/* The length, 2 to 4 bytes, of the non-ASCII character that text begins with; 0 if it is not UTF-8 (RFC 3629: the
 * shortest form, no surrogates, at most U+10FFFF). */
static size_t json_utf8_length(const char *text)
{
	static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
	unsigned char first = (unsigned char)text[0];
	size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
	uint32_t code = first & (0xffu >> (length + 1));
	if (first < 0xc2 || first > 0xf4)
		return 0;
	for (size_t i = 1; i < length; i++) {
		if (((unsigned char)text[i] & 0xc0) != 0x80) /* also true at the end of text */
			return 0;
		code = code << 6 | ((unsigned char)text[i] & 0x3f);
	}
	return code < least[length] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff) ? 0 : length;
}

static void json_quote(stilb_json *json, const char *value)
{
	json_put(json, "\"");
	while (*value) {
		char escaped[8];
		unsigned char c = (unsigned char)*value;
		size_t length = c < 0x80 ? 1 : json_utf8_length(value);
		if (length == 0)
			json_put(json, "\xef\xbf\xbd"); /* U+FFFD: a driver's name may be cut or in another encoding */
		else if (c >= 0x20 && c != '"' && c != '\\')
			json_append(json, value, length);
		else
			json_append(json, escaped, (size_t)snprintf(escaped, sizeof escaped, c < 0x20 ? "\\u%04x" : "\\%c", c));
		value += length ? length : 1;
	}
	json_put(json, "\"");
}

/* True if the innermost open bracket is an object. */
static bool json_in_object(const stilb_json *json)
{
	return json->depth > 0 && (json->objects >> (json->depth - 1) & 1);
}

/* Writes the part before a value: the comma, a new line, the key. */
static void json_lead(stilb_json *json, const char *key)
{
	STILB_ASSERT(json && json_is_sound(json));
	STILB_ASSERT(!key == !json_in_object(json) && "a value in an object has a key, others have none");
	STILB_ASSERT((json->depth > 0 || !json->comma) && "one value at the top");
	if (json->comma)
		json_put(json, ",");
	if (json->depth > 0) {
		json_put(json, "\n");
		for (uint32_t i = 0; i < json->depth; i++)
			json_put(json, "  ");
	}
	if (key) {
		json_quote(json, key);
		json_put(json, ": ");
	}
	json->comma = true;
}

void stilb_json_begin(stilb_json *json, const char *key, char bracket)
{
	STILB_ASSERT(bracket == '{' || bracket == '[');
	json_lead(json, key);
	STILB_ASSERT(json->depth < STILB_JSON_MAX_DEPTH);
	json_append(json, &bracket, 1);
	json->objects = (json->objects & ~(UINT64_C(1) << json->depth)) | (uint64_t)(bracket == '{') << json->depth;
	json->depth++;
	json->comma = false;
}

void stilb_json_end(stilb_json *json, char bracket)
{
	STILB_ASSERT(json && json->depth > 0);
	STILB_ASSERT(bracket == (json_in_object(json) ? '}' : ']') && "closes the innermost bracket");
	json->depth--;
	if (json->comma) { /* there were values inside: the bracket gets its own line */
		json_put(json, "\n");
		for (uint32_t i = 0; i < json->depth; i++)
			json_put(json, "  ");
	}
	json_append(json, &bracket, 1);
	json->comma = true;
}

void stilb_json_string(stilb_json *json, const char *key, const char *value)
{
	STILB_ASSERT(value);
	json_lead(json, key);
	json_quote(json, value);
}

void stilb_json_int(stilb_json *json, const char *key, int64_t value)
{
	char text[32];
	snprintf(text, sizeof text, "%" PRId64, value);
	json_lead(json, key);
	json_put(json, text);
}

void stilb_json_double(stilb_json *json, const char *key, double value)
{
	char text[64];
	if (!isfinite(value) || fabs(value) >= 9e12)
		value = 0.0;
	int64_t micro = llround(fabs(value) * 1e6); /* integers print the same in every locale */
	snprintf(text, sizeof text, "%s%" PRId64 ".%06" PRId64, value < 0 && micro ? "-" : "", micro / 1000000,
	         micro % 1000000);
	json_lead(json, key);
	json_put(json, text);
}

void stilb_json_float(stilb_json *json, const char *key, float value)
{
	char text[32];
	snprintf(text, sizeof text, "%.9g", isfinite(value) ? (double)value : 0.0);
	char *point = strpbrk(text, localeconv()->decimal_point);
	if (point) /* of one byte in the locales that there are */
		*point = '.';
	json_lead(json, key);
	json_put(json, text);
}

void stilb_json_bool(stilb_json *json, const char *key, bool value)
{
	json_lead(json, key);
	json_put(json, value ? "true" : "false");
}

stilb_result stilb_json_save(stilb_json *json, const char *path)
{
	STILB_ASSERT(json && path);
	STILB_ASSERT(json->depth == 0 && "every bracket is closed");
	STILB_ASSERT(json->comma && "there is a value");
	json_put(json, "\n");
	stilb_result result = json->failed ? stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path)
	                                   : stilb_file_save(path, json->text, json->length);
	stilb_json_finish(json);
	return result;
}

void stilb_json_finish(stilb_json *json)
{
	STILB_ASSERT(json);
	free(json->text);
	*json = (stilb_json){0};
}
