/*
 * base_json: writes one JSON document into a growing string. Numbers are finite and use '.' in every locale.
 *
 *   stilb_json json = {0};
 *   stilb_json_begin(&json, NULL, '{');
 *   stilb_json_int(&json, "models", 10000);
 *   stilb_json_end(&json, '}');
 *   stilb_result result = stilb_json_save(&json, path);   // frees it as well
 *
 * A key is NULL inside an array and at the top. Strings are UTF-8; bytes that are not become U+FFFD. Running out of
 * memory is remembered and reported by save. Threads: one writer per stilb_json; otherwise [any-thread].
 */
#ifndef STILB_BASE_JSON_H
#define STILB_BASE_JSON_H

#include "base/base.h"

typedef struct stilb_json {
	char *text;
	size_t length, capacity;
	uint32_t depth;
	bool comma;  /* the next value needs a ',' before it */
	bool failed; /* out of memory */
} stilb_json;

void stilb_json_begin(stilb_json *json, const char *key, char bracket);
void stilb_json_end(stilb_json *json, char bracket);
void stilb_json_string(stilb_json *json, const char *key, const char *value);
void stilb_json_int(stilb_json *json, const char *key, int64_t value);
/* Six digits after the point; what is not finite, or not below 9e12, is written as 0. */
void stilb_json_double(stilb_json *json, const char *key, double value);
void stilb_json_bool(stilb_json *json, const char *key, bool value);

/* Saves the document with a newline at its end (base_file.h says how) and finishes it. */
stilb_result stilb_json_save(stilb_json *json, const char *path);
void stilb_json_finish(stilb_json *json);

#endif
