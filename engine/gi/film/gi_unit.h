/*
 * gi_unit: the picture as units, the squares of pixels that machines share (farm.h).
 *
 * Their numbers run through the picture in van der Corput's order in two dimensions: the bits of a number, from the
 * lowest on, are the bits of the square's row and column, from the highest on, in turn. So the units of any range are
 * spread evenly over the picture, and a share of it is a small picture of the whole, which costs its share of the time.
 * The sums of a pixel are made in the order of its samples, so a pixel is never divided.
 */
#ifndef GI_UNIT_H
#define GI_UNIT_H

#include "gi/film/gi_film.h"

typedef struct gi_units {
	uint32_t width, height; /* of the picture, pixels */
	uint32_t side;          /* of a unit, pixels */
	uint32_t count;
	uint32_t columns; /* units side by side */
	uint32_t *order;  /* [count] row * columns + column of each unit */
} gi_units;

typedef struct gi_unit_place {
	uint32_t x, y, width, height; /* pixels; smaller than a unit at the right and lower edge */
} gi_unit_place;

/* Units of a picture with so many samples a pixel: as small as fills a batch, 4 to 16 pixels, so that many machines end
 * at about the same time (docs/many-machines.md). False: no memory. free(units->order) ends it. */
bool gi_units_create(uint32_t width, uint32_t height, uint32_t samples, gi_units *units);

gi_unit_place gi_unit_place_of(const gi_units *units, uint32_t unit);

/* Pixels of so many units from `first` on. */
uint64_t gi_unit_pixels(const gi_units *units, uint32_t first, uint32_t count);

/* Bytes of a unit's result: its pixels' sums, row by row, then their weights and halves, each padded to a whole
 * unit. */
uint32_t gi_unit_size(const gi_units *units, const gi_film *film);

void gi_unit_get(const gi_units *units, const gi_film *film, uint32_t unit, void *result);

/* The least number of samples that a pixel of the unit has, and the most. */
void gi_unit_samples(const gi_units *units, const gi_film *film, uint32_t unit, uint32_t *least, uint32_t *most);

/* Takes over the result, and writes the unit's pixels in all planes. False: a pixel has fewer or more samples, or more
 * hits than samples; then nothing is changed. */
bool gi_unit_set(const gi_units *units, gi_film *film, uint32_t unit, uint32_t least, uint32_t most,
                 const void *result);

#endif
