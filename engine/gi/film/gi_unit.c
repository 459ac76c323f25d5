#include "gi/film/gi_unit.h"

#include <stdlib.h>
#include <string.h>

#define UNIT_BATCH 1024u /* samples that are computed together, GI_BATCH */
#define UNIT_LEAST 4u
#define UNIT_MOST 16u

static_assert(sizeof(gi_film_pixel) % 8 == 0 && sizeof(gi_film_weight) % 8 == 0 && sizeof(gi_film_half) % 8 == 0,
              "results are whole numbers of words");

/* The least n with 2^n >= count. */
static uint32_t bits_for(uint32_t count)
{
	uint32_t bits = 0;
	while ((1u << bits) < count)
		bits++;
	return bits;
}

/* Row and column whose bits, from the highest on, are those of code, from the lowest on, in turn. */
static void code_place(uint32_t code, uint32_t column_bits, uint32_t row_bits, uint32_t *column, uint32_t *row)
{
	*column = *row = 0;
	for (bool down = false; column_bits + row_bits > 0; code >>= 1) {
		if (column_bits == 0 || (down && row_bits > 0))
			*row |= (code & 1u) << --row_bits;
		else
			*column |= (code & 1u) << --column_bits;
		down = !down;
	}
}

static size_t unit_pixels(const gi_units *units)
{
	return (size_t)units->side * units->side;
}

bool gi_units_create(uint32_t width, uint32_t height, uint32_t samples, gi_units *units)
{
	STILB_ASSERT(width > 0 && height > 0 && samples > 0 && units);
	uint32_t side = UNIT_LEAST;
	while (side < UNIT_MOST && side * side * samples < UNIT_BATCH)
		side *= 2;
	uint32_t columns = (width + side - 1) / side, rows = (height + side - 1) / side;
	uint32_t column_bits = bits_for(columns), row_bits = bits_for(rows), count = 0;
	STILB_ASSERT(column_bits + row_bits < 32);
	*units = (gi_units){.width = width, .height = height, .side = side, .columns = columns, .count = columns * rows};
	units->order = malloc(units->count * sizeof *units->order);
	if (!units->order)
		return false;
	for (uint32_t code = 0; code < 1u << (column_bits + row_bits); code++) {
		uint32_t column, row;
		code_place(code, column_bits, row_bits, &column, &row);
		if (column < columns && row < rows)
			units->order[count++] = row * columns + column;
	}
	STILB_ASSERT(count == units->count);
	return true;
}

gi_unit_place gi_unit_place_of(const gi_units *units, uint32_t unit)
{
	STILB_ASSERT(unit < units->count);
	uint32_t side = units->side;
	uint32_t x = units->order[unit] % units->columns * side, y = units->order[unit] / units->columns * side;
	uint32_t right = units->width - x, below = units->height - y;
	return (gi_unit_place){x, y, right < side ? right : side, below < side ? below : side};
}

uint64_t gi_unit_pixels(const gi_units *units, uint32_t first, uint32_t count)
{
	uint64_t pixels = 0;
	for (uint32_t i = 0; i < count; i++) {
		gi_unit_place place = gi_unit_place_of(units, first + i);
		pixels += (uint64_t)place.width * place.height;
	}
	return pixels;
}

uint32_t gi_unit_size(const gi_units *units, const gi_film *film)
{
	size_t pixel = sizeof *film->pixels;
	pixel += film->weights ? sizeof *film->weights : 0;
	pixel += film->halves ? sizeof *film->halves : 0;
	return (uint32_t)(unit_pixels(units) * pixel);
}

void gi_unit_get(const gi_units *units, const gi_film *film, uint32_t unit, void *result)
{
	gi_unit_place place = gi_unit_place_of(units, unit);
	gi_film_pixel *pixels = result;
	gi_film_weight *weights = (gi_film_weight *)(pixels + unit_pixels(units));
	gi_film_half *halves = (gi_film_half *)(weights + (film->weights ? unit_pixels(units) : 0));
	memset(result, 0, gi_unit_size(units, film));
	for (uint32_t row = 0; row < place.height; row++) {
		size_t from = (size_t)(place.y + row) * film->width + place.x, to = (size_t)row * units->side;
		memcpy(&pixels[to], &film->pixels[from], place.width * sizeof *pixels);
		if (film->weights)
			memcpy(&weights[to], &film->weights[from], place.width * sizeof *weights);
		if (film->halves)
			memcpy(&halves[to], &film->halves[from], place.width * sizeof *halves);
	}
}

void gi_unit_samples(const gi_units *units, const gi_film *film, uint32_t unit, uint32_t *least, uint32_t *most)
{
	gi_unit_place place = gi_unit_place_of(units, unit);
	*least = UINT32_MAX;
	*most = 0;
	for (uint32_t row = 0; row < place.height; row++)
		for (uint32_t x = 0; x < place.width; x++) {
			uint32_t samples = film->pixels[(size_t)(place.y + row) * film->width + place.x + x].samples;
			*least = samples < *least ? samples : *least;
			*most = samples > *most ? samples : *most;
		}
}

bool gi_unit_set(const gi_units *units, gi_film *film, uint32_t unit, uint32_t least, uint32_t most, const void *result)
{
	gi_unit_place place = gi_unit_place_of(units, unit);
	const gi_film_pixel *pixels = result;
	const gi_film_weight *weights = (const gi_film_weight *)(pixels + unit_pixels(units));
	const gi_film_half *halves = (const gi_film_half *)(weights + (film->weights ? unit_pixels(units) : 0));
	for (uint32_t row = 0; row < place.height; row++)
		for (uint32_t x = 0; x < place.width; x++) {
			const gi_film_pixel *pixel = &pixels[(size_t)row * units->side + x];
			if (pixel->samples < least || pixel->samples > most || pixel->hits > pixel->samples)
				return false;
		}
	for (uint32_t row = 0; row < place.height; row++) {
		size_t to = (size_t)(place.y + row) * film->width + place.x, from = (size_t)row * units->side;
		memcpy(&film->pixels[to], &pixels[from], place.width * sizeof *pixels);
		if (film->weights)
			memcpy(&film->weights[to], &weights[from], place.width * sizeof *weights);
		if (film->halves)
			memcpy(&film->halves[to], &halves[from], place.width * sizeof *halves);
		for (uint32_t x = 0; x < place.width; x++)
			gi_film_resolve(film, to + x);
	}
	return true;
}
