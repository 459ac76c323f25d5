#include "gi/gi_texture.h"

#include "shading/shade_srgb.h"

/* A float from the bits of a half (IEEE binary16). */
static float texture_half(uint16_t half)
{
	uint32_t exponent = half >> 10 & 31, mantissa = half & 1023;
	float value;
	if (exponent == 31)
		value = mantissa ? NAN : INFINITY;
	else if (exponent == 0)
		value = ldexpf((float)mantissa, -24);
	else
		value = ldexpf((float)(mantissa + 1024), (int)exponent - 25);
	return half & 0x8000 ? -value : value;
}

static float texture_scalar(const stilb_image *image, size_t at)
{
	switch (image->format) {
	case STILB_IMAGE_U8_SRGB:
		return shade_srgb_to_linear((float)((const uint8_t *)image->pixels)[at] * (1.0f / 255.0f));
	case STILB_IMAGE_F16_LINEAR:
		return texture_half(((const uint16_t *)image->pixels)[at]);
	case STILB_IMAGE_U16_SRGB:
		return shade_srgb_to_linear((float)((const uint16_t *)image->pixels)[at] * (1.0f / 65535.0f));
	case STILB_IMAGE_U8_LINEAR:
		return (float)((const uint8_t *)image->pixels)[at] * (1.0f / 255.0f);
	case STILB_IMAGE_U16_LINEAR:
		return (float)((const uint16_t *)image->pixels)[at] * (1.0f / 65535.0f);
	default:
		STILB_ASSERT(image->format == STILB_IMAGE_F32_LINEAR && "scenes have no textures of blocks");
		return ((const float *)image->pixels)[at];
	}
}

static stilb_vec3 texture_texel(const stilb_image *image, uint32_t x, uint32_t y)
{
	STILB_ASSERT(x < image->width && y < image->height);
	size_t at = ((size_t)y * image->width + x) * image->channels;
	float red = texture_scalar(image, at);
	if (image->channels < 3)
		return stilb_vec3_make(red, red, red);
	return stilb_vec3_make(red, texture_scalar(image, at + 1), texture_scalar(image, at + 2));
}

/* For linear interpolation along one side of `size` texels: returns the index of the last texel whose centre is not
 * beyond the coordinate (0 to 1 is the whole side; it repeats), and in *fraction how far beyond it is, in texels,
 * [0, 1). */
static uint32_t texture_place(float coordinate, uint32_t size, float *fraction)
{
	STILB_ASSERT(size > 0);
	coordinate -= floorf(coordinate);
	if (!(coordinate >= 0.0f && coordinate < 1.0f))
		coordinate = 0.0f;
	float place = coordinate * (float)size - 0.5f, whole = floorf(place);
	*fraction = place - whole;
	return whole < 0.0f ? size - 1 : (uint32_t)whole % size;
}

stilb_vec3 gi_texture_at(const stilb_image *image, stilb_vec2 uv)
{
	if (!image->pixels)
		return stilb_vec3_make(1.0f, 1.0f, 1.0f);
	STILB_ASSERT(image->channels >= 1 && image->channels <= 4);
	float across, down;
	uint32_t x = texture_place(uv[0], image->width, &across), y = texture_place(uv[1], image->height, &down);
	uint32_t next_x = (x + 1) % image->width, next_y = (y + 1) % image->height;
	stilb_vec3 above = texture_texel(image, x, y) * (1.0f - across) + texture_texel(image, next_x, y) * across;
	stilb_vec3 below =
		texture_texel(image, x, next_y) * (1.0f - across) + texture_texel(image, next_x, next_y) * across;
	return above * (1.0f - down) + below * down;
}
