/* Buffered text output for the writers of trace files. Numbers are formatted so that the locale cannot change them. */
#ifndef STILB_PROF_TEXT_H
#define STILB_PROF_TEXT_H

#include "profiler/prof_trace.h"

#include <assert.h>
#include <string.h>

#define PROF_TEXT_SIZE (256u << 10) /* fits into the second-level cache; few system calls */

typedef struct prof_text {
	stilb_prof_sink sink;
	int error; /* the first value other than 0 that sink.write returned; then nothing more is written */
	uint32_t used;
	char bytes[PROF_TEXT_SIZE];
} prof_text;

/* Creates an output to sink. NULL: no memory. */
prof_text *prof_text_create(stilb_prof_sink sink);
int prof_text_flush(prof_text *text);
/* Flushes and frees. Returns error, which is the caller's, if it is not 0; else that of the output. text NULL:
 * -ENOMEM. */
int prof_text_finish(prof_text *text, int error);

void prof_text_bytes(prof_text *text, const void *bytes, size_t size);
void prof_text_add(prof_text *text, const char *string);
void prof_text_escaped(prof_text *text,
                       const char *string); /* as in a JSON string; bytes that are not UTF-8 become U+FFFD */
void prof_text_json(prof_text *text, const char *string); /* prof_text_escaped in quotes: a JSON string */
void prof_text_u64(prof_text *text, uint64_t value);
void prof_text_double(prof_text *text, double value); /* finite; the fewest digits that read back the same */
void prof_text_ms(prof_text *text, uint64_t ns);      /* milliseconds with six decimals */

/* Returns a buffer of at least size bytes, size <= PROF_TEXT_SIZE (asserted). prof_text_fill then says how far it is
 * filled. */
static inline char *prof_text_room(prof_text *text, uint32_t size)
{
	assert(size <= PROF_TEXT_SIZE && text->used <= PROF_TEXT_SIZE);
	if (__builtin_expect(PROF_TEXT_SIZE - text->used < size, 0))
		prof_text_flush(text);
	return text->bytes + text->used;
}

static inline void prof_text_fill(prof_text *text, const char *end)
{
	assert(end >= text->bytes + text->used && end <= text->bytes + PROF_TEXT_SIZE && "within the room that was made");
	text->used = (uint32_t)(end - text->bytes);
}

/* ---- into memory: each returns the end of what it wrote ---------------------------------------------------------- */

#define PROF_PUT_U64_MAX 20
#define PROF_PUT_US_MAX (PROF_PUT_U64_MAX + 5)

/* Copies size bytes. */
static inline char *prof_put(char *at, const char *text, size_t size)
{
	memcpy(at, text, size);
	return at + size;
}

/* Decimal digits. */
char *prof_put_u64(char *at, uint64_t value);
/* Writes a time given in tenths of a nanosecond as microseconds with three decimals, or four if the tenth is not 0. */
char *prof_put_us(char *at, uint64_t tenths);
/* A JSON string in quotes; at has room for PROF_PUT_JSON_MAX(strlen(string)) bytes. */
#define PROF_PUT_JSON_MAX(length) (6 * (length) + 2)
char *prof_put_json(char *at, const char *string);

#endif
