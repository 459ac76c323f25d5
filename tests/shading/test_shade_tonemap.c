/* shade_tonemap.h and shade_firefly.h: the tone curves and their inverses, applied to the largest channel and to the
 * luminance, and the weights against fireflies: against Karis's formulas as printed. */

#include "shading/shade_firefly.h"
#include "shading/shade_tonemap.h"

#include "support/shade_proof.h"

/* {a, b} of the curve that is linear up to a and has the limit b: the renderer's, one without a linear part, one for
 * the range of an encoding, one that bends nearly as a corner. */
static const float RANGES[][2] = {{0.6f, 1.0f}, {0.0f, 1.0f}, {2.0f, 6.0f}, {0.9f, 1.0f}};
enum { RANGE_COUNT = sizeof RANGES / sizeof RANGES[0] };

/* Karis's curve as printed, in double: the number that a colour of this luma is multiplied by. */
static double scale_printed(double luma, double a, double b)
{
	return luma <= a ? 1.0 : (a * a - b * luma) / (2.0 * a - b - luma) / luma;
}

static double scale_inverse_printed(double luma, double a, double b)
{
	return luma <= a ? 1.0 : (a * a - (2.0 * a - b) * luma) / (b - luma) / luma;
}

static double luminance(stilb_vec3 c)
{
	return 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
}

static float largest(stilb_vec3 v)
{
	return fmaxf(v[0], fmaxf(v[1], v[2]));
}

/* Channels in [0, 2^19), dim and bright colours alike. */
static stilb_vec3 random_color(shade_proof_random *random)
{
	float height = shade_proof_log_range(random, 0.05f, 5e5f);
	return shade_proof_random_color(random, 1.0f) * height;
}

static void scaled_near(stilb_vec3 got, stilb_vec3 color, double scale, double relative)
{
	SHADE_PROOF_NEAR3(got, scale * (double)color[0], scale * (double)color[1], scale * (double)color[2], relative,
	                  1e-30);
}

/* ---- exactness --------------------------------------------------------------------------------------------------- */

static void renderer_is_linear_to_code_203(void **state)
{
	(void)state;
	assert_true(SHADE_TONEMAP_A == 0.6f && SHADE_TONEMAP_B == 1.0f);
}

static void luma_is_the_largest_channel(void **state)
{
	(void)state;
	for (int c = 0; c < 3; c++) {
		stilb_vec3 color = stilb_vec3_make(0.25f, 0.5f, 0.125f);
		color[c] = 3.0f;
		assert_true(shade_largest(color) == 3.0f);
	}
}

static void simple_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {1, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 color = random_color(&random);
		float range = shade_proof_log_range(&random, 0.1f, 100.0f), share = shade_proof_uniform(&random);
		double luma = luminance(color), y = (double)range * (double)share;
		scaled_near(shade_tonemap_simple(color, (float)luma, range), color, 1.0 / (1.0 + luma / (double)range), 5e-7);
		scaled_near(shade_tonemap_simple_inverse(color, (float)y, range), color, 1.0 / (1.0 - y / (double)range),
		            1e-6 / (1.0 - (double)share));
		SHADE_PROOF_NEAR(shade_firefly_weight((float)luma, range), 1.0 / (1.0 + luma / (double)range), 3e-7, 0.0);
	}
}

static void curve_is_the_printed_one(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1];
		for (float x = 1e-3f; x < 1e6f; x = x * 1.03f + 1e-3f) {
			float y = shade_tonemap_curve(x, a, b);
			SHADE_PROOF_NEAR(y, (double)x * scale_printed((double)x, (double)a, (double)b), 0.0, 3e-7 * (double)b);
			if (y < 0.99f * b)
				SHADE_PROOF_NEAR(shade_tonemap_curve_inverse(y, a, b),
				                 (double)y * scale_inverse_printed((double)y, (double)a, (double)b), 3e-5, 0.0);
		}
	}
}

static void colors_are_the_printed_ones(void **state)
{
	(void)state;
	shade_proof_random random = {2, 0};
	for (int i = 0; i < 2000; i++) {
		float a = RANGES[i % RANGE_COUNT][0], b = RANGES[i % RANGE_COUNT][1];
		stilb_vec3 color = random_color(&random);
		double by_luminance = scale_printed(luminance(color), (double)a, (double)b);
		double by_largest = scale_printed((double)largest(color), (double)a, (double)b);
		scaled_near(shade_tonemap_luminance(color, a, b), color, by_luminance, 2e-6);
		scaled_near(shade_tonemap(color, a, b), color, by_largest, 2e-6);
		scaled_near(shade_tonemap_scaled(color, largest(color), a, b), color, by_largest, 2e-6);
		stilb_vec3 dim = color * (0.97f * b * shade_proof_uniform(&random) / fmaxf(largest(color), 1e-3f));
		by_luminance = scale_inverse_printed(luminance(dim), (double)a, (double)b);
		by_largest = scale_inverse_printed((double)largest(dim), (double)a, (double)b);
		scaled_near(shade_tonemap_luminance_inverse(dim, a, b), dim, by_luminance, 3e-5);
		scaled_near(shade_tonemap_inverse(dim, a, b), dim, by_largest, 3e-5);
		scaled_near(shade_tonemap_unscaled(dim, largest(dim), a, b), dim, by_largest, 3e-5);
	}
}

static void curve_without_a_linear_part_is_the_simple_one(void **state)
{
	(void)state;
	shade_proof_random random = {3, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 color = random_color(&random);
		float range = shade_proof_range(&random, 0.5f, 8.0f);
		stilb_vec3 simple = shade_tonemap_simple(color, shade_luminance(color), range);
		stilb_vec3 curve = shade_tonemap_luminance(color, 0.0f, range);
		SHADE_PROOF_NEAR3(curve, simple[0], simple[1], simple[2], 1e-6, 1e-30);
	}
}

/* Where the curve's two pieces meet, at a, both have the value a and the slope 1. */
static void curve_is_smooth_at_the_knee(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		double a = (double)RANGES[r][0], b = (double)RANGES[r][1], step = 1e-3 * (b - a);
		double after = (double)shade_tonemap_curve((float)(a + step), (float)a, (float)b);
		/* Above a: a + s - s^2 / (b - a) + ..., so one step of 1e-3 (b - a) is off by 1e-3 of itself. */
		SHADE_PROOF_NEAR((after - a) / step, 1.0, 0.0, 1.1e-3 + 2e-7 * b / step);
		SHADE_PROOF_NEAR(shade_tonemap_curve(nextafterf((float)a, 9.0f), (float)a, (float)b), a, 0.0, 3e-7 * b);
	}
}

enum { SAMPLES = 64 };

/* A few dim values and one firefly. */
static void random_samples(shade_proof_random *random, stilb_vec3 samples[SAMPLES])
{
	for (int i = 0; i < SAMPLES; i++)
		samples[i] = shade_proof_random_color(random, 2.0f);
	samples[SAMPLES / 2] = stilb_vec3_make(5000.0f, 300.0f, 20000.0f);
}

/* The mean of the samples weighted by shade_firefly_weight of their luminance, in double. */
static stilb_vec3 weighted_mean(const stilb_vec3 samples[SAMPLES], float range)
{
	stilb_vec4 sums = {0.0f, 0.0f, 0.0f, 0.0f};
	for (int i = 0; i < SAMPLES; i++)
		sums = shade_firefly_add(sums, samples[i], range);
	return shade_firefly_mean(sums);
}

/* The samples tone mapped by the simple curve, averaged, and mapped back; the luma is the luminance or the largest
 * channel. */
static stilb_vec3 mapped_mean(const stilb_vec3 samples[SAMPLES], float range, bool by_luminance)
{
	stilb_vec3 mean = {0.0f, 0.0f, 0.0f, 0.0f};
	for (int i = 0; i < SAMPLES; i++)
		mean += shade_tonemap_simple(samples[i], by_luminance ? shade_luminance(samples[i]) : shade_largest(samples[i]),
		                             range) /
		        (float)SAMPLES;
	return shade_tonemap_simple_inverse(mean, by_luminance ? shade_luminance(mean) : shade_largest(mean), range);
}

static void weights_equal_the_curve_for_linear_luma(void **state)
{
	(void)state;
	shade_proof_random random = {4, 0};
	for (int i = 0; i < 50; i++) {
		stilb_vec3 samples[SAMPLES];
		random_samples(&random, samples);
		float range = shade_proof_log_range(&random, 0.25f, 16.0f);
		stilb_vec3 weighted = weighted_mean(samples, range), mapped = mapped_mean(samples, range, true);
		SHADE_PROOF_NEAR3(weighted, mapped[0], mapped[1], mapped[2], 1e-5, 0.0);
	}
}

/* Weights made of the largest channel do not give what tone mapping by the largest channel gives; nor do those of the
 * luminance give what the curve gives that is linear up to a. */
static void weights_differ_from_the_curve_for_other_lumas(void **state)
{
	(void)state;
	shade_proof_random random = {5, 0};
	stilb_vec3 samples[SAMPLES];
	random_samples(&random, samples);
	stilb_vec3 sum = {0.0f, 0.0f, 0.0f, 0.0f}, bent = sum;
	float weights = 0.0f;
	for (int i = 0; i < SAMPLES; i++) {
		float weight = shade_firefly_weight(shade_largest(samples[i]), 1.0f);
		sum += samples[i] * weight;
		weights += weight;
		bent += shade_tonemap_luminance(samples[i], 0.6f, 1.0f) / (float)SAMPLES;
	}
	stilb_vec3 weighted = sum / weights, mapped = mapped_mean(samples, 1.0f, false);
	assert_true(fabsf(mapped[0] - weighted[0]) > 0.02f * weighted[0]);
	bent = shade_tonemap_luminance_inverse(bent, 0.6f, 1.0f);
	weighted = weighted_mean(samples, 1.0f);
	assert_true(fabsf(bent[0] - weighted[0]) > 0.02f * weighted[0]);
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

static void curve_is_linear_then_bends_to_its_limit(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1], last = -1.0f;
		for (int i = 0; i <= 100; i++)
			assert_true(shade_tonemap_curve(a * (float)i / 100.0f, a, b) == a * (float)i / 100.0f);
		for (float x = 0.0f; x < 1e4f; x = x * 1.02f + 1e-3f) {
			float y = shade_tonemap_curve(x, a, b);
			assert_true(y >= last && y <= b && y <= x);
			assert_true(x > 100.0f || y > last);
			last = y;
		}
		SHADE_PROOF_NEAR(shade_tonemap_curve(1e9f, a, b), (double)b, 0.0, 1e-6);
		assert_true(shade_tonemap_curve(INFINITY, a, b) == b);
	}
}

static void curve_has_its_inverse(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1];
		for (float x = 0.0f; x < 5000.0f * b; x = x * 1.0005f + 1e-3f) {
			float y = shade_tonemap_curve(x, a, b);
			/* One rounding of y, 6e-8 b, grows by the inverse's slope ((b - a) / (b - y))^2. */
			double slope = x <= a ? 1.0 : pow((double)((b - a) / (b - y)), 2.0);
			SHADE_PROOF_NEAR(shade_tonemap_curve_inverse(y, a, b), (double)x, 2e-7,
			                 2e-7 * (double)b * slope + 2e-7 * (double)x);
		}
		SHADE_PROOF_LIGHT(shade_tonemap_curve_inverse(b, a, b));
		SHADE_PROOF_LIGHT(shade_tonemap_curve_inverse(2.0f * b, a, b));
		SHADE_PROOF_LIGHT3(shade_tonemap_simple_inverse(stilb_vec3_make(b, b, b), b, b));
		SHADE_PROOF_LIGHT3(shade_tonemap_simple_inverse(stilb_vec3_make(b, b, b), 2.0f * b, b));
	}
}

static void colors_keep_hue_and_range(void **state)
{
	(void)state;
	shade_proof_random random = {6, 0};
	float a = SHADE_TONEMAP_A, b = SHADE_TONEMAP_B;
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 color = random_color(&random), mapped = shade_tonemap(color, a, b);
		assert_true(largest(mapped) <= b);
		SHADE_PROOF_LIGHT3(mapped);
		SHADE_PROOF_NEAR(largest(mapped), shade_tonemap_curve(largest(color), a, b), 0.0, 2e-7);
		for (int c = 0; c < 3; c++) {
			/* mapped[c] / largest(mapped) = color[c] / largest(color) */
			SHADE_PROOF_NEAR(mapped[c] * largest(color), color[c] * largest(mapped), 5e-7, 1e-30);
			assert_true(largest(color) > a || mapped[c] == color[c]);
		}
		stilb_vec3 back = shade_tonemap_inverse(mapped, a, b);
		double slope = fmax(1.0, (double)(largest(color) * largest(color)));
		SHADE_PROOF_LIGHT3(back);
		if (largest(color) < 1000.0f)
			SHADE_PROOF_NEAR(largest(back), (double)largest(color), 1e-6, 2e-6 * slope);
	}
}

static void luminance_comes_into_range_and_back(void **state)
{
	(void)state;
	shade_proof_random random = {7, 0};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float a = RANGES[i % RANGE_COUNT][0], b = RANGES[i % RANGE_COUNT][1];
		stilb_vec3 color = random_color(&random), mapped = shade_tonemap_luminance(color, a, b);
		SHADE_PROOF_LIGHT3(mapped);
		assert_true(shade_luminance(mapped) <= b * 1.0000005f);
		assert_true(largest(mapped) <= b / SHADE_LUMINANCE_B * 1.000001f);
		stilb_vec3 back = shade_tonemap_luminance_inverse(mapped, a, b);
		SHADE_PROOF_LIGHT3(back);
		stilb_vec3 simple = shade_tonemap_simple(color, shade_luminance(color), b);
		SHADE_PROOF_LIGHT3(simple);
		SHADE_PROOF_LIGHT3(shade_tonemap_simple_inverse(simple, shade_luminance(simple), b));
		if (luminance(color) < (double)(100.0f * b)) {
			double slope = pow(1.0 + luminance(color) / (double)(b - a), 2.0);
			SHADE_PROOF_NEAR(shade_luminance(back), luminance(color), 1e-6 * slope, 1e-6 * (double)b);
			simple = shade_tonemap_simple_inverse(simple, shade_luminance(simple), b);
			SHADE_PROOF_NEAR(shade_luminance(simple), luminance(color), 1e-6 * slope, 1e-6 * (double)b);
		}
	}
}

/* Scaling a colour rounds: without the min in shade_tonemap some of these would end above b by one bit. */
static void bright_and_black_colors_stay_in_range(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1];
		for (int i = 0; i < 2000; i++) {
			float height = 1e8f * (1.0f + (float)i / 1999.0f);
			assert_true(largest(shade_tonemap(stilb_vec3_make(height, 0.0f, 0.0f), a, b)) <= b);
		}
		stilb_vec3 bright = stilb_vec3_make(1e30f, 1e29f, 0.0f), black = {0.0f, 0.0f, 0.0f, 0.0f};
		SHADE_PROOF_NEAR3(shade_tonemap(bright, a, b), (double)b, 0.1 * (double)b, 0.0, 2e-3, 0.0);
		SHADE_PROOF_LIGHT3(shade_tonemap_inverse(shade_tonemap(bright, a, b), a, b));
		SHADE_PROOF_LIGHT3(shade_tonemap_luminance_inverse(shade_tonemap_luminance(bright, a, b), a, b));
		SHADE_PROOF_NEAR3(shade_tonemap(black, a, b), 0.0, 0.0, 0.0, 0.0, 0.0);
		SHADE_PROOF_NEAR3(shade_tonemap_inverse(black, a, b), 0.0, 0.0, 0.0, 0.0, 0.0);
		SHADE_PROOF_NEAR3(shade_tonemap_luminance(black, a, b), 0.0, 0.0, 0.0, 0.0, 0.0);
		SHADE_PROOF_NEAR3(shade_tonemap_simple(black, 0.0f, b), 0.0, 0.0, 0.0, 0.0, 0.0);
	}
}

static void fireflies_do_not_drown_the_rest(void **state)
{
	(void)state;
	shade_proof_random random = {8, 0};
	stilb_vec4 sums = {0.0f, 0.0f, 0.0f, 0.0f};
	SHADE_PROOF_NEAR3(shade_firefly_mean(sums), 0.0, 0.0, 0.0, 0.0, 0.0);
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 color = random_color(&random);
		float range = shade_proof_log_range(&random, 0.01f, 1000.0f);
		float weight = shade_firefly_weight(shade_luminance(color), range);
		assert_true(weight > 0.0f && weight <= 1.0f);
		sums = shade_firefly_add((stilb_vec4){0.0f, 0.0f, 0.0f, 0.0f}, color, range);
		/* The mean of one value is that value. */
		SHADE_PROOF_NEAR3(shade_firefly_mean(sums), color[0], color[1], color[2], 5e-7, 0.0);
	}
	for (int i = 0; i < 999; i++)
		sums = shade_firefly_add(i == 0 ? (stilb_vec4){0.0f, 0.0f, 0.0f, 0.0f} : sums,
		                         (stilb_vec3){1.0f, 1.0f, 1.0f, 0.0f}, 1.0f);
	sums = shade_firefly_add(sums, (stilb_vec3){1e30f, 1e30f, 1e30f, 0.0f}, 1.0f);
	SHADE_PROOF_NEAR3(shade_firefly_mean(sums), 1.002, 1.002, 1.002, 1e-3, 0.0); /* a plain mean would be 1e27 */
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(renderer_is_linear_to_code_203),
		cmocka_unit_test(luma_is_the_largest_channel),
		cmocka_unit_test(simple_is_the_printed_one),
		cmocka_unit_test(curve_is_the_printed_one),
		cmocka_unit_test(colors_are_the_printed_ones),
		cmocka_unit_test(curve_without_a_linear_part_is_the_simple_one),
		cmocka_unit_test(curve_is_smooth_at_the_knee),
		cmocka_unit_test(weights_equal_the_curve_for_linear_luma),
		cmocka_unit_test(weights_differ_from_the_curve_for_other_lumas),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(curve_is_linear_then_bends_to_its_limit),
		cmocka_unit_test(curve_has_its_inverse),
		cmocka_unit_test(colors_keep_hue_and_range),
		cmocka_unit_test(luminance_comes_into_range_and_back),
		cmocka_unit_test(bright_and_black_colors_stay_in_range),
		cmocka_unit_test(fireflies_do_not_drown_the_rest),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
