#include "nearest.h"

#include "base/base.h"

#include <string.h>

static size_t nearest_min(size_t a, size_t b)
{
	return a < b ? a : b;
}

/* The least number of insertions, removals, replacements and swaps of neighbours that turn a into b (optimal string
 * alignment distance). cost[i][j] is that number for the first i bytes of a and the first j of b. Both lengths are at
 * most NEAREST_LENGTH. */
static size_t nearest_edits(const char *a, size_t a_length, const char *b, size_t b_length)
{
	STILB_ASSERT(a_length <= NEAREST_LENGTH && b_length <= NEAREST_LENGTH);
	size_t cost[NEAREST_LENGTH + 1][NEAREST_LENGTH + 1];
	for (size_t i = 0; i <= a_length; i++)
		for (size_t j = 0; j <= b_length; j++) {
			if (i == 0 || j == 0) {
				cost[i][j] = i + j;
				continue;
			}
			size_t wrong = a[i - 1] != b[j - 1];
			cost[i][j] = nearest_min(cost[i - 1][j], cost[i][j - 1]) + 1;
			cost[i][j] = nearest_min(cost[i][j], cost[i - 1][j - 1] + wrong);
			if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
				cost[i][j] = nearest_min(cost[i][j], cost[i - 2][j - 2] + 1);
		}
	return cost[a_length][b_length];
}

nearest_word nearest_begin(const char *typed, size_t length)
{
	return (nearest_word){.typed = typed, .length = length, .edits = (length < 6 ? 1 : length / 3) + 1};
}

void nearest_try(nearest_word *nearest, const char *word)
{
	size_t length = strlen(word);
	if (length > NEAREST_LENGTH || nearest->length > NEAREST_LENGTH)
		return;
	size_t edits = nearest_edits(nearest->typed, nearest->length, word, length);
	if (edits >= nearest->edits)
		return;
	nearest->edits = edits;
	nearest->best = word;
}
