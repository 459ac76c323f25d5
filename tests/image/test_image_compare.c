/* How far pictures are apart, against closed forms; Khronos' number against its definition in other words; masks
 * against each pixel's distance to each edge. */

#include "image/image_compare.h"
#include "support/failing_alloc.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_image made(uint32_t width, uint32_t height, uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	if (stilb_image_create(&image, width, height, channels, format) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static float *at(const stilb_image *image, uint32_t x, uint32_t y)
{
	return (float *)image->pixels + ((size_t)y * image->width + x) * image->channels;
}

static stilb_image_comparison compared(const stilb_image *a, const stilb_image *b, const stilb_image *mask,
                                       double bound)
{
	stilb_image_comparison out;
	if (stilb_image_compare(a, b, mask, bound, &out) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return out;
}

static double fidelity(const stilb_image *candidate, const stilb_image *golden, const stilb_image *mask)
{
	double db;
	if (stilb_image_fidelity(candidate, golden, mask, &db) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return db;
}

#define NEAR(got, want) assert_true(fabs((got) - (want)) <= 1e-12 * fabs(want) + 1e-300)

/* ---- differences ------------------------------------------------------------------------------------------------- */

/* Each channel differs by an exact step at a known share of the pixels. */
static void steps_give_closed_forms(void **state)
{
	(void)state;
	stilb_image a = made(20, 10, 3, STILB_IMAGE_F32_LINEAR), b = made(20, 10, 3, STILB_IMAGE_F32_LINEAR);
	for (uint32_t i = 0; i < 200; i++) {
		float *of_a = at(&a, i % 20, i / 20), *of_b = at(&b, i % 20, i / 20);
		for (int c = 0; c < 3; c++)
			of_a[c] = of_b[c] = (float)(i % 7);
		of_a[0] += i % 4 == 0 ? 0.5f : 0.0f; /* 50 pixels */
		of_a[1] -= 0.25f;
	}
	at(&a, 13, 6)[2] += 3.0f;
	at(&a, 14, 6)[2] -= 3.0f; /* as far, but later */
	stilb_image_comparison out = compared(&a, &b, NULL, 0.25);
	assert_true(out.pixels == 200 && out.channels == 3);
	NEAR(out.rms[0], sqrt(50 * 0.25 / 200));
	NEAR(out.rms[1], 0.25);
	NEAR(out.rms[2], sqrt(18.0 / 200));
	assert_true(out.rms[3] == 0.0);
	NEAR(out.rms_all, sqrt((50 * 0.25 + 200 * 0.0625 + 18) / 600));
	assert_true(out.worst == 3.0 && out.worst_x == 13 && out.worst_y == 6 && out.worst_channel == 2);
	assert_int_equal(out.above, 50 + 2); /* 133 and 134 are not among the 50; a step of the bound itself is not above */
	assert_true(out.largest == 6.0);
	out = compared(&b, &a, NULL, 0.1);
	assert_int_equal(out.above, 200);
	NEAR(out.rms_all, sqrt((50 * 0.25 + 200 * 0.0625 + 18) / 600));
	stilb_image_comparison same = compared(&a, &a, NULL, 0.0);
	assert_true(same.rms_all == 0.0 && same.worst == 0.0 && same.above == 0 && same.pixels == 200);
	stilb_image_finish(&a);
	stilb_image_finish(&b);
}

/* Light and codes of the same picture are the same; named data, their codes are compared. */
static void formats_and_channels_may_differ(void **state)
{
	(void)state;
	stilb_image codes = made(256, 1, 4, STILB_IMAGE_U8_SRGB), light = made(256, 1, 4, STILB_IMAGE_F32_LINEAR);
	for (uint32_t i = 0; i < 1024; i++)
		((uint8_t *)codes.pixels)[i] = (uint8_t)(i / 4);
	stilb_image_row_to_light(&codes, 0, light.pixels);
	stilb_image_comparison out = compared(&codes, &light, NULL, 0.0);
	assert_true(out.channels == 4 && out.worst == 0.0 && out.pixels == 256 && out.largest == 1.0);
	at(&light, 9, 0)[3] += 0.5f;
	out = compared(&codes, &light, NULL, 0.0);
	assert_true(out.worst_channel == 3 && out.worst_x == 9 && out.above == 1);
	NEAR(out.rms[3], out.worst / 16.0);
	stilb_image colors = made(256, 1, 3, STILB_IMAGE_F32_LINEAR);
	for (uint32_t x = 0; x < 256; x++)
		memcpy(at(&colors, x, 0), at(&light, x, 0), 3 * sizeof(float));
	out = compared(&colors, &light, NULL, 0.0);
	assert_true(out.channels == 3 && out.worst == 0.0);
	out = compared(&light, &colors, NULL, 0.0);
	assert_true(out.channels == 3 && out.worst == 0.0 && out.above == 0);
	stilb_image one = codes, two = made(256, 1, 4, STILB_IMAGE_U8_SRGB);
	memcpy(two.pixels, codes.pixels, 1024);
	((uint8_t *)two.pixels)[40] += 2;
	one.format = stilb_image_format_as_data(one.format);
	two.format = stilb_image_format_as_data(two.format);
	assert_true(fabs(compared(&one, &two, NULL, 0.0).worst * 255.0 - 2.0) < 1e-5);
	stilb_image grey = made(2, 2, 1, STILB_IMAGE_F32_LINEAR), veiled = made(2, 2, 2, STILB_IMAGE_F32_LINEAR);
	at(&veiled, 1, 1)[0] = 0.25f;
	at(&veiled, 1, 0)[1] = 9.0f; /* of alpha, which grey has not */
	out = compared(&grey, &veiled, NULL, 0.0);
	assert_true(out.channels == 1 && out.worst == 0.25 && out.worst_x == 1 && out.worst_y == 1 && out.largest == 0.25);
	at(&grey, 0, 0)[0] = 1.0f;
	out = compared(&veiled, &veiled, NULL, 0.0);
	assert_true(out.channels == 2 && out.largest == 9.0);
	stilb_image_finish(&codes);
	stilb_image_finish(&light);
	stilb_image_finish(&colors);
	stilb_image_finish(&two);
	stilb_image_finish(&grey);
	stilb_image_finish(&veiled);
}

static void no_number_passes_no_bound(void **state)
{
	(void)state;
	static const struct {
		float a, b;
		double apart;
	} pairs[] = {{NAN, 1.0f, HUGE_VAL},       {1.0f, NAN, HUGE_VAL},
	             {NAN, NAN, HUGE_VAL},        {INFINITY, INFINITY, 0.0},
	             {-INFINITY, -INFINITY, 0.0}, {INFINITY, -INFINITY, HUGE_VAL},
	             {INFINITY, 3.0f, HUGE_VAL},  {3e38f, -3e38f, (double)3e38f * 2.0},
	             {0.0f, -0.0f, 0.0}};
	for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
		stilb_image a = made(3, 3, 1, STILB_IMAGE_F32_LINEAR), b = made(3, 3, 1, STILB_IMAGE_F32_LINEAR);
		*at(&a, 2, 1) = pairs[i].a;
		*at(&b, 2, 1) = pairs[i].b;
		stilb_image_comparison out = compared(&a, &b, NULL, 1e30);
		assert_true(out.worst == pairs[i].apart);
		assert_int_equal(out.above, pairs[i].apart > 0.0);
		assert_true(out.worst_x == (pairs[i].apart > 0.0 ? 2 : 0));
		assert_true(isinf(pairs[i].apart) ? isinf(out.rms_all) : out.rms_all == pairs[i].apart / 3.0);
		assert_true(isfinite(out.largest));
		stilb_image_finish(&a);
		stilb_image_finish(&b);
	}
}

static void masked_pixels_do_not_count(void **state)
{
	(void)state;
	stilb_image a = made(8, 8, 2, STILB_IMAGE_F32_LINEAR), b = made(8, 8, 2, STILB_IMAGE_F32_LINEAR);
	stilb_image mask = made(8, 8, 1, STILB_IMAGE_U8_LINEAR);
	for (uint32_t i = 0; i < 64; i++) {
		bool kept = i % 3 == 1;
		((uint8_t *)mask.pixels)[i] = kept ? (uint8_t)(1 + i) : 0;
		at(&a, i % 8, i / 8)[0] = kept ? 0.5f : NAN;
		at(&b, i % 8, i / 8)[0] = kept ? 0.25f : 1e9f;
	}
	stilb_image_comparison out = compared(&a, &b, &mask, 0.0);
	assert_true(out.pixels == 21 && out.above == 21 && out.worst == 0.25 && out.largest == 0.25 && out.worst_x == 1);
	NEAR(out.rms[0], 0.25);
	memset(mask.pixels, 0, 64);
	out = compared(&a, &b, &mask, 0.0);
	stilb_image_comparison none = {.channels = 2};
	assert_memory_equal(&out, &none, sizeof none);
	assert_true(isnan(fidelity(&a, &b, &mask)));
	stilb_image_finish(&a);
	stilb_image_finish(&b);
	stilb_image_finish(&mask);
}

/* ---- Khronos' number --------------------------------------------------------------------------------------------- */

/* Grey has Y alone, since YIQ's rows sum to 1, 0 and 0: black on white is 0.5053 * 255^2 = 32857 of 35215, a step of
 * one grey code 0.5053. Over white, black with a fifth of the alpha is a step of 51 codes. */
static void fidelity_has_closed_forms(void **state)
{
	(void)state;
	stilb_image black = made(16, 4, 3, STILB_IMAGE_U8_SRGB), white = made(16, 4, 3, STILB_IMAGE_U8_SRGB);
	memset(white.pixels, 255, stilb_image_size(&white));
	assert_true(isinf(fidelity(&black, &black, NULL)) && fidelity(&black, &black, NULL) < 0.0);
	double step = 10.0 * log10(0.5053 / 35215.0);
	assert_true(fabs(fidelity(&black, &white, NULL) - (step + 20.0 * log10(255.0))) < 1e-6);
	stilb_image grey = made(16, 4, 1, STILB_IMAGE_U8_SRGB);
	memset(grey.pixels, 1, 64);
	assert_true(fabs(fidelity(&black, &grey, NULL) - step) < 1e-6);
	memset(grey.pixels, 0, 48); /* a quarter of the pixels: the root of the mean square halves */
	assert_true(fabs(fidelity(&black, &grey, NULL) - (step - 10.0 * log10(2.0))) < 1e-6);
	/* red, from the definition: y = 0.29889531, i = 0.59597799, q = 0.21147017 times 255 */
	stilb_image red = made(16, 4, 3, STILB_IMAGE_U8_SRGB);
	for (int i = 0; i < 64; i++)
		((uint8_t *)red.pixels)[3 * i] = 255;
	double distance = 255.0 * 255.0 * (0.5053 * 0.089338 + 0.299 * 0.355190 + 0.1957 * 0.044720);
	assert_true(fabs(fidelity(&red, &black, NULL) - 10.0 * log10(distance / 35215.0)) < 1e-4);
	stilb_image clear = made(16, 4, 4, STILB_IMAGE_U8_SRGB);
	assert_true(isnan(fidelity(&clear, &black, NULL))); /* no pixel of the candidate is there */
	assert_true(fabs(fidelity(&black, &clear, NULL) - (step + 20.0 * log10(255.0))) < 1e-6); /* clear is white */
	for (int i = 0; i < 32; i++)
		((uint8_t *)clear.pixels)[4 * i + 3] = 51; /* a fifth: 4 / 5 white */
	assert_true(fabs(fidelity(&clear, &white, NULL) - (step + 20.0 * log10(51.0))) < 1e-6);
	stilb_image light = made(16, 4, 3, STILB_IMAGE_F32_LINEAR); /* 0.5 is code 188 */
	for (int i = 0; i < 192; i++)
		((float *)light.pixels)[i] = 0.5f;
	assert_true(fabs(fidelity(&light, &black, NULL) - (step + 20.0 * log10(188.0))) < 1e-6);
	stilb_image_finish(&black);
	stilb_image_finish(&white);
	stilb_image_finish(&grey);
	stilb_image_finish(&red);
	stilb_image_finish(&clear);
	stilb_image_finish(&light);
}

/* All three differences at random, over white, as the distance of each pixel's YIQ; in the tool's order of words. */
static void fidelity_of_noise(void **state)
{
	(void)state;
	static const double yiq[3][3] = {{0.29889531, 0.58662247, 0.11448223},
	                                 {0.59597799, -0.27417610, -0.32180189},
	                                 {0.21147017, -0.52261711, 0.31114694}};
	static const double weights[3] = {0.5053, 0.299, 0.1957};
	stilb_image pair[2] = {made(31, 17, 4, STILB_IMAGE_U8_SRGB), made(31, 17, 4, STILB_IMAGE_U8_SRGB)};
	for (uint32_t i = 0; i < 31 * 17 * 4; i++)
		for (uint32_t k = 0; k < 2; k++)
			((uint8_t *)pair[k].pixels)[i] = (uint8_t)stilb_random_u64(k, i);
	double sum = 0.0, count = 0.0;
	for (uint32_t p = 0; p < 31 * 17; p++) {
		const uint8_t *codes[2] = {(uint8_t *)pair[0].pixels + 4 * (size_t)p,
		                           (uint8_t *)pair[1].pixels + 4 * (size_t)p};
		double delta = 0.0;
		for (int row = 0; row < 3; row++) {
			double value[2] = {0, 0};
			for (int k = 0; k < 2; k++)
				for (int c = 0; c < 3; c++)
					value[k] += yiq[row][c] * (255.0 + (codes[k][c] - 255.0) * (codes[k][3] / 255.0));
			delta += weights[row] * (value[0] - value[1]) * (value[0] - value[1]);
		}
		sum += codes[0][3] ? delta * delta : 0.0;
		count += codes[0][3] > 0;
	}
	assert_true(fabs(fidelity(&pair[0], &pair[1], NULL) - 10.0 * log10(sqrt(sum / count) / 35215.0)) < 1e-9);
	stilb_image_finish(&pair[0]);
	stilb_image_finish(&pair[1]);
}

/* ---- masks ------------------------------------------------------------------------------------------------------- */

#define SIDE_X 23
#define SIDE_Y 17

static bool differ(const stilb_image *image, uint32_t x, uint32_t y, uint32_t u, uint32_t v)
{
	return u < SIDE_X && v < SIDE_Y && *at(image, x, y) != *at(image, u, v);
}

/* Random spots of ids: each pixel's distance to each pixel of an edge. */
static void edges_are_as_far_as_said(void **state)
{
	(void)state;
	for (uint32_t seed = 0; seed < 40; seed++) {
		uint32_t distance = seed % 5;
		stilb_image ids = made(SIDE_X, SIDE_Y, 1, STILB_IMAGE_F32_LINEAR), mask = {0};
		for (uint32_t spot = 0; spot < seed % 4; spot++)
			*at(&ids, (uint32_t)stilb_random_u64(seed, 2 * spot) % SIDE_X,
			    (uint32_t)stilb_random_u64(seed, 2 * spot + 1) % SIDE_Y) = (float)(spot + 1);
		assert_int_equal(stilb_image_mask_edges(&ids, 0.0f, 0.0f, distance, &mask), STILB_OK);
		assert_true(mask.channels == 1 && mask.format == STILB_IMAGE_U8_LINEAR && mask.width == SIDE_X);
		for (uint32_t i = 0; i < SIDE_X * SIDE_Y; i++) {
			bool kept = true;
			for (uint32_t k = 0; k < SIDE_X * SIDE_Y; k++) {
				uint32_t x = k % SIDE_X, y = k / SIDE_X;
				bool edge = differ(&ids, x, y, x - 1, y) || differ(&ids, x, y, x + 1, y) ||
				            differ(&ids, x, y, x, y - 1) || differ(&ids, x, y, x, y + 1);
				kept &= !edge || (uint32_t)abs((int)(i % SIDE_X) - (int)x) > distance ||
				        (uint32_t)abs((int)(i / SIDE_X) - (int)y) > distance;
			}
			assert_int_equal(((uint8_t *)mask.pixels)[i], kept ? 255 : 0);
		}
		stilb_image_finish(&ids);
		stilb_image_finish(&mask);
	}
}

/* How many of eight pixels in a row are left out, with an edge between the fourth and the fifth alone, or none. */
static uint32_t left_out(float before, float after, float step, float share)
{
	stilb_image depth = made(8, 1, 1, STILB_IMAGE_F32_LINEAR), mask = {0};
	for (uint32_t x = 0; x < 8; x++)
		*at(&depth, x, 0) = x < 4 ? before : after;
	assert_int_equal(stilb_image_mask_edges(&depth, step, share, 0, &mask), STILB_OK);
	uint32_t count = 0;
	for (uint32_t x = 0; x < 8; x++)
		count += ((uint8_t *)mask.pixels)[x] == 0;
	stilb_image_finish(&depth);
	stilb_image_finish(&mask);
	return count;
}

static void depths_have_a_step_and_a_share(void **state)
{
	(void)state;
	assert_int_equal(left_out(1.0f, 1.5f, 0.5f, 0.0f), 0);
	assert_int_equal(left_out(1.0f, 1.625f, 0.5f, 0.0f), 2);
	assert_int_equal(left_out(100.0f, 110.0f, 0.0f, 0.125f), 0); /* 10 of 110 */
	assert_int_equal(left_out(100.0f, 120.0f, 0.0f, 0.125f), 2);
	assert_int_equal(left_out(-100.0f, -110.0f, 0.0f, 0.125f), 0);
	assert_int_equal(left_out(8.0f, 10.0f, 0.5f, 0.125f), 2); /* 2 of 1.75 */
	assert_int_equal(left_out(8.0f, 9.5f, 0.5f, 0.125f), 0);
	assert_int_equal(left_out(INFINITY, INFINITY, 0.0f, 0.125f), 0); /* the sky */
	assert_int_equal(left_out(5.0f, INFINITY, 1.0f, 0.125f), 2);
	assert_int_equal(left_out(NAN, NAN, 1.0f, 1.0f), 8);
}

static void masks_keep_what_both_keep(void **state)
{
	(void)state;
	stilb_image across = made(9, 9, 3, STILB_IMAGE_U8_SRGB), down = made(9, 9, 2, STILB_IMAGE_F32_LINEAR), mask = {0};
	for (uint32_t i = 0; i < 81; i++) {
		((uint8_t *)across.pixels)[3 * i + 2] = i % 9 < 3 ? 1 : 2; /* in the last channel alone */
		at(&down, i % 9, i / 9)[1] = i / 9 < 6 ? 1.0f : 2.0f;
	}
	assert_int_equal(stilb_image_mask_edges(&across, 0.0f, 0.0f, 0, &mask), STILB_OK);
	assert_int_equal(stilb_image_mask_edges(&down, 0.0f, 0.0f, 1, &mask), STILB_OK);
	for (uint32_t i = 0; i < 81; i++) {
		uint32_t x = i % 9, y = i / 9;
		assert_int_equal(((uint8_t *)mask.pixels)[i], x == 2 || x == 3 || (y >= 4 && y <= 7) ? 0 : 255);
	}
	stilb_image_finish(&across);
	stilb_image_finish(&down);
	stilb_image_finish(&mask);
}

/* ---- what is refused --------------------------------------------------------------------------------------------- */

static void refused(stilb_result got, stilb_result want, const char *why)
{
	assert_int_equal(got, want);
	if (!strstr(stilb_error_message(), why))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), why);
}

static void other_shapes_are_refused(void **state)
{
	(void)state;
	stilb_image a = made(4, 3, 3, STILB_IMAGE_F32_LINEAR), tall = made(4, 4, 3, STILB_IMAGE_F32_LINEAR);
	stilb_image grey = made(4, 3, 1, STILB_IMAGE_U8_SRGB), mask = made(4, 3, 1, STILB_IMAGE_U8_LINEAR);
	stilb_image small = made(3, 3, 1, STILB_IMAGE_U8_LINEAR);
	stilb_image_comparison out = {.pixels = 5};
	double db = 1.0;
	refused(stilb_image_compare(&a, &tall, NULL, 0.0, &out), STILB_ERROR_ARGUMENT, "4 x 3 and 4 x 4");
	assert_true(out.pixels == 0);
	refused(stilb_image_compare(&a, &grey, NULL, 0.0, &out), STILB_ERROR_ARGUMENT, "3 channels with one of 1");
	refused(stilb_image_compare(&a, &a, &small, 0.0, &out), STILB_ERROR_ARGUMENT, "one of 3 x 3 with 1 channels");
	refused(stilb_image_compare(&a, &a, &grey, 0.0, &out), STILB_ERROR_ARGUMENT, "with one channel in U8_LINEAR");
	refused(stilb_image_fidelity(&a, &tall, NULL, &db), STILB_ERROR_ARGUMENT, "4 x 3 and 4 x 4");
	assert_true(isnan(db));
	refused(stilb_image_fidelity(&a, &a, &small, &db), STILB_ERROR_ARGUMENT, "one of 3 x 3");
	refused(stilb_image_mask_edges(&a, 0.0f, 0.0f, 1, &small), STILB_ERROR_ARGUMENT, "one of 3 x 3");
	for (int i = 0; i < 2; i++) {
		fail_after = i;
		refused(stilb_image_compare(&a, &a, &mask, 0.0, &out), STILB_ERROR_MEMORY, "4 x 3 pixels: out of memory");
		fail_after = i;
		refused(stilb_image_fidelity(&a, &a, &mask, &db), STILB_ERROR_MEMORY, "4 x 3 pixels: out of memory");
	}
	for (int i = 0; i < 4; i++) {
		stilb_image empty = {0};
		fail_after = i;
		refused(stilb_image_mask_edges(&a, 0.0f, 0.0f, 1, &empty), STILB_ERROR_MEMORY, "4 x 3 pixels");
		assert_null(empty.pixels);
	}
	fail_after = -1;
	stilb_image_finish(&a);
	stilb_image_finish(&tall);
	stilb_image_finish(&grey);
	stilb_image_finish(&mask);
	stilb_image_finish(&small);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(steps_give_closed_forms),   cmocka_unit_test(formats_and_channels_may_differ),
		cmocka_unit_test(no_number_passes_no_bound), cmocka_unit_test(masked_pixels_do_not_count),
		cmocka_unit_test(fidelity_has_closed_forms), cmocka_unit_test(fidelity_of_noise),
		cmocka_unit_test(edges_are_as_far_as_said),  cmocka_unit_test(depths_have_a_step_and_a_share),
		cmocka_unit_test(masks_keep_what_both_keep), cmocka_unit_test(other_shapes_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
