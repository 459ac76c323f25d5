/* Mip chains of normal and roughness maps against averages in double over the whole map; wrong input is refused. */

#include "image/image_normals.h"

#include "shading/shade_normal_filter.h"
#include "support/failing_alloc.h"
#include "support/shade_proof.h"

#include <string.h>

/* ---- maps -------------------------------------------------------------------------------------------------------- */

static stilb_image made(uint32_t width, uint32_t height, uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	if (stilb_image_create(&image, width, height, channels, format) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static float *float_pixel(const stilb_image *image, uint32_t x, uint32_t y)
{
	return (float *)image->pixels + ((size_t)y * image->width + x) * image->channels;
}

typedef struct maps {
	stilb_image normals, roughness;
} maps;

static maps maps_make(uint32_t width, uint32_t height)
{
	return (maps){made(width, height, 3, STILB_IMAGE_F32_LINEAR), made(width, height, 1, STILB_IMAGE_F32_LINEAR)};
}

static void maps_set(const maps *m, uint32_t x, uint32_t y, stilb_vec3 normal, float roughness)
{
	for (int k = 0; k < 3; k++)
		float_pixel(&m->normals, x, y)[k] = normal[k];
	*float_pixel(&m->roughness, x, y) = roughness;
}

/* Random bumps, tilted by up to 40 degrees for steepness 1; in object space normals in all directions. */
static maps maps_random(uint32_t width, uint32_t height, stilb_normal_space space, uint64_t seed)
{
	maps m = maps_make(width, height);
	shade_proof_random random = {.seed = seed};
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			stilb_vec3 n = shade_proof_random_direction(&random);
			if (space == STILB_NORMAL_SPACE_TANGENT)
				n = stilb_vec3_normalize(stilb_vec3_make(0.6f * n[0], 0.6f * n[1], 1.0f));
			maps_set(&m, x, y, n, shade_proof_range(&random, 0.1f, 1.0f));
		}
	return m;
}

static void maps_finish(maps *m)
{
	stilb_image_finish(&m->normals);
	stilb_image_finish(&m->roughness);
}

static stilb_image_normals chain_of(const maps *m, stilb_normal_filter filter, stilb_normal_space space)
{
	stilb_image_normals_desc desc = stilb_image_normals_desc_default(&m->normals);
	desc.roughness = m->roughness.pixels ? &m->roughness : NULL;
	desc.filter = filter;
	desc.space = space;
	stilb_image_normals chain;
	if (stilb_image_normals_create(&desc, &chain) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return chain;
}

static const float *last_pixel(const stilb_image_normals *chain)
{
	return chain->levels[chain->level_count - 1].pixels;
}

/* ---- truth: the whole map at once, in double --------------------------------------------------------------------- */

typedef struct truth {
	double normal[3], alpha;
} truth;

static double langevin(double k)
{
	return 1.0 / tanh(1.0 / k) - k;
}

/* 1 / sharpness of the mean length r, by bisection. */
static double inverse_sharpness_of(double r)
{
	double low = 0.0, high = 100.0;
	for (int i = 0; i < 200; i++) {
		double middle = 0.5 * (low + high);
		if (langevin(middle) > r)
			low = middle;
		else
			high = middle;
	}
	return low;
}

typedef struct sums {
	double r[3], n[3], toksvig[3], slope[2], slope2, alpha2;
} sums;

static sums sums_of(const maps *m)
{
	sums s = {.alpha2 = 0.0};
	double share = 1.0 / ((double)m->normals.width * m->normals.height);
	for (uint32_t y = 0; y < m->normals.height; y++)
		for (uint32_t x = 0; x < m->normals.width; x++) {
			const float *n = float_pixel(&m->normals, x, y);
			double rough = (double)*float_pixel(&m->roughness, x, y), alpha2 = pow(rough, 4.0);
			double size = sqrt(pow((double)n[0], 2.0) + pow((double)n[1], 2.0) + pow((double)n[2], 2.0));
			for (int k = 0; k < 3; k++) {
				s.n[k] += share * (double)n[k] / size;
				s.r[k] += share * (double)n[k] / size * langevin(alpha2 / 2.0);
				s.toksvig[k] += share * (double)n[k] / size * (2.0 - 2.0 * alpha2) / (2.0 - alpha2);
			}
			double slope_x = (double)(n[0] / n[2]), slope_y = (double)(n[1] / n[2]);
			s.slope[0] += share * slope_x;
			s.slope[1] += share * slope_y;
			s.slope2 += share * (slope_x * slope_x + slope_y * slope_y);
			s.alpha2 += share * alpha2;
		}
	return s;
}

static truth truth_of(stilb_normal_filter filter, const maps *m)
{
	sums s = sums_of(m);
	const double *v = filter == STILB_NORMAL_FILTER_VMF ? s.r : filter == STILB_NORMAL_FILTER_TOKSVIG ? s.toksvig : s.n;
	const double slopes[3] = {s.slope[0], s.slope[1], 1.0};
	if (filter == STILB_NORMAL_FILTER_LEAN)
		v = slopes;
	double size = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), alpha2;
	if (filter == STILB_NORMAL_FILTER_VMF)
		alpha2 = 2.0 * inverse_sharpness_of(size);
	else if (filter == STILB_NORMAL_FILTER_TOKSVIG)
		alpha2 = 2.0 * (1.0 - size) / (2.0 - size);
	else if (filter == STILB_NORMAL_FILTER_VARIANCE)
		alpha2 = s.alpha2 + 2.0 * (1.0 - size) / size;
	else if (filter == STILB_NORMAL_FILTER_CONVOLUTION)
		alpha2 = s.alpha2 + 2.0 * inverse_sharpness_of(size);
	else
		alpha2 = s.alpha2 + s.slope2 - s.slope[0] * s.slope[0] - s.slope[1] * s.slope[1];
	return (truth){{v[0] / size, v[1] / size, v[2] / size}, fmin(sqrt(alpha2), 1.0)};
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* For sides of any length every pixel has the same weight in the last level. */
static void the_last_level_stands_for_the_map(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{1, 1}, {2, 2}, {16, 16}, {5, 3}, {7, 1}, {1, 6}, {23, 40}, {33, 31}};
	for (size_t i = 0; i < sizeof sides / sizeof sides[0]; i++)
		for (int space = 0; space < 2; space++)
			for (int f = 0; f < STILB_NORMAL_FILTER_COUNT; f++) {
				if (space == STILB_NORMAL_SPACE_OBJECT && f == STILB_NORMAL_FILTER_LEAN)
					continue;
				maps m = maps_random(sides[i][0], sides[i][1], (stilb_normal_space)space, i);
				stilb_image_normals chain = chain_of(&m, (stilb_normal_filter)f, (stilb_normal_space)space);
				const float *got = last_pixel(&chain);
				truth want = truth_of((stilb_normal_filter)f, &m);
				for (int k = 0; k < 3; k++)
					SHADE_PROOF_NEAR(got[k], want.normal[k], 0.0, 2e-5);
				SHADE_PROOF_NEAR(got[3] * got[3], want.alpha, 1e-5, 0.0);
				stilb_image_normals_finish(&chain);
				maps_finish(&m);
			}
}

/* A pixel of level 2 of an 8 x 8 map is the last level of the 4 x 4 piece of the map that it covers. */
static void levels_stand_for_their_pieces(void **state)
{
	(void)state;
	maps m = maps_random(8, 8, STILB_NORMAL_SPACE_TANGENT, 9), piece = maps_make(4, 4);
	for (int f = 0; f < STILB_NORMAL_FILTER_COUNT; f++) {
		stilb_image_normals chain = chain_of(&m, (stilb_normal_filter)f, STILB_NORMAL_SPACE_TANGENT);
		assert_int_equal(chain.level_count, 4);
		assert_int_equal(chain.levels[2].width, 2);
		for (uint32_t p = 0; p < 4; p++) {
			for (uint32_t i = 0; i < 16; i++) {
				uint32_t x = p % 2 * 4 + i % 4, y = p / 2 * 4 + i / 4;
				const float *n = float_pixel(&m.normals, x, y);
				maps_set(&piece, i % 4, i / 4, stilb_vec3_make(n[0], n[1], n[2]), *float_pixel(&m.roughness, x, y));
			}
			truth want = truth_of((stilb_normal_filter)f, &piece);
			const float *got = float_pixel(&chain.levels[2], p % 2, p / 2);
			for (int k = 0; k < 3; k++)
				SHADE_PROOF_NEAR(got[k], want.normal[k], 0.0, 1e-5);
			SHADE_PROOF_NEAR(got[3] * got[3], want.alpha, 1e-5, 0.0);
		}
		stilb_image_normals_finish(&chain);
	}
	maps_finish(&m);
	maps_finish(&piece);
}

static void flat_maps_stay(void **state)
{
	(void)state;
	static const float roughnesses[] = {0.0f, 0.04f, 0.3f, 1.0f};
	stilb_vec3 tilted = stilb_vec3_normalize(stilb_vec3_make(0.3f, -0.2f, 0.9f));
	for (int f = 0; f < STILB_NORMAL_FILTER_COUNT; f++)
		for (int r = 0; r < 4; r++) {
			maps m = maps_make(13, 6);
			for (uint32_t i = 0; i < 13 * 6; i++)
				maps_set(&m, i % 13, i / 13, tilted * 0.5f, roughnesses[r]);
			stilb_image_normals chain = chain_of(&m, (stilb_normal_filter)f, STILB_NORMAL_SPACE_TANGENT);
			for (uint32_t level = 0; level < chain.level_count; level++) {
				const float *got = chain.levels[level].pixels;
				for (int k = 0; k < 3; k++)
					SHADE_PROOF_NEAR(got[k], (double)tilted[k], 0.0, 2e-7);
				SHADE_PROOF_NEAR(got[3] * got[3], fmax((double)(roughnesses[r] * roughnesses[r]), 1e-3), 1e-4, 0.0);
			}
			stilb_image_normals_finish(&chain);
			maps_finish(&m);
		}
}

/* Half the map smooth and leaning to +X, half rough and leaning to -X. */
static void a_smooth_normal_outweighs_a_rough_one(void **state)
{
	(void)state;
	maps m = maps_make(4, 4);
	for (uint32_t i = 0; i < 16; i++)
		maps_set(&m, i % 4, i / 4, stilb_vec3_make(i % 2 ? -0.3f : 0.3f, 0.0f, 1.0f), i % 2 ? 0.9f : 0.2f);
	for (int f = 0; f < STILB_NORMAL_FILTER_COUNT; f++) {
		stilb_image_normals chain = chain_of(&m, (stilb_normal_filter)f, STILB_NORMAL_SPACE_TANGENT);
		float lean = last_pixel(&chain)[0];
		if (f == STILB_NORMAL_FILTER_VMF || f == STILB_NORMAL_FILTER_TOKSVIG)
			assert_true(lean > 0.05f);
		else
			assert_true(fabsf(lean) < 1e-6f);
		stilb_image_normals_finish(&chain);
	}
	maps_finish(&m);
}

/* Turning a map in object space turns its chain: axes swapped in a circle. */
static void object_space_has_no_axis(void **state)
{
	(void)state;
	maps m = maps_random(9, 12, STILB_NORMAL_SPACE_OBJECT, 4), turned = maps_make(9, 12);
	for (uint32_t i = 0; i < 9 * 12; i++) {
		const float *n = float_pixel(&m.normals, i % 9, i / 9);
		maps_set(&turned, i % 9, i / 9, stilb_vec3_make(n[1], n[2], n[0]), *float_pixel(&m.roughness, i % 9, i / 9));
	}
	for (int f = 0; f < STILB_NORMAL_FILTER_LEAN; f++) {
		stilb_image_normals a = chain_of(&m, (stilb_normal_filter)f, STILB_NORMAL_SPACE_OBJECT);
		stilb_image_normals b = chain_of(&turned, (stilb_normal_filter)f, STILB_NORMAL_SPACE_OBJECT);
		for (uint32_t level = 0; level < a.level_count; level++) {
			const float *p = a.levels[level].pixels, *q = b.levels[level].pixels;
			for (int k = 0; k < 3; k++)
				SHADE_PROOF_NEAR(q[k], (double)p[(k + 1) % 3], 0.0, 1e-5);
			SHADE_PROOF_NEAR(q[3], (double)p[3], 1e-5, 0.0);
		}
		stilb_image_normals_finish(&a);
		stilb_image_normals_finish(&b);
	}
	maps_finish(&m);
	maps_finish(&turned);
}

/* Codes are numbers: the largest is 1, 0 is -1 (normal) or 0 (roughness), and nothing goes through the sRGB transfer,
 * whether a reader took them for colour or not. */
static void codes_are_numbers(void **state)
{
	(void)state;
	static const stilb_image_format formats[] = {STILB_IMAGE_U8_SRGB, STILB_IMAGE_U8_LINEAR, STILB_IMAGE_U16_SRGB,
	                                             STILB_IMAGE_U16_LINEAR};
	static const uint8_t normal[] = {255, 0, 204, 7}, roughness[] = {102, 255};
	maps m;
	stilb_image_normals chain;
	for (int f = 0; f < 4; f++) {
		m = (maps){made(1, 1, 4, formats[f]), made(1, 1, 2, formats[f])};
		for (int i = 0; i < 4; i++)
			if (f < 2)
				((uint8_t *)m.normals.pixels)[i] = normal[i];
			else
				((uint16_t *)m.normals.pixels)[i] = (uint16_t)(normal[i] * 257);
		for (int i = 0; i < 2; i++)
			if (f < 2)
				((uint8_t *)m.roughness.pixels)[i] = roughness[i];
			else
				((uint16_t *)m.roughness.pixels)[i] = (uint16_t)(roughness[i] * 257);
		chain = chain_of(&m, STILB_NORMAL_FILTER_VMF, STILB_NORMAL_SPACE_TANGENT);
		const float *got = last_pixel(&chain);
		double size = sqrt(1.0 + 1.0 + 0.36);
		SHADE_PROOF_NEAR(got[0], 1.0 / size, 1e-6, 0.0);
		SHADE_PROOF_NEAR(got[1], -1.0 / size, 1e-6, 0.0);
		SHADE_PROOF_NEAR(got[2], 0.6 / size, 1e-6, 0.0);
		SHADE_PROOF_NEAR(got[3], 0.4, 1e-6, 0.0);
		stilb_image_normals_finish(&chain);
		maps_finish(&m);
	}

	m = (maps){made(1, 1, 2, STILB_IMAGE_F32_LINEAR), {0}}; /* z from x and y; no roughness map */
	memcpy(m.normals.pixels, (float[]){0.48f, -0.6f}, 8);
	chain = chain_of(&m, STILB_NORMAL_FILTER_VMF, STILB_NORMAL_SPACE_TANGENT);
	SHADE_PROOF_NEAR(last_pixel(&chain)[2], 0.64, 1e-6, 0.0);
	SHADE_PROOF_NEAR(last_pixel(&chain)[3], 0.5, 1e-6, 0.0);
	stilb_image_normals_finish(&chain);
	maps_finish(&m);
}

static void refused(stilb_image_normals_desc desc, stilb_result result, const char *why)
{
	stilb_image_normals chain = {.level_count = 3};
	assert_int_equal(stilb_image_normals_create(&desc, &chain), result);
	assert_int_equal(chain.level_count, 0);
	assert_null(chain.levels[0].pixels);
	if (!strstr(stilb_error_message(), why))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), why);
}

static void bad_input_is_refused(void **state)
{
	(void)state;
	maps m = maps_random(4, 3, STILB_NORMAL_SPACE_TANGENT, 1);
	stilb_image other = made(4, 4, 1, STILB_IMAGE_F32_LINEAR), half = made(4, 3, 3, STILB_IMAGE_F16_LINEAR);
	stilb_image blocks = made(4, 3, 4, STILB_IMAGE_BC7_LINEAR);
	stilb_image empty = {.width = 0}, two = made(4, 3, 2, STILB_IMAGE_F32_LINEAR);
	stilb_image_normals_desc good = stilb_image_normals_desc_default(&m.normals);
	stilb_image_normals_desc bad = good;
#define REFUSED(member, value, result, why)                                                                            \
	bad = good, bad.member = value;                                                                                    \
	refused(bad, result, why)
	REFUSED(normals, NULL, STILB_ERROR_ARGUMENT, "a picture is empty");
	REFUSED(roughness, &empty, STILB_ERROR_ARGUMENT, "a picture is empty");
	REFUSED(normals, &half, STILB_ERROR_ARGUMENT, "halves");
	REFUSED(roughness, &half, STILB_ERROR_ARGUMENT, "halves");
	REFUSED(normals, &blocks, STILB_ERROR_ARGUMENT, "blocks");
	REFUSED(normals, &other, STILB_ERROR_ARGUMENT, "one channel");
	REFUSED(roughness, &other, STILB_ERROR_ARGUMENT, "4 x 3 pixels, the roughness has 4 x 4");
	REFUSED(constant_roughness, 1.5f, STILB_ERROR_ARGUMENT, "constant_roughness");
	REFUSED(constant_roughness, NAN, STILB_ERROR_ARGUMENT, "constant_roughness");
	REFUSED(filter, STILB_NORMAL_FILTER_COUNT, STILB_ERROR_ARGUMENT, "unknown filter");
	bad = good, bad.filter = STILB_NORMAL_FILTER_LEAN, bad.space = STILB_NORMAL_SPACE_OBJECT;
	refused(bad, STILB_ERROR_ARGUMENT, "needs tangent space");
	bad = good, bad.normals = &two, bad.space = STILB_NORMAL_SPACE_OBJECT;
	refused(bad, STILB_ERROR_ARGUMENT, "2 channels");
	bad = good, bad.roughness = &m.roughness;
	*float_pixel(&m.roughness, 2, 1) = -0.1f;
	refused(bad, STILB_ERROR_ARGUMENT, "pixel (2, 1) is -0.1");
	memset(float_pixel(&m.normals, 3, 2), 0, 12);
	refused(good, STILB_ERROR_ARGUMENT, "pixel (3, 2) is (0, 0, 0)");
	*float_pixel(&m.normals, 1, 0) = NAN;
	refused(good, STILB_ERROR_ARGUMENT, "pixel (1, 0)");
	stilb_image_finish(&other);
	stilb_image_finish(&half);
	stilb_image_finish(&blocks);
	stilb_image_finish(&two);
	maps_finish(&m);
}

/* Every allocation fails once; nothing leaks, as the address sanitizer sees. */
static void out_of_memory_is_told(void **state)
{
	(void)state;
	maps m = maps_random(9, 5, STILB_NORMAL_SPACE_TANGENT, 1);
	stilb_image_normals_desc desc = stilb_image_normals_desc_default(&m.normals);
	stilb_image_normals chain;
	int failures = 0;
	for (;; failures++) {
		fail_after = failures;
		stilb_result result = stilb_image_normals_create(&desc, &chain);
		bool failed = fail_after < 0;
		fail_after = -1;
		if (!failed) {
			assert_int_equal(result, STILB_OK);
			break;
		}
		assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_non_null(strstr(stilb_error_message(), "out of memory"));
		assert_int_equal(chain.level_count, 0);
	}
	assert_int_equal(failures, 4 + 3); /* the levels, and what three of them are resolved from */
	stilb_image_normals_finish(&chain);
	stilb_image_normals_finish(&chain);
	stilb_image_normals_finish(NULL);
	maps_finish(&m);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_last_level_stands_for_the_map),
		cmocka_unit_test(levels_stand_for_their_pieces),
		cmocka_unit_test(flat_maps_stay),
		cmocka_unit_test(a_smooth_normal_outweighs_a_rough_one),
		cmocka_unit_test(object_space_has_no_axis),
		cmocka_unit_test(codes_are_numbers),
		cmocka_unit_test(bad_input_is_refused),
		cmocka_unit_test(out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
