/* Makes of pictures what scenes can hold: values that are NaN or infinite become 0, and sides that are too long are
 * halved. */
#include "scene/importer/importer.h"

#include <stdlib.h>
#include <string.h>

#define MEND_SIDE 16384u /* of a scene's textures at most (scene_build.h) */

/* ---- values ------------------------------------------------------------------------------------------------------ */

uint64_t importer_mend_values(stilb_image *image)
{
	size_t count = (size_t)image->width * image->height * image->channels;
	uint64_t mended = 0;
	if (image->format == STILB_IMAGE_F32_LINEAR) {
		float *values = image->pixels;
		for (size_t i = 0; i < count; i++) {
			bool good = isfinite(values[i]);
			mended += !good;
			values[i] = good ? values[i] : 0.0f;
		}
	} else if (image->format == STILB_IMAGE_F16_LINEAR) {
		uint16_t *values = image->pixels;
		for (size_t i = 0; i < count; i++) {
			bool good = (values[i] & 0x7c00u) != 0x7c00u;
			mended += !good;
			values[i] = good ? values[i] : 0;
		}
	}
	return mended;
}

/* ---- sides ------------------------------------------------------------------------------------------------------- */

static float mend_half_mean(const uint16_t *const four[4])
{
	float sum = 0.0f;
	for (int i = 0; i < 4; i++)
		sum += stilb_image_half_to_float(*four[i]);
	return 0.25f * sum;
}

/* One value of the smaller picture: the mean of four values as they are stored. from: where the first value is. */
static void mend_mean(const stilb_image *image, const size_t from[4], size_t to, void *out)
{
	const uint8_t *bytes = image->pixels;
	const uint16_t *words = image->pixels;
	const float *floats = image->pixels;
	switch (image->format) {
	case STILB_IMAGE_F32_LINEAR:
		((float *)out)[to] =
			0.25f * floats[from[0]] + 0.25f * floats[from[1]] + 0.25f * floats[from[2]] + 0.25f * floats[from[3]];
		break;
	case STILB_IMAGE_F16_LINEAR:
		((uint16_t *)out)[to] = stilb_image_half_from_float(mend_half_mean(
			(const uint16_t *const[4]){&words[from[0]], &words[from[1]], &words[from[2]], &words[from[3]]}));
		break;
	case STILB_IMAGE_U16_SRGB:
	case STILB_IMAGE_U16_LINEAR:
		((uint16_t *)out)[to] =
			(uint16_t)(((uint32_t)words[from[0]] + words[from[1]] + words[from[2]] + words[from[3]] + 2u) / 4u);
		break;
	default:
		((uint8_t *)out)[to] =
			(uint8_t)(((uint32_t)bytes[from[0]] + bytes[from[1]] + bytes[from[2]] + bytes[from[3]] + 2u) / 4u);
		break;
	}
}

/* A picture of half the sides, each 1 at least. Of an odd number the last row or column goes. */
static stilb_result mend_halve(stilb_image *image)
{
	stilb_image small;
	uint32_t width = image->width > 1 ? image->width / 2 : 1, height = image->height > 1 ? image->height / 2 : 1;
	stilb_result result = stilb_image_create_shared(&small, width, height, image->channels, image->format);
	if (result != STILB_OK)
		return result;
	size_t right = image->width > 1 ? image->channels : 0;
	size_t row = (size_t)image->width * image->channels, down = image->height > 1 ? row : 0, to = 0;
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++)
			for (uint32_t c = 0; c < image->channels; c++) {
				size_t first = 2 * (size_t)y * row + 2 * (size_t)x * image->channels + c;
				const size_t from[4] = {first, first + right, first + down, first + right + down};
				mend_mean(image, from, to++, small.pixels);
			}
	stilb_image_finish(image);
	*image = small;
	return STILB_OK;
}

stilb_result importer_mend_sides(stilb_image *image)
{
	stilb_result result = STILB_OK;
	if ((image->width > MEND_SIDE || image->height > MEND_SIDE) && stilb_image_format_is_blocks(image->format)) {
		stilb_image texels;
		result = stilb_image_decode(image, &texels);
		stilb_image_finish(image);
		*image = result == STILB_OK ? texels : (stilb_image){0};
	}
	while (result == STILB_OK && (image->width > MEND_SIDE || image->height > MEND_SIDE))
		result = mend_halve(image);
	return result;
}
