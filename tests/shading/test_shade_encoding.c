/* How colours are stored: the sRGB transfer, RGBM, XYZ and LogLuv: against their formulas in double, and their errors
 * over ten million colours against the precision that the header states. */

#include "shading/shade_encoding.h"
#include "shading/shade_srgb.h"

#include "support/shade_proof.h"

#include <stdio.h>

#define MANY 10000000 /* colours whose error is measured */

static double unorm8(double x)
{
	return floor(255.0 * x + 0.5) / 255.0;
}

static float largest(stilb_vec3 v)
{
	return fmaxf(v[0], fmaxf(v[1], v[2]));
}

/* A colour whose brightness is anywhere in [1e-30, 1e30). */
static stilb_vec3 random_any_color(shade_proof_random *random)
{
	float height = shade_proof_log_range(random, 1e-15f, 1e15f) * shade_proof_log_range(random, 1e-15f, 1e15f);
	return shade_proof_random_color(random, 1.0f) * height;
}

static double worst_channel(stilb_vec3 a, stilb_vec3 b)
{
	stilb_vec3 d = a - b;
	return (double)fmaxf(fabsf(d[0]), fmaxf(fabsf(d[1]), fabsf(d[2])));
}

/* ---- sRGB -------------------------------------------------------------------------------------------------------- */

static double srgb_exact(double light)
{
	return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

static double srgb_inverse_exact(double code)
{
	return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

static void srgb_has_its_known_values(void **state)
{
	(void)state;
	static const double known[][2] = {{0.0, 0.0},           {1.0, 1.0},       {0.5, 0.735356983}, {0.18, 0.461356129},
	                                  {0.0031308, 0.04045}, {0.001, 0.01292}, {0.2140411, 0.5},   {0.03310477, 0.2}};
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
		SHADE_PROOF_NEAR(shade_srgb_from_linear((float)known[i][0]), known[i][1], 0.0, 5e-7);
		SHADE_PROOF_NEAR(shade_srgb_to_linear((float)known[i][1]), known[i][0], 0.0, 5e-7);
	}
	assert_true(shade_srgb_from_linear(0.0f) == 0.0f && shade_srgb_to_linear(0.0f) == 0.0f);
	assert_int_equal(lrintf(255.0f * shade_srgb_from_linear(1.0f)), 255);
}

/* sRGB is a line for dark values and a power for others. The two are closest where the one follows the other; 0.1 %
 * beside that place they differ by 1e-5 of themselves. */
static void srgb_changes_piece_where_it_should(void **state)
{
	(void)state;
	for (int i = -10; i <= 10; i++) {
		double light = 0.0031308 * (1.0 + 1e-4 * (i + 0.5)), code = 0.04045 * (1.0 + 1e-4 * (i + 0.5));
		SHADE_PROOF_NEAR(shade_srgb_from_linear((float)light), srgb_exact(light), 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_srgb_to_linear((float)code), srgb_inverse_exact(code), 2e-6, 0.0);
	}
}

static void srgb_goes_there_and_back(void **state)
{
	(void)state;
	float last = -1.0f;
	for (int i = 0; i <= 65535; i++) {
		float light = (float)i / 65535.0f, code = shade_srgb_from_linear(light);
		assert_true(code > last);
		last = code;
		SHADE_PROOF_NEAR(code, srgb_exact((double)light), 0.0, 3e-7);
		SHADE_PROOF_NEAR(shade_srgb_to_linear(code), (double)light, 0.0, 1e-6);
	}
	for (int code = 0; code < 256; code++) /* 8-bit codes survive exactly */
		assert_int_equal(lrintf(255.0f * shade_srgb_from_linear(shade_srgb_to_linear((float)code / 255.0f))), code);
}

/* ---- 8 bits ------------------------------------------------------------------------------------------------------ */

static void unorm8_is_the_nearest_step(void **state)
{
	(void)state;
	for (int code = 0; code < 255; code++) {
		stilb_vec4 beside = {((float)code + 0.4998f) / 255.0f, ((float)code + 0.5002f) / 255.0f, -0.3f, 1.7f};
		stilb_vec4 stored = shade_unorm8(beside);
		SHADE_PROOF_NEAR(stored[0], code / 255.0, 1e-7, 0.0);
		SHADE_PROOF_NEAR(stored[1], (code + 1) / 255.0, 1e-7, 0.0);
		assert_true(stored[2] == 0.0f && stored[3] == 1.0f);
	}
}

/* ---- RGBM -------------------------------------------------------------------------------------------------------- */

static stilb_vec3 rgbm_stored_and_read(stilb_vec3 color, float factor, float gamma)
{
	return shade_rgbm_decode(shade_unorm8(shade_rgbm_encode(color, factor, gamma)), factor, gamma);
}

static void rgbm_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {1, 0};
	for (int i = 0; i < 2000; i++) {
		float factor = shade_proof_range(&random, 1.0f, 8.0f), gamma = shade_proof_range(&random, 1.0f, 3.0f);
		stilb_vec3 color = shade_proof_random_color(&random, powf(factor, gamma) * shade_proof_uniform(&random));
		stilb_vec4 got = shade_rgbm_encode(color, factor, gamma);
		double scaled[3], m = 1e-6;
		for (int c = 0; c < 3; c++) {
			scaled[c] = pow((double)color[c], 1.0 / (double)gamma) / (double)factor;
			m = fmax(m, scaled[c]);
		}
		m = ceil(255.0 * m - 1e-5) / 255.0;
		SHADE_PROOF_NEAR(got[3], m, 1e-6, 0.0);
		for (int c = 0; c < 3; c++)
			SHADE_PROOF_NEAR(got[c], fmin(scaled[c] / m, 1.0), 3e-6, 1e-30);
		SHADE_PROOF_NEAR3(shade_rgbm_decode(got, factor, gamma), color[0], color[1], color[2], 1e-5, 1e-30);
		stilb_vec3 tint = stilb_vec3_make(got[1], got[2], got[3]);
		SHADE_PROOF_NEAR3(shade_rgbm_tint(tint, gamma), pow((double)tint[0], 1.0 / (double)gamma),
		                  pow((double)tint[1], 1.0 / (double)gamma), pow((double)tint[2], 1.0 / (double)gamma), 1e-6,
		                  1e-30);
	}
}

/* 51.5 is the factor 6 at gamma 2.2; with a square root it is 36. */
static void rgbm_has_its_range(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_rgbm_range(SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA), 51.5, 0.0, 0.05);
	SHADE_PROOF_NEAR(shade_rgbm_range(SHADE_RGBM_FACTOR, 2.0f), 36.0, 1e-6, 0.0);
	for (float factor = 1.0f; factor < 9.0f; factor += 0.5f) {
		double range = pow((double)factor, 2.2);
		SHADE_PROOF_NEAR(shade_rgbm_range(factor, 2.2f), range, 1e-6, 0.0);
		stilb_vec3 end = stilb_vec3_make((float)range, 0.5f * (float)range, 2.0f * (float)range);
		SHADE_PROOF_NEAR3(shade_rgbm_decode(shade_rgbm_encode(end, factor, 2.2f), factor, 2.2f), range, 0.5 * range,
		                  range, 3e-6, 0.0);
	}
}

/* Decodes as RGBM does, but with sRGB's transfer, which is not a pure power; range 1. For the comparison below. */
static stilb_vec3 srgb_m_decode(stilb_vec3 rgb, float m)
{
	return stilb_vec3_make(shade_srgb_to_linear(rgb[0] * m), shade_srgb_to_linear(rgb[1] * m),
	                       shade_srgb_to_linear(rgb[2] * m));
}

static void rgbm_multiplies_exactly_for_a_pure_power_only(void **state)
{
	(void)state;
	shade_proof_random random = {2, 0};
	double worst_srgb = 0.0;
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 color = shade_proof_random_color(&random, 36.0f), tint = shade_proof_random_color(&random, 1.0f);
		float gamma = shade_proof_range(&random, 1.0f, 3.0f);
		stilb_vec4 stored = shade_rgbm_encode(color, 36.0f, gamma);
		stilb_vec3 blend = shade_rgbm_tint(tint, gamma);
		stored = (stilb_vec4){stored[0] * blend[0], stored[1] * blend[1], stored[2] * blend[2], stored[3]};
		SHADE_PROOF_NEAR3(shade_rgbm_decode(stored, 36.0f, gamma), color[0] * tint[0], color[1] * tint[1],
		                  color[2] * tint[2], 2e-5, 1e-30);

		float m = 0.01f + 0.99f * shade_proof_uniform(&random);
		stilb_vec3 rgb = shade_proof_random_color(&random, 1.0f), half = rgb * 0.5f;
		float right = shade_srgb_to_linear(0.5f) * srgb_m_decode(rgb, m)[0];
		worst_srgb = fmax(worst_srgb, (double)fabsf(srgb_m_decode(half, m)[0] - right) / fmax((double)right, 1e-6));
	}
	assert_true(worst_srgb > 0.5); /* dark colours are on sRGB's linear part: half the code is half the light */
}

static void rgbm_error_is_as_stated(void **state)
{
	(void)state;
	shade_proof_random random = {3, 0};
	const float gammas[] = {SHADE_RGBM_GAMMA, 2.0f, 1.0f};
	for (int g = 0; g < 3; g++) {
		float gamma = gammas[g], range = shade_rgbm_range(SHADE_RGBM_FACTOR, gamma);
		double worst = 0.0, worst_bright = 0.0;
		for (int i = 0; i < (g == 0 ? MANY : MANY / 10); i++) {
			stilb_vec3 color = shade_proof_random_color(&random, shade_proof_log_range(&random, 1e-4f, 1.0f) * range);
			stilb_vec4 stored = shade_unorm8(shade_rgbm_encode(color, SHADE_RGBM_FACTOR, gamma));
			double x = (double)largest(color), k = 255.0 * (double)stored[3];
			double error = worst_channel(shade_rgbm_decode(stored, SHADE_RGBM_FACTOR, gamma), color);
			if (k > 1.5) {
				/* (1 + e)^gamma with e = k / (k - 1) / 510, all in float. */
				double bound = pow(1.0 + k / (k - 1.0) / 510.0, (double)gamma) - 1.0 + 2e-6;
				if (error > bound * x)
					fail_msg("gamma %g: %g is off by %g, not within %g", (double)gamma, x, error, bound * x);
				worst = fmax(worst, error / x);
			}
			if (k > 50.0)
				worst_bright = fmax(worst_bright, error / x);
		}
		printf("RGBM, gamma %.1f: off by at most %.3f %%, %.3f %% where m >= 0.2, of the largest channel\n",
		       (double)gamma, 100.0 * worst, 100.0 * worst_bright);
		SHADE_PROOF_NEAR(worst_bright, (double)gamma / 510.0, 0.03, 0.0);
	}
}

/* Colours that get the smallest m, 1/255: the error is half a step of rgb times that m. */
static void rgbm_keeps_the_dark(void **state)
{
	(void)state;
	double step = (double)SHADE_RGBM_FACTOR / 255.0 / 510.0;
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		double encoded = (double)SHADE_RGBM_FACTOR / 255.0 * i / SHADE_PROOF_COUNT;
		float light = (float)pow(encoded, (double)SHADE_RGBM_GAMMA);
		stilb_vec3 back =
			rgbm_stored_and_read(stilb_vec3_make(light, 0.0f, light), SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA);
		SHADE_PROOF_NEAR(pow((double)back[0], 1.0 / (double)SHADE_RGBM_GAMMA), encoded, 2e-6, step * 1.001);
		assert_true(back[1] == 0.0f && back[0] == back[2]);
	}
}

static void rgbm_survives_anything(void **state)
{
	(void)state;
	shade_proof_random random = {4, 0};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec4 stored = shade_rgbm_encode(random_any_color(&random), 6.0f, 2.2f);
		assert_true(stored[3] >= 0.0039f);
		for (int c = 0; c < 4; c++)
			assert_true(stored[c] >= 0.0f && stored[c] <= 1.0f);
		stilb_vec3 back = shade_rgbm_decode(stored, 6.0f, 2.2f);
		SHADE_PROOF_LIGHT3(back);
		assert_true(largest(back) <= 51.6f);
	}
}

/* ---- XYZ --------------------------------------------------------------------------------------------------------- */

static void xyz_is_the_standards(void **state)
{
	(void)state;
	static const double matrix[3][3] = {
		{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}}; /* IEC 61966-2-1, 5.2 */
	shade_proof_random random = {5, 0};
	for (int i = 0; i < 200; i++) {
		stilb_vec3 color = shade_proof_random_color(&random, 10.0f);
		double want[3];
		for (int row = 0; row < 3; row++)
			want[row] = matrix[row][0] * (double)color[0] + matrix[row][1] * (double)color[1] +
			            matrix[row][2] * (double)color[2];
		stilb_vec3 xyz = shade_xyz_from_linear(color);
		SHADE_PROOF_NEAR3(xyz, want[0], want[1], want[2], 1e-6, 0.0);
		SHADE_PROOF_NEAR3(shade_linear_from_xyz(xyz), color[0], color[1], color[2], 0.0, 3e-7 * 30.0);
	}
	/* The white point D65, x = 0.3127, y = 0.3290. */
	stilb_vec3 white = shade_xyz_from_linear(stilb_vec3_make(1.0f, 1.0f, 1.0f));
	SHADE_PROOF_NEAR(white[0] / (white[0] + white[1] + white[2]), 0.3127, 1e-4, 0.0);
	SHADE_PROOF_NEAR(white[1] / (white[0] + white[1] + white[2]), 0.3290, 1e-4, 0.0);
}

/* ---- LogLuv ------------------------------------------------------------------------------------------------------ */

/* Ward's formulas in double, from the tristimulus values that the header makes. */
static void logluv_encode_exact(stilb_vec3 xyz, double encoded[4])
{
	double x = (double)xyz[0], y = (double)xyz[1], z = (double)xyz[2], level = 2.0 * log2(y) + 127.0;
	double s = x + 15.0 * y + 3.0 * z;
	encoded[0] = 410.0 / 255.0 * 4.0 * x / s;
	encoded[1] = 410.0 / 255.0 * 9.0 * y / s;
	encoded[2] = floor(level) / 255.0;
	encoded[3] = level - floor(level);
}

static void logluv_is_wards(void **state)
{
	(void)state;
	shade_proof_random random = {6, 0};
	for (int i = 0; i < 5000; i++) {
		stilb_vec3 color = stilb_vec3_make(shade_proof_uniform(&random), shade_proof_uniform(&random), 0.01f);
		color *= shade_proof_log_range(&random, 1e-6f, 1e12f);
		double want[4];
		logluv_encode_exact(shade_xyz_from_linear(color), want);
		stilb_vec4 got = shade_logluv_encode(color);
		SHADE_PROOF_NEAR(got[0], want[0], 1e-6, 0.0);
		SHADE_PROOF_NEAR(got[1], want[1], 1e-6, 0.0);
		/* 16 bits: the whole part may carry. Rounding log2 in float costs 1e-5 of the level. */
		SHADE_PROOF_NEAR((double)got[2] * 255.0 + (double)got[3], want[2] * 255.0 + want[3], 0.0, 3e-5);
		if (want[3] > 1e-3 && want[3] < 0.999)
			SHADE_PROOF_NEAR(got[2], want[2], 1e-6, 0.0);
		float height = largest(color);
		SHADE_PROOF_NEAR3(shade_logluv_decode(got), color[0], color[1], color[2], 0.0, 2e-5 * (double)height);
	}
}

/* The same through 8 bits, with a decoder that solves Ward's equations for x, y and Y. */
static void logluv_decodes_as_wards(void **state)
{
	(void)state;
	shade_proof_random random = {7, 0};
	for (int i = 0; i < 5000; i++) {
		stilb_vec4 stored;
		for (int c = 0; c < 4; c++)
			stored[c] = (float)unorm8(0.2 + 0.5 * (double)shade_proof_uniform(&random));
		double u = (double)stored[0] * 255.0 / 410.0, v = (double)stored[1] * 255.0 / 410.0;
		double x = 9.0 * u / (6.0 * u - 16.0 * v + 12.0), y = 4.0 * v / (6.0 * u - 16.0 * v + 12.0);
		double bright = exp2((255.0 * (double)stored[2] + (double)stored[3] - 127.0) / 2.0);
		stilb_vec3 xyz = stilb_vec3_make((float)(bright * x / y), (float)bright, (float)(bright * (1.0 - x - y) / y));
		stilb_vec3 want = shade_linear_from_xyz(xyz), got = shade_logluv_decode(stored);
		for (int c = 0; c < 3; c++)
			want[c] = fmaxf(want[c], 0.0f);
		double kept = fmin(bright / (double)shade_luminance(want), 1.0);
		for (int c = 0; c < 3; c++)
			SHADE_PROOF_NEAR(got[c], kept * (double)want[c], 0.0, 1e-5 * (double)largest(got));
	}
}

static void logluv_holds_black_and_its_ends(void **state)
{
	(void)state;
	stilb_vec3 black = {0.0f, 0.0f, 0.0f, 0.0f};
	SHADE_PROOF_NEAR3(shade_logluv_decode(shade_logluv_encode(black)), 0.0, 0.0, 0.0, 0.0, 0.0);
	for (float level = 0.5f; level < 255.9f; level += 0.25f) {
		float y = exp2f(0.5f * (level - 127.0f));
		stilb_vec3 gray = stilb_vec3_make(y, y, y), back = shade_logluv_decode(shade_logluv_encode(gray));
		SHADE_PROOF_NEAR3(back, y, y, y, 5e-5, 0.0);
	}
	stilb_vec3 over = shade_logluv_decode(shade_unorm8(shade_logluv_encode(stilb_vec3_make(1e25f, 1e25f, 1e25f))));
	assert_true(over[0] > 2.5e19f && over[0] < 2.9e19f);
}

static void logluv_error_is_as_stated(void **state)
{
	(void)state;
	shade_proof_random random = {8, 0};
	double worst = 0.0, worst_luminance = 0.0, sum = 0.0;
	for (int i = 0; i < MANY; i++) {
		stilb_vec3 color = shade_proof_random_color(&random, 1.0f);
		color[i % 3] *= (float)(i & 1); /* half of them lack a channel: there hue is coarsest */
		color *= exp2f((float)(i % 121) - 60.0f);
		if (!(largest(color) > 1e-15f))
			continue;
		stilb_vec4 stored = shade_unorm8(shade_logluv_encode(color));
		stilb_vec3 back = shade_logluv_decode(stored);
		double error = worst_channel(back, color) / (double)largest(color);
		worst = fmax(worst, error);
		sum += error;
		double luminance = (double)shade_luminance(color);
		worst_luminance = fmax(worst_luminance, fabs((double)shade_luminance(back) - luminance) / luminance);
	}
	printf("LogLuv: off by at most %.2f %%, on average %.2f %%, of the largest channel; luminance by %.3f %%\n",
	       100.0 * worst, 100.0 * sum / MANY, 100.0 * worst_luminance);
	assert_true(worst < 0.021 && worst > 0.01);
	assert_true(worst_luminance < 0.00069 && worst_luminance > 0.0006);
}

/* Decodes arbitrary bytes, also those that no encoder writes: the result is finite. */
static void logluv_survives_anything(void **state)
{
	(void)state;
	shade_proof_random random = {9, 0};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec4 stored = shade_logluv_encode(random_any_color(&random));
		for (int c = 0; c < 4; c++)
			assert_true(stored[c] >= 0.0f && stored[c] <= 1.0f);
		SHADE_PROOF_LIGHT3(shade_logluv_decode(stored));
		for (int c = 0; c < 4; c++)
			stored[c] = shade_proof_uniform(&random);
		SHADE_PROOF_LIGHT3(shade_logluv_decode(shade_unorm8(stored)));
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(srgb_has_its_known_values),  cmocka_unit_test(srgb_changes_piece_where_it_should),
		cmocka_unit_test(unorm8_is_the_nearest_step), cmocka_unit_test(rgbm_is_the_printed_one),
		cmocka_unit_test(rgbm_has_its_range),         cmocka_unit_test(rgbm_multiplies_exactly_for_a_pure_power_only),
		cmocka_unit_test(xyz_is_the_standards),       cmocka_unit_test(logluv_is_wards),
		cmocka_unit_test(logluv_decodes_as_wards),    cmocka_unit_test(logluv_holds_black_and_its_ends),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(srgb_goes_there_and_back),  cmocka_unit_test(rgbm_error_is_as_stated),
		cmocka_unit_test(rgbm_keeps_the_dark),       cmocka_unit_test(rgbm_survives_anything),
		cmocka_unit_test(logluv_error_is_as_stated), cmocka_unit_test(logluv_survives_anything),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
