/* json_flat: a JSON document as a list of paths and values, for tests. The parser is trace_check's, strict to RFC
 * 8259. */
#ifndef STILB_JSON_FLAT_H
#define STILB_JSON_FLAT_H

#include <stdbool.h>
#include <stddef.h>

typedef struct json_flat_value {
	char *path; /* "stages.cull.median", "gpus[0].name"; "" for the document itself */
	char *text; /* a string without its quotes and escapes; anything else as it was written; "{}" and "[]" */
	char kind;  /* '"' string, '0' number, 'w' true, false or null, '{' object, '[' array */
} json_flat_value;

typedef struct json_flat {
	char error[256]; /* "" when the document is well formed */
	json_flat_value *values;
	size_t count, capacity;
} json_flat;

/* false: flat->error says what is wrong. Finish in both cases. */
bool json_flat_text(const char *text, size_t size, json_flat *flat);
bool json_flat_file(const char *path, json_flat *flat);
void json_flat_finish(json_flat *flat);

/* NULL: there is none. */
const json_flat_value *json_flat_find(const json_flat *flat, const char *path);

#endif
