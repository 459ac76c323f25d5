/* image_exr: reads and writes EXR files with any channels, for image_codec_exr (pictures of up to four channels) and
 * image_layers. A C interface, implemented in C++. [any-thread] */
#ifndef STILB_IMAGE_EXR_H
#define STILB_IMAGE_EXR_H

#include "image/image_internal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A channel to be written. */
typedef struct image_exr_channel {
	const char *name;
	const void *first;           /* value of the top left pixel */
	size_t pixel_step, row_step; /* bytes from one value to the next, and from one row to the next */
} image_exr_channel;

typedef struct image_exr_file {
	uint32_t width, height, channel_count, attribute_count;
	const image_exr_channel *channels; /* [channel_count], of different names, in any order */
	const stilb_image_attribute *attributes;
	image_scalar scalar, stored; /* type of the values in memory, and in the file: F16 or F32 */
} image_exr_file;

/* Appends the encoded file, zip compressed. The same input gives the same bytes. */
image_outcome image_exr_encode(const image_exr_file *from, image_bytes *file, image_message *message);

/* Receives a decoded file. create returns the memory for [height][width][channels] floats, or NULL to refuse; then
 * follow the channels' names, in the order of the floats, and the text attributes. Strings are valid during the call
 * only. channel and attribute return false if they are out of memory. */
typedef struct image_exr_sink {
	void *context;
	float *(*create)(void *context, uint32_t width, uint32_t height, uint32_t channels);
	bool (*channel)(void *context, const char *name);
	bool (*attribute)(void *context, const char *name, const char *text);
} image_exr_sink;

/* Decodes the file's first part. Order of channels: those without a layer (no dot in the name) first, then layer by
 * layer; in a layer R G B (X Y Z) A, then the others by name. */
image_outcome image_exr_decode(const void *data, size_t size, const image_exr_sink *sink, image_message *message);

#ifdef __cplusplus
}
#endif

#endif
