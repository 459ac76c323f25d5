/* Textures of what is baked: linear light, with smaller copies. */
#include "geometry/geometry_impostor_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Number of levels and their sides; returns the texels of all together. */
static size_t texture_measure(impostor_texture *texture)
{
	uint32_t width = texture->image->width, height = texture->image->height;
	size_t texels = 0;
	for (uint32_t level = 0;; level++) {
		STILB_ASSERT(level < IMPOSTOR_MAX_LEVELS);
		texture->width[level] = width;
		texture->height[level] = height;
		texels += (size_t)width * height;
		texture->level_count = level + 1;
		if (width == 1 && height == 1)
			return texels;
		width = width > 1 ? width / 2 : 1;
		height = height > 1 ? height / 2 : 1;
	}
}

/* Row y of the image as red, green and blue; grey becomes three equal ones. row: room for 4 floats a pixel. */
static void texture_read_row(const stilb_image *image, uint32_t y, float *row, float *out)
{
	uint32_t channels = image->channels;
	stilb_image_row_to_light(image, y, row);
	for (uint32_t x = 0; x < image->width; x++)
		for (uint32_t c = 0; c < 3; c++)
			out[3 * x + c] = row[channels * x + (channels < 3 ? 0 : c)];
}

/* Each texel is the mean of the up to four that it covers of the level before; of odd sides the last row or column is
 * left out. */
static void texture_halve(impostor_texture *texture, uint32_t level)
{
	uint32_t width = texture->width[level], from_width = texture->width[level - 1];
	uint32_t right = from_width > 1 ? 1 : 0, below = texture->height[level - 1] > 1 ? 1 : 0;
	const float *from = texture->texels[level - 1];
	for (uint32_t y = 0; y < texture->height[level]; y++)
		for (uint32_t x = 0; x < width; x++) {
			size_t x0 = (size_t)x << right, upper = ((size_t)y << below) * from_width;
			size_t lower = upper + (below ? from_width : 0);
			for (size_t c = 0; c < 3; c++)
				texture->texels[level][3 * ((size_t)y * width + x) + c] =
					0.25f * (from[3 * (upper + x0) + c] + from[3 * (upper + x0 + right) + c] +
				             from[3 * (lower + x0) + c] + from[3 * (lower + x0 + right) + c]);
		}
}

stilb_result geometry_impostor_texture_make(const stilb_image *image, impostor_texture *texture)
{
	*texture = (impostor_texture){.image = image};
	size_t texels = texture_measure(texture);
	float *row = stilb_memory_alloc(image->width, 4 * sizeof *row);
	float *all = stilb_memory_alloc(texels, 3 * sizeof *all);
	if (!row || !all) {
		free(row);
		free(all);
		*texture = (impostor_texture){0};
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a texture of %ux%u texels", image->width, image->height);
	}
	for (uint32_t level = 0; level < texture->level_count; level++) {
		texture->texels[level] = all;
		all += 3 * (size_t)texture->width[level] * texture->height[level];
	}
	for (uint32_t y = 0; y < image->height; y++)
		texture_read_row(image, y, row, texture->texels[0] + 3 * (size_t)y * image->width);
	free(row);
	for (uint32_t level = 1; level < texture->level_count; level++)
		texture_halve(texture, level);
	return STILB_OK;
}

void geometry_impostor_texture_finish(impostor_texture *texture)
{
	free(texture->texels[0]);
	*texture = (impostor_texture){0};
}

/* The texel left of or above a coordinate in [0, 1), its neighbour, and the share of the neighbour. */
static void texture_axis(float at, uint32_t side, uint32_t *low, uint32_t *high, float *share)
{
	float x = (at - floorf(at)) * (float)side - 0.5f, whole = floorf(x);
	*share = x - whole;
	*low = whole < 0.0f ? side - 1 : (uint32_t)whole % side;
	*high = (*low + 1) % side;
}

stilb_vec3 geometry_impostor_texture_at(const impostor_texture *texture, const float uv[2], float level)
{
	float last = (float)(texture->level_count - 1);
	uint32_t l = level > 0.0f ? (uint32_t)((level < last ? level : last) + 0.5f) : 0;
	uint32_t left, right, upper, lower, width = texture->width[l];
	float x, y;
	texture_axis(uv[0], width, &left, &right, &x);
	texture_axis(uv[1], texture->height[l], &upper, &lower, &y);
	const float *texels = texture->texels[l];
	const float *a = texels + 3 * ((size_t)upper * width + left), *b = texels + 3 * ((size_t)upper * width + right);
	const float *c = texels + 3 * ((size_t)lower * width + left), *d = texels + 3 * ((size_t)lower * width + right);
	stilb_vec3 color = {0};
	for (int i = 0; i < 3; i++)
		color[i] = (a[i] * (1.0f - x) + b[i] * x) * (1.0f - y) + (c[i] * (1.0f - x) + d[i] * x) * y;
	return color;
}
