/*
 * image: pictures in memory, and as PNG, EXR and Radiance HDR files.
 *
 * A picture is rows of pixels, top row first, each pixel `channels` values one after the other, nothing in between.
 * Channels: 1 grey, 2 grey and alpha, 3 red green blue, 4 with alpha. Alpha is linear in every format and colour is
 * stored as given: nothing is multiplied or divided by alpha.
 *
 * PNG is 8 bits of sRGB; EXR and HDR are linear Rec.709 and never tone mapped; saving converts between the two as
 * needed. Files are written whole or not at all, and the same picture gives the same bytes (no date, no host name). PNG
 * goes through libpng, EXR through OpenEXR, HDR through code of our own; OpenImageIO, which reads all other formats, is
 * loaded with the first such picture.
 *
 * Life cycle.  stilb_image_create or stilb_image_load -> stilb_image_save -> stilb_image_finish.
 * Threads.     [one-writer] per picture: any thread may work on a picture that no other thread writes to.
 * Errors.      Refused names, sizes and formats are STILB_ERROR_ARGUMENT, trouble while reading or writing
 *              STILB_ERROR_FILE; every message names the file.
 */
#ifndef STILB_IMAGE_H
#define STILB_IMAGE_H

#include "base/base.h"

#define STILB_IMAGE_MAX_SIDE 65536u        /* pixels */
#define STILB_IMAGE_MAX_BYTES (1ull << 32) /* 16384 x 16384 x 4 floats */

typedef enum stilb_image_format {
	STILB_IMAGE_U8_SRGB,    /* uint8_t codes, IEC 61966-2-1 */
	STILB_IMAGE_F16_LINEAR, /* IEEE binary16 in uint16_t */
	STILB_IMAGE_F32_LINEAR, /* float */
	STILB_IMAGE_U16_SRGB,   /* uint16_t codes, the same transfer with 65535 as 1 */
} stilb_image_format;

typedef struct stilb_image {
	uint32_t width, height, channels;
	stilb_image_format format;
	void *pixels;     /* [height][width][channels]; 64-byte aligned */
	uint32_t storage; /* how pixels are held and given back: 0 is memory of stilb_memory_alloc; others are image.c's */
} stilb_image;

/* A black picture (alpha 0 too). Width and height 1..STILB_IMAGE_MAX_SIDE, channels 1..4, at most
 * STILB_IMAGE_MAX_BYTES. [any-thread] STILB_ERROR_ARGUMENT, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_create(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                stilb_image_format format);

/* Frees the pixels and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_image_finish(stilb_image *image);

/* As stilb_image_create, in memory that stilb_image_share can hand to another process. */
stilb_result stilb_image_create_shared(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format);

/* Takes a picture of stilb_image_create_shared out of this process: leaves {0} and returns a descriptor of its pixels,
 * which nobody can change or cut off any more, for the caller to send and close; or -1 with a message. [one-writer] */
int stilb_image_share(stilb_image *image);

/* The picture of this shape behind such a descriptor, from any process, trusted or not: one of another size or that can
 * still be changed is STILB_ERROR_FILE. file may be closed afterwards. Its pixels are this process's own to change.
 * [any-thread] STILB_ERROR_ARGUMENT for a shape that is refused, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_map(int file, uint32_t width, uint32_t height, uint32_t channels, stilb_image_format format,
                             stilb_image *image);

/* Row y as linear floats, [width][channels]; alpha as it is. [any-thread] */
void stilb_image_row_to_light(const stilb_image *image, uint32_t y, float *light);

/* Bytes of all pixels. [any-thread] */
size_t stilb_image_size(const stilb_image *image);

/* STILB_ERROR_ARGUMENT when no picture can be saved as path: an extension other than .png, .exr and .hdr (capitals
 * count as small letters), a missing folder, a directory, no permission. To be asked before the work starts; writes
 * nothing. [any-thread] */
stilb_result stilb_image_path_check(const char *path);

/* Does a picture saved as path keep linear light (.exr, .hdr), not codes for a display? False for an extension that
 * cannot be saved. [any-thread] */
bool stilb_image_path_is_light(const char *path);

/* Writes path: .png as 8 bits of sRGB, .exr as 32-bit floats from F32_LINEAR and as 16-bit floats from the rest, .hdr
 * as 8 bits a channel with one exponent for the three (grey becomes RGB; a picture with alpha is STILB_ERROR_FILE).
 * Linear values become codes by the sRGB transfer, clamped to [0, 1] and rounded to the nearest; NaN becomes 0.
 * [any-thread] STILB_ERROR_ARGUMENT as stilb_image_path_check, STILB_ERROR_FILE (disk full), STILB_ERROR_MEMORY. */
stilb_result stilb_image_save(const stilb_image *image, const char *path);

/* Reads path: .png into U8_SRGB (16-bit files are rounded to 8), .hdr and .exr into F32_LINEAR; of an .exr the first
 * part, up to 4 channels, or R G B (A) of one with more (image_layers.h reads all).
 * [any-thread] STILB_ERROR_ARGUMENT for an unknown extension, STILB_ERROR_FILE for a file that is missing, damaged or
 * of a kind or size that is not supported, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_load(const char *path, stilb_image *image);

#endif
