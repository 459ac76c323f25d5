/* Blocks become texels: BC1, BC3, BC4 and BC5 as the specification has them, in double; all modes of BC7 and the others
 * beside OpenImageIO's decoder; what stb_dxt made of pictures is these pictures again. */
#include "image/image_blocks.h"
#include "support/test.h"

#define STB_DXT_IMPLEMENTATION
#define STB_DXT_STATIC
#include <stb_dxt.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Random blocks of each format; fewer where each piece of code need run once. */
#if TEST_ASAN || TEST_TSAN
#define BLOCKS 4000u
#else
#define BLOCKS 100000u
#endif

/* A block of random bytes. Of every 16, some have equal and swapped ends, which random ones hardly have. */
static void block_random(uint64_t number, uint32_t size, uint8_t *block)
{
	for (uint32_t k = 0; k < size; k += 8) {
		uint64_t bits = stilb_random_u64(number, k);
		memcpy(block + k, &bits, 8);
	}
	for (uint32_t k = 0; k < size && number % 16 == 0; k += 8) { /* equal: BC1's and BC4's */
		memcpy(block + k + 2, block + k, 2);
		block[k + 1] = number % 32 ? block[k] : block[k + 1];
	}
}

/* ---- the specification, in double -------------------------------------------------------------------------------- */

/* The nearest code, halves up; a sum that is a half but for rounding is one. */
static uint32_t code_of(double value, uint32_t most)
{
	return (uint32_t)floor(value * most + 0.5 + 1e-9);
}

/* Red, green, blue and alpha of texel t of a block of BC1; alpha 1 in four colours. */
static void spec_color(const uint8_t *block, bool four, uint32_t t, double out[4])
{
	uint32_t first = block[0] + 256u * block[1], second = block[2] + 256u * block[3];
	uint32_t bits = block[4] + 256u * (block[5] + 256u * (block[6] + 256u * (uint32_t)block[7]));
	uint32_t code = bits >> 2 * t & 3;
	const double a[3] = {(first >> 11) / 31.0, (first >> 5 & 63) / 63.0, (first & 31) / 31.0};
	const double b[3] = {(second >> 11) / 31.0, (second >> 5 & 63) / 63.0, (second & 31) / 31.0};
	four = four || first > second;
	for (int c = 0; c < 3; c++) {
		double mixed = code == 2 ? (four ? (2 * a[c] + b[c]) / 3 : (a[c] + b[c]) / 2)
		               : four    ? (a[c] + 2 * b[c]) / 3
		                         : 0;
		out[c] = code == 0 ? a[c] : code == 1 ? b[c] : mixed;
	}
	out[3] = four || code < 3 ? 1.0 : 0.0;
}

/* The value of texel t of a block of BC4. */
static double spec_value(const uint8_t *block, uint32_t t)
{
	double a = block[0] / 255.0, b = block[1] / 255.0;
	uint64_t bits = 0;
	for (int k = 0; k < 6; k++)
		bits += (uint64_t)block[2 + k] << 8 * k;
	uint32_t code = bits >> 3 * t & 7;
	if (code < 2)
		return code ? b : a;
	if (a > b)
		return ((8 - code) * a + (code - 1) * b) / 7;
	return code == 6 ? 0.0 : code == 7 ? 1.0 : ((6 - code) * a + (code - 1) * b) / 5;
}

static void blocks_are_the_specifications(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < BLOCKS; i++) {
		uint8_t block[16], bc1[16][4], bc3[16][4];
		uint16_t bc4[16], bc5[16][2];
		block_random(i, 16, block);
		image_block_decode(i % 2 ? STILB_IMAGE_BC1_SRGB : STILB_IMAGE_BC1_LINEAR, block, bc1);
		image_block_decode(i % 2 ? STILB_IMAGE_BC3_SRGB : STILB_IMAGE_BC3_LINEAR, block, bc3);
		image_block_decode(STILB_IMAGE_BC4_LINEAR, block, bc4);
		image_block_decode(STILB_IMAGE_BC5_LINEAR, block, bc5);
		for (uint32_t t = 0; t < 16; t++) {
			double of_1[4], of_3[4];
			spec_color(block, false, t, of_1);
			spec_color(block + 8, true, t, of_3);
			of_3[3] = spec_value(block, t);
			for (int c = 0; c < 4; c++)
				if (bc1[t][c] != code_of(of_1[c], 255) || bc3[t][c] != code_of(of_3[c], 255))
					fail_msg("block %u, texel %u, channel %d: BC1 %u, not %g; BC3 %u, not %g", i, t, c, bc1[t][c],
					         255 * of_1[c], bc3[t][c], 255 * of_3[c]);
			uint32_t red = code_of(of_3[3], 65535), green = code_of(spec_value(block + 8, t), 65535);
			if (bc4[t] != red || bc5[t][0] != red || bc5[t][1] != green)
				fail_msg("block %u, texel %u: BC4 %u, BC5 %u %u; not %u %u", i, t, bc4[t], bc5[t][0], bc5[t][1], red,
				         green);
		}
	}
}

/* ---- beside another decoder -------------------------------------------------------------------------------------- */

#define SIDE 400u /* texels: 10,000 blocks */

static void put(uint8_t *file, size_t at, uint32_t number)
{
	for (int k = 0; k < 4; k++)
		file[at + (size_t)k] = (uint8_t)(number >> 8 * k);
}

/* The decoded picture of a DDS file, as allocated by the callback below. */
typedef struct other_picture {
	image_shape shape;
	uint8_t *pixels;
} other_picture;

static void *other_allocate(void *context, image_shape *shape)
{
	other_picture *picture = context;
	picture->shape = *shape;
	picture->pixels = calloc((size_t)shape->width * shape->height, shape->channels * image_scalar_bytes[shape->scalar]);
	return picture->pixels;
}

/* The blocks, SIDE x SIDE texels, as OpenImageIO decodes them. DX10 is BC7 here. */
static other_picture other_decode(const uint8_t *blocks, size_t size, const char *code)
{
	const image_foreign *foreign;
	image_message message;
	other_picture picture = {.pixels = NULL};
	size_t begin = strcmp(code, "DX10") == 0 ? 148 : 128;
	uint8_t *file = calloc(begin + size, 1);
	memcpy(file, "DDS ", 4);
	put(file, 4, 124), put(file, 8, 0x1007), put(file, 12, SIDE), put(file, 16, SIDE);
	put(file, 76, 32), put(file, 80, 4), put(file, 108, 0x1000);
	memcpy(file + 84, code, 4);
	if (begin == 148)
		put(file, 128, 98), put(file, 132, 3), put(file, 140, 1);
	memcpy(file + begin, blocks, size);
	foreign = image_foreign_load(&message);
	if (!foreign ||
	    foreign->decode("dds", file, begin + size, other_allocate, &picture, &message) != IMAGE_OUTCOME_DONE)
		fail_msg("%s", message.text);
	free(file);
	return picture;
}

/* The largest difference of each 8-bit code from the other decoder's. */
static uint32_t apart_of(stilb_image_format format, const char *code, const uint8_t *blocks)
{
	stilb_image image = {SIDE, SIDE, image_block_formats[format].channels, format, (void *)(uintptr_t)blocks, 0}, ours;
	assert_int_equal(stilb_image_decode(&image, &ours), STILB_OK);
	other_picture other = other_decode(blocks, stilb_image_size(&image), code);
	uint32_t most = 0, channels = other.shape.channels < image.channels ? other.shape.channels : image.channels;
	assert_true(other.shape.width == SIDE && other.shape.height == SIDE && other.shape.scalar == IMAGE_SCALAR_U8);
	for (size_t p = 0; p < SIDE * SIDE; p++)
		for (uint32_t c = 0; c < channels; c++) {
			size_t at = p * image.channels + c;
			uint32_t own = ours.format == STILB_IMAGE_U16_LINEAR
			                   ? (((uint16_t *)ours.pixels)[at] * 255u + 32767u) / 65535u
			                   : ((uint8_t *)ours.pixels)[at];
			uint32_t its = other.pixels[p * other.shape.channels + c];
			most = abs((int)own - (int)its) > (int)most ? (uint32_t)abs((int)own - (int)its) : most;
		}
	stilb_image_finish(&ours);
	free(other.pixels);
	return most;
}

static void bc7_is_what_others_decode(void **state)
{
	(void)state;
	uint8_t *blocks = malloc(SIDE * SIDE);
	for (uint32_t mode = 0; mode <= 8; mode++)
		for (uint32_t round = 0; round < (mode == 8 ? 1 : BLOCKS / 8 / 4000 + 1); round++) {
			for (uint32_t i = 0; i < SIDE * SIDE / 16; i++) {
				block_random(7 + i + (uint64_t)(16 * round + mode) * 10000, 16, blocks + 16 * i);
				blocks[16 * i] = mode == 8 ? 0 : (uint8_t)((blocks[16 * i] & ~0u << mode) | 1u << mode);
			}
			uint32_t apart = apart_of(STILB_IMAGE_BC7_LINEAR, "DX10", blocks);
			if (apart > 0)
				fail_msg("mode %u, round %u: up to %u apart", mode, round, apart);
		}
	free(blocks);
}

/* The other decoder rounds what lies between the ends in its own ways, by one code at most. */
static void others_round_by_one_code(void **state)
{
	(void)state;
	static const struct {
		stilb_image_format format;
		const char *code;
	} formats[] = {{STILB_IMAGE_BC1_LINEAR, "DXT1"},
	               {STILB_IMAGE_BC3_LINEAR, "DXT5"},
	               {STILB_IMAGE_BC4_LINEAR, "ATI1"},
	               {STILB_IMAGE_BC5_LINEAR, "ATI2"}};
	uint8_t *blocks = malloc(SIDE * SIDE);
	for (size_t f = 0; f < 4; f++)
		for (uint32_t round = 0; round < BLOCKS / 10000 + 1; round++) {
			uint32_t size = image_block_formats[formats[f].format].bytes;
			for (uint32_t i = 0; i < SIDE * SIDE / 16; i++)
				block_random(i + (uint64_t)round * 10000, size, blocks + size * i);
			uint32_t apart = apart_of(formats[f].format, formats[f].code, blocks);
			if (apart > 1)
				fail_msg("%s, round %u: up to %u apart", formats[f].code, round, apart);
		}
	free(blocks);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* A slope of each channel, coded by stb_dxt: texels in their places, channels in their order. */
static void coded_slopes_come_back(void **state)
{
	(void)state;
	uint8_t texels[32][32][4], coded[4][64 * 16], *at[4] = {coded[0], coded[1], coded[2], coded[3]};
	for (uint32_t i = 0; i < 32 * 32; i++) {
		uint32_t x = i % 32, y = i / 32;
		const uint8_t slope[4] = {(uint8_t)(8 * x), (uint8_t)(8 * y), (uint8_t)(4 * x + 3 * y), (uint8_t)(255 - 7 * y)};
		memcpy(texels[y][x], slope, 4);
	}
	for (uint32_t i = 0; i < 64; i++) {
		uint8_t block[16][4], grey[16], pair[16][2];
		for (uint32_t t = 0; t < 16; t++) {
			memcpy(block[t], texels[i / 8 * 4 + t / 4][i % 8 * 4 + t % 4], 4);
			grey[t] = pair[t][0] = block[t][0];
			pair[t][1] = block[t][1];
		}
		stb_compress_dxt_block(at[1], &block[0][0], 1, STB_DXT_HIGHQUAL), at[1] += 16;
		stb_compress_bc4_block(at[2], grey), at[2] += 8;
		stb_compress_bc5_block(at[3], &pair[0][0]), at[3] += 16;
		for (uint32_t t = 0; t < 16; t++)
			block[t][3] = 255;
		stb_compress_dxt_block(at[0], &block[0][0], 0, STB_DXT_HIGHQUAL), at[0] += 8;
	}
	static const stilb_image_format formats[] = {STILB_IMAGE_BC1_SRGB, STILB_IMAGE_BC3_SRGB, STILB_IMAGE_BC4_LINEAR,
	                                             STILB_IMAGE_BC5_LINEAR};
	for (int f = 0; f < 4; f++) {
		stilb_image image = {32, 32, image_block_formats[formats[f]].channels, formats[f], coded[f], 0}, back;
		assert_int_equal(stilb_image_decode(&image, &back), STILB_OK);
		for (uint32_t i = 0; i < 32 * 32 * image.channels; i++) {
			uint32_t c = i % image.channels, p = i / image.channels;
			int want = f == 0 && c == 3 ? 255 : texels[p / 32][p % 32][c];
			int got = f < 2 ? ((uint8_t *)back.pixels)[i] : (((uint16_t *)back.pixels)[i] + 128) / 257;
			if (abs(got - want) > (f < 2 && c < 3 ? 22 : 3))
				fail_msg("format %d: texel %u, %u has %d in channel %u, not %d", f, p % 32, p / 32, got, c, want);
		}
		stilb_image_finish(&back);
	}
}

/* Sides that are no multiples of 4, and longer than what is converted together: each row is that of the texels. */
static void rows_are_those_of_the_texels(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{1, 1}, {3, 5}, {4, 4}, {7, 2}, {256, 3}, {261, 6}, {1030, 1}};
	for (int f = STILB_IMAGE_BC1_SRGB; f < STILB_IMAGE_FORMAT_COUNT; f++)
		for (size_t s = 0; s < sizeof sides / sizeof *sides; s++) {
			uint32_t width = sides[s][0], height = sides[s][1], channels = image_block_formats[f].channels;
			stilb_image image, texels;
			float *a = malloc(width * channels * sizeof *a), *b = malloc(width * channels * sizeof *b);
			assert_int_equal(stilb_image_create(&image, width, height, channels, (stilb_image_format)f), STILB_OK);
			size_t size = stilb_image_size(&image);
			assert_int_equal(size, ((width + 3) / 4) * ((height + 3) / 4) * image_block_formats[f].bytes);
			for (size_t i = 0; i < size; i++)
				((uint8_t *)image.pixels)[i] = (uint8_t)stilb_random_u64(s, i);
			assert_int_equal(stilb_image_decode(&image, &texels), STILB_OK);
			for (uint32_t y = 0; y < height; y++) {
				uint8_t one[16 * 4];
				stilb_image_row_to_light(&image, y, a);
				stilb_image_row_to_light(&texels, y, b);
				assert_memory_equal(a, b, width * channels * sizeof *a);
				const uint8_t *block = (uint8_t *)image.pixels +
				                       (y / 4 * ((width + 3) / 4) + (width - 1) / 4) * image_block_formats[f].bytes;
				image_block_decode(image.format, block, one);
				size_t texel = stilb_image_size(&texels) / width / height;
				assert_memory_equal(one + (y % 4 * 4 + (width - 1) % 4) * texel,
				                    (uint8_t *)texels.pixels + ((y + 1) * width - 1) * texel, texel);
			}
			stilb_image_finish(&image);
			stilb_image_finish(&texels);
			free(a);
			free(b);
		}
}

static void decoding_copies_texels_and_refuses_the_rest(void **state)
{
	(void)state;
	uint16_t halves[] = {1, 2, 3, 4, 5, 6};
	uint8_t block[16] = {0};
	stilb_image image = {3, 1, 2, STILB_IMAGE_F16_LINEAR, halves, 0}, texels;
	assert_int_equal(stilb_image_decode(&image, &texels), STILB_OK);
	assert_true(texels.format == STILB_IMAGE_F16_LINEAR && texels.channels == 2 && texels.pixels != image.pixels);
	assert_memory_equal(texels.pixels, halves, sizeof halves);
	stilb_image_finish(&texels);
	stilb_image wrong[] = {{1, 1, 3, STILB_IMAGE_BC7_SRGB, block, 0},
	                       {1, 1, 4, STILB_IMAGE_BC7_SRGB, NULL, 0},
	                       {0, 1, 4, STILB_IMAGE_BC7_SRGB, block, 0},
	                       {65536, 65536, 4, STILB_IMAGE_BC1_SRGB, block, 0}};
	static const char *const why[] = {"another number of channels", "it is empty", "must be 1 to 65536", "4 GiB"};
	for (int i = 0; i < 4; i++) {
		assert_int_equal(stilb_image_decode(&wrong[i], &texels), STILB_ERROR_ARGUMENT);
		assert_null(texels.pixels);
		if (i < 3)
			assert_non_null(strstr(stilb_error_message(), why[i]));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(blocks_are_the_specifications), cmocka_unit_test(bc7_is_what_others_decode),
		cmocka_unit_test(others_round_by_one_code),      cmocka_unit_test(coded_slopes_come_back),
		cmocka_unit_test(rows_are_those_of_the_texels),  cmocka_unit_test(decoding_copies_texels_and_refuses_the_rest),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
