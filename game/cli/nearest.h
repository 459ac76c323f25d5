/*
 * nearest: which known word a mistyped one may have meant.
 *
 *   nearest_word nearest = nearest_begin(typed, strlen(typed));
 *   nearest_try(&nearest, "--workers");          once for each known word
 *   if (nearest.best) ... "did you mean"
 */
#ifndef STILB_NEAREST_H
#define STILB_NEAREST_H

#include <stddef.h>

#define NEAREST_LENGTH 32 /* bytes; longer words are near to none */

typedef struct nearest_word {
	const char *typed, *best; /* best: NULL when no word is near */
	size_t length;            /* of typed */
	size_t edits;             /* that a better word needs less than */
} nearest_word;

/* Words are near up to a third of typed's letters wrong, and at least one may be. */
nearest_word nearest_begin(const char *typed, size_t length);

/* Takes the word if it is nearer than all before. */
void nearest_try(nearest_word *nearest, const char *word);

#endif
