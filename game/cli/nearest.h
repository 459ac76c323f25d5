/*
 * nearest: finds the known word that a mistyped one may have meant.
 *
 *   nearest_word nearest = nearest_begin(typed, strlen(typed));
 *   nearest_try(&nearest, "--workers");          once for each known word
 *   if (nearest.best)
 *       stilb_log("unknown flag '%s'; did you mean '%s'?", typed, nearest.best);
 *
 * Threads.  [any-thread]; a nearest_word belongs to its caller.
 */
#ifndef STILB_NEAREST_H
#define STILB_NEAREST_H

#include <stddef.h>

#define NEAREST_LENGTH 32 /* bytes; a longer word, typed or known, matches nothing */

typedef struct nearest_word {
	const char *typed; /* the mistyped word is its first `length` bytes; more may follow, like "=value" */
	const char *best;  /* the nearest word so far; NULL: none is near enough */
	size_t length;     /* of typed, bytes */
	size_t edits;      /* a word becomes best if it needs fewer edits than this */
} nearest_word;

/* Begins a search. A known word is near enough if it needs at most one edit for every three bytes that were typed, and
 * at most one if fewer than six were. */
nearest_word nearest_begin(const char *typed, size_t length);

/* Makes word the best one if it needs fewer edits than all words before; among words that need equally many the first
 * stays the best. An edit inserts, removes or replaces a byte, or swaps two neighbours. word must stay valid as long as
 * nearest. */
void nearest_try(nearest_word *nearest, const char *word);

#endif
