/*
 * image_internal: the border between image.c and OpenImageIO, plain C on both sides. Behind it is image_oiio.cpp, the
 * engine's only C++; no exception leaves it.
 *
 * OpenImageIO brings some 260 shared libraries along, 0.17 s of every start. So image_oiio.cpp is a module of its own,
 * stilb-image-oiio.so, which image_codec.c loads when the first picture is read or written.
 */
#ifndef STILB_IMAGE_INTERNAL_H
#define STILB_IMAGE_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct stilb_image_layers;

#ifdef __cplusplus
extern "C" {
#endif

/* The library's name of a file format. */
#define IMAGE_CODEC_PNG "png"
#define IMAGE_CODEC_EXR "openexr"
#define IMAGE_CODEC_HDR "hdr"

typedef enum image_scalar {
	IMAGE_SCALAR_U8,
	IMAGE_SCALAR_F16,
	IMAGE_SCALAR_F32,
} image_scalar;

/* Pixels without a gap: [height][width][channels]. */
typedef struct image_shape {
	uint32_t width, height, channels;
	image_scalar scalar;
} image_shape;

typedef struct image_message {
	char text[512];
} image_message;

/* Takes the whole file. Returns 0, or anything else for failure. */
typedef int image_sink(void *context, const void *data, size_t size);

/* Returns the memory for a picture of this shape, or NULL to refuse it. */
typedef void *image_allocate(void *context, const image_shape *shape);

/* Who takes a picture of many channels. create returns the memory for [height][width][channels] floats, or NULL to refuse;
 * then follow the channels' names, in order, and the attributes; both texts are gone afterwards. False: no memory. */
typedef struct image_layers_sink {
	void *context;
	float *(*create)(void *context, uint32_t width, uint32_t height, uint32_t channels);
	bool (*channel)(void *context, const char *name);
	bool (*attribute)(void *context, const char *name, const char *text);
} image_layers_sink;

typedef enum image_outcome {
	IMAGE_OUTCOME_DONE,
	IMAGE_OUTCOME_CALLBACK, /* the sink or allocate failed and knows why */
	IMAGE_OUTCOME_CODEC,    /* message says why */
	IMAGE_OUTCOME_MEMORY,
} image_outcome;

/* What the module offers, as the symbol IMAGE_CODEC_SYMBOL. */
typedef struct image_codec {
	/* Encodes into memory; the file holds `stored` scalars. codec is IMAGE_CODEC_... */
	image_outcome (*encode)(const char *codec, const image_shape *shape, const void *pixels, image_scalar stored,
	                        image_sink *sink, void *context, image_message *message);
	/* Decodes data into what allocate returns, converted to `wanted` scalars. */
	image_outcome (*decode)(const char *codec, const void *data, size_t size, image_scalar wanted,
	                        image_allocate *allocate, void *context, image_message *message);
	/* The same for pictures of many channels, all floats, as EXR. */
	image_outcome (*encode_layers)(const struct stilb_image_layers *layers, image_sink *sink, void *context,
	                               image_message *message);
	image_outcome (*decode_layers)(const void *data, size_t size, const image_layers_sink *sink,
	                               image_message *message);
	/* "2.4.7": of the library that is loaded. */
	const char *(*version)(void);
} image_codec;

#define IMAGE_CODEC_FILE "stilb-image-oiio.so"
#define IMAGE_CODEC_SYMBOL "image_codec_oiio"

/* The loaded module; NULL with a message when it cannot be loaded. [any-thread] */
const image_codec *image_codec_load(image_message *message);

/* The whole file into memory, to be freed also after a failure. NULL, or why not. Only regular files: devices and pipes may
 * have no end. */
const char *image_file_read(const char *path, void **data, size_t *size);

/* False with a message when data is not a PNG file whose chunks are all there with the right checksums. Asked before
 * decoding, because libpng prints its own lines on stderr about such files. Source: ISO/IEC 15948 (PNG), chapter 5. */
bool image_png_is_whole(const void *data, size_t size, image_message *message);

#ifdef __cplusplus
}
#endif

#endif
