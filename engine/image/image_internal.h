/*
 * image_internal: what the files of image/ share: the table of file formats, and the border to OpenImageIO.
 *
 * PNG (libpng), EXR (OpenEXR) and Radiance HDR (our own reader and writer) are codecs of this library. Every other
 * format is read by OpenImageIO, which brings some 260 shared libraries and 0.5 GB of addresses along; it stands behind
 * image_oiio.cpp, a module that image_foreign.c loads with the first picture of such a format.
 */
#ifndef STILB_IMAGE_INTERNAL_H
#define STILB_IMAGE_INTERNAL_H

#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum image_scalar {
	IMAGE_SCALAR_U8, /* sRGB codes, alpha linear */
	IMAGE_SCALAR_F16,
	IMAGE_SCALAR_F32,
	IMAGE_SCALAR_U16, /* as U8 */
} image_scalar;

/* Pixels without a gap: [height][width][channels], the top row first. */
typedef struct image_shape {
	uint32_t width, height, channels;
	image_scalar scalar;
} image_shape;

typedef struct image_message {
	char text[512]; /* one line, without the file's name */
} image_message;

typedef enum image_outcome {
	IMAGE_OUTCOME_DONE,
	IMAGE_OUTCOME_CALLBACK, /* allocate refused and knows why */
	IMAGE_OUTCOME_CODEC,    /* message says why */
	IMAGE_OUTCOME_MEMORY,
} image_outcome;

/* A file that is made in memory. Begins as {0}; the owner frees data. */
typedef struct image_bytes {
	unsigned char *data;
	size_t size, room;
} image_bytes;

/* Writes size bytes at offset, which may lie at or before the end; false: out of memory. */
bool image_bytes_write(image_bytes *bytes, size_t offset, const void *data, size_t size);

/* Returns the memory for a picture of this shape, or NULL to refuse it. The scalar is the file's own; allocate may
 * change it from U16 to U8 and from F16 to F32, and the codec then converts. A codec asks as soon as it has read the
 * header and before it takes memory that grows with the picture. */
typedef void *image_allocate(void *context, image_shape *shape);

/* A file format of this library. [any-thread] Neither function prints. */
typedef struct image_codec {
	const char *extension; /* ".png" */
	bool codes;            /* holds sRGB codes (scalar U8), not linear light (F32) */

	/* Encodes pixels of U8 (codes) or of F16 or F32 (light) to the end of file. `stored` is what light is stored as;
	 * formats without a choice ignore it. */
	image_outcome (*encode)(const image_shape *shape, const void *pixels, image_scalar stored, image_bytes *file,
	                        image_message *message);

	/* Decodes a file into what allocate returns: U8 or U16, F16 or F32, as codes says. */
	image_outcome (*decode)(const void *data, size_t size, image_allocate *allocate, void *context,
	                        image_message *message);
} image_codec;

extern const image_codec image_codec_png, image_codec_exr, image_codec_hdr;

/* Sets message to text up to its first line's end. */
void image_message_set(image_message *message, const char *text);

/* ---- pictures in memory (image.c) -------------------------------------------------------------------------------- */

extern const size_t image_scalar_bytes[];         /* indexed by image_scalar */
extern const image_scalar image_format_scalars[]; /* indexed by stilb_image_format */

/* Why a picture of this shape is refused, or NULL. */
const char *image_refusal(const stilb_image *image);

/* ---- files (image_file.c) ---------------------------------------------------------------------------------------- */

/* The whole file into memory, to be freed also after a failure. NULL, or why not. Only regular files: devices and pipes
 * may have no end. */
const char *image_file_read(const char *path, void **data, size_t *size);

/* A picture that is being read; the context of image_load_allocate. */
typedef struct image_load {
	const char *path;    /* what messages call it */
	stilb_image *image;  /* {0} at first */
	stilb_result result; /* why image_load_allocate refused */
	bool exact;          /* 16 bits stay 16 bits, and halves halves */
	bool shared;         /* pixels as of stilb_image_create_shared */
	bool for_light;      /* there must be room for three floats a pixel, too */
} image_load;

/* image_allocate. Pixels stay untouched until they are decoded: a short file that claims to be huge costs address space
 * only. */
void *image_load_allocate(void *context, image_shape *shape);

/* The result of reading, with its message; leaves {0} in the picture unless all went well. */
stilb_result image_load_end(image_load *load, image_outcome outcome, const image_message *message);

/* STILB_ERROR_MEMORY or STILB_ERROR_FILE with "cannot <verb> '<path>': ..."; outcome is MEMORY or CODEC. */
stilb_result image_fail(image_outcome outcome, const char *verb, const char *path, const image_message *message);

/* ---- other formats ----------------------------------------------------------------------------------------------- */

/* What the module with OpenImageIO offers, as the symbol IMAGE_FOREIGN_SYMBOL. */
typedef struct image_foreign {
	/* Decodes data, a file of the format that OpenImageIO calls `format`, into what allocate returns. */
	image_outcome (*decode)(const char *format, const void *data, size_t size, image_allocate *allocate, void *context,
	                        image_message *message);
	/* "2.4.7": of the library that is loaded. */
	const char *(*version)(void);
} image_foreign;

#define IMAGE_FOREIGN_FILE "stilb-image-oiio.so"
#define IMAGE_FOREIGN_SYMBOL "image_foreign_oiio"

/* Loads the module at the first call; NULL with a message when it cannot be loaded. [any-thread] */
const image_foreign *image_foreign_load(image_message *message);

#ifdef __cplusplus
}
#endif

#endif
