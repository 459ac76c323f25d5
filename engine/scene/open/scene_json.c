#include "scene/open/scene_json.h"

#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JSON_NUMBER 64u /* bytes of a number's text, with the 0 behind it; a double needs 24 */

/* ---- reading ----------------------------------------------------------------------------------------------------- */

typedef struct json_reader {
	scene_json *json;
	uint32_t at, capacity;
	uint32_t open[SCENE_JSON_DEPTH]; /* the containers around the place, outermost first */
	uint32_t depth;
} json_reader;

/* The line and the column, counted from 1, of a byte. */
static void json_place(const scene_json *json, uint32_t at, uint32_t place[2])
{
	place[0] = 1;
	place[1] = 1;
	for (uint32_t i = 0; i < at && i < json->size; i++) {
		place[1]++;
		if (json->text[i] == '\n') {
			place[0]++;
			place[1] = 1;
		}
	}
}

static stilb_result json_expected(const json_reader *reader, const char *what)
{
	uint32_t place[2];
	json_place(reader->json, reader->at, place);
	return stilb_fail(STILB_ERROR_FILE, "its JSON is damaged at line %u, column %u: expected %s", place[0], place[1],
	                  what);
}

/* The next byte that is no blank; 0 at the end. */
static char json_peek(json_reader *reader)
{
	const scene_json *json = reader->json;
	while (reader->at < json->size && strchr(" \t\r\n", json->text[reader->at]) && json->text[reader->at])
		reader->at++;
	return (char)(reader->at < json->size ? json->text[reader->at] : '\0');
}

/* Adds a token of this kind that begins here. */
static stilb_result json_add(json_reader *reader, scene_json_kind kind, uint32_t at, uint32_t size)
{
	scene_json *json = reader->json;
	if (json->count == reader->capacity) {
		uint64_t capacity = 2ull * reader->capacity + 256;
		scene_json_token *more = capacity < UINT32_MAX ? realloc(json->tokens, (size_t)capacity * sizeof *more) : NULL;
		if (!more)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for its JSON");
		json->tokens = more;
		reader->capacity = (uint32_t)capacity;
	}
	json->tokens[json->count] = (scene_json_token){at, size, json->count + 1, kind};
	json->count++;
	return STILB_OK;
}

static stilb_result json_read_string(json_reader *reader)
{
	const scene_json *json = reader->json;
	if (json_peek(reader) != '"')
		return json_expected(reader, "a key in quotes");
	uint32_t from = ++reader->at;
	while (reader->at < json->size && json->text[reader->at] != '"' && (unsigned char)json->text[reader->at] >= ' ')
		reader->at += json->text[reader->at] == '\\' ? 2 : 1;
	if (reader->at >= json->size || json->text[reader->at] != '"') {
		reader->at = reader->at < json->size ? reader->at : json->size;
		return json_expected(reader, "the end of a string");
	}
	return json_add(reader, SCENE_JSON_STRING, from, reader->at++ - from);
}

/* Passes over digits; false: there are none. */
static bool json_skip_digits(json_reader *reader)
{
	uint32_t from = reader->at;
	while (reader->at < reader->json->size && isdigit((unsigned char)reader->json->text[reader->at]))
		reader->at++;
	return reader->at > from;
}

/* Passes over one of these bytes, if it is here. */
static bool json_skip_one(json_reader *reader, const char *bytes)
{
	bool here = reader->at < reader->json->size && reader->json->text[reader->at] &&
	            strchr(bytes, reader->json->text[reader->at]);
	reader->at += here;
	return here;
}

static stilb_result json_read_number(json_reader *reader)
{
	uint32_t from = reader->at;
	json_skip_one(reader, "-");
	bool good = json_skip_digits(reader);
	if (good && json_skip_one(reader, "."))
		good = json_skip_digits(reader);
	if (good && json_skip_one(reader, "eE")) {
		json_skip_one(reader, "+-");
		good = json_skip_digits(reader);
	}
	if (!good)
		return json_expected(reader, "a digit");
	uint32_t size = reader->at - from;
	if (size >= JSON_NUMBER) {
		reader->at = from;
		return json_expected(reader, "a number of 63 signs at most");
	}
	return json_add(reader, SCENE_JSON_NUMBER, from, size);
}

static stilb_result json_read_word(json_reader *reader)
{
	static const struct {
		const char *word;
		scene_json_kind kind;
	} words[] = {{"null", SCENE_JSON_NULL}, {"false", SCENE_JSON_FALSE}, {"true", SCENE_JSON_TRUE}};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		size_t size = strlen(words[i].word);
		if (reader->json->size - reader->at < size || memcmp(reader->json->text + reader->at, words[i].word, size) != 0)
			continue;
		reader->at += (uint32_t)size;
		return json_add(reader, words[i].kind, reader->at - (uint32_t)size, (uint32_t)size);
	}
	return json_expected(reader, "a value");
}

static stilb_result json_open(json_reader *reader, scene_json_kind kind)
{
	if (reader->depth == SCENE_JSON_DEPTH)
		return stilb_fail(STILB_ERROR_FILE, "its JSON is nested more than %d deep", SCENE_JSON_DEPTH);
	reader->open[reader->depth++] = reader->json->count;
	return json_add(reader, kind, reader->at++, 0);
}

/* Reads a value, of a container its beginning only. */
static stilb_result json_read_value(json_reader *reader)
{
	char c = json_peek(reader);
	if (c == '{')
		return json_open(reader, SCENE_JSON_OBJECT);
	if (c == '[')
		return json_open(reader, SCENE_JSON_ARRAY);
	if (c == '"')
		return json_read_string(reader);
	return c == '-' || isdigit((unsigned char)c) ? json_read_number(reader) : json_read_word(reader);
}

/* The container around the place; only inside of one. */
static scene_json_token *json_around(const json_reader *reader)
{
	STILB_ASSERT(reader->depth > 0);
	return &reader->json->tokens[reader->open[reader->depth - 1]];
}

/* Closes containers that end here, and passes over the comma before a further value. Afterwards depth is 0, or a value
 * follows, or a key. */
static stilb_result json_go_on(json_reader *reader)
{
	while (reader->depth > 0) {
		scene_json_token *around = json_around(reader);
		bool empty = around + 1 == reader->json->tokens + reader->json->count;
		char c = json_peek(reader), end = around->kind == SCENE_JSON_OBJECT ? '}' : ']';
		if (c == end) {
			around->next = reader->json->count;
			reader->depth--;
			reader->at++;
			continue;
		}
		if (!empty && c != ',')
			return json_expected(reader, end == '}' ? "',' or '}'" : "',' or ']'");
		reader->at += !empty;
		return STILB_OK;
	}
	return STILB_OK;
}

static stilb_result json_read(json_reader *reader)
{
	stilb_result result = json_read_value(reader);
	if (result == STILB_OK)
		result = json_go_on(reader);
	while (result == STILB_OK && reader->depth > 0) {
		if (json_around(reader)->kind == SCENE_JSON_OBJECT) {
			result = json_read_string(reader);
			if (result == STILB_OK && json_peek(reader) != ':')
				result = json_expected(reader, "':'");
			reader->at++;
		}
		if (result == STILB_OK)
			result = json_read_value(reader);
		if (result == STILB_OK)
			result = json_go_on(reader);
	}
	if (result == STILB_OK && json_peek(reader) && reader->at < reader->json->size)
		result = json_expected(reader, "the end of the text");
	return result;
}

stilb_result scene_json_parse(scene_json *json, const char *text, size_t size)
{
	STILB_ASSERT(json && (text || size == 0));
	*json = (scene_json){0};
	if (size >= UINT32_MAX - 2)
		return stilb_fail(STILB_ERROR_FILE, "its JSON is larger than 4 GiB");
	if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) { /* a byte order mark, which some editors write */
		text += 3;
		size -= 3;
	}
	json->text = text;
	json->size = (uint32_t)size;
	json_reader reader = {.json = json};
	stilb_result result = json_read(&reader);
	if (result != STILB_OK)
		scene_json_finish(json);
	return result;
}

void scene_json_finish(scene_json *json)
{
	free(json->tokens);
	*json = (scene_json){0};
}

/* ---- faults ------------------------------------------------------------------------------------------------------ */

stilb_result scene_json_check(const scene_json *json)
{
	return json->fault[0] ? stilb_fail(STILB_ERROR_FILE, "%s", json->fault) : STILB_OK;
}

void scene_json_blame(scene_json *json, uint32_t token, const char *format, ...)
{
	uint32_t place[2];
	char words[128];
	va_list arguments;
	if (json->fault[0])
		return;
	va_start(arguments, format);
	vsnprintf(words, sizeof words, format, arguments);
	va_end(arguments);
	json_place(json, json->tokens[token < json->count ? token : 0].at, place);
	snprintf(json->fault, sizeof json->fault, "JSON line %u, column %u: %s", place[0], place[1], words);
}

/* ---- looking up -------------------------------------------------------------------------------------------------- */

uint32_t scene_json_member(scene_json *json, uint32_t object, const char *key)
{
	if (object == SCENE_JSON_NONE)
		return SCENE_JSON_NONE;
	STILB_ASSERT(object < json->count);
	if (json->tokens[object].kind != SCENE_JSON_OBJECT) {
		scene_json_blame(json, object, "it is not of type object, in which '%s' is looked for", key);
		return SCENE_JSON_NONE;
	}
	for (uint32_t at = object + 1; at < json->tokens[object].next; at = json->tokens[at + 1].next)
		if (scene_json_is(json, at, key))
			return at + 1;
	return SCENE_JSON_NONE;
}

uint32_t scene_json_first(const scene_json *json, uint32_t container)
{
	return container != SCENE_JSON_NONE && json->tokens[container].next > container + 1 ? container + 1
	                                                                                    : SCENE_JSON_NONE;
}

uint32_t scene_json_after(const scene_json *json, uint32_t container, uint32_t token)
{
	STILB_ASSERT(container < token && token < json->tokens[container].next);
	uint32_t next = json->tokens[token].next;
	return next < json->tokens[container].next ? next : SCENE_JSON_NONE;
}

uint32_t scene_json_array(scene_json *json, uint32_t object, const char *key)
{
	uint32_t token = scene_json_member(json, object, key);
	if (token == SCENE_JSON_NONE || json->tokens[token].kind == SCENE_JSON_ARRAY)
		return token;
	scene_json_blame(json, token, "'%s' is not of type array", key);
	return SCENE_JSON_NONE;
}

/* The number of a token. Behind a number comes another sign of JSON, where strtod ends, unless it is all of the text,
 * which nobody reads. */
static double json_value(const scene_json *json, uint32_t token)
{
	char text[JSON_NUMBER];
	snprintf(text, sizeof text, "%.*s", (int)json->tokens[token].size, json->text + json->tokens[token].at);
	char *point = strchr(text, '.');
	if (point) /* which the program's locale may write otherwise */
		*point = *localeconv()->decimal_point;
	return strtod(text, NULL);
}

bool scene_json_numbers(scene_json *json, uint32_t object, const char *key, float *out, uint32_t count)
{
	STILB_ASSERT(count <= 16);
	float numbers[16];
	uint32_t array = scene_json_array(json, object, key), found = 0;
	if (array == SCENE_JSON_NONE)
		return false;
	for (uint32_t at = scene_json_first(json, array); at != SCENE_JSON_NONE; at = scene_json_after(json, array, at)) {
		if (json->tokens[at].kind != SCENE_JSON_NUMBER || found == count) {
			scene_json_blame(json, at, "'%s' is not of type array of %u numbers", key, count);
			return false;
		}
		numbers[found++] = (float)json_value(json, at);
	}
	if (found < count) {
		scene_json_blame(json, array, "'%s' has %u numbers instead of %u", key, found, count);
		return false;
	}
	memcpy(out, numbers, count * sizeof *out);
	return true;
}

double scene_json_value(const scene_json *json, uint32_t token)
{
	return json->tokens[token].kind == SCENE_JSON_NUMBER ? json_value(json, token) : (double)NAN;
}

double scene_json_number(scene_json *json, uint32_t object, const char *key, double missing)
{
	uint32_t token = scene_json_member(json, object, key);
	if (token == SCENE_JSON_NONE)
		return missing;
	if (json->tokens[token].kind == SCENE_JSON_NUMBER)
		return json_value(json, token);
	scene_json_blame(json, token, "'%s' is not of type number", key);
	return missing;
}

bool scene_json_bool(scene_json *json, uint32_t object, const char *key, bool missing)
{
	uint32_t token = scene_json_member(json, object, key);
	if (token == SCENE_JSON_NONE)
		return missing;
	scene_json_kind kind = json->tokens[token].kind;
	if (kind != SCENE_JSON_TRUE && kind != SCENE_JSON_FALSE)
		scene_json_blame(json, token, "'%s' is not of type true or false", key);
	return kind == SCENE_JSON_TRUE;
}

uint64_t scene_json_whole(scene_json *json, uint32_t token)
{
	double value = json->tokens[token].kind == SCENE_JSON_NUMBER ? json_value(json, token) : -1.0;
	if (value >= 0.0 && value <= (double)SCENE_JSON_EXACT && floor(value) == value)
		return (uint64_t)value;
	scene_json_blame(json, token, "it is not of type whole number >= 0");
	return UINT64_MAX;
}

uint64_t scene_json_size(scene_json *json, uint32_t object, const char *key, uint64_t missing)
{
	uint32_t token = scene_json_member(json, object, key);
	if (token == SCENE_JSON_NONE)
		return missing;
	uint64_t value = scene_json_whole(json, token);
	return value == UINT64_MAX ? missing : value;
}

/* ---- strings ----------------------------------------------------------------------------------------------------- */

/* The four hexadecimal digits at text[0..left) as a number; -1: they are not there. */
static int32_t json_hex(const char *text, size_t left)
{
	int32_t value = 0;
	for (int i = 0; i < 4; i++) {
		if (left <= (size_t)i || !isxdigit((unsigned char)text[i]))
			return -1;
		int digit = isdigit((unsigned char)text[i]) ? text[i] - '0' : (text[i] | 32) - 'a' + 10;
		value = 16 * value + digit;
	}
	return value;
}

/* Writes a code point in UTF-8, 1 to 4 bytes; returns their number. */
static size_t json_utf8(uint32_t code, char out[4])
{
	if (code < 0x80) {
		out[0] = (char)code;
		return 1;
	}
	size_t size = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
	for (size_t i = size - 1; i > 0; i--, code >>= 6)
		out[i] = (char)(0x80 | (code & 0x3f));
	out[0] = (char)(code | (size == 2 ? 0xc0 : size == 3 ? 0xe0 : 0xf0));
	return size;
}

/* Resolves the escape at text[0..left), behind its backslash, into out; *size: of what it wrote. Returns the bytes of
 * the escape. A wrong one becomes the byte behind the backslash. */
static size_t json_unescape(const char *text, size_t left, char out[4], size_t *size)
{
	static const char letters[] = "bfnrt", bytes[] = "\b\f\n\r\t";
	*size = 1;
	out[0] = (char)(left > 0 ? text[0] : '\\');
	if (left == 0)
		return 0;
	const char *letter = text[0] ? strchr(letters, text[0]) : NULL;
	if (letter)
		out[0] = bytes[letter - letters];
	int32_t code = text[0] == 'u' ? json_hex(text + 1, left - 1) : -1;
	if (code < 0)
		return 1;
	int32_t low = code >= 0xd800 && code < 0xdc00 && left > 6 && text[5] == '\\' && text[6] == 'u'
	                  ? json_hex(text + 7, left - 7)
	                  : -1;
	bool pair = low >= 0xdc00 && low < 0xe000;
	uint32_t point = pair ? 0x10000u + ((uint32_t)(code - 0xd800) << 10) + (uint32_t)(low - 0xdc00) : (uint32_t)code;
	*size = json_utf8(point, out);
	return pair ? 11 : 5;
}

size_t scene_json_copy(scene_json *json, uint32_t token, char *out, size_t room)
{
	STILB_ASSERT(room > 0);
	out[0] = '\0';
	if (token == SCENE_JSON_NONE)
		return 0;
	if (json->tokens[token].kind != SCENE_JSON_STRING) {
		scene_json_blame(json, token, "it is not of type string");
		return 0;
	}
	const char *text = json->text + json->tokens[token].at;
	size_t left = json->tokens[token].size, whole = 0, kept = 0;
	while (left > 0) {
		char bytes[4] = {text[0]};
		size_t size = 1, used = 1;
		if (text[0] == '\\')
			used += json_unescape(text + 1, left - 1, bytes, &size);
		if (whole == kept && kept + size < room) {
			memcpy(out + kept, bytes, size);
			kept += size;
		}
		whole += size;
		text += used;
		left -= used;
	}
	out[kept] = '\0';
	return whole;
}

size_t scene_json_string(scene_json *json, uint32_t object, const char *key, char *out, size_t room)
{
	return scene_json_copy(json, scene_json_member(json, object, key), out, room);
}

bool scene_json_is(const scene_json *json, uint32_t token, const char *text)
{
	size_t size = strlen(text);
	return token != SCENE_JSON_NONE && json->tokens[token].kind == SCENE_JSON_STRING &&
	       json->tokens[token].size == size && memcmp(json->text + json->tokens[token].at, text, size) == 0;
}
