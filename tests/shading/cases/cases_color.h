/* cases_color: tone curves, firefly weights, sRGB, RGBM and LogLuv as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_COLOR_H
#define SHADE_CASES_COLOR_H

#include "case_inputs.h"
#include "shading/shade_encoding.h"
#include "shading/shade_firefly.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute)
 * shade_logluv_encode: its level is a number up to 255 made by log2; one float step of it is 1.5e-5. Channels that are
 * differences, of XYZ and LogLuv, are compared where their terms are about 1. */
#define SHADE_CASES_COLOR(X)                                                                                           \
	X(0, shade_largest, 1e-5f, 1e-6f)                                                                                  \
	X(1, shade_tonemap_simple, 1e-5f, 1e-6f)                                                                           \
	X(2, shade_tonemap_simple_inverse, 1e-5f, 1e-6f)                                                                   \
	X(3, shade_tonemap_curve, 1e-5f, 1e-6f)                                                                            \
	X(4, shade_tonemap_scaled, 1e-5f, 1e-6f)                                                                           \
	X(5, shade_tonemap_unscaled, 1e-5f, 1e-6f)                                                                         \
	X(6, shade_tonemap, 1e-5f, 1e-6f)                                                                                  \
	X(7, shade_tonemap_inverse, 1e-5f, 1e-6f)                                                                          \
	X(8, shade_tonemap_luminance, 1e-5f, 1e-6f)                                                                        \
	X(9, shade_tonemap_luminance_inverse, 1e-5f, 1e-6f)                                                                \
	X(10, shade_firefly_weight, 1e-5f, 1e-6f)                                                                          \
	X(11, shade_firefly_add, 1e-5f, 1e-6f)                                                                             \
	X(12, shade_firefly_mean, 1e-5f, 1e-6f)                                                                            \
	X(13, shade_srgb_from_linear, 1e-5f, 1e-6f)                                                                        \
	X(14, shade_srgb_to_linear, 1e-5f, 1e-6f)                                                                          \
	X(15, shade_unorm8, 1e-5f, 1e-6f)                                                                                  \
	X(16, shade_rgbm_range, 1e-5f, 1e-6f)                                                                              \
	X(17, shade_rgbm_encode, 1e-5f, 1e-6f)                                                                             \
	X(18, shade_rgbm_decode, 1e-5f, 1e-6f)                                                                             \
	X(19, shade_rgbm_tint, 1e-5f, 1e-6f)                                                                               \
	X(20, shade_xyz_from_linear, 1e-5f, 1e-6f)                                                                         \
	X(21, shade_linear_from_xyz, 1e-5f, 1e-6f)                                                                         \
	X(22, shade_logluv_encode, 1e-5f, 3e-5f)                                                                           \
	X(23, shade_logluv_decode, 1e-5f, 1e-6f)                                                                           \
	X(24, shade_neutral, 1e-5f, 1e-6f)                                                                                 \
	X(25, shade_neutral_inverse, 2e-5f, 1e-5f)                                                                         \
	X(26, shade_filmic_curve, 1e-5f, 1e-6f)                                                                            \
	X(27, shade_filmic_curve_inverse, 1e-5f, 1e-6f)                                                                    \
	X(28, shade_filmic, 1e-5f, 1e-6f)                                                                                  \
	X(29, shade_filmic_inverse, 1e-5f, 1e-6f)                                                                          \
	X(30, shade_tone, 1e-5f, 1e-6f)                                                                                    \
	X(31, shade_tone_inverse, 2e-5f, 1e-5f)                                                                            \
	X(32, shade_shown_by_luminance, 1e-5f, 1e-6f)                                                                      \
	X(33, shade_shown_by_luminance_inverse, 1e-5f, 1e-6f)                                                              \
	X(34, shade_piecewise_curve, 1e-5f, 1e-6f)                                                                         \
	X(35, shade_piecewise_curve_inverse, 2e-5f, 1e-6f)                                                                 \
	X(36, shade_piecewise, 1e-5f, 1e-6f)                                                                               \
	X(37, shade_piecewise_inverse, 2e-5f, 1e-6f)                                                                       \
	X(38, shade_hable_curve, 1e-5f, 1e-6f)                                                                             \
	X(39, shade_hable_curve_inverse, 1e-5f, 1e-6f)                                                                     \
	X(40, shade_hable, 1e-5f, 1e-6f)                                                                                   \
	X(41, shade_hable_inverse, 1e-5f, 1e-6f)
#define SHADE_CASES_COLOR_COUNT 42

/* Rows 0 to 9. color is dim, bright or black; a < b. */
SHADE_FN vec4 shade_case_tonemap(int row, vec3 color, float share, float a, float b)
{
	vec3 mapped = color * (0.95f * share * b / max(shade_largest(color), 1e-3f));
	if (row == 0)
		return vec4(shade_largest(color), 0.0f, 0.0f, 0.0f);
	if (row == 1)
		return vec4(shade_tonemap_simple(color, shade_luminance(color), b), 0.0f);
	if (row == 2)
		return vec4(shade_tonemap_simple_inverse(mapped, shade_luminance(mapped), b), 0.0f);
	if (row == 3)
		return vec4(shade_tonemap_curve(color[0], a, b), shade_tonemap_curve_inverse(0.95f * share * b, a, b), 0.0f,
		            0.0f);
	if (row == 4)
		return vec4(shade_tonemap_scaled(color, color[1], a, b), 0.0f);
	if (row == 5)
		return vec4(shade_tonemap_unscaled(color, mapped[1], a, b), 0.0f);
	if (row == 6)
		return vec4(shade_tonemap(color, a, b), 0.0f);
	if (row == 7)
		return vec4(shade_tonemap_inverse(mapped, a, b), 0.0f);
	if (row == 8)
		return vec4(shade_tonemap_luminance(color, a, b), 0.0f);
	return vec4(shade_tonemap_luminance_inverse(mapped, a, b), 0.0f);
}

/* Rows 15 to 23. */
SHADE_FN vec4 shade_case_encoding(int row, vec3 color, vec4 a, vec4 b)
{
	float factor = shade_case_range(b[1], 1.0f, 8.0f);
	float gamma = shade_case_range(b[2], 1.0f, 3.0f);
	if (row == 15)
		return shade_unorm8(a * 1.2f - 0.1f);
	if (row == 16)
		return vec4(shade_rgbm_range(factor, gamma), 0.0f, 0.0f, 0.0f);
	if (row == 17) {
		vec4 stored = shade_rgbm_encode(vec3(a), factor, gamma);
		// m is rounded up: where C and GPU round to different sides of a step, rgb and m differ, and not their product.
		return vec4(vec3(stored[0], stored[1], stored[2]) * stored[3], 0.0f);
	}
	if (row == 18)
		return vec4(shade_rgbm_decode(a, factor, gamma), 0.0f);
	if (row == 19)
		return vec4(shade_rgbm_tint(vec3(a), gamma), 0.0f);
	if (row == 20)
		return vec4(shade_xyz_from_linear(color), 0.0f);
	if (row == 21)
		return vec4(shade_linear_from_xyz(vec3(a)), 0.0f);
	if (row == 22) {
		vec4 stored = shade_logluv_encode(color);
		return vec4(stored[0], stored[1], stored[2] * 255.0f + stored[3], 0.0f);
	}
	return vec4(shade_logluv_decode(vec4(0.2f + 0.4f * a[0], 0.6f + 0.3f * a[1], 127.0f / 255.0f, a[3])), 0.0f);
}

/* Rows 24 to 41. color is dim, bright or black; shown, share in [0, 1). */
SHADE_FN vec4 shade_case_tone(int row, vec3 color, vec3 shown, float share)
{
	int tone = int(share * 6.999f);
	if (row == 24)
		return vec4(shade_neutral(color), 0.0f);
	if (row == 25)
		return vec4(shade_neutral_inverse(shown), 0.0f);
	if (row == 26)
		return vec4(shade_filmic_curve(color[0]), 0.0f, 0.0f, 0.0f);
	if (row == 27)
		return vec4(shade_filmic_curve_inverse(shown[0]), 0.0f, 0.0f, 0.0f);
	if (row == 28)
		return vec4(shade_filmic(color), 0.0f);
	if (row == 29)
		return vec4(shade_filmic_inverse(shown), 0.0f);
	if (row == 30)
		return vec4(shade_tone(tone, color), 0.0f);
	if (row == 31)
		return vec4(shade_tone_inverse(tone, shown), 0.0f);
	if (row == 32)
		return vec4(shade_shown_by_luminance(color), 0.0f);
	if (row == 33)
		return vec4(shade_shown_by_luminance_inverse(shown), 0.0f);
	if (row == 34)
		return vec4(shade_piecewise_curve(color[0]), 0.0f, 0.0f, 0.0f);
	if (row == 35)
		return vec4(shade_piecewise_curve_inverse(shown[0]), 0.0f, 0.0f, 0.0f);
	if (row == 36)
		return vec4(shade_piecewise(color), 0.0f);
	if (row == 37)
		return vec4(shade_piecewise_inverse(shown), 0.0f);
	if (row == 38)
		return vec4(shade_hable_curve(color[0]), 0.0f, 0.0f, 0.0f);
	if (row == 39)
		return vec4(shade_hable_curve_inverse(shown[0]), 0.0f, 0.0f, 0.0f);
	if (row == 40)
		return vec4(shade_hable(color), 0.0f);
	return vec4(shade_hable_inverse(shown), 0.0f);
}

SHADE_FN vec4 shade_case_color(int row, vec4 a, vec4 b)
{
	vec3 color = vec3(a) * shade_case_skewed(b[0], 0.01f, 1e6f);
	float range = shade_case_range(b[1], 0.5f, 8.0f);
	if (row < 10)
		return shade_case_tonemap(row, color, a[3], range * 0.9f * b[2], range);
	if (row == 10)
		return vec4(shade_firefly_weight(color[0], range), 0.0f, 0.0f, 0.0f);
	if (row == 11)
		return shade_firefly_add(b, color, range);
	if (row == 12)
		return vec4(shade_firefly_mean(shade_firefly_add(b, color, range)), 0.0f);
	if (row == 13)
		return vec4(shade_srgb_from_linear(a[0]), shade_srgb_from_linear(0.01f * a[1]), 0.0f, 0.0f);
	if (row == 14)
		return vec4(shade_srgb_to_linear(a[0]), shade_srgb_to_linear(0.1f * a[1]), 0.0f, 0.0f);
	if (row > 23)
		return shade_case_tone(row, color, vec3(a) * 0.95f, b[2]);
	return shade_case_encoding(row, color, a, b);
}

#include "shading/glsl_end.h"
#endif
