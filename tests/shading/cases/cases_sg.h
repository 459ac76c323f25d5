/* cases_sg: Spherical Gaussians and von Mises-Fisher as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_SG_H
#define SHADE_CASES_SG_H

#include "case_inputs.h"
#include "shading/shade_sg.h"
#include "shading/shade_vmf.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_SG(X)                                                                                              \
	X(0, shade_sg_evaluate, 1e-5f, 1e-6f)                                                                              \
	X(1, shade_sg_mean_cosine, 1e-5f, 1e-6f)                                                                           \
	X(2, shade_sg_normalize, 1e-5f, 1e-6f)                                                                             \
	X(3, shade_sg_integral, 1e-5f, 1e-6f)                                                                              \
	X(4, shade_sg_product_shape, 1e-5f, 1e-6f)                                                                         \
	X(5, shade_sg_product_amplitude, 1e-5f, 1e-6f)                                                                     \
	X(6, shade_sg_power, 1e-5f, 1e-6f) /* pow of the amplitude: 2e-6 on lavapipe */                                    \
	X(7, shade_sg_inner_product, 1e-5f, 1e-6f)                                                                         \
	X(8, shade_sg_convolve, 1e-5f, 1e-6f)                                                                              \
	X(9, shade_vmf_density, 1e-5f, 1e-6f)                                                                              \
	X(10, shade_vmf_variance_and_inverse, 1e-5f, 1e-6f)                                                                \
	X(11, shade_mean_direction_vector, 1e-5f, 1e-6f)                                                                   \
	X(12, shade_mean_direction_mix, 1e-5f, 1e-6f)                                                                      \
	X(13, shade_vmf_from_mean, 1e-5f, 1e-6f)                                                                           \
	X(14, shade_sg_from_vmf, 1e-5f, 1e-6f)                                                                             \
	X(15, shade_sg_add_shape, 1e-5f, 1e-6f)                                                                            \
	X(16, shade_sg_add_amplitude, 1e-5f, 1e-6f)
#define SHADE_CASES_SG_COUNT 17

/* A unit vector within 6 degrees of the axis. */
SHADE_FN vec3 shade_case_sg_near(vec3 axis, vec3 other)
{
	vec3 p = axis + 0.1f * other;
	return p / sqrt(dot(p, p));
}

SHADE_FN vec4 shade_case_sg_lobes(int row, shade_sg g1, shade_sg g2, vec4 b)
{
	if (row == 0)
		return vec4(shade_sg_evaluate(g1, shade_case_sg_near(g1.axis, shade_case_direction(b[2], b[3]))), 0.0f);
	if (row == 1)
		return vec4(shade_sg_mean_cosine(g1.sharpness), shade_sg_mean_cosine(b[0]),
		            shade_sg_coth_minus_one(1.0f + g1.sharpness), shade_sg_normalized_amplitude(2.0f * b[0]));
	if (row == 2)
		return vec4(shade_sg_normalize(g1).amplitude, shade_sg_normalize(g1).sharpness);
	if (row == 3)
		return vec4(shade_sg_integral(g1), 0.0f);
	shade_sg product = shade_sg_product(g1, g2);
	if (row == 4)
		return vec4(product.axis, product.sharpness);
	if (row == 5)
		return vec4(product.amplitude, 0.0f);
	shade_sg power = shade_sg_power(g1, 16.0f * b[2] + 0.1f);
	if (row == 6)
		return vec4(power.amplitude, power.sharpness);
	if (row == 7)
		return vec4(shade_sg_inner_product(g1, g2), 0.0f);
	shade_sg blurred = shade_sg_convolve(g1, g2);
	return vec4(blurred.amplitude, blurred.sharpness);
}

SHADE_FN vec4 shade_case_sg_vmf(int row, shade_vmf d, shade_mean_direction mean, vec4 b)
{
	if (row == 9)
		return vec4(shade_vmf_density(d, shade_case_sg_near(d.axis, mean.axis)), shade_vmf_density(d, d.axis), 0.0f,
		            0.0f);
	if (row == 10)
		return vec4(shade_vmf_variance(d.inverse_sharpness), shade_vmf_variance_slope(d.inverse_sharpness),
		            shade_vmf_inverse_sharpness_fast(b[0]), shade_vmf_inverse_sharpness(0.9f * b[0]));
	shade_mean_direction back = shade_mean_direction_from_vector(shade_mean_direction_vector(mean) * b[1]);
	if (row == 11)
		return vec4(back.axis, back.variance);
	shade_mean_direction mixed = shade_mean_direction_mix(shade_vmf_mean(d), mean, b[1]);
	if (row == 12)
		return vec4(mixed.axis, mixed.variance);
	shade_vmf fitted = shade_vmf_from_mean(shade_vmf_mean(d));
	return vec4(fitted.axis, fitted.inverse_sharpness);
}

SHADE_FN vec4 shade_case_sg(int row, vec4 a, vec4 b)
{
	vec3 amplitude = vec3(a) * 2.0f;
	vec3 axis = shade_case_direction(a[0], a[1]);
	vec3 other = shade_case_direction(a[2], a[3]);
	shade_sg g1 = {axis, shade_case_skewed(b[0], 0.0f, 1e4f), amplitude};
	shade_sg g2 = {normalize(axis + 0.3f * other), shade_case_skewed(b[1], 0.0f, 1e3f), vec3(b)};
	shade_vmf d = {axis, shade_case_skewed(b[2], 1e-6f, 2.0f)};
	shade_mean_direction mean = {other, 0.9f * b[3]};
	if (row <= 8)
		return shade_case_sg_lobes(row, g1, g2, b);
	if (row <= 13)
		return shade_case_sg_vmf(row, d, mean, b);
	shade_sg g3 = shade_sg_from_vmf(d, vec3(b) + 0.1f);
	if (row == 14)
		return vec4(g3.amplitude, shade_vmf_from_sg(g3).inverse_sharpness);
	shade_sg added = shade_sg_add(g1, g2);
	return select(row == 15, vec4(added.axis, added.sharpness), vec4(added.amplitude, 0.0f));
}

#include "shading/glsl_end.h"
#endif
