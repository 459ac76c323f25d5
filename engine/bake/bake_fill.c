#include "bake/bake_fill.h"

#include <stdlib.h>
#include <string.h>

#define EVENING 64 /* rounds in which what was filled within charts is made even */

typedef enum fill_state {
	FILL_LACKS, /* the texel has no value */
	FILL_NEW,   /* it got one in the round that runs */
	FILL_HAS,
} fill_state;

typedef struct fill {
	uint32_t side, channels;
	const uint32_t *place;
	uint8_t *has;   /* [side * side] fill_state */
	uint32_t *list; /* [count] texels to fill; after the rounds those that were filled come last */
	float *values;
} fill;

/* Gives texel t the mean of its neighbours that have values, and, if it is of a chart, are of the same one. False: none
 * is. */
static bool take_mean(const fill *f, size_t t)
{
	uint32_t x = (uint32_t)(t % f->side), y = (uint32_t)(t / f->side), count = 0;
	float sum[STILB_BAKE_FILL_CHANNELS] = {0.0f};
	for (uint32_t ny = y > 0 ? y - 1 : 0; ny <= y + 1 && ny < f->side; ny++)
		for (uint32_t nx = x > 0 ? x - 1 : 0; nx <= x + 1 && nx < f->side; nx++) {
			size_t n = (size_t)ny * f->side + nx;
			bool alike = f->place[t] == STILB_BAKE_NO_CHART || f->place[t] == f->place[n];
			if (n == t || f->has[n] != FILL_HAS || !alike)
				continue;
			for (uint32_t k = 0; k < f->channels; k++)
				sum[k] += f->values[n * f->channels + k];
			count++;
		}
	for (uint32_t k = 0; k < f->channels && count > 0; k++)
		f->values[t * f->channels + k] = sum[k] / (float)count;
	return count > 0;
}

/* One round over list[0..count). Returns how many texels still have no value; these stand in front. */
static size_t fill_round(fill *f, size_t count)
{
	size_t left = 0;
	for (size_t i = 0; i < count; i++)
		if (take_mean(f, f->list[i]))
			f->has[f->list[i]] = FILL_NEW;
	for (size_t i = 0; i < count; i++) {
		uint32_t t = f->list[i];
		if (f->has[t] == FILL_LACKS) {
			f->list[i] = f->list[left];
			f->list[left++] = t;
		} else {
			f->has[t] = FILL_HAS;
		}
	}
	return left;
}

/* Lists the texels of a state. Returns how many there are. */
static size_t list_texels_of(fill *f, const uint8_t *state, stilb_bake_state wanted)
{
	size_t count = 0;
	for (size_t t = 0; t < (size_t)f->side * f->side; t++)
		if (state[t] == wanted)
			f->list[count++] = (uint32_t)t;
	return count;
}

/* Fills what is hidden, then gives each of these texels the mean of its neighbours again and again: without it there
 * would be streaks from the border of what is hidden inwards. */
static void fill_hidden(fill *f, const uint8_t *state)
{
	size_t count = list_texels_of(f, state, STILB_BAKE_HIDDEN), left = count, before = count + 1;
	while (left > 0 && left < before) {
		before = left;
		left = fill_round(f, left);
	}
	count = list_texels_of(f, state, STILB_BAKE_HIDDEN);
	for (int round = 0; round < EVENING; round++)
		for (size_t i = 0; i < count; i++)
			if (f->has[f->list[i]] == FILL_HAS)
				take_mean(f, f->list[i]);
}

stilb_result stilb_bake_fill(uint32_t side, const uint32_t *place, uint32_t border, uint8_t *state, bool mark,
                             float *values, uint32_t channels)
{
	STILB_ASSERT(channels >= 1 && channels <= STILB_BAKE_FILL_CHANNELS);
	size_t count = (size_t)side * side;
	fill f = {side, channels, place, NULL, NULL, values};
	f.has = stilb_memory_alloc(count, 1);
	f.list = stilb_memory_alloc(count, sizeof *f.list);
	bool good = f.has && f.list;
	for (size_t t = 0; t < count && good; t++)
		f.has[t] = state[t] == STILB_BAKE_LIT ? FILL_HAS : FILL_LACKS;
	if (good) {
		fill_hidden(&f, state);
		size_t empty = list_texels_of(&f, state, STILB_BAKE_EMPTY);
		for (uint32_t round = 0; round < border; round++)
			empty = fill_round(&f, empty);
	}
	for (size_t t = 0; t < count && good && mark; t++)
		if (f.has[t] == FILL_HAS && state[t] != STILB_BAKE_LIT)
			state[t] = STILB_BAKE_FILLED;
	free(f.has);
	free(f.list);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "out of memory to fill %zu texels", count);
}
