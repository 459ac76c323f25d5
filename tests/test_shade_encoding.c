/* What happens to light on its way to the screen: the tone curve and its inverse, and the sRGB transfer. */

#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#include "base/base.h"
#include "base/base_math.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void near(const char *what, double got, double want, double bound)
{
	if (!(fabs(got - want) <= bound))
		fail_msg("%s: got %.9g, expected %.9g within %g", what, got, want, bound);
}

/* a and b of the curve: the renderer's, without a linear part, an encoding's range, a nearly hard knee. */
static const float RANGES[][2] = {{SHADE_TONEMAP_A, SHADE_TONEMAP_B}, {0.0f, 1.0f}, {2.0f, 6.0f}, {0.9f, 1.0f}};
enum { RANGE_COUNT = sizeof RANGES / sizeof RANGES[0] };

/* Karis's formula as printed, in double. */
static double curve_printed(double x, double a, double b)
{
	return x <= a ? x : (a * a - b * x) / (2.0 * a - b - x);
}

static void curve_is_the_printed_one(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1];
		for (float x = 0.0f; x < 1e6f; x = x * 1.03f + 1e-3f)
			near("curve", (double)shade_tonemap_curve(x, a, b), curve_printed((double)x, (double)a, (double)b),
			     3e-7 * (double)b);
	}
}

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
		near("limit", (double)shade_tonemap_curve(1e9f, a, b), (double)b, 1e-6);
		assert_true(shade_tonemap_curve(INFINITY, a, b) == b);
	}
}

/* At a the two pieces meet with the value a and the slope 1. */
static void curve_is_smooth_at_the_knee(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		double a = (double)RANGES[r][0], b = (double)RANGES[r][1], step = 1e-3 * (b - a);
		double after = (double)shade_tonemap_curve((float)(a + step), (float)a, (float)b);
		/* Above a: a + s - s^2 / (b - a) + ..., so one step of 1e-3 (b - a) is off by 1e-3 of itself. */
		near("slope", (after - a) / step, 1.0, 1.1e-3 + 2e-7 * b / step);
		near("value", (double)shade_tonemap_curve(nextafterf((float)a, 9.0f), (float)a, (float)b), a, 3e-7 * b);
	}
}

static void curve_has_its_inverse(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		float a = RANGES[r][0], b = RANGES[r][1];
		for (float x = 0.0f; x < 50.0f * b; x = x * 1.05f + 1e-3f) {
			float y = shade_tonemap_curve(x, a, b);
			/* One rounding of y, 6e-8 b, grows by the inverse's slope ((b - a) / (b - y))^2. */
			double slope = x <= a ? 1.0 : pow((double)((b - a) / (b - y)), 2.0);
			near("inverse", (double)shade_tonemap_curve_inverse(y, a, b), (double)x,
			     2e-7 * (double)b * slope + 2e-7 * (double)x);
		}
	}
}

static float largest(stilb_vec3 v)
{
	return fmaxf(v[0], fmaxf(v[1], v[2]));
}

static void colors_keep_hue_and_range(void **state)
{
	(void)state;
	float a = SHADE_TONEMAP_A, b = SHADE_TONEMAP_B;
	for (uint64_t i = 0; i < 20000; i++) {
		float height = exp2f(24.0f * stilb_random_float(1, i) - 4.0f);
		stilb_vec3 color =
			stilb_vec3_make(stilb_random_float(2, i), stilb_random_float(3, i), stilb_random_float(4, i));
		color *= height;
		stilb_vec3 mapped = shade_tonemap(color, a, b);
		near("largest", (double)largest(mapped), (double)shade_tonemap_curve(largest(color), a, b), 2e-7);
		for (int c = 0; c < 3; c++) {
			assert_true(mapped[c] >= 0.0f && mapped[c] <= b);
			near("hue", (double)(mapped[c] / largest(mapped)), (double)(color[c] / largest(color)), 4e-7);
			assert_true(largest(color) > a || mapped[c] == color[c]);
		}
	}
	stilb_vec3 blue = shade_tonemap(stilb_vec3_make(0.0f, 0.0f, 40.0f), a, b);
	assert_true(blue[0] == 0.0f && blue[2] > 0.95f && blue[2] < 1.0f);
	stilb_vec3 bright = shade_tonemap(stilb_vec3_make(1e30f, 1e29f, 0.0f), a, b);
	assert_true(bright[0] <= b && bright[0] > 0.999f && bright[2] == 0.0f);
	stilb_vec3 black = shade_tonemap(stilb_vec3_make(0.0f, 0.0f, 0.0f), 0.0f, 1.0f);
	assert_true(black[0] == 0.0f && black[1] == 0.0f && black[2] == 0.0f);
}

/* Scaling rounds: without the last min some of these would leave the range by one bit. */
static void bright_colors_stay_in_range(void **state)
{
	(void)state;
	for (int r = 0; r < RANGE_COUNT; r++) {
		for (int i = 0; i < 2000; i++) {
			float height = 1e8f * (1.0f + (float)i / 1999.0f);
			stilb_vec3 mapped = shade_tonemap(stilb_vec3_make(height, 0.0f, 0.0f), RANGES[r][0], RANGES[r][1]);
			assert_true(mapped[0] <= RANGES[r][1]);
		}
	}
}

static void colors_come_back(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 5000; i++) {
		stilb_vec3 color =
			stilb_vec3_make(stilb_random_float(2, i), stilb_random_float(3, i), stilb_random_float(4, i));
		color *= exp2f(6.0f * stilb_random_float(1, i) - 4.0f);
		stilb_vec3 back = shade_tonemap_inverse(shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B), SHADE_TONEMAP_A,
		                                        SHADE_TONEMAP_B);
		for (int c = 0; c < 3; c++)
			near("color", (double)back[c], (double)color[c], 2e-5 * (double)largest(color));
	}
}

/* ---- sRGB ---------------------------------------------------------------------------------------------------------- */

static double srgb_exact(double light)
{
	return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

static void srgb_has_its_known_values(void **state)
{
	(void)state;
	static const double known[][2] = {{0.0, 0.0},           {1.0, 1.0},       {0.5, 0.735356983}, {0.18, 0.461356129},
	                                  {0.0031308, 0.04045}, {0.001, 0.01292}, {0.2140411, 0.5},   {0.03310477, 0.2}};
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
		near("code", (double)shade_srgb_from_linear((float)known[i][0]), known[i][1], 5e-7);
		near("light", (double)shade_srgb_to_linear((float)known[i][1]), known[i][0], 5e-7);
	}
	assert_true(shade_srgb_from_linear(0.0f) == 0.0f && shade_srgb_to_linear(0.0f) == 0.0f);
	assert_int_equal(lrintf(255.0f * shade_srgb_from_linear(1.0f)), 255);
}

static void srgb_goes_there_and_back(void **state)
{
	(void)state;
	float last = -1.0f;
	for (int i = 0; i <= 65535; i++) {
		float light = (float)i / 65535.0f, code = shade_srgb_from_linear(light);
		assert_true(code > last);
		last = code;
		near("code", (double)code, srgb_exact((double)light), 3e-7);
		near("back", (double)shade_srgb_to_linear(code), (double)light, 1e-6);
	}
	for (int code = 0; code < 256; code++) /* 8-bit codes survive exactly */
		assert_int_equal(lrintf(255.0f * shade_srgb_from_linear(shade_srgb_to_linear((float)code / 255.0f))), code);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(curve_is_the_printed_one),
		cmocka_unit_test(curve_is_linear_then_bends_to_its_limit),
		cmocka_unit_test(curve_is_smooth_at_the_knee),
		cmocka_unit_test(curve_has_its_inverse),
		cmocka_unit_test(colors_keep_hue_and_range),
		cmocka_unit_test(bright_colors_stay_in_range),
		cmocka_unit_test(colors_come_back),
		cmocka_unit_test(srgb_has_its_known_values),
		cmocka_unit_test(srgb_goes_there_and_back),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
