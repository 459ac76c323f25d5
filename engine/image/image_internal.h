/*
 * image_internal: shared by the files of image/: codecs of file formats, and the module with OpenImageIO.
 *
 * PNG (libpng), EXR (OpenEXR) and Radiance HDR (our own reader and writer) are codecs of this library, and most DDS
 * files are read by it (image_dds.c). Every other format is read by OpenImageIO, which loads some 260 shared libraries
 * and needs 0.5 GB of address space. So it is linked into a module of its own (image_oiio.cpp), which image_foreign.c
 * loads with the first picture of such a format.
 */
#ifndef STILB_IMAGE_INTERNAL_H
#define STILB_IMAGE_INTERNAL_H

#include "image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum image_scalar {
	IMAGE_SCALAR_U8, /* codes of colour or data; a file's are taken for sRGB, alpha linear */
	IMAGE_SCALAR_F16,
	IMAGE_SCALAR_F32,
	IMAGE_SCALAR_U16, /* as U8 */
} image_scalar;

/* Pixels without gaps: [height][width][channels], the top row first. */
typedef struct image_shape {
	uint32_t width, height, channels;
	image_scalar scalar;
} image_shape;

/* What a codec encodes. */
typedef struct image_input {
	image_shape shape;
	image_scalar stored; /* F16 or F32: the type of light in the file; ignored by formats without a choice */
	const void *pixels;  /* U8 if the codec has codes, else F16 or F32 */
	uint32_t attribute_count;
	const stilb_image_attribute *attributes;
} image_input;

typedef struct image_message {
	char text[512]; /* one line, without the file's name */
} image_message;

typedef enum image_outcome {
	IMAGE_OUTCOME_DONE,
	IMAGE_OUTCOME_CALLBACK, /* allocate refused; its context holds the reason */
	IMAGE_OUTCOME_CODEC,    /* damaged or not supported; message says why */
	IMAGE_OUTCOME_MEMORY,
} image_outcome;

/* A file in memory that grows while it is written. Begins as {0}; the owner frees data. */
typedef struct image_bytes {
	unsigned char *data;
	size_t size, capacity;
} image_bytes;

/* Writes size bytes at offset, which is at most bytes->size: over old bytes, behind them or both. False: out of
 * memory. */
bool image_bytes_write(image_bytes *bytes, size_t offset, const void *data, size_t size);

/* Returns the memory for a picture of this shape, or NULL to refuse it. The scalar is the file's own; allocate may
 * change it from U16 to U8 and from F16 to F32, and the codec then converts. A codec calls it once, right after reading
 * the header and before it allocates memory in proportion to the picture. */
typedef void *image_allocate(void *context, image_shape *shape);

/* A file format of this library. [any-thread] Neither function prints. */
typedef struct image_codec {
	const char *extension; /* ".png" */
	bool codes;            /* holds sRGB codes (scalar U8), not linear light (F32) */

	/* Appends the encoded picture to file. */
	image_outcome (*encode)(const image_input *input, image_bytes *file, image_message *message);

	/* Decodes a file of size bytes into the memory that allocate returns: U8 or U16 if codes is set, else F16 or
	 * F32. */
	image_outcome (*decode)(const void *data, size_t size, image_allocate *allocate, void *context,
	                        image_message *message);
} image_codec;

extern const image_codec image_codec_png, image_codec_exr, image_codec_hdr;

/* Sets message to the first line of text. */
void image_message_set(image_message *message, const char *text);

/* ---- pictures in memory (image.c) -------------------------------------------------------------------------------- */

extern const size_t image_scalar_bytes[];         /* indexed by image_scalar */
extern const image_scalar image_format_scalars[]; /* indexed by stilb_image_format */

/* The reason why a picture of this shape is refused, or NULL. Does not look at the pixels. */
const char *image_refusal(const stilb_image *image);

/* True if image has pixels and a shape that is not refused. For asserts. */
bool image_is_sound(const stilb_image *image);

#define IMAGE_MAX_LEVELS 17u /* of a picture of STILB_IMAGE_MAX_SIDE */

/* How many levels a picture of these sides can have. */
uint32_t image_most_levels(uint32_t width, uint32_t height);

/* Bytes of so many levels of a picture of image's shape, which is not refused. */
uint64_t image_levels_size(const stilb_image *image, uint32_t levels);

/* Allocates pixels for image, which has a shape that is not refused, with so many levels. False: out of memory. */
bool image_levels_allocate(stilb_image *image, uint32_t levels);

/* The picture as 8-bit codes, as stilb_image_save writes them into a .png: its own pixels, or new ones, which *made, to
 * be freed, points to; else *made is NULL. NULL: out of memory. */
const uint8_t *image_codes(const stilb_image *image, void **made);

/* ---- files (image_file.c) ---------------------------------------------------------------------------------------- */

/* Reads a whole regular file into *data, to be freed by the caller also after a failure; *data is NULL before. Returns
 * NULL, or the reason of the failure. Devices and pipes, which may have no end, are refused. */
const char *image_file_read(const char *path, void **data, size_t *size);

/* A picture that is being read; the context of image_load_allocate. */
typedef struct image_load {
	const char *path;    /* its name in messages */
	stilb_image *image;  /* {0} at first */
	stilb_image memory;  /* a picture whose memory the new one gets, if shared is set and it is large enough; or {0} */
	stilb_result result; /* why image_load_allocate refused */
	bool exact;          /* keep 16-bit codes and halves; else they become 8 bits and floats */
	bool shared;         /* allocate by stilb_image_create_shared */
	bool for_light;      /* also refuse a picture that would be too large as three floats a pixel */
	bool blocks;         /* of DDS keep the format and the levels; else decode to codes of colour */
} image_load;

/* image.c: allocates the picture, which has a shape and no pixels, with so many levels, into load->image. NULL with
 * load->result: refused. A codec calls it once. */
void *image_load_make(image_load *load, stilb_image made, uint32_t levels);

/* An image_allocate. Does not touch the pixels: a short file that claims to be huge costs address space only. */
void *image_load_allocate(void *context, image_shape *shape);

/* The result of reading, with its message. Unless it is STILB_OK the picture is finished and {0}. */
stilb_result image_load_end(image_load *load, image_outcome outcome, const image_message *message);

/* Fails with "cannot <verb> '<path>': <reason>": STILB_ERROR_MEMORY for outcome MEMORY, STILB_ERROR_FILE with the
 * message for outcome CODEC; there are no others. */
stilb_result image_fail(image_outcome outcome, const char *verb, const char *path, const image_message *message);

/* ---- DDS (image_dds.c) ------------------------------------------------------------------------------------------- */

/* False for a DDS file with pixels of a kind that image_dds_decode does not know, as BC2 and floats. */
bool image_dds_is_known(const void *data, size_t size);

/* Decodes a DDS file of size bytes into load->image; as image_codec.decode. */
image_outcome image_dds_decode(const void *data, size_t size, image_load *load, image_message *message);

/* ---- other formats ----------------------------------------------------------------------------------------------- */

/* The functions of the module with OpenImageIO, which exports this struct as IMAGE_FOREIGN_SYMBOL. */
typedef struct image_foreign {
	/* As image_codec.decode; format is OpenImageIO's name of the file's format. */
	image_outcome (*decode)(const char *format, const void *data, size_t size, image_allocate *allocate, void *context,
	                        image_message *message);
	/* The version of the loaded library, "2.4.7". */
	const char *(*version)(void);
} image_foreign;

#define IMAGE_FOREIGN_FILE "stilb-image-oiio.so"
#define IMAGE_FOREIGN_SYMBOL "image_foreign_oiio"

/* Loads the module at the first call; NULL with a message if it cannot be loaded. [any-thread] */
const image_foreign *image_foreign_load(image_message *message);

#ifdef __cplusplus
}
#endif

#endif
