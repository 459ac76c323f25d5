/* cases_filter: filtering of normals and roughness as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_FILTER_H
#define SHADE_CASES_FILTER_H

#include "case_inputs.h"
#include "shading/shade_normal_filter.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_FILTER(X)                                                                                          \
	X(0, shade_filter_alpha, 1e-5f, 1e-6f)                                                                             \
	X(1, shade_filter_vmf, 1e-5f, 1e-6f)                                                                               \
	X(2, shade_filter_vmf_encode, 1e-5f, 1e-6f)                                                                        \
	X(3, shade_filter_vmf_decode, 1e-5f, 1e-6f)                                                                        \
	X(4, shade_toksvig_factor, 1e-5f, 1e-6f)                                                                           \
	X(5, shade_filter_toksvig, 1e-5f, 1e-6f)                                                                           \
	X(6, shade_filter_variance_and_convolution, 1e-5f, 1e-6f)                                                          \
	X(7, shade_lean_from_normal, 1e-5f, 1e-6f)                                                                         \
	X(8, shade_lean_mix, 1e-5f, 1e-6f)                                                                                 \
	X(9, shade_lean_moments, 1e-5f, 1e-6f)                                                                             \
	X(10, shade_lean_from_moments, 1e-5f, 1e-6f)                                                                       \
	X(11, shade_lean_normal, 1e-5f, 1e-6f)                                                                             \
	X(12, shade_lean_axes_of, 1e-5f, 1e-6f)
#define SHADE_CASES_FILTER_COUNT 13

SHADE_FN vec4 shade_case_filter_mean(int row, shade_rough_normal x, shade_rough_normal y, vec4 b)
{
	shade_mean_direction lobes = shade_mean_direction_mix(shade_filter_vmf_mean(x), shade_filter_vmf_mean(y), b[3]);
	shade_rough_normal texel = shade_filter_vmf(lobes);
	if (row == 1)
		return vec4(texel.normal, texel.alpha);
	vec3 average = shade_filter_vmf_encode(x);
	if (row == 2)
		return vec4(average, 0.0f);
	// Half as long as it is wide, so that 1 - |r| is no difference of equal numbers, in which the two round apart.
	texel = shade_filter_vmf_decode(average * (0.9f * b[2]));
	if (row == 3)
		return vec4(texel.normal, texel.alpha);
	if (row == 4)
		return vec4(shade_toksvig_factor(b[0], 1e4f * b[1]), 0.0f, 0.0f, 0.0f);
	texel = shade_filter_toksvig(
		shade_mean_direction_mix(shade_filter_toksvig_mean(x), shade_filter_toksvig_mean(y), b[3]));
	if (row == 5)
		return vec4(texel.normal, texel.alpha);
	shade_mean_direction normals =
		shade_mean_direction_mix(shade_filter_normal_mean(x.normal), shade_filter_normal_mean(y.normal), b[3]);
	shade_rough_normal widened = shade_filter_variance(normals, b[0] * b[1]);
	shade_rough_normal convolved = shade_filter_convolution(normals, b[0] * b[1]);
	return vec4(widened.alpha, convolved.alpha, widened.normal[0], convolved.normal[1]);
}

SHADE_FN vec4 shade_case_filter_lean(int row, shade_rough_normal x, shade_rough_normal y, vec4 b)
{
	shade_lean lean = shade_lean_from_normal(x);
	if (row == 7)
		return vec4(lean.slope[0], lean.slope[1], lean.covariance[0], lean.covariance[2]);
	shade_lean mixed = shade_lean_mix(lean, shade_lean_from_normal(y), b[3]);
	if (row == 8)
		return vec4(mixed.covariance, mixed.slope[0]);
	if (row == 9)
		return vec4(shade_lean_moments(mixed), 0.0f);
	shade_lean back = shade_lean_from_moments(vec2(b[0], b[1]) * 0.1f, vec3(b) * 4.0f + 0.1f);
	if (row == 10)
		return vec4(back.covariance, back.slope[0]);
	shade_rough_normal texel = shade_lean_normal(mixed);
	if (row == 11)
		return vec4(texel.normal, texel.alpha);
	shade_lean_axes axes = shade_lean_axes_of(back);
	return vec4(axes.direction[0], axes.direction[1], axes.alpha_along, axes.alpha_across);
}

SHADE_FN vec4 shade_case_filter(int row, vec4 a, vec4 b)
{
	vec3 up = vec3(0.0f, 0.0f, 1.0f);
	shade_rough_normal x = {shade_case_above(up, a[0], a[1]), shade_case_range(b[0], SHADE_ALPHA_MIN, 1.0f)};
	shade_rough_normal y = {shade_case_above(up, a[2], a[3]), shade_case_range(b[1], SHADE_ALPHA_MIN, 1.0f)};
	if (row == 0)
		return vec4(shade_filter_inverse_sharpness(x.alpha), shade_filter_alpha(b[1]), 0.0f, 0.0f);
	if (row <= 6)
		return shade_case_filter_mean(row, x, y, b);
	return shade_case_filter_lean(row, x, y, b);
}

#include "shading/glsl_end.h"
#endif
