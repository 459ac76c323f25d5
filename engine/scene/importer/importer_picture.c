/* Decodes pictures into memory that can be shared, and converts them to linear light. */
#include "scene/importer/importer.h"

#include "image/image_import.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* True if these are the first bytes of a KTX 2 file, of which no library of Debian's reads the Basis textures. */
static bool picture_is_ktx(const importer_bytes *bytes)
{
	static const unsigned char first[] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};
	return bytes->size >= sizeof first && memcmp(bytes->data, first, sizeof first) == 0;
}

stilb_result importer_decode(const char *name, const importer_bytes *bytes, uint32_t flags, stilb_image *image)
{
	STILB_ASSERT(bytes->data);
	if (picture_is_ktx(bytes)) {
		*image = (stilb_image){0};
		return stilb_fail(STILB_ERROR_FILE, "it is KTX2, which is not read: convert it with "
		                                    "'ktx extract --transcode rgba8 IN.ktx2 OUT.png' and name the PNG instead");
	}
	stilb_result result =
		stilb_image_import_memory(name, bytes->data, bytes->size, flags | STILB_IMAGE_IMPORT_SHARED, image);
	if (result == STILB_OK)
		return result;
	/* The message is "cannot read '<name>': <reason>"; the caller adds the name itself. */
	char reason[400];
	const char *said = strstr(stilb_error_message(), "': ");
	snprintf(reason, sizeof reason, "%s", said ? said + 3 : stilb_error_message());
	return stilb_fail(result, "%s", reason);
}

/* Converts pixels to RGB; of one or two channels the first is grey. NaN, infinite and negative values become 0. */
static void picture_take_light(const float *light, uint32_t channels, size_t pixels, float *rgb)
{
	for (size_t p = 0; p < pixels; p++)
		for (uint32_t i = 0; i < 3; i++) {
			float value = light[p * channels + (channels < 3 ? 0 : i)];
			rgb[3 * p + i] = value > 0.0f && value < INFINITY ? value : 0.0f;
		}
}

stilb_result importer_picture_to_light(stilb_image *image)
{
	STILB_ASSERT(image->pixels);
	stilb_image rgb;
	size_t row = (size_t)image->width * image->channels;
	float *light = malloc(row * sizeof *light);
	stilb_result result = stilb_image_create_shared(&rgb, image->width, image->height, 3, STILB_IMAGE_F32_LINEAR);
	if (result == STILB_OK && !light)
		result = stilb_fail(STILB_ERROR_MEMORY, "out of memory");
	for (uint32_t y = 0; result == STILB_OK && y < image->height; y++) {
		stilb_image_row_to_light(image, y, light);
		picture_take_light(light, image->channels, image->width, (float *)rgb.pixels + (size_t)y * image->width * 3);
	}
	free(light);
	stilb_image_finish(image);
	if (result == STILB_OK)
		*image = rgb;
	else
		stilb_image_finish(&rgb);
	return result;
}
