/* BC1, BC3, BC4 and BC5 (S3TC, RGTC), and pictures of blocks as a whole. Sources: Khronos Data Format Specification,
 * "S3TC Compressed Texture Image Formats" and "RGTC Compressed Texture Image Formats"; Microsoft, "Texture Block
 * Compression in Direct3D 11". */
#include "image/image_blocks.h"

#include <string.h>

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

/* value / most as a code of 8 bits, the nearest, halves up. */
static uint8_t block_code(uint32_t value, uint32_t most)
{
	STILB_ASSERT(value <= most);
	return (uint8_t)((510 * value + most) / (2 * most));
}

/* The colours of BC1, of 5, 6 and 5 bits a channel, mixed before they are rounded. opaque: as in BC3, where there are
 * four colours whatever their order is. */
static void block_colors(const uint8_t *block, bool opaque, uint8_t texels[16][4])
{
	static const uint32_t shifts[3] = {11, 5, 0}, most[3] = {31, 63, 31};
	uint32_t first = block[0] | (uint32_t)block[1] << 8, second = block[2] | (uint32_t)block[3] << 8;
	uint8_t palette[4][4];
	bool four = opaque || first > second;
	for (uint32_t c = 0; c < 3; c++) {
		uint32_t a = first >> shifts[c] & most[c], b = second >> shifts[c] & most[c];
		palette[0][c] = block_code(a, most[c]);
		palette[1][c] = block_code(b, most[c]);
		palette[2][c] = four ? block_code(2 * a + b, 3 * most[c]) : block_code(a + b, 2 * most[c]);
		palette[3][c] = four ? block_code(a + 2 * b, 3 * most[c]) : 0;
	}
	for (uint32_t k = 0; k < 4; k++)
		palette[k][3] = k < 3 || four ? 255 : 0;
	for (uint32_t t = 0; t < 16; t++)
		memcpy(texels[t], palette[block[4 + t / 4] >> 2 * (t % 4) & 3], 4);
}

/* One channel of BC4: the sixteen values as parts of *most, 255 * 7 or 255 * 5. */
static uint32_t block_values(const uint8_t *block, uint32_t values[16])
{
	uint32_t a = block[0], b = block[1], steps = a > b ? 7 : 5, palette[8] = {a * steps, b * steps};
	uint64_t indices = 0;
	for (uint32_t k = 1; k < steps; k++)
		palette[1 + k] = (steps - k) * a + k * b;
	if (steps == 5)
		palette[6] = 0, palette[7] = 255 * steps;
	for (uint32_t k = 0; k < 6; k++)
		indices |= (uint64_t)block[2 + k] << 8 * k;
	for (uint32_t t = 0; t < 16; t++)
		values[t] = palette[indices >> 3 * t & 7];
	return 255 * steps;
}

/* Writes a channel of 16 bits, [16][channels]. */
static void block_words(const uint8_t *block, uint32_t channels, uint16_t *words)
{
	uint32_t values[16], most = block_values(block, values);
	for (uint32_t t = 0; t < 16; t++)
		words[(size_t)t * channels] = (uint16_t)((2 * 65535 * values[t] + most) / (2 * most));
}

void image_block_decode(stilb_image_format format, const uint8_t *block, void *texels)
{
	uint8_t(*bytes)[4] = texels;
	uint32_t values[16], most;
	switch (format) {
	case STILB_IMAGE_BC1_SRGB:
	case STILB_IMAGE_BC1_LINEAR:
		block_colors(block, false, bytes);
		return;
	case STILB_IMAGE_BC3_SRGB:
	case STILB_IMAGE_BC3_LINEAR:
		block_colors(block + 8, true, bytes);
		most = block_values(block, values);
		for (uint32_t t = 0; t < 16; t++)
			bytes[t][3] = block_code(values[t], most);
		return;
	case STILB_IMAGE_BC4_LINEAR:
		block_words(block, 1, texels);
		return;
	case STILB_IMAGE_BC5_LINEAR:
		block_words(block, 2, texels);
		block_words(block + 8, 2, (uint16_t *)texels + 1);
		return;
	default:
		STILB_ASSERT(image_block_formats[format].bytes > 0 && "a format of blocks");
		image_block_bc7(block, bytes);
	}
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef union block_texels {
	uint8_t bytes[16][4];
	uint16_t words[16][2];
} block_texels;

/* Bytes of a decoded texel. */
static size_t block_texel_bytes(const image_block_format *format)
{
	return format->channels * image_scalar_bytes[image_format_scalars[format->texels]];
}

void image_block_rows(const stilb_image *shape, const void *blocks, uint32_t y, uint32_t rows, void *texels)
{
	const image_block_format *format = &image_block_formats[shape->format];
	STILB_ASSERT(format->bytes > 0);
	STILB_ASSERT(y % 4 == 0 && rows > 0 && rows <= 4 && y + rows <= shape->height);
	size_t texel = block_texel_bytes(format), row = shape->width * texel;
	const uint8_t *block = (const uint8_t *)blocks + (size_t)(y / 4) * ((shape->width + 3) / 4) * format->bytes;
	block_texels decoded;
	for (uint32_t x = 0; x < shape->width; x += 4, block += format->bytes) {
		size_t width = shape->width - x < 4 ? shape->width - x : 4;
		image_block_decode(shape->format, block, &decoded);
		for (uint32_t r = 0; r < rows; r++)
			memcpy((uint8_t *)texels + r * row + x * texel, (const uint8_t *)&decoded + (size_t)r * 4 * texel,
			       width * texel);
	}
}

void image_block_row(const stilb_image *shape, const void *blocks, uint32_t y, uint32_t first, uint32_t count,
                     void *texels)
{
	const image_block_format *format = &image_block_formats[shape->format];
	STILB_ASSERT(format->bytes > 0);
	STILB_ASSERT(first % 4 == 0 && first + count <= shape->width && y < shape->height);
	size_t texel = block_texel_bytes(format);
	const uint8_t *block =
		(const uint8_t *)blocks + ((size_t)(y / 4) * ((shape->width + 3) / 4) + first / 4) * format->bytes;
	block_texels decoded;
	for (uint32_t x = 0; x < count; x += 4, block += format->bytes) {
		size_t width = count - x < 4 ? count - x : 4;
		image_block_decode(shape->format, block, &decoded);
		memcpy((uint8_t *)texels + x * texel, (const uint8_t *)&decoded + (size_t)(y % 4) * 4 * texel, width * texel);
	}
}

stilb_image_format stilb_image_decoded_format(stilb_image_format format)
{
	return stilb_image_format_is_blocks(format) ? image_block_formats[format].texels : format;
}

void stilb_image_decode_rows(const stilb_image *image, uint32_t first, uint32_t end, stilb_image *texels)
{
	STILB_ASSERT(image_is_sound(image) && image_is_sound(texels));
	STILB_ASSERT(texels->width == image->width && texels->height == image->height);
	STILB_ASSERT(texels->channels == image->channels && texels->format == stilb_image_decoded_format(image->format));
	STILB_ASSERT(first % 4 == 0 && first <= end && end <= image->height && (end % 4 == 0 || end == image->height));
	size_t row = stilb_image_size(texels) / texels->height;
	for (uint32_t y = first; y < end; y += 4)
		image_block_rows(image, image->pixels, y, end - y < 4 ? end - y : 4, (uint8_t *)texels->pixels + y * row);
}

stilb_result stilb_image_decode(const stilb_image *image, stilb_image *texels)
{
	STILB_ASSERT(image && texels);
	const char *refusal = image->pixels ? image_refusal(image) : "it is empty";
	*texels = (stilb_image){0};
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot decode a picture of %u x %u pixels: %s", image->width,
		                  image->height, refusal);
	stilb_image_format format = stilb_image_decoded_format(image->format);
	stilb_result result = stilb_image_create(texels, image->width, image->height, image->channels, format);
	if (result != STILB_OK)
		return result;
	if (format == image->format)
		memcpy(texels->pixels, image->pixels, stilb_image_size(image));
	else
		stilb_image_decode_rows(image, 0, image->height, texels);
	return STILB_OK;
}
