/*
 * base_json: writes one JSON document (RFC 8259) into a growing string, indented. Numbers are finite and use '.' in
 * every locale.
 *
 * Life cycle.  A stilb_json begins as {0}. One value at the top, usually an object or an array, with everything inside
 *              it -> stilb_json_save, which finishes it, or stilb_json_finish to drop it. Then it is {0} again.
 * Keys.        A value in an object has a key; in an array and at the top its key is NULL. Keys are not checked for
 *              repetition.
 * Strings.     UTF-8; bytes that are not UTF-8 become U+FFFD, control characters are escaped.
 * Errors.      Out of memory is remembered, and reported by stilb_json_save.
 * Threads.     [one-writer] per stilb_json.
 * Example.
 *
 *   stilb_json json = {0};
 *   stilb_json_begin(&json, NULL, '{');
 *   stilb_json_int(&json, "models", 10000);
 *   stilb_json_begin(&json, "ms", '[');
 *   stilb_json_double(&json, NULL, 1.5);
 *   stilb_json_end(&json, ']');
 *   stilb_json_end(&json, '}');
 *   stilb_result result = stilb_json_save(&json, path);
 */
#ifndef STILB_BASE_JSON_H
#define STILB_BASE_JSON_H

#include "base/base.h"

#define STILB_JSON_MAX_DEPTH 64u /* brackets inside one another */

typedef struct stilb_json {
	char *text; /* [length] and a 0; NULL before the first value */
	size_t length, capacity;
	uint32_t depth;   /* brackets that are open */
	uint64_t objects; /* bit d: the bracket opened at depth d is '{' */
	bool comma;       /* a value was written in the innermost open bracket: the next one needs a ',' before it */
	bool failed;      /* out of memory */
} stilb_json;

/* Opens an object ('{') or an array ('['), at most STILB_JSON_MAX_DEPTH inside one another. */
void stilb_json_begin(stilb_json *json, const char *key, char bracket);

/* Closes the innermost open object ('}') or array (']'). */
void stilb_json_end(stilb_json *json, char bracket);

/* Adds a string; value is not NULL. */
void stilb_json_string(stilb_json *json, const char *key, const char *value);

void stilb_json_int(stilb_json *json, const char *key, int64_t value);

/* Adds a number with six digits after the point. NaN, infinity and |value| >= 9e12 are written as 0. */
void stilb_json_double(stilb_json *json, const char *key, double value);

/* Adds a number that is read back as the same float. NaN and infinity are written as 0. */
void stilb_json_float(stilb_json *json, const char *key, float value);

void stilb_json_bool(stilb_json *json, const char *key, bool value);

/* Saves the document, which is complete, with a newline at its end, whole or not at all (base_file.h), and finishes it.
 * STILB_ERROR_MEMORY, STILB_ERROR_FILE. */
stilb_result stilb_json_save(stilb_json *json, const char *path);

/* Frees the text and leaves {0}, complete or not. */
void stilb_json_finish(stilb_json *json);

#endif
