/*
 * scene_json: reads JSON, of glTF files and of SCENE.lights.json, into one array, and looks values up in it.
 *
 * The array has a token for each value and each key, in the order of the text: a container, then what is in it, so
 * that a token and the number of the first one behind it are all there is to a tree. Neither reading nor looking up
 * recurses, and a file of n bytes has at most n tokens.
 *
 * Life cycle.  scene_json_parse -> any number of the others -> scene_json_finish. The text must stay.
 * Errors.      Values of the wrong type: the functions return what they return for a missing value and keep the first
 *              such fault in `fault`, with its line and column, so that one test at the end of a step is enough.
 * Threads.     [one-writer]
 */
#ifndef STILB_SCENE_JSON_H
#define STILB_SCENE_JSON_H

#include "base/base.h"

typedef enum scene_json_kind {
	SCENE_JSON_NULL,
	SCENE_JSON_FALSE,
	SCENE_JSON_TRUE,
	SCENE_JSON_NUMBER,
	SCENE_JSON_STRING,
	SCENE_JSON_ARRAY,
	SCENE_JSON_OBJECT, /* its tokens are keys, which are strings, and values in turn */
} scene_json_kind;

typedef struct scene_json_token {
	uint32_t at;   /* first byte in the text; of a string the one behind its quote */
	uint32_t size; /* bytes of a string without its quotes; else unused */
	uint32_t next; /* number of the first token that is not inside of this one */
	scene_json_kind kind;
} scene_json_token;

typedef struct scene_json {
	const char *text;
	uint32_t size;
	scene_json_token *tokens; /* [count]; 0 is the whole text's */
	uint32_t count;
	char fault[192]; /* the first fault; "": none */
} scene_json;

#define SCENE_JSON_NONE UINT32_MAX    /* no token */
#define SCENE_JSON_DEPTH 256          /* containers inside of each other, at most */
#define SCENE_JSON_ROOT 0u            /* the token of the whole text */
#define SCENE_JSON_EXACT (1ull << 53) /* whole numbers up to this one are exact in JSON's numbers */

/* Reads size bytes of text; the file has the text's bytes at text[0..size). STILB_ERROR_FILE: it is no JSON, the
 * message says where; STILB_ERROR_MEMORY. json is {0} then. */
stilb_result scene_json_parse(scene_json *json, const char *text, size_t size);

/* Accepts {0}. */
void scene_json_finish(scene_json *json);

/* STILB_ERROR_FILE with the first fault, or STILB_OK. */
stilb_result scene_json_check(const scene_json *json);

/* Keeps a fault at this token, unless there is one already: "line 3, column 7: <words>". */
void scene_json_blame(scene_json *json, uint32_t token, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The value of this key; SCENE_JSON_NONE: the object has none, or is SCENE_JSON_NONE itself. */
uint32_t scene_json_member(scene_json *json, uint32_t object, const char *key);

/* The first value in an array, or the first key in an object; SCENE_JSON_NONE: it is empty, or that itself. */
uint32_t scene_json_first(const scene_json *json, uint32_t container);

/* The value behind another one in an array; of keys and values the one behind that; SCENE_JSON_NONE: it is the last. */
uint32_t scene_json_after(const scene_json *json, uint32_t container, uint32_t token);

/* The array of this key, or SCENE_JSON_NONE. */
uint32_t scene_json_array(scene_json *json, uint32_t object, const char *key);

/* The values of the array of this key, written to out[0..count); false, and out as it was: there is none, or it has
 * not `count` numbers, which is a fault. */
bool scene_json_numbers(scene_json *json, uint32_t object, const char *key, float *out, uint32_t count);

/* The number that a token is; NaN: it is none. */
double scene_json_value(const scene_json *json, uint32_t token);

double scene_json_number(scene_json *json, uint32_t object, const char *key, double missing);
bool scene_json_bool(scene_json *json, uint32_t object, const char *key, bool missing);

/* A whole number, 0 <= n <= SCENE_JSON_EXACT. */
uint64_t scene_json_size(scene_json *json, uint32_t object, const char *key, uint64_t missing);

/* The value of a token, a whole number <= SCENE_JSON_EXACT; UINT64_MAX and a fault: it is none. */
uint64_t scene_json_whole(scene_json *json, uint32_t token);

/* Copies a string token with its escapes resolved, cut to room bytes with the 0 at its end; "" for SCENE_JSON_NONE or a
 * token that is no string, which is a fault. Returns the size of the whole string. A 0 in it ends it. */
size_t scene_json_copy(scene_json *json, uint32_t token, char *out, size_t room);

/* scene_json_copy of the value of a key. */
size_t scene_json_string(scene_json *json, uint32_t object, const char *key, char *out, size_t room);

/* True if the token is the string text. */
bool scene_json_is(const scene_json *json, uint32_t token, const char *text);

#endif
