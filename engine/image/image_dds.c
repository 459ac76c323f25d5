/* DDS, read alone: BC1, BC3, BC4, BC5 and BC7, and plain pixels of 24 and 32 bits, with mip levels. Sources: Microsoft,
 * "Programming Guide for DDS", "DDS_HEADER", "DDS_PIXELFORMAT", "DDS_HEADER_DXT10" and "DXGI_FORMAT". */
#include "image/image_blocks.h"
#include "image/image_internal.h"

#include <stdio.h>
#include <string.h>

#define DDS_HEADER_BYTES 128u /* with the magic number */
#define DDS_DX10_BYTES 20u    /* that may follow */

/* Offsets of 32-bit numbers in the header. */
enum {
	DDS_SIZE = 4,
	DDS_HEIGHT = 12,
	DDS_WIDTH = 16,
	DDS_LEVELS = 28,
	DDS_PIXEL_SIZE = 76,
	DDS_PIXEL_FLAGS = 80,
	DDS_FOUR_CC = 84,
	DDS_PIXEL_BITS = 88,
	DDS_MASKS = 92, /* of red, green, blue, alpha */
	DDS_CAPS_2 = 112,
	DDS_DXGI = 128,
	DDS_DIMENSION = 132,
	DDS_MISC = 136,
	DDS_ARRAY = 140,
	DDS_ALPHA = 144,
};

#define DDS_PIXEL_ALPHA 0x1u
#define DDS_PIXEL_FOUR_CC 0x4u
#define DDS_PIXEL_RGB 0x40u
#define DDS_CAPS_CUBE 0x200u
#define DDS_CAPS_VOLUME 0x200000u
#define DDS_MISC_CUBE 0x4u
#define DDS_DIMENSION_2D 3u
#define DDS_ALPHA_PREMULTIPLIED 2u

/* What a file says of its pixels. */
typedef struct dds_pixels {
	stilb_image_format format;
	uint8_t bytes;    /* of a plain pixel in the file; 0: blocks */
	uint8_t channels; /* of the picture */
	bool blue_first;  /* plain pixels: blue, green, red */
} dds_pixels;

typedef struct dds_input {
	const uint8_t *data;
	size_t size;
	uint32_t width, height, levels;
	size_t begin; /* of the pixels */
	dds_pixels pixels;
	const char *trouble; /* why it is not read, or NULL; its text is in message if it has numbers */
	bool unknown;        /* the trouble is a kind of pixels that this reader does not know */
} dds_input;

static uint32_t dds_number(const dds_input *input, size_t at)
{
	STILB_ASSERT(at + 4 <= input->size);
	const uint8_t *b = input->data + at;
	return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* ---- kinds of pixels --------------------------------------------------------------------------------------------- */

static bool dds_dxgi(uint32_t number, dds_pixels *out)
{
	static const struct {
		uint8_t number;
		dds_pixels pixels;
	} known[] = {
		{28, {STILB_IMAGE_U8_LINEAR, 4, 4, false}},  {29, {STILB_IMAGE_U8_SRGB, 4, 4, false}},
		{87, {STILB_IMAGE_U8_LINEAR, 4, 4, true}},   {91, {STILB_IMAGE_U8_SRGB, 4, 4, true}},
		{88, {STILB_IMAGE_U8_LINEAR, 4, 3, true}},   {93, {STILB_IMAGE_U8_SRGB, 4, 3, true}},
		{71, {STILB_IMAGE_BC1_LINEAR, 0, 4, false}}, {72, {STILB_IMAGE_BC1_SRGB, 0, 4, false}},
		{77, {STILB_IMAGE_BC3_LINEAR, 0, 4, false}}, {78, {STILB_IMAGE_BC3_SRGB, 0, 4, false}},
		{80, {STILB_IMAGE_BC4_LINEAR, 0, 1, false}}, {83, {STILB_IMAGE_BC5_LINEAR, 0, 2, false}},
		{98, {STILB_IMAGE_BC7_LINEAR, 0, 4, false}}, {99, {STILB_IMAGE_BC7_SRGB, 0, 4, false}},
	};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++)
		if (known[i].number == number) {
			*out = known[i].pixels;
			return true;
		}
	return false;
}

/* Old files do not say whether they are colour; BC1 and BC3 are taken for it. */
static bool dds_four_cc(const uint8_t *name, dds_pixels *out)
{
	static const struct {
		char name[5];
		dds_pixels pixels;
	} known[] = {
		{"DXT1", {STILB_IMAGE_BC1_SRGB, 0, 4, false}},   {"DXT5", {STILB_IMAGE_BC3_SRGB, 0, 4, false}},
		{"ATI1", {STILB_IMAGE_BC4_LINEAR, 0, 1, false}}, {"BC4U", {STILB_IMAGE_BC4_LINEAR, 0, 1, false}},
		{"ATI2", {STILB_IMAGE_BC5_LINEAR, 0, 2, false}}, {"BC5U", {STILB_IMAGE_BC5_LINEAR, 0, 2, false}},
	};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++)
		if (memcmp(known[i].name, name, 4) == 0) {
			*out = known[i].pixels;
			return true;
		}
	return false;
}

/* Plain pixels by the masks of their channels. */
static bool dds_masks(const dds_input *input, dds_pixels *out)
{
	uint32_t bits = dds_number(input, DDS_PIXEL_BITS), red = dds_number(input, DDS_MASKS);
	uint32_t green = dds_number(input, DDS_MASKS + 4), blue = dds_number(input, DDS_MASKS + 8);
	uint32_t flags = dds_number(input, DDS_PIXEL_FLAGS), alpha = dds_number(input, DDS_MASKS + 12);
	bool red_first = red == 0xff && blue == 0xff0000, blue_first = red == 0xff0000 && blue == 0xff;
	bool has_alpha = flags & DDS_PIXEL_ALPHA;
	if ((bits != 24 && bits != 32) || green != 0xff00 || (!red_first && !blue_first))
		return false;
	if (has_alpha && (bits != 32 || alpha != 0xff000000))
		return false;
	*out = (dds_pixels){STILB_IMAGE_U8_SRGB, (uint8_t)(bits / 8), has_alpha ? 4 : 3, blue_first};
	return true;
}

/* ---- the header -------------------------------------------------------------------------------------------------- */

static void dds_refuse(dds_input *input, const char *trouble)
{
	input->trouble = trouble;
}

/* The DX10 header, in place of the pixels' description: pixels, and what is not one flat picture. */
static void dds_read_dx10(dds_input *input, char text[static 200])
{
	if (input->size < DDS_HEADER_BYTES + DDS_DX10_BYTES) {
		dds_refuse(input, "the file is cut off");
		return;
	}
	uint32_t count = dds_number(input, DDS_ARRAY), dimension = dds_number(input, DDS_DIMENSION);
	input->begin += DDS_DX10_BYTES;
	if (dds_number(input, DDS_MISC) & DDS_MISC_CUBE) {
		dds_refuse(input, "it is a cube map; save one of its sides as a flat picture");
	} else if (dimension != DDS_DIMENSION_2D) {
		dds_refuse(input, "it is a volume or a line; save it as a flat picture");
	} else if (count != 1) {
		snprintf(text, 200, "it is an array of %u pictures; save one of them as a flat picture", count);
		dds_refuse(input, text);
	} else if (!dds_dxgi(dds_number(input, DDS_DXGI), &input->pixels)) {
		snprintf(text, 200, "its pixels have DXGI format %u; save it as BC1, BC3, BC4, BC5, BC7 or RGBA of 8 bits",
		         dds_number(input, DDS_DXGI));
		dds_refuse(input, text);
		input->unknown = true;
	} else if ((dds_number(input, DDS_ALPHA) & 7) == DDS_ALPHA_PREMULTIPLIED) {
		dds_refuse(input, "its colours are multiplied by alpha; save it with straight alpha");
	}
}

static void dds_read_pixels(dds_input *input, char text[static 200])
{
	const uint8_t *name = input->data + DDS_FOUR_CC;
	uint32_t flags = dds_number(input, DDS_PIXEL_FLAGS);
	if (flags & DDS_PIXEL_FOUR_CC && memcmp(name, "DX10", 4) == 0) {
		dds_read_dx10(input, text);
		return;
	}
	input->unknown = flags & DDS_PIXEL_FOUR_CC ? !dds_four_cc(name, &input->pixels)
	                                           : !(flags & DDS_PIXEL_RGB) || !dds_masks(input, &input->pixels);
	if (!input->unknown)
		return;
	char shown[5] = "none";
	if (flags & DDS_PIXEL_FOUR_CC)
		memcpy(shown, name, 4);
	for (int i = 0; i < 4; i++)
		if (shown[i] <= ' ' || shown[i] > '~')
			shown[i] = '?';
	snprintf(text, 200,
	         "its pixels have %u bits and the code '%s'; save it as BC1, BC3, BC4, BC5, BC7 or RGBA of 8 bits",
	         dds_number(input, DDS_PIXEL_BITS), shown);
	dds_refuse(input, text);
}

/* Reads and checks everything but the pixels. text: room for a trouble with numbers. */
static dds_input dds_read(const void *data, size_t size, char text[static 200])
{
	dds_input input = {.data = data, .size = size, .begin = DDS_HEADER_BYTES};
	if (size < 4 || memcmp(data, "DDS ", 4) != 0) {
		dds_refuse(&input, "it is not a DDS file");
		return input;
	}
	if (size < DDS_HEADER_BYTES) {
		dds_refuse(&input, "the file is cut off");
		return input;
	}
	input.width = dds_number(&input, DDS_WIDTH);
	input.height = dds_number(&input, DDS_HEIGHT);
	input.levels = dds_number(&input, DDS_LEVELS);
	if (input.levels == 0)
		input.levels = 1;
	uint32_t caps = dds_number(&input, DDS_CAPS_2);
	if (dds_number(&input, DDS_SIZE) != 124 || dds_number(&input, DDS_PIXEL_SIZE) != 32)
		dds_refuse(&input, "its header is damaged");
	else if (caps & DDS_CAPS_CUBE)
		dds_refuse(&input, "it is a cube map; save one of its sides as a flat picture");
	else if (caps & DDS_CAPS_VOLUME)
		dds_refuse(&input, "it is a volume; save it as a flat picture");
	else
		dds_read_pixels(&input, text);
	if (!input.trouble && input.width > 0 && input.height > 0 &&
	    input.levels > image_most_levels(input.width, input.height)) {
		snprintf(text, 200, "it has %u mip levels; %u x %u pixels have at most %u", input.levels, input.width,
		         input.height, image_most_levels(input.width, input.height));
		dds_refuse(&input, text);
	}
	return input;
}

bool image_dds_is_known(const void *data, size_t size)
{
	char text[200];
	return !dds_read(data, size, text).unknown;
}

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

/* The picture as it is in the file, without pixels. */
static stilb_image dds_shape(const dds_input *input)
{
	stilb_image shape = {.width = input->width, .height = input->height, .channels = input->pixels.channels};
	shape.format = input->pixels.format;
	return shape;
}

/* Bytes of the file's pixels, of so many levels. */
static uint64_t dds_bytes(const dds_input *input, uint32_t levels)
{
	stilb_image shape = dds_shape(input);
	uint64_t size = image_levels_size(&shape, levels);
	return input->pixels.bytes > 0 ? size / input->pixels.channels * input->pixels.bytes : size;
}

/* Plain pixels of so many levels, from the file's order of channels. */
static void dds_copy(const dds_input *input, uint32_t levels, uint8_t *pixels)
{
	uint32_t channels = input->pixels.channels, bytes = input->pixels.bytes;
	const uint8_t *from = input->data + input->begin;
	if (bytes == 0) {
		memcpy(pixels, from, dds_bytes(input, levels));
		return;
	}
	for (uint64_t i = 0, count = dds_bytes(input, levels) / bytes; i < count; i++, from += bytes, pixels += channels) {
		pixels[0] = from[input->pixels.blue_first ? 2 : 0];
		pixels[1] = from[1];
		pixels[2] = from[input->pixels.blue_first ? 0 : 2];
		if (channels == 4)
			pixels[3] = from[3];
	}
}

/* The texels of the largest level, as colour if there is such a format. */
static void *dds_decode(const dds_input *input, image_load *load)
{
	stilb_image blocks = dds_shape(input), shape = blocks;
	bool plain = input->pixels.bytes > 0;
	shape.format = stilb_image_format_as_color(blocks.format);
	if (!plain)
		shape.format = image_block_formats[shape.format].texels;
	uint8_t *pixels = image_load_make(load, shape, 1);
	if (!pixels)
		return NULL;
	if (plain) {
		dds_copy(input, 1, pixels);
		return pixels;
	}
	size_t row = stilb_image_size(load->image) / shape.height;
	for (uint32_t y = 0; y < shape.height; y += 4)
		image_block_rows(&blocks, input->data + input->begin, y, shape.height - y < 4 ? shape.height - y : 4,
		                 pixels + y * row);
	return pixels;
}

image_outcome image_dds_decode(const void *data, size_t size, image_load *load, image_message *message)
{
	STILB_ASSERT(data && load);
	STILB_ASSERT(message);
	char text[200];
	dds_input input = dds_read(data, size, text);
	if (input.trouble) {
		image_message_set(message, input.trouble);
		return IMAGE_OUTCOME_CODEC;
	}
	stilb_image shape = dds_shape(&input);
	const char *refusal = image_refusal(&shape);
	uint64_t there = size - input.begin, need = refusal ? 0 : dds_bytes(&input, input.levels);
	if (need > there) {
		snprintf(message->text, sizeof message->text,
		         "the file is cut off: %u x %u pixels with %u mip levels need %llu bytes, and there are %llu",
		         input.width, input.height, input.levels, (unsigned long long)need, (unsigned long long)there);
		return IMAGE_OUTCOME_CODEC;
	}
	if (!load->blocks)
		return dds_decode(&input, load) ? IMAGE_OUTCOME_DONE : IMAGE_OUTCOME_CALLBACK;
	uint8_t *pixels = image_load_make(load, shape, input.levels);
	if (!pixels)
		return IMAGE_OUTCOME_CALLBACK;
	dds_copy(&input, input.levels, pixels);
	return IMAGE_OUTCOME_DONE;
}
