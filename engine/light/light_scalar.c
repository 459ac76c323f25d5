/* The innermost loops in plain C: the reference for the others. */
#include "light/light_scalar.h"

static void scalar_slices(const light_depths *depths, const float *depth, const float *radius, uint32_t count,
                          uint8_t *first, uint8_t *last)
{
	for (uint32_t i = 0; i < count; i++) {
		float from = depth[i] - radius[i], to = depth[i] + radius[i];
		uint32_t ended = 0, begun = 0;
		for (uint32_t k = 0; k + 1 < depths->count; k++) {
			ended += depths->far_z[k] < from;
			begun += depths->near_z[k + 1] <= to;
		}
		first[i] = (uint8_t)ended;
		last[i] = (uint8_t)begun;
	}
}

static void scalar_pick(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_chunk *chunk,
                        light_picked *picked)
{
	for (uint32_t i = 0; i < chunk->count; i++)
		scalar_pick_one(slab, first_row, end_row, chunk, i, picked);
}

static void scalar_narrow(const light_slab *slab, uint32_t first_row, uint32_t end_row, const light_picked *from,
                          light_picked *to)
{
	to->count = 0;
	for (uint32_t i = 0; i < from->count; i++) {
		uint32_t at = to->count;
		to->x[at] = from->x[i];
		to->y[at] = from->y[i];
		to->w[at] = from->w[i];
		to->square[at] = from->square[i];
		to->number[at] = from->number[i];
		to->count += scalar_in_rows(slab, first_row, end_row, from->y[i], from->w[i], from->square[i]);
	}
}

static uint32_t scalar_spans(const light_slab *slab, const light_picked *picked, uint32_t row, uint32_t *numbers,
                             light_span *spans)
{
	uint32_t count = 0;
	for (uint32_t i = 0; i < picked->count; i++)
		scalar_span_one(slab, picked, i, row, numbers, spans, &count);
	return count;
}

static light_span scalar_trim(const light_cone_row *row, light_span span)
{
	uint32_t first = span.first, end = span.last + 1u;
	while (first < end && !scalar_cone_meets(row, first))
		first++;
	while (first < end && !scalar_cone_meets(row, end - 1))
		end--;
	return first < end ? (light_span){(uint16_t)first, (uint16_t)(end - 1)} : LIGHT_SPAN_NONE;
}

void light_fill(const uint32_t *restrict numbers, const light_span *restrict spans, uint32_t count,
                uint32_t *restrict cursors, uint32_t *restrict ids)
{
	for (uint32_t i = 0; i < count; i++) {
		uint32_t number = numbers[i], end = spans[i].last + 1u;
		for (uint32_t c = spans[i].first; c < end; c++) {
			uint32_t at = cursors[c];
			cursors[c] = at + 1;
			ids[at] = number;
		}
	}
}

static void scalar_fill_dense(uint32_t *numbers, light_span *spans, uint32_t count, uint32_t *cursors, uint32_t columns,
                              uint32_t end, uint32_t *ids)
{
	(void)columns;
	(void)end;
	light_fill(numbers, spans, count, cursors, ids);
}

const light_kernels light_kernels_scalar = {
	.slices = scalar_slices,
	.pick = scalar_pick,
	.narrow = scalar_narrow,
	.spans = scalar_spans,
	.trim = scalar_trim,
	.fill_dense = scalar_fill_dense,
};
