/* Colour and data: what the codes of each format mean as light and in files; halves against every half there is. */

#include "image/image.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static stilb_image made(uint32_t width, uint32_t height, uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	if (stilb_image_create(&image, width, height, channels, format) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* The sRGB transfer in double, IEC 61966-2-1. */
static double light_of(double code)
{
	return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

/* ---- light ------------------------------------------------------------------------------------------------------- */

/* Every code of 8 bits and all or some of 16, in pictures of 1 to 4 channels: colour through the transfer, data and
 * alpha not. */
static void codes_become_light(void **state)
{
	(void)state;
	static const struct {
		stilb_image_format format;
		uint32_t most;
		bool data;
	} formats[] = {{STILB_IMAGE_U8_SRGB, 255, false},
	               {STILB_IMAGE_U8_LINEAR, 255, true},
	               {STILB_IMAGE_U16_SRGB, 65535, false},
	               {STILB_IMAGE_U16_LINEAR, 65535, true}};
	for (uint32_t f = 0; f < 4; f++)
		for (uint32_t channels = 1; channels <= 4; channels++) {
			uint32_t most = formats[f].most, width = (most + 1) / 8;
			stilb_image image = made(width, 8, channels, formats[f].format);
			assert_int_equal(stilb_image_size(&image), (size_t)width * 8 * channels * (most == 255 ? 1 : 2));
			for (uint32_t i = 0; i < width * 8 * channels; i++)
				if (most == 255)
					((uint8_t *)image.pixels)[i] = (uint8_t)(i / channels);
				else
					((uint16_t *)image.pixels)[i] = (uint16_t)(i / channels);
			float *light = malloc((size_t)width * channels * sizeof *light);
			for (uint32_t y = 0; y < 8; y++) {
				stilb_image_row_to_light(&image, y, light);
				for (uint32_t i = 0; i < width * channels; i++) {
					bool alpha = channels % 2 == 0 && i % channels == channels - 1;
					double code = (y * width + i / channels) / (double)most;
					double want = formats[f].data || alpha ? code : light_of(code);
					if (!(fabs((double)light[i] - want) <= 2e-7 + 1e-6 * want))
						fail_msg("format %d, %u channels: code %g is %g, not %g", (int)formats[f].format, channels,
						         code * most, (double)light[i], want);
				}
			}
			free(light);
			stilb_image_finish(&image);
		}
}

static void every_format_has_its_data(void **state)
{
	(void)state;
	static const struct {
		stilb_image_format data, color;
		uint8_t channels; /* of blocks */
	} others[] = {
		[STILB_IMAGE_U8_SRGB] = {STILB_IMAGE_U8_LINEAR, STILB_IMAGE_U8_SRGB, 0},
		[STILB_IMAGE_F16_LINEAR] = {STILB_IMAGE_F16_LINEAR, STILB_IMAGE_F16_LINEAR, 0},
		[STILB_IMAGE_F32_LINEAR] = {STILB_IMAGE_F32_LINEAR, STILB_IMAGE_F32_LINEAR, 0},
		[STILB_IMAGE_U16_SRGB] = {STILB_IMAGE_U16_LINEAR, STILB_IMAGE_U16_SRGB, 0},
		[STILB_IMAGE_U8_LINEAR] = {STILB_IMAGE_U8_LINEAR, STILB_IMAGE_U8_SRGB, 0},
		[STILB_IMAGE_U16_LINEAR] = {STILB_IMAGE_U16_LINEAR, STILB_IMAGE_U16_SRGB, 0},
		[STILB_IMAGE_BC1_SRGB] = {STILB_IMAGE_BC1_LINEAR, STILB_IMAGE_BC1_SRGB, 4},
		[STILB_IMAGE_BC1_LINEAR] = {STILB_IMAGE_BC1_LINEAR, STILB_IMAGE_BC1_SRGB, 4},
		[STILB_IMAGE_BC3_SRGB] = {STILB_IMAGE_BC3_LINEAR, STILB_IMAGE_BC3_SRGB, 4},
		[STILB_IMAGE_BC3_LINEAR] = {STILB_IMAGE_BC3_LINEAR, STILB_IMAGE_BC3_SRGB, 4},
		[STILB_IMAGE_BC4_LINEAR] = {STILB_IMAGE_BC4_LINEAR, STILB_IMAGE_BC4_LINEAR, 1},
		[STILB_IMAGE_BC5_LINEAR] = {STILB_IMAGE_BC5_LINEAR, STILB_IMAGE_BC5_LINEAR, 2},
		[STILB_IMAGE_BC7_SRGB] = {STILB_IMAGE_BC7_LINEAR, STILB_IMAGE_BC7_SRGB, 4},
		[STILB_IMAGE_BC7_LINEAR] = {STILB_IMAGE_BC7_LINEAR, STILB_IMAGE_BC7_SRGB, 4},
	};
	static_assert(sizeof others / sizeof *others == STILB_IMAGE_FORMAT_COUNT, "all formats");
	stilb_image image;
	for (int f = 0; f < STILB_IMAGE_FORMAT_COUNT; f++) {
		stilb_image_format format = (stilb_image_format)f;
		uint32_t channels = others[f].channels;
		assert_int_equal(stilb_image_format_as_data(format), others[f].data);
		assert_int_equal(stilb_image_format_as_color(format), others[f].color);
		assert_int_equal(stilb_image_format_is_blocks(format), channels > 0);
		stilb_image from = made(3, 2, channels ? channels : 4, format);
		stilb_image to = made(3, 2, channels ? channels : 4, others[f].data);
		assert_int_equal(stilb_image_size(&from), stilb_image_size(&to)); /* the same bytes */
		assert_int_equal(stilb_image_level_count(&from), 1);
		stilb_image_finish(&from);
		stilb_image_finish(&to);
		if (channels > 0) {
			assert_int_equal(stilb_image_create(&image, 3, 2, channels % 4 + 1, format), STILB_ERROR_ARGUMENT);
			assert_non_null(strstr(stilb_error_message(), "its blocks have another number"));
		}
	}
	assert_int_equal(stilb_image_create(&image, 1, 1, 1, STILB_IMAGE_FORMAT_COUNT), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "unknown pixel format"));
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static stilb_image through(const stilb_image *image, const char *extension)
{
	char path[] = "test_image_formats_XXXXXX.ext";
	stilb_image back = {0};
	memcpy(strrchr(path, '.'), extension, 5);
	int file = mkstemps(path, 4);
	assert_true(file >= 0);
	close(file);
	if (stilb_image_save(image, path) != STILB_OK || stilb_image_load(path, &back) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	unlink(path);
	return back;
}

/* .png holds the codes themselves, .exr the values, of which each code comes back. */
static void data_survive_files(void **state)
{
	(void)state;
	stilb_image bytes = made(256, 1, 2, STILB_IMAGE_U8_LINEAR), words = made(257, 255, 1, STILB_IMAGE_U16_LINEAR);
	for (int i = 0; i < 512; i++)
		((uint8_t *)bytes.pixels)[i] = (uint8_t)(i / 2);
	for (int i = 0; i < 65535; i++)
		((uint16_t *)words.pixels)[i] = (uint16_t)(i + 1);
	stilb_image png = through(&bytes, ".png"), exr = through(&bytes, ".exr");
	assert_memory_equal(png.pixels, bytes.pixels, 512);
	for (int i = 0; i < 512; i++) {
		assert_true(lround(255.0 * (double)((float *)exr.pixels)[i]) == i / 2);
		assert_true(fabs((double)((float *)exr.pixels)[i] - i / 2 / 255.0) <= 1.0 / 4096); /* half a step of a half */
	}
	stilb_image_finish(&png);
	stilb_image_finish(&exr);
	png = through(&words, ".png"), exr = through(&words, ".exr");
	for (int i = 0; i < 65535; i++) {
		if (((uint8_t *)png.pixels)[i] != lround((i + 1) / 257.0))
			fail_msg("%d became %u", i + 1, ((uint8_t *)png.pixels)[i]);
		assert_true(((float *)exr.pixels)[i] == (float)(i + 1) / 65535.0f);
	}
	stilb_image_finish(&png);
	stilb_image_finish(&exr);
	stilb_image_finish(&bytes);
	stilb_image_finish(&words);
}

/* ---- halves ------------------------------------------------------------------------------------------------------ */

static double half_value(uint32_t half)
{
	int exponent = half >> 10 & 31, mantissa = half & 1023;
	double size = exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
	return half >> 15 ? -size : size;
}

static void halves_are_exact_floats(void **state)
{
	(void)state;
	for (uint32_t h = 0; h < 0x10000; h++) {
		float value = stilb_image_half_to_float((uint16_t)h);
		assert_int_equal(signbit(value) != 0, h >> 15);
		if ((h & 0x7c00) != 0x7c00)
			assert_true((double)value == half_value(h));
		else if ((h & 1023) == 0)
			assert_true(isinf(value));
		else
			assert_true(isnan(value));
	}
}

/* All finite halves, what lies between each two of them, and the ties. Beyond 65504 the next half would be 65536. */
static void halves_are_the_nearest(void **state)
{
	(void)state;
	for (uint32_t sign = 0; sign <= 0x8000; sign += 0x8000)
		for (uint32_t h = sign; h <= (sign | 0x7bff); h++) {
			double own = half_value(h), next = sign ? -half_value((h & 0x7fff) + 1) : half_value(h + 1);
			float tie = (float)((own + next) / 2);
			uint32_t even = h % 2 ? h + 1 : h;
			assert_int_equal(stilb_image_half_from_float((float)own), h);
			assert_int_equal(stilb_image_half_from_float(tie), even);
			assert_int_equal(stilb_image_half_from_float(nextafterf(tie, (float)own)), h);
			assert_int_equal(stilb_image_half_from_float(nextafterf(tie, (float)next)), h + 1);
		}
	assert_int_equal(stilb_image_half_from_float(INFINITY), 0x7c00);
	assert_int_equal(stilb_image_half_from_float(-INFINITY), 0xfc00);
	assert_int_equal(stilb_image_half_from_float(3e38f), 0x7c00);
	assert_int_equal(stilb_image_half_from_float(65536.0f), 0x7c00);
	assert_int_equal(stilb_image_half_from_float(-1e-30f), 0x8000);
	assert_int_equal(stilb_image_half_from_float(NAN) & 0x7fff, 0x7e00);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(codes_become_light),     cmocka_unit_test(every_format_has_its_data),
		cmocka_unit_test(data_survive_files),     cmocka_unit_test(halves_are_exact_floats),
		cmocka_unit_test(halves_are_the_nearest),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
