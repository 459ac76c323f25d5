#include "image/image.h"

#include "image/image_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const size_t image_scalar_bytes[] = {[IMAGE_SCALAR_U8] = 1, [IMAGE_SCALAR_F16] = 2, [IMAGE_SCALAR_F32] = 4};
const image_scalar image_format_scalars[] = {[STILB_IMAGE_U8_SRGB] = IMAGE_SCALAR_U8,
                                             [STILB_IMAGE_F16_LINEAR] = IMAGE_SCALAR_F16,
                                             [STILB_IMAGE_F32_LINEAR] = IMAGE_SCALAR_F32};

size_t stilb_image_size(const stilb_image *image)
{
	return (size_t)image->width * image->height * image->channels *
	       image_scalar_bytes[image_format_scalars[image->format]];
}

/* The sides are bounded first, so that the product cannot overflow. */
const char *image_refusal(const stilb_image *image)
{
	if (image->width < 1 || image->height < 1 || image->width > STILB_IMAGE_MAX_SIDE ||
	    image->height > STILB_IMAGE_MAX_SIDE)
		return "width and height must be 1 to 65536";
	if (image->channels < 1 || image->channels > 4)
		return "1 to 4 channels are supported";
	if ((unsigned)image->format > STILB_IMAGE_F32_LINEAR)
		return "unknown pixel format";
	if (stilb_image_size(image) > STILB_IMAGE_MAX_BYTES)
		return "its pixels would take more than 4 GiB";
	return NULL;
}

stilb_result stilb_image_create(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                stilb_image_format format)
{
	stilb_image made = {.width = width, .height = height, .channels = channels, .format = format};
	*image = (stilb_image){0};
	const char *refusal = image_refusal(&made);
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot make a picture of %u x %u pixels with %u channels: %s", width,
		                  height, channels, refusal);
	made.pixels = stilb_memory_alloc(stilb_image_size(&made), 1);
	if (!made.pixels)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a picture of %u x %u pixels", width, height);
	memset(made.pixels, 0, stilb_image_size(&made));
	*image = made;
	return STILB_OK;
}

void stilb_image_finish(stilb_image *image)
{
	if (!image)
		return;
	free(image->pixels);
	*image = (stilb_image){0};
}

/* ---- what the codecs share ------------------------------------------------------------------------------------------ */

void image_message_set(image_message *message, const char *text)
{
	snprintf(message->text, sizeof message->text, "%.*s", (int)strcspn(text, "\n"), text);
}

bool image_bytes_write(image_bytes *bytes, size_t offset, const void *data, size_t size)
{
	if (offset + size > bytes->room) {
		const size_t room = (offset + size) / 2 * 3 + 65536;
		unsigned char *grown = realloc(bytes->data, room);
		if (!grown)
			return false;
		bytes->data = grown;
		bytes->room = room;
	}
	memcpy(bytes->data + offset, data, size);
	if (offset + size > bytes->size)
		bytes->size = offset + size;
	return true;
}
