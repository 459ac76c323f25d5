/* cases_sampling: samplers and their densities as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_SAMPLING_H
#define SHADE_CASES_SAMPLING_H

#include "case_inputs.h"
#include "shading/shade_sampling.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute)
 * Where a result is a difference of nearly equal vectors, it shows the last bit of a sine: opposite the axis of a vMF
 * lobe (u[0] near 1), and at small v.h, where densities of reflections have a pole. The rows keep away from there. */
#define SHADE_CASES_SAMPLING(X)                                                                                        \
	X(0, shade_log1p, 1e-5f, 1e-6f)                                                                                    \
	X(1, shade_one_minus_exp, 1e-5f, 1e-6f)                                                                            \
	X(2, shade_sample_stratified, 1e-5f, 1e-6f)                                                                        \
	X(3, shade_concentric, 1e-5f, 1e-6f)                                                                               \
	X(4, shade_sample_disk, 1e-5f, 1e-6f)                                                                              \
	X(5, shade_direction_polar, 1e-5f, 1e-6f)                                                                          \
	X(6, shade_sample_sphere, 1e-5f, 1e-6f)                                                                            \
	X(7, shade_sample_hemisphere, 1e-5f, 1e-6f)                                                                        \
	X(8, shade_sample_cosine, 1e-5f, 1e-6f)                                                                            \
	X(9, shade_log_cosine, 1e-5f, 1e-6f)                                                                               \
	X(10, shade_sample_power, 1e-5f, 1e-6f)                                                                            \
	X(11, shade_pdf_power, 1e-5f, 1e-6f)                                                                               \
	X(12, shade_sample_vmf, 1e-5f, 1e-6f)                                                                              \
	X(13, shade_pdf_vmf, 1e-5f, 1e-6f)                                                                                 \
	X(14, shade_half_vector, 1e-5f, 1e-6f)                                                                             \
	X(15, shade_sample_blinn_normal, 1e-5f, 1e-6f)                                                                     \
	X(16, shade_sample_blinn_phong, 1e-5f, 1e-6f)                                                                      \
	X(17, shade_pdf_blinn_phong, 1e-5f, 1e-6f)                                                                         \
	X(18, shade_sample_phong, 1e-5f, 1e-6f)                                                                            \
	X(19, shade_pdf_phong, 1e-5f, 1e-6f)                                                                               \
	X(20, shade_ggx_visible_density, 1e-5f, 1e-6f)                                                                     \
	X(21, shade_sample_ggx_normal, 1e-5f, 1e-6f)                                                                       \
	X(22, shade_sample_ggx, 1e-5f, 1e-6f)                                                                              \
	X(23, shade_pdf_ggx, 1e-5f, 1e-6f)                                                                                 \
	X(24, shade_sample_ggx_visible_normal, 1e-5f, 1e-6f)                                                               \
	X(25, shade_pdf_ggx_visible_normal, 1e-5f, 1e-6f)                                                                  \
	X(26, shade_sample_ggx_visible, 1e-5f, 1e-6f)                                                                      \
	X(27, shade_pdf_ggx_visible, 1e-5f, 1e-6f)                                                                         \
	X(28, shade_pdf_uniform, 1e-5f, 1e-6f)                                                                             \
	X(29, shade_sample_reflected, 1e-5f, 1e-6f)
#define SHADE_CASES_SAMPLING_COUNT 30

SHADE_FN vec4 shade_case_sample(shade_sample chosen)
{
	return vec4(chosen.direction, chosen.pdf);
}

/* Rows 0 to 9. */
SHADE_FN vec4 shade_case_patterns(int row, vec2 u, vec4 b)
{
	vec3 direction = shade_case_direction(b[0], b[1]);
	if (row == 0)
		return vec4(shade_log1p(u[0] - 0.99f), shade_log1p(1e-3f * u[1]), shade_log1p(1e3f * b[0]), 0.0f);
	if (row == 1)
		return vec4(shade_one_minus_exp(u[0]), shade_one_minus_exp(1e-3f * u[1]), shade_one_minus_exp(90.0f * b[0]),
		            0.0f);
	if (row == 2)
		return vec4(vec3(shade_sample_stratified(int(b[0] * 35.0f), 5, 7, u), shade_pdf_stratified(u * 2.0f - 0.5f)),
		            0.0f);
	if (row == 3)
		return vec4(shade_concentric(u), 0.0f);
	if (row == 4)
		return vec4(vec3(shade_sample_disk(u), shade_pdf_disk(u * 2.0f - 1.0f)), 0.0f);
	if (row == 5)
		return vec4(shade_direction_polar(b[0], b[1], 6.0f * u[0]), 0.0f);
	if (row == 6)
		return shade_case_sample(shade_sample_sphere(u));
	if (row == 7)
		return shade_case_sample(shade_sample_hemisphere(u));
	if (row == 8)
		return shade_case_sample(shade_sample_cosine(u));
	return vec4(shade_log_cosine(vec3(direction[0], direction[1], abs(direction[2]) + 1e-3f)), 0.0f, 0.0f, 0.0f);
}

/* Rows 10 to 13 and 15: lobes about z. */
SHADE_FN vec4 shade_case_lobes(int row, vec2 u, vec4 b)
{
	vec3 direction = shade_case_direction(b[0], b[1]);
	float n = shade_case_skewed(b[2], 0.0f, 2e6f);
	float seen = shade_case_skewed(b[2], 0.0f, 300.0f); // whose density is a number far from the axis too
	if (row == 10)
		return shade_case_sample(shade_sample_power(n, u));
	if (row == 11)
		return vec4(shade_pdf_power(seen, direction), 0.0f, 0.0f, 0.0f);
	if (row == 12)
		return shade_case_sample(shade_sample_vmf(n, vec2(0.8f * u[0], u[1])));
	if (row == 13)
		return vec4(shade_pdf_vmf(seen, direction), 0.0f, 0.0f, 0.0f);
	return vec4(shade_sample_blinn_normal(n, u).direction, shade_pdf_blinn_normal(seen, direction));
}

/* Rows 16 to 19: lobes that v is reflected into. */
SHADE_FN vec4 shade_case_phong_lobes(int row, vec2 u, vec3 v, vec3 l, float n)
{
	if (row == 16)
		return shade_case_sample(shade_sample_blinn_phong(n, v, u));
	if (row == 17)
		return vec4(shade_pdf_blinn_phong(n, v, l), 0.0f, 0.0f, 0.0f);
	if (row == 18)
		return shade_case_sample(shade_sample_phong(n, v, u));
	return vec4(shade_pdf_phong(n, v, l), 0.0f, 0.0f, 0.0f);
}

/* Rows 20 to 27: GGX normals h, and v reflected by them. */
SHADE_FN vec4 shade_case_ggx(int row, vec2 u, vec3 v_steep, vec3 v, vec3 l, shade_alphas alphas)
{
	vec3 h = shade_half_vector(v, l);
	if (row == 20)
		return vec4(shade_ggx_visible_density(alphas, v, h), 0.0f, 0.0f, 0.0f);
	if (row == 21)
		return vec4(shade_sample_ggx_normal(alphas, u).direction, shade_pdf_ggx_normal(alphas, h));
	if (row == 22)
		return shade_case_sample(shade_sample_ggx(alphas, v_steep, (u - 0.5f) * 0.7f + 0.5f));
	if (row == 23)
		return vec4(shade_pdf_ggx(alphas, v, l), shade_pdf_reflected(alphas.x, v[2]),
		            shade_pdf_mirrored(alphas.y, v, l), 0.0f);
	if (row == 24)
		return shade_case_sample(shade_sample_ggx_visible_normal(alphas, v, u));
	if (row == 25)
		return vec4(shade_pdf_ggx_visible_normal(alphas, v, h), 0.0f, 0.0f, 0.0f);
	if (row == 26)
		return shade_case_sample(shade_sample_ggx_visible(alphas, v, u));
	return vec4(shade_pdf_ggx_visible(alphas, v, l), 0.0f, 0.0f, 0.0f);
}

SHADE_FN vec4 shade_case_sampling(int row, vec4 a, vec4 b)
{
	vec2 u = vec2(a[0], a[1]);
	vec3 l = shade_case_direction(a[2], a[3]);
	vec3 v = shade_case_above(vec3(0.0f, 0.0f, 1.0f), b[0], b[1]);
	vec3 v_steep = normalize(vec3(0.0f, 0.0f, 2.0f) + shade_case_direction(b[0], b[1]));
	shade_alphas alphas = {shade_case_skewed(b[2], SHADE_ALPHA_MIN, 1.0f),
	                       shade_case_skewed(b[3], SHADE_ALPHA_MIN, 1.0f)};
	vec2 u_inner = vec2(0.8f * u[0], u[1]);
	float n = shade_case_skewed(b[2], 5.0f, 100.0f);
	if (row < 10)
		return shade_case_patterns(row, u, b);
	if (row == 14)
		return vec4(shade_half_vector(v, l), 0.0f);
	if (row < 16)
		return shade_case_lobes(row, u, b);
	if (row < 20)
		return shade_case_phong_lobes(row, u_inner, v_steep, l, n);
	if (row < 28)
		return shade_case_ggx(row, u_inner, v_steep, v, l, alphas);
	if (row == 28)
		return vec4(shade_pdf_sphere(), shade_pdf_hemisphere(l), shade_pdf_cosine(l), 0.0f);
	return shade_case_sample(shade_sample_reflected(v_steep, shade_sample_cosine((u - 0.5f) * 0.5f + 0.5f)));
}

#include "shading/glsl_end.h"
#endif
