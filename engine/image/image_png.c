/* PNG through libpng. Source of the format: ISO/IEC 15948. */
#include "image/image_internal.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The user pointer of libpng's callbacks. */
typedef struct png_job {
	image_message *message;
	image_bytes *file; /* the output of encoding */
	bool out_of_memory;
	const unsigned char *data; /* [size], the input of decoding */
	size_t size, at;           /* at: the next byte to read, <= size */
} png_job;

static void png_on_error(png_structp png, png_const_charp text)
{
	png_job *job = png_get_error_ptr(png);
	snprintf(job->message->text, sizeof job->message->text, "%s", text);
	png_longjmp(png, 1);
}

/* Warnings, such as of a broken colour profile, are ignored: they change no pixel. */
static void png_on_warning(png_structp png, png_const_charp text)
{
	(void)png, (void)text;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void png_put(png_structp png, png_bytep data, size_t size)
{
	png_job *job = png_get_io_ptr(png);
	job->out_of_memory = !image_bytes_write(job->file, job->file->size, data, size);
	if (job->out_of_memory)
		png_error(png, "out of memory");
}

static void png_flush_nothing(png_structp png)
{
	(void)png;
}

static void png_put_text(png_structp png, png_infop info, const char *name, const char *text)
{
	bool ascii = true;
	for (const char *c = text; *c; c++)
		ascii = ascii && (unsigned char)*c < 0x80;
	/* libpng takes what it only reads without const */
	png_text entry = {.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE,
	                  .key = (char *)name,
	                  .text = (char *)text};
	png_set_text(png, info, &entry, 1);
}

/* Encodes the picture. A failure of libpng leaves the function by png_longjmp. */
static void png_write_all(png_structp png, png_infop info, const image_input *input)
{
	const image_shape *shape = &input->shape;
	const unsigned char *pixels = input->pixels;
	static const int colors[5] = {[1] = PNG_COLOR_TYPE_GRAY,
	                              [2] = PNG_COLOR_TYPE_GRAY_ALPHA,
	                              [3] = PNG_COLOR_TYPE_RGB,
	                              [4] = PNG_COLOR_TYPE_RGB_ALPHA};
	png_set_IHDR(png, info, shape->width, shape->height, 8, colors[shape->channels], PNG_INTERLACE_NONE,
	             PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
	png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
	png_put_text(png, info, "Software", "Stilb " STILB_VERSION);
	for (uint32_t i = 0; i < input->attribute_count; i++)
		png_put_text(png, info, input->attributes[i].name, input->attributes[i].text);
	png_set_compression_level(png, 3); /* three times as fast as level 6, and a tenth larger */
	png_write_info(png, info);
	for (uint32_t y = 0; y < shape->height; y++)
		png_write_row(png, pixels + (size_t)y * shape->width * shape->channels);
	png_write_end(png, NULL);
}

static image_outcome png_encode(const image_input *input, image_bytes *file, image_message *message)
{
	STILB_ASSERT(input->shape.channels >= 1 && input->shape.channels <= 4);
	STILB_ASSERT(input->shape.scalar == IMAGE_SCALAR_U8);
	STILB_ASSERT(input->pixels && file && message);
	png_job job = {.message = message, .file = file};
	png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, png_on_error, png_on_warning);
	png_infop info = png ? png_create_info_struct(png) : NULL;
	image_outcome outcome = IMAGE_OUTCOME_MEMORY;
	if (info) {
		if (setjmp(png_jmpbuf(png)) == 0) {
			png_set_write_fn(png, &job, png_put, png_flush_nothing);
			png_write_all(png, info, input);
			outcome = IMAGE_OUTCOME_DONE;
		} else {
			outcome = job.out_of_memory ? IMAGE_OUTCOME_MEMORY : IMAGE_OUTCOME_CODEC;
		}
	}
	png_destroy_write_struct(&png, &info);
	return outcome;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static void png_get(png_structp png, png_bytep out, size_t size)
{
	png_job *job = png_get_io_ptr(png);
	STILB_ASSERT(job->at <= job->size);
	if (size > job->size - job->at)
		png_error(png, "the file is cut off");
	memcpy(out, job->data + job->at, size);
	job->at += size;
}

/* The shape in which the file's picture is decoded; called after png_read_info. Also tells libpng to expand the rows to
 * that shape: 8 or 16 bits a channel, grey or RGB, with alpha if the file has any transparency. */
static image_shape png_shape(png_structp png, png_infop info)
{
	int color = png_get_color_type(png, info);
	bool alpha = (color & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(png, info, PNG_INFO_tRNS) != 0;
	png_set_expand(png); /* palettes to RGB, fewer than 8 bits to 8, a transparent colour to alpha */
	return (image_shape){.width = png_get_image_width(png, info),
	                     .height = png_get_image_height(png, info),
	                     .channels = (color & PNG_COLOR_MASK_COLOR ? 3u : 1u) + (alpha ? 1u : 0u),
	                     .scalar = png_get_bit_depth(png, info) == 16 ? IMAGE_SCALAR_U16 : IMAGE_SCALAR_U8};
}

/* Decodes the picture into the memory that allocate returns. A failure of libpng leaves the function by png_longjmp.
 * False: allocate refused. */
static bool png_read_all(png_structp png, png_infop info, image_allocate *allocate, void *context)
{
	png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
	png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* allocate refuses instead, with a better message */
	png_read_info(png, info);
	image_shape shape = png_shape(png, info);
	int passes = png_set_interlace_handling(png);
	unsigned char *pixels = allocate(context, &shape);
	if (!pixels)
		return false;
	STILB_ASSERT(shape.scalar == IMAGE_SCALAR_U8 || shape.scalar == IMAGE_SCALAR_U16);
	if (shape.scalar == IMAGE_SCALAR_U8)
		png_set_scale_16(png); /* rounded to the nearest */
	else
		png_set_swap(png); /* the file has the high byte first */
	png_read_update_info(png, info);
	size_t row = (size_t)shape.width * shape.channels * image_scalar_bytes[shape.scalar];
	if (png_get_rowbytes(png, info) != row)
		png_error(png, "its rows are not of the size that its header says");
	for (int pass = 0; pass < passes; pass++)
		for (uint32_t y = 0; y < shape.height; y++)
			png_read_row(png, pixels + y * row, NULL);
	png_read_end(png, NULL);
	return true;
}

static image_outcome png_decode(const void *data, size_t size, image_allocate *allocate, void *context,
                                image_message *message)
{
	STILB_ASSERT(data && allocate && message);
	png_job job = {.message = message, .data = data, .size = size};
	if (size < 8 || png_sig_cmp(job.data, 0, 8) != 0) {
		image_message_set(message, "it is not a PNG file");
		return IMAGE_OUTCOME_CODEC;
	}
	png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &job, png_on_error, png_on_warning);
	png_infop info = png ? png_create_info_struct(png) : NULL;
	image_outcome outcome = IMAGE_OUTCOME_MEMORY;
	if (info) {
		if (setjmp(png_jmpbuf(png)) == 0) {
			png_set_read_fn(png, &job, png_get);
			outcome = png_read_all(png, info, allocate, context) ? IMAGE_OUTCOME_DONE : IMAGE_OUTCOME_CALLBACK;
		} else {
			image_message why = *message; /* set by png_on_error */
			snprintf(message->text, sizeof message->text, "the file is damaged near byte %zu: %.400s", job.at,
			         why.text);
			outcome = IMAGE_OUTCOME_CODEC;
		}
	}
	png_destroy_read_struct(&png, &info, NULL);
	return outcome;
}

const image_codec image_codec_png = {".png", true, png_encode, png_decode};
