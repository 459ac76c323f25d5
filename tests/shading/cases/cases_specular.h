/* cases_specular: the microfacet terms as rows: calls in which C and GPU are compared (README.md). [any-thread] */
#ifndef SHADE_CASES_SPECULAR_H
#define SHADE_CASES_SPECULAR_H

#include "case_inputs.h"
#include "shading/shade_minimalist.h"
#include "shading/shade_specular.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_SPECULAR(X)                                                                                        \
	X(0, shade_angles_of, 1e-5f, 1e-6f)                                                                                \
	X(1, shade_alphas, 1e-5f, 1e-6f)                                                                                   \
	X(2, shade_d_isotropic, 1e-5f, 1e-6f)                                                                              \
	X(3, shade_d, 1e-5f, 1e-6f)                                                                                        \
	X(4, shade_d_ggx_anisotropic, 1e-5f, 1e-6f)                                                                        \
	X(5, shade_v_of_angles, 1e-5f, 1e-6f)                                                                              \
	X(6, shade_v1, 1e-5f, 1e-6f)                                                                                       \
	X(7, shade_v_smith_ggx, 1e-5f, 1e-6f)                                                                              \
	X(8, shade_v, 1e-5f, 1e-6f)                                                                                        \
	X(9, shade_f_schlick, 1e-5f, 1e-6f)                                                                                \
	X(10, shade_f_cook_torrance, 1e-5f, 1e-6f)                                                                         \
	X(11, shade_f, 1e-5f, 1e-6f)                                                                                       \
	X(12, shade_minimalist, 1e-5f, 1e-6f)
#define SHADE_CASES_SPECULAR_COUNT 13

SHADE_FN vec4 shade_case_specular_d(int row, vec4 a, float alpha)
{
	// sin^2 of facets as far as D reaches: a[1] is spread over four of its widths
	float tan2 = 16.0f * a[1] * a[1] * alpha * alpha;
	float sin2 = tan2 / (1.0f + tan2);
	float x = 4.0f * (a[1] - 0.5f) * alpha;
	float y = 4.0f * (a[2] - 0.5f) * alpha;
	if (row == 2)
		return vec4(shade_d_blinn(sin2, alpha), shade_d_beckmann(sin2, alpha), shade_d_ggx(sin2, alpha), 0.0f);
	if (row == 3)
		return vec4(shade_d(SHADE_NDF_BLINN, sin2, alpha), shade_d(SHADE_NDF_BECKMANN, sin2, alpha),
		            shade_d(SHADE_NDF_GGX, sin2, alpha), 0.0f);
	return vec4(shade_d_ggx_anisotropic(min(x, 0.7f), min(y, 0.7f), alpha, shade_case_range(a[3], 1e-3f, 1.0f)), 0.0f,
	            0.0f, 0.0f);
}

SHADE_FN vec4 shade_case_specular_v(int row, shade_angles angles, float alpha, float other)
{
	float c = angles.n_dot_l;
	int g = int(other * 7.999f);
	if (row == 5)
		return vec4(shade_v_implicit(), shade_v_neumann(c, angles.n_dot_v), shade_v_kelemen(angles.v_dot_h),
		            shade_v_cook_torrance(c, angles.n_dot_v, angles.n_dot_h, angles.v_dot_h));
	if (row == 6)
		return vec4(shade_v1_smith_beckmann(c, alpha), shade_v1_smith_ggx(c, alpha),
		            shade_v1_schlick(c, shade_schlick_k_beckmann(alpha)),
		            shade_v1_schlick(c, shade_schlick_k_ggx(alpha)));
	if (row == 7)
		return vec4(shade_v_smith_ggx(c, angles.n_dot_v, alpha, other),
		            shade_dv_ggx(angles.sin2_h, c, angles.n_dot_v, alpha), 0.0f, 0.0f);
	return vec4(shade_v(g, angles, alpha, other), shade_g(g, angles, alpha, other), 0.0f, 0.0f);
}

SHADE_FN vec4 shade_case_specular_f(int row, vec3 f0, float c)
{
	if (row == 9)
		return vec4(shade_f_schlick(f0, c), shade_f_schlick_1(f0[0], c) + shade_schlick_share(c));
	if (row == 10)
		return vec4(shade_f_cook_torrance(f0, c), shade_f_cook_torrance_1(f0[1], c));
	vec3 none = shade_f(SHADE_F_NONE, f0, c);
	return vec4(none[0], shade_f(SHADE_F_SCHLICK, f0, c)[1], shade_f(SHADE_F_COOK_TORRANCE, f0, c)[2], 0.0f);
}

SHADE_FN vec4 shade_case_specular(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	shade_angles angles = shade_angles_of(n, shade_case_above(n, a[2], a[3]), shade_case_above(n, b[0], b[1]));
	float alpha = shade_case_range(b[2], 1e-3f, 1.0f);
	if (row == 0)
		return vec4(angles.n_dot_l, angles.n_dot_h, angles.v_dot_h, angles.sin2_h + angles.n_dot_v);
	if (row == 1) {
		shade_alphas widths = shade_alphas_from_anisotropy(alpha, shade_case_range(b[3], -1.0f, 1.0f));
		return vec4(shade_alpha_from_roughness(a[0]), widths.x, widths.y, shade_alpha_along(widths, n));
	}
	if (row < 5)
		return shade_case_specular_d(row, a, alpha);
	if (row < 9)
		return shade_case_specular_v(row, angles, alpha, shade_case_range(b[3], 1e-3f, 1.0f));
	if (row < 12)
		return shade_case_specular_f(row, vec3(a), b[0]);
	vec3 schlick = shade_schlick_kelemen_fv(vec3(a), angles.v_dot_h);
	float exponent = 100.0f * a[0];
	return vec4(shade_minimalist_d(angles.sin2_h, exponent), shade_minimalist_fv(angles.v_dot_h),
	            shade_minimalist(angles.sin2_h, angles.v_dot_h, exponent), schlick[0]);
}

#include "shading/glsl_end.h"
#endif
