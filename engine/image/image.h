/*
 * image: pictures in memory, and as PNG, EXR and Radiance HDR files.
 *
 * A picture is rows of pixels, top row first, each pixel `channels` values one after the other, without gaps.
 * Channels: 1 grey, 2 grey and alpha, 3 red green blue, 4 with alpha. Alpha is linear in every format, and colour is
 * not premultiplied: nothing here multiplies or divides by alpha.
 *
 * A picture of codes is colour or data: U8_SRGB holds codes of colour, U8_LINEAR numbers such as normals, roughness and
 * masks, which no transfer touches. Floats are what they are. No file tells which it holds, so reading takes codes for
 * colour; who knows better uses stilb_image_format_as_data.
 *
 * A picture may be made of compressed blocks of 4 x 4 texels, as GPUs read them, and have mip levels: pixels then holds
 * the rows of blocks of the largest level, behind them those of the next one, and so on (stilb_image_level).
 * stilb_image_decode makes texels of blocks; functions that take any format say so.
 *
 * PNG is 8 bits of sRGB; EXR and HDR are linear Rec.709 and never tone mapped; saving converts between the two. Files
 * are written whole or not at all, and the same picture gives the same bytes (no date, no host name). PNG goes through
 * libpng, EXR through OpenEXR, HDR through code of our own. Other formats, and files of unknown origin, are read by the
 * import process (image_import.h).
 *
 * Life cycle.  stilb_image_create or stilb_image_load -> stilb_image_save -> stilb_image_finish.
 *              stilb_image_row_to_light reads any format. A stilb_image may also be filled in by hand around pixels
 *              that somebody else owns, with storage 0: such a one is saved and read, but not finished.
 * Threads.     [one-writer] per picture: any thread may work on a picture that no other thread writes to.
 * Errors.      Refused names, sizes and formats are STILB_ERROR_ARGUMENT, trouble while reading or writing
 *              STILB_ERROR_FILE; every message names the file.
 * Example.     A picture as PNG:
 *
 *   stilb_image image;
 *   stilb_result result = stilb_image_create(&image, 640, 480, 3, STILB_IMAGE_F32_LINEAR);
 *   if (result == STILB_OK) {
 *       draw(image.pixels);
 *       result = stilb_image_save(&image, "out.png");
 *       stilb_image_finish(&image);
 *   }
 */
#ifndef STILB_IMAGE_H
#define STILB_IMAGE_H

#include "base/base.h"

#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_IMAGE_MAX_SIDE 65536u        /* pixels */
#define STILB_IMAGE_MAX_BYTES (1ull << 32) /* 16384 x 16384 x 4 floats */

/* SRGB: colour in codes that follow the sRGB transfer of IEC 61966-2-1; alpha is linear in all formats. Frame dumps
 * hold these numbers, so new ones come last. */
typedef enum stilb_image_format {
	STILB_IMAGE_U8_SRGB,    /* uint8_t codes, 255 is 1 */
	STILB_IMAGE_F16_LINEAR, /* IEEE binary16 in uint16_t */
	STILB_IMAGE_F32_LINEAR, /* float */
	STILB_IMAGE_U16_SRGB,   /* uint16_t codes, 65535 is 1 */
	STILB_IMAGE_U8_LINEAR,  /* data: uint8_t, code / 255 is the value */
	STILB_IMAGE_U16_LINEAR, /* data: uint16_t, code / 65535 is the value */
	STILB_IMAGE_BC1_SRGB,   /* blocks of 8 bytes, 4 channels, alpha 0 or 1; 8-bit codes */
	STILB_IMAGE_BC1_LINEAR,
	STILB_IMAGE_BC3_SRGB, /* blocks of 16 bytes, 4 channels, 8-bit codes */
	STILB_IMAGE_BC3_LINEAR,
	STILB_IMAGE_BC4_LINEAR, /* blocks of 8 bytes, 1 channel, data: finer than 8 bits */
	STILB_IMAGE_BC5_LINEAR, /* blocks of 16 bytes, 2 channels, data: finer than 8 bits */
	STILB_IMAGE_BC7_SRGB,   /* blocks of 16 bytes, 4 channels, 8-bit codes */
	STILB_IMAGE_BC7_LINEAR,
	STILB_IMAGE_FORMAT_COUNT
} stilb_image_format;

typedef struct stilb_image {
	uint32_t width, height, channels;
	stilb_image_format format;
	void *pixels; /* [height][width][channels], or rows of blocks; 64-byte aligned if allocated here */
	uint32_t
		storage; /* how finish frees pixels: 0 for memory of stilb_memory_alloc, of one level; others are private */
} stilb_image;

/* What a file says of its picture, as text of UTF-8: of the exposure, the camera, ... */
typedef struct stilb_image_attribute {
	const char *name, *text;
} stilb_image_attribute;

/* A black picture, alpha 0. Width and height 1..STILB_IMAGE_MAX_SIDE, channels 1..4, of blocks those of the format; at
 * most STILB_IMAGE_MAX_BYTES.
 * [any-thread] STILB_ERROR_ARGUMENT for any other shape, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_create(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                stilb_image_format format);

/* As stilb_image_create, with so many mip levels: 1 to as many as halve the longer side down to 1. [any-thread] */
stilb_result stilb_image_create_levels(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format, uint32_t levels);

/* A copy of all levels, in memory of its own; shared: as of stilb_image_create_shared. [any-thread]
 * STILB_ERROR_ARGUMENT for an empty picture and a shape that is refused, STILB_ERROR_MEMORY; then copy is {0}. */
stilb_result stilb_image_copy(const stilb_image *image, bool shared, stilb_image *copy);

/* Frees the pixels and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_image_finish(stilb_image *image);

/* As stilb_image_create, in memory that stilb_image_share or stilb_image_lend gives to another process. [any-thread] */
stilb_result stilb_image_create_shared(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format);

/* Gives image, a picture of stilb_image_create_shared or {0}, another shape. Its memory is kept if it is large enough,
 * and its pixels then have any values. Errors of stilb_image_create_shared; image is {0} then. [one-writer] */
stilb_result stilb_image_reshape_shared(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                        stilb_image_format format);

/* Hands over a picture of stilb_image_create_shared: unmaps its pixels, leaves {0}, and returns a descriptor of them,
 * sealed against writing and resizing by anybody, which the caller sends and closes. -1 with a message if it cannot be
 * sealed. The other process gets the memory itself, so nothing is copied, but the next picture needs new memory.
 * [one-writer] */
int stilb_image_share(stilb_image *image);

#define STILB_IMAGE_LEND_MAX (16u << 20) /* bytes of a picture */

/* Returns the descriptor of a picture of stilb_image_create_shared of at most STILB_IMAGE_LEND_MAX bytes, for another
 * process to copy by stilb_image_receive. It stays the picture's: when the other process has its copy, the memory can
 * be used again (stilb_image_reshape_shared), which takes a fifth of the time of new memory. [one-writer] */
int stilb_image_lend(const stilb_image *image);

/* Receives the picture of this shape, with so many levels, behind file, a descriptor (>= 0) of stilb_image_share or
 * stilb_image_lend, from any process, trusted or not; the caller still closes file. Afterwards nobody else can change
 * its pixels: those of stilb_image_share are mapped, and changing them changes nobody else's; those of stilb_image_lend
 * are copied. [any-thread] STILB_ERROR_FILE if the memory has another size, or is too large to be copied and not
 * sealed, STILB_ERROR_ARGUMENT for a shape that is refused, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_receive(int file, uint32_t width, uint32_t height, uint32_t channels,
                                 stilb_image_format format, uint32_t levels, stilb_image *image);

/* The format of the same bytes when they are data and not colour: U8_LINEAR for U8_SRGB, BC7_LINEAR for BC7_SRGB, ...;
 * any other format itself. For a picture that was read from a file:
 * image.format = stilb_image_format_as_data(image.format). [any-thread] */
stilb_image_format stilb_image_format_as_data(stilb_image_format format);

/* The other way round: the format of the same bytes when they are colour. BC4 and BC5 have none. [any-thread] */
stilb_image_format stilb_image_format_as_color(stilb_image_format format);

/* True for BC1 to BC7. [any-thread] */
bool stilb_image_format_is_blocks(stilb_image_format format);

/* How many channels a picture of this format of blocks has; 0: it is not one of blocks. [any-thread] */
uint32_t stilb_image_format_channels(stilb_image_format format);

/* How many mip levels the picture has: 1, but of stilb_image_create_levels and of DDS files. [any-thread] */
uint32_t stilb_image_level_count(const stilb_image *image);

/* Mip level `level`, below stilb_image_level_count: a view of image's pixels, not to be finished. Each level has half
 * the sides of the one before, rounded down, at least 1. [any-thread] */
stilb_image stilb_image_level(const stilb_image *image, uint32_t level);

/* A picture that was filled in by hand (storage 0) with so many levels, which its pixels hold one behind the other; not
 * to be finished. [any-thread] */
stilb_image stilb_image_view_levels(const stilb_image *image, uint32_t levels);

/* Bytes of the pixels of all levels; 0 for {0}. [any-thread] */
uint64_t stilb_image_levels_size(const stilb_image *image);

/* Makes texels, to be finished, of the largest level: of blocks U8_SRGB or U8_LINEAR, of BC4 and BC5 U16_LINEAR, each
 * value rounded to the nearest code, halves up; other formats are copied. [any-thread] STILB_ERROR_ARGUMENT for an
 * empty picture, a shape that is refused, and texels that would take more than STILB_IMAGE_MAX_BYTES;
 * STILB_ERROR_MEMORY. Then texels is {0}. */
stilb_result stilb_image_decode(const stilb_image *image, stilb_image *texels);

/* The same for rows first .. end - 1 of a picture of blocks, into texels of its size, channels and the format that
 * stilb_image_decode makes: so that several threads can share the work. first is a multiple of 4, end too or the
 * height. [any-thread] */
void stilb_image_decode_rows(const stilb_image *image, uint32_t first, uint32_t end, stilb_image *texels);

/* The format of the texels of stilb_image_decode. [any-thread] */
stilb_image_format stilb_image_decoded_format(stilb_image_format format);

/* Converts row y, 0 <= y < height, to linear floats in light, [width][channels]: codes of colour by the sRGB transfer,
 * data and alpha / 255 or / 65535. Of blocks the texels of stilb_image_decode, in about four times the time of that.
 * [any-thread] */
void stilb_image_row_to_light(const stilb_image *image, uint32_t y, float *light);

/* The nearest half (IEEE binary16), ties to even; values beyond 65504 become infinite from 65520 on, and NaN stays NaN.
 * [any-thread] */
uint16_t stilb_image_half_from_float(float value);

/* The float that a half is, exactly; infinite and NaN stay so. [any-thread] */
static inline float stilb_image_half_to_float(uint16_t half)
{
	uint32_t exponent = half >> 10 & 31u, mantissa = half & 1023u;
	uint32_t bits = (exponent == 31u ? 255u : exponent + 112u) << 23 | mantissa << 13;
	float magnitude;
	memcpy(&magnitude, &bits, sizeof magnitude);
	if (exponent == 0u)
		magnitude = (float)mantissa / 16777216.0f; /* 2^-24 each: denormal */
	return half & 0x8000u ? -magnitude : magnitude;
}

/* Bytes of all pixels of the largest level; 0 for {0}. [any-thread] */
size_t stilb_image_size(const stilb_image *image);

/* STILB_ERROR_ARGUMENT if no picture can be saved as path: an extension other than .png, .exr and .hdr (in any case), a
 * missing folder, a directory, no permission. For use before the work starts; writes nothing. [any-thread] */
stilb_result stilb_image_path_check(const char *path);

/* True if a picture saved as path keeps linear light (.exr, .hdr), false if it becomes display codes (.png) or the
 * extension cannot be saved. [any-thread] */
bool stilb_image_path_is_light(const char *path);

/* Writes path: .png as 8 bits of sRGB, .exr as 32-bit floats from F32_LINEAR and pictures of 16-bit codes and as 16-bit
 * floats from the others, .hdr as three 8-bit mantissas with one exponent (grey becomes RGB; alpha is
 * STILB_ERROR_FILE). Floats become codes by the sRGB transfer, clamped to [0, 1] and rounded to the nearest; NaN
 * becomes 0. Codes go into a .png as they are, data without a transfer, of 16 bits rounded to 8; the file says sRGB of
 * data, too. A .exr and a .hdr get data as values, 0 to 1. Blocks are decoded before, and levels but the largest are
 * left out.
 * [any-thread] STILB_ERROR_ARGUMENT as stilb_image_path_check and for an empty picture, STILB_ERROR_FILE (disk full),
 * STILB_ERROR_MEMORY. */
stilb_result stilb_image_save(const stilb_image *image, const char *path);

/* As stilb_image_save, with texts in the file's header: tEXt or iTXt chunks of .png, attributes of .exr, variables of
 * .hdr, where a line's end becomes a space. Names have 1..79 characters of ASCII, no '=', no spaces at their ends.
 * [any-thread] */
stilb_result stilb_image_save_with(const stilb_image *image, const char *path, const stilb_image_attribute *attributes,
                                   uint32_t attribute_count);

/* Reads path: .png into U8_SRGB (16-bit files are rounded to 8), .hdr and .exr into F32_LINEAR; of an .exr the first
 * part, up to 4 channels, or R G B (A) of one with more (image_layers.h reads all). .dds with all its levels, as it is:
 * BC1, BC3, BC4, BC5 and BC7, and plain pixels of 24 and 32 bits as U8; data if the file says UNORM, colour if it says
 * SRGB or, as old files do, nothing. No cube maps, arrays and volumes.
 * [any-thread] STILB_ERROR_ARGUMENT for an unknown extension, STILB_ERROR_FILE for a file that is missing, damaged or
 * of a kind or size that is not supported, STILB_ERROR_MEMORY; then image is {0}. */
stilb_result stilb_image_load(const char *path, stilb_image *image);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
