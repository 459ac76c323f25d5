/* The mips of textures that surfaces name. They are made on the CPU, so that every device has the same ones, of every
 * format: by the thread that makes the texture and the threads of a pool, a few rows each. */
#include "render/maps/render_maps.h"

#include "base/base_contract.h"
#include "image/image.h"
#include "shading/shade_gltf.h"
#include "shading/shade_normal_filter.h"
#include "shading/shade_srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MIPS_BLOCK 256u /* texels that are made at once */
#define MIPS_BLOCK_FROM (2 * MIPS_BLOCK + 1)
#define MIPS_SLICE 16384u /* texels of a job, or a few more: some 0.1 ms */

uint32_t render_mip_count(uint32_t width, uint32_t height)
{
	uint32_t side = width > height ? width : height;
	STILB_ASSERT(side > 0);
	return 32u - (uint32_t)__builtin_clz(side);
}

uint64_t render_mip_texels(uint32_t width, uint32_t height, uint32_t levels)
{
	uint64_t texels = 0;
	for (uint32_t l = 0; l < levels; l++)
		texels += (uint64_t)(width >> l ? width >> l : 1) * (height >> l ? height >> l : 1);
	return texels;
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

/* ---- the spread of normals --------------------------------------------------------------------------------------- */

/* Variances below this are rounding: of equal normals the mean is as long as they are. */
#define MIPS_VARIANCE_MIN 1e-6f

/* From the spherical variance of the normals below a texel to their spread, [0, 1], and back. */
static float mips_spread(stilb_render_specular_aa how, float variance)
{
	shade_mean_direction mean = {.variance = variance};
	if (!(variance > MIPS_VARIANCE_MIN))
		return 0.0f;
	return how == STILB_RENDER_SPECULAR_AA_VMF ? shade_filter_convolution(mean, 0.0f).alpha
	                                           : shade_filter_variance(mean, 0.0f).alpha;
}

static float mips_variance(stilb_render_specular_aa how, float spread)
{
	float inverse_sharpness = shade_filter_inverse_sharpness(spread);
	return how == STILB_RENDER_SPECULAR_AA_VMF ? shade_vmf_variance(inverse_sharpness)
	                                           : inverse_sharpness / (1.0f + inverse_sharpness);
}

/* The channel that holds 1 - the spread. */
static uint32_t mips_spread_channel(render_mips_kind kind)
{
	return kind == RENDER_MIPS_NORMALS ? 3 : 1;
}

/* The mean of the normals of a texel, of which these are the four channels. */
static stilb_vec3 mips_normal(const render_mips_codes *codes, const float texel[4])
{
	bool two = codes->kind == RENDER_MIPS_NORMALS_TWO;
	stilb_vec3 code = two ? stilb_vec3_make(texel[0], texel[3], shade_gltf_normal_z(texel[0], texel[3]))
	                      : stilb_vec3_make(texel[0], texel[1], texel[2]);
	float left = texel[mips_spread_channel(codes->kind)];
	float variance = 0.0f;
	if (codes->format == STILB_IMAGE_U8_LINEAR)
		variance = codes->variances[(uint32_t)(left * 255.0f + 0.5f)];
	else if (left < 1.0f)
		variance = mips_variance(codes->spread, left > 0.0f ? 1.0f - left : 1.0f);
	return shade_gltf_normal(code, 1.0f) * (1.0f - variance);
}

/* ---- codes ------------------------------------------------------------------------------------------------------- */

void render_mips_codes_make(stilb_image_format format, render_mips_kind kind, stilb_render_specular_aa spread,
                            render_mips_codes *codes)
{
	STILB_ASSERT(kind == RENDER_MIPS_MEANS ||
	             (spread != STILB_RENDER_SPECULAR_AA_OFF && format != STILB_IMAGE_U8_SRGB));
	codes->kind = kind;
	codes->spread = spread;
	for (uint32_t c = 0; c < 256 && kind != RENDER_MIPS_MEANS; c++)
		codes->variances[c] = mips_variance(spread, (float)(255 - c) / 255.0f);
	uint32_t code = 0;
	bool color = format == STILB_IMAGE_U8_SRGB;
	codes->format = format;
	codes->borders[0] = -INFINITY;
	codes->borders[256] = INFINITY;
	for (uint32_t c = 0; c < 256 && (color || format == STILB_IMAGE_U8_LINEAR); c++) {
		codes->lights[1][c] = (float)c / 255.0f;
		codes->lights[0][c] = color ? shade_srgb_to_linear((float)c / 255.0f) : codes->lights[1][c];
	}
	if (!color)
		return;
	for (uint32_t c = 1; c < 256; c++)
		codes->borders[c] = shade_srgb_to_linear(((float)c - 0.5f) / 255.0f);
	for (uint32_t i = 0; i <= RENDER_MIPS_STEPS; i++) {
		while ((float)i / RENDER_MIPS_STEPS >= codes->borders[code + 1])
			code++;
		codes->first[i] = (uint8_t)code;
	}
}

/* The code whose light is nearest in codes. light: 0 or more, and 1 or hardly more. */
static uint8_t mips_srgb(const render_mips_codes *codes, float light)
{
	uint32_t at = (uint32_t)(light * RENDER_MIPS_STEPS);
	uint32_t code = codes->first[at < RENDER_MIPS_STEPS ? at : RENDER_MIPS_STEPS];
	return (uint8_t)(code + (light >= codes->borders[code + 1]));
}

/* The nearest whole number of a value from 0 to 65535, ties to even: a float to which 1.5 * 2^23 is added loses what is
 * behind its point. */
static uint32_t mips_round(float value)
{
	float shifted = value + 12582912.0f;
	uint32_t bits;
	memcpy(&bits, &shifted, sizeof bits);
	return bits & 0x3fffffu;
}

/* Writes `count` values of light, four channels a texel. */
static void mips_write(const render_mips_codes *codes, const float *light, size_t count, uint8_t *out)
{
	uint16_t *words = (uint16_t *)(void *)out;
	switch (codes->format) {
	case STILB_IMAGE_U8_SRGB:
		for (size_t i = 0; i < count; i += 4) {
			for (size_t c = 0; c < 3; c++)
				out[i + c] = mips_srgb(codes, light[i + c]);
			out[i + 3] = (uint8_t)mips_round(light[i + 3] * 255.0f);
		}
		break;
	case STILB_IMAGE_U8_LINEAR:
		for (size_t i = 0; i < count; i++)
			out[i] = (uint8_t)mips_round(light[i] * 255.0f);
		break;
	case STILB_IMAGE_U16_LINEAR:
		for (size_t i = 0; i < count; i++)
			words[i] = (uint16_t)mips_round(light[i] * 65535.0f);
		break;
	case STILB_IMAGE_F16_LINEAR:
		for (size_t i = 0; i < count; i++)
			words[i] = stilb_image_half_from_float(light[i]);
		break;
	default:
		STILB_ASSERT(codes->format == STILB_IMAGE_F32_LINEAR);
		memcpy(out, light, count * sizeof *light);
	}
}

/* The light of `count` texels in a row. */
static void mips_read(const render_mips_codes *codes, const stilb_image *row, uint32_t count, float *light)
{
	const uint8_t *in = row->pixels;
	bool bytes = codes->format == STILB_IMAGE_U8_SRGB || codes->format == STILB_IMAGE_U8_LINEAR;
	if (!bytes) {
		stilb_image_row_to_light(row, 0, light);
		return;
	}
	for (uint32_t i = 0; i < 4 * count; i += 4) {
		for (uint32_t c = 0; c < 3; c++)
			light[i + c] = codes->lights[0][in[i + c]];
		light[i + 3] = codes->lights[1][in[i + 3]];
	}
}

/* A mip that is being made of the one before it. */
typedef struct mips_level {
	const stilb_image *from;
	const render_mips_codes *codes;
	uint32_t width;
	uint32_t row; /* the first that is made now */
	size_t texel; /* bytes of a texel, of `from` too */
	uint8_t *out;
} mips_level;

/* Puts the mean normals in the place of `count` texels in a row; the fourth number is 0. */
static void mips_to_normals(const render_mips_codes *codes, uint32_t count, float *texels)
{
	for (uint32_t i = 0; i < 4 * count; i += 4) {
		stilb_vec3 n = mips_normal(codes, texels + i);
		texels[i] = n[0], texels[i + 1] = n[1], texels[i + 2] = n[2], texels[i + 3] = 0.0f;
	}
}

/* The light that `count` texels from (x, y) on cover, or their normals, as means down the columns of level->from.
 * Returns the number of the first column. */
static uint32_t mips_column_means(const mips_level *level, bool normals, uint32_t y, uint32_t x, uint32_t count,
                                  float *sum)
{
	const stilb_image *from = level->from;
	float row[4 * MIPS_BLOCK_FROM];
	mips_taps down = mips_taps_of(from->height, y), left = mips_taps_of(from->width, x),
			  right = mips_taps_of(from->width, x + count - 1);
	uint32_t columns = right.first + right.count - left.first;
	stilb_image part = *from;
	STILB_ASSERT(columns <= MIPS_BLOCK_FROM);
	part.width = columns;
	part.height = 1;
	for (uint32_t t = 0; t < down.count; t++) {
		size_t place = (size_t)(down.first + t) * from->width + left.first;
		part.pixels = (uint8_t *)from->pixels + place * level->texel;
		mips_read(level->codes, &part, columns, row);
		if (normals)
			mips_to_normals(level->codes, columns, row);
		for (uint32_t i = 0; i < 4 * columns; i++)
			sum[i] = (t > 0 ? sum[i] : 0.0f) + down.weights[t] * row[i];
	}
	return left.first;
}

/* The means, along the row, of what `count` texels from x on cover. sum: of column `first` and those behind it. */
static void mips_row_means(uint32_t from, uint32_t x, uint32_t count, uint32_t first, const float *sum, float *texels)
{
	if (from % 2 == 0) { /* as below, in a loop that compilers make wide */
		for (uint32_t i = 0; i < count; i++)
			for (uint32_t c = 0; c < 4; c++)
				texels[4 * i + c] = (0.0f + 0.5f * sum[8 * i + c]) + 0.5f * sum[8 * i + 4 + c];
		return;
	}
	for (uint32_t i = 0; i < count; i++) {
		mips_taps across = mips_taps_of(from, x + i);
		const float *in = sum + 4 * (size_t)(across.first - first);
		for (uint32_t c = 0; c < 4; c++) {
			float texel = 0.0f + across.weights[0] * in[c];
			for (uint32_t t = 1; t < across.count; t++)
				texel += across.weights[t] * in[4 * t + c];
			texels[4 * i + c] = texel;
		}
	}
}

/* Writes the spread of the normals into `count` texels whose means are made. sum: scratch, of MIPS_BLOCK_FROM. */
static void mips_add_spread(const mips_level *level, uint32_t y, uint32_t x, uint32_t count, float *sum, float *texels)
{
	float normals[4 * MIPS_BLOCK];
	uint32_t first = mips_column_means(level, true, y, x, count, sum);
	mips_row_means(level->from->width, x, count, first, sum, normals);
	uint32_t channel = mips_spread_channel(level->codes->kind);
	for (uint32_t i = 0; i < 4 * count; i += 4) {
		stilb_vec3 mean = stilb_vec3_make(normals[i], normals[i + 1], normals[i + 2]);
		texels[i + channel] = 1.0f - mips_spread(level->codes->spread, 1.0f - sqrtf(stilb_vec3_dot(mean, mean)));
	}
}

/* Writes rows begin .. end - 1 of the mip, counted from level->row. */
static void mips_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const mips_level *level = context;
	float sum[4 * MIPS_BLOCK_FROM], texels[4 * MIPS_BLOCK];
	(void)worker;
	for (uint32_t y = level->row + begin; y < level->row + end; y++)
		for (uint32_t x = 0; x < level->width; x += MIPS_BLOCK) {
			uint32_t count = level->width - x < MIPS_BLOCK ? level->width - x : MIPS_BLOCK;
			uint32_t first = mips_column_means(level, false, y, x, count, sum);
			mips_row_means(level->from->width, x, count, first, sum, texels);
			if (level->codes->kind != RENDER_MIPS_MEANS)
				mips_add_spread(level, y, x, count, sum, texels);
			mips_write(level->codes, texels, 4 * (size_t)count,
			           level->out + ((size_t)y * level->width + x) * level->texel);
		}
}

void render_mips_rows(const render_mips_codes *codes, const stilb_image *from, uint32_t begin, uint32_t end,
                      stilb_job_pool *pool, const stilb_image *to)
{
	STILB_ASSERT(from->channels == 4 && from->format == codes->format && to->format == codes->format);
	STILB_ASSERT(from->format != STILB_IMAGE_U16_SRGB && !stilb_image_format_is_blocks(from->format));
	STILB_ASSERT(to->width == (from->width > 1 ? from->width / 2 : 1) && begin <= end && end <= to->height);
	mips_level level = {from, codes, to->width, begin, stilb_image_size(from) / from->width / from->height, to->pixels};
	uint32_t grain = MIPS_SLICE / to->width + 1, rows = end - begin;
	if (pool && rows > grain)
		stilb_job_parallel_for(pool, rows, grain, mips_rows, &level, 0);
	else
		mips_rows(0, rows, 0, &level);
}

void render_mips_prepare(const stilb_image *image, render_mips_kind kind)
{
	STILB_ASSERT(image->channels == 4);
	if (kind == RENDER_MIPS_MEANS)
		return;
	size_t texels = (size_t)image->width * image->height, size = stilb_image_size(image) / texels / 4;
	uint16_t half = stilb_image_half_from_float(1.0f), most = UINT16_MAX;
	float one = 1.0f;
	const void *value = image->format == STILB_IMAGE_F32_LINEAR   ? (const void *)&one
	                    : image->format == STILB_IMAGE_F16_LINEAR ? (const void *)&half
	                                                              : &most; /* of 8 bits its first byte */
	uint8_t *out = (uint8_t *)image->pixels + mips_spread_channel(kind) * size;
	for (size_t i = 0; i < texels; i++, out += 4 * size)
		memcpy(out, value, size);
}
