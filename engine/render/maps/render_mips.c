/* The mips of textures that surfaces name. They are made on the CPU, by the thread that makes the texture: every device
 * then has the same ones, of every format. */
#include "render/maps/render_maps.h"

#include "base/base_contract.h"
#include "image/image.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

uint32_t render_mip_count(uint32_t width, uint32_t height)
{
	uint32_t side = width > height ? width : height;
	STILB_ASSERT(side > 0);
	return 32u - (uint32_t)__builtin_clz(side);
}

/* Which texels of a row or column of `from` a texel of the next mip covers: `count` from `first` on, each by its
 * weight; the weights' sum is 1. */
typedef struct mips_taps {
	uint32_t first, count;
	float weights[3];
} mips_taps;

static mips_taps mips_taps_of(uint32_t from, uint32_t texel)
{
	if (from == 1)
		return (mips_taps){0, 1, {1.0f}};
	if (from % 2 == 0)
		return (mips_taps){2 * texel, 2, {0.5f, 0.5f}};
	/* A texel of the m that there are is 2 + 1 / m wide. */
	uint32_t to = from / 2;
	float whole = (float)from;
	return (mips_taps){2 * texel, 3, {(float)(to - texel) / whole, (float)to / whole, (float)(texel + 1) / whole}};
}

/* How light becomes codes of a format. */
typedef struct mips_codes {
	stilb_image_format format;
	float borders[256]; /* U8_SRGB: the light from which on a code is that or more; of code 0: below all */
} mips_codes;

static void mips_codes_make(stilb_image_format format, mips_codes *codes)
{
	codes->format = format;
	codes->borders[0] = -INFINITY;
	for (uint32_t c = 1; c < 256 && format == STILB_IMAGE_U8_SRGB; c++)
		codes->borders[c] = shade_srgb_to_linear(((float)c - 0.5f) / 255.0f);
}

/* The code whose light is nearest in codes. */
static uint8_t mips_srgb(const mips_codes *codes, float light)
{
	uint32_t code = 0;
	for (uint32_t step = 128; step > 0; step /= 2)
		code += light >= codes->borders[code + step] ? step : 0;
	return (uint8_t)code;
}

/* Writes `count` values of light, four channels a texel. Returns the end. */
static uint8_t *mips_write(const mips_codes *codes, const float *light, size_t count, uint8_t *out)
{
	uint16_t *words = (uint16_t *)(void *)out;
	switch (codes->format) {
	case STILB_IMAGE_U8_SRGB:
		for (size_t i = 0; i < count; i++)
			out[i] = i % 4 < 3 ? mips_srgb(codes, light[i]) : (uint8_t)lrintf(light[i] * 255.0f);
		return out + count;
	case STILB_IMAGE_U8_LINEAR:
		for (size_t i = 0; i < count; i++)
			out[i] = (uint8_t)lrintf(light[i] * 255.0f);
		return out + count;
	case STILB_IMAGE_U16_LINEAR:
		for (size_t i = 0; i < count; i++)
			words[i] = (uint16_t)lrintf(light[i] * 65535.0f);
		return out + count * sizeof *words;
	case STILB_IMAGE_F16_LINEAR:
		for (size_t i = 0; i < count; i++)
			words[i] = stilb_image_half_from_float(light[i]);
		return out + count * sizeof *words;
	default:
		STILB_ASSERT(codes->format == STILB_IMAGE_F32_LINEAR);
		memcpy(out, light, count * sizeof *light);
		return out + count * sizeof *light;
	}
}

/* Writes the mip after `from`. rows: room for two rows of `from` in light. Returns the end. */
static uint8_t *mips_next(const stilb_image *from, const mips_codes *codes, float *rows, uint8_t *out)
{
	uint32_t width = from->width > 1 ? from->width / 2 : 1, height = from->height > 1 ? from->height / 2 : 1;
	size_t row = (size_t)from->width * 4;
	float *sum = rows + row;
	for (uint32_t y = 0; y < height; y++) {
		mips_taps down = mips_taps_of(from->height, y);
		for (uint32_t t = 0; t < down.count; t++) {
			stilb_image_row_to_light(from, down.first + t, rows);
			for (size_t i = 0; i < row; i++)
				sum[i] = (t > 0 ? sum[i] : 0.0f) + down.weights[t] * rows[i];
		}
		for (uint32_t x = 0; x < width; x++) {
			mips_taps across = mips_taps_of(from->width, x);
			float texel[4] = {0.0f};
			for (uint32_t t = 0; t < across.count; t++)
				for (uint32_t c = 0; c < 4; c++)
					texel[c] += across.weights[t] * sum[4 * (size_t)(across.first + t) + c];
			out = mips_write(codes, texel, 4, out);
		}
	}
	return out;
}

void *render_mips_make(const stilb_image *image, size_t *bytes)
{
	STILB_ASSERT(image->channels == 4 && image->format != STILB_IMAGE_U16_SRGB);
	size_t texel = stilb_image_size(image) / image->width / image->height;
	uint32_t count = render_mip_count(image->width, image->height);
	*bytes = 0;
	for (uint32_t m = 1; m < count; m++)
		*bytes += texel * (image->width >> m ? image->width >> m : 1) * (image->height >> m ? image->height >> m : 1);
	if (*bytes == 0)
		return NULL;
	uint8_t *mips = stilb_memory_alloc(*bytes, 1), *out = mips;
	float *rows = stilb_memory_alloc((size_t)image->width * 8, sizeof *rows);
	mips_codes codes;
	mips_codes_make(image->format, &codes);
	stilb_image from = *image;
	for (uint32_t m = 1; m < count && mips && rows; m++) {
		uint8_t *here = out;
		out = mips_next(&from, &codes, rows, out);
		from.pixels = here;
		from.width = from.width > 1 ? from.width / 2 : 1;
		from.height = from.height > 1 ? from.height / 2 : 1;
	}
	STILB_ASSERT(!mips || !rows || out == mips + *bytes);
	if (!rows) {
		free(mips);
		mips = NULL;
	}
	free(rows);
	return mips;
}
