/* Rows of half floats in plain C. */
#include "image/image.h"
#include "post/cpu/post_cpu.h"

static void scalar_widen(const uint16_t *from, uint32_t count, post_texel *to)
{
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t c = 0; c < 4; c++)
			to[i][c] = stilb_image_half_to_float(from[4 * i + c]);
}

static void scalar_narrow(const post_texel *from, uint32_t count, uint16_t *to)
{
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t c = 0; c < 4; c++)
			to[4 * i + c] = stilb_image_half_from_float(from[i][c]);
}

const post_cpu_rows post_cpu_rows_scalar = {scalar_widen, scalar_narrow};
