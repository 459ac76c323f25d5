/* cases_phong: Schueler's zoo as rows: calls in which C and GPU are compared (README.md). [any-thread] */
#ifndef SHADE_CASES_PHONG_H
#define SHADE_CASES_PHONG_H

#include "case_inputs.h"
#include "shading/shade_phong.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_PHONG(X)                                                                                           \
	X(0, shade_cos_power, 1e-5f, 1e-6f)                                                                                \
	X(1, shade_sin2_r, 1e-5f, 1e-6f)                                                                                   \
	X(2, shade_exponent_from_alpha, 1e-5f, 1e-6f)                                                                      \
	X(3, shade_gloss, 1e-5f, 1e-6f)                                                                                    \
	X(4, shade_phong_factor, 1e-5f, 1e-6f)                                                                             \
	X(5, shade_blinn_phong_factor, 1e-5f, 1e-6f)                                                                       \
	X(6, shade_blinn_phong_modified_factor, 1e-5f, 1e-6f)                                                              \
	X(7, shade_phong, 1e-5f, 1e-6f)
#define SHADE_CASES_PHONG_COUNT 8

SHADE_FN vec4 shade_case_phong(int row, vec4 a, vec4 b)
{
	float n = shade_case_skewed(a[0], 0.0f, 2e6f);
	float sin2 = a[1] * min(20.0f / (n + 1.0f), 1.0f); // where the lobe is
	vec3 normal = shade_case_direction(a[2], a[3]);
	vec3 l = shade_case_above(normal, b[0], b[1]);
	vec3 v = shade_case_above(normal, b[2], b[3]);
	float alpha = shade_case_range(a[2], 1e-3f, 1.0f);
	if (row == 0)
		return vec4(shade_cos_power(sin2, n), shade_cos_power(a[1], 10.0f * a[2]), 0.0f, 0.0f);
	if (row == 1)
		return vec4(shade_sin2_r(normal, l, v), 0.0f, 0.0f, 0.0f);
	if (row == 2)
		return vec4(shade_exponent_from_alpha(alpha), shade_alpha_from_exponent(n), shade_exponent_about_r(n), 0.0f);
	if (row == 3)
		return vec4(shade_exponent_from_gloss(a[1]), shade_gloss_from_exponent(n + 0.5f), 0.0f, 0.0f);
	if (row == 4)
		return vec4(shade_phong_factor(n), shade_phong_modified_factor(n), shade_blinn_phong_ndf_factor(n),
		            shade_blinn_phong_heightfield_factor(n));
	if (row == 5)
		return vec4(shade_blinn_phong_factor_low(n), shade_blinn_phong_factor(n), shade_blinn_phong_factor_high(n),
		            0.0f);
	if (row == 6)
		return vec4(shade_blinn_phong_modified_factor_low(n), shade_blinn_phong_modified_factor(n),
		            shade_blinn_phong_modified_factor_high(n), 0.0f);
	return vec4(shade_phong(sin2, n), shade_phong_modified(sin2, a[3], n), shade_blinn_phong(sin2, n),
	            shade_blinn_phong_modified(sin2, a[3], n));
}

#include "shading/glsl_end.h"
#endif
