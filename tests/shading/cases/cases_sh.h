/* cases_sh: spherical harmonics, luminance and colours of glowing bodies as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_SH_H
#define SHADE_CASES_SH_H

#include "case_inputs.h"
#include "shading/shade_sh.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_SH(X)                                                                                              \
	X(0, shade_luminance, 1e-5f, 1e-6f)                                                                                \
	X(1, shade_sh_basis, 1e-5f, 1e-6f)                                                                                 \
	X(2, shade_sh_basis_band_2, 1e-5f, 1e-6f)                                                                          \
	X(3, shade_sh_add, 1e-5f, 1e-6f)                                                                                   \
	X(4, shade_sh_scale, 1e-5f, 1e-6f)                                                                                 \
	X(5, shade_sh_dot, 1e-5f, 1e-6f)                                                                                   \
	X(6, shade_sh_evaluate, 1e-5f, 1e-6f)                                                                              \
	X(7, shade_sh_directional, 1e-5f, 1e-6f)                                                                           \
	X(8, shade_sh_ambient, 1e-5f, 1e-6f)                                                                               \
	X(9, shade_sh_convolve, 1e-5f, 1e-6f)                                                                              \
	X(10, shade_sh_convolve_cosine, 1e-5f, 1e-6f)                                                                      \
	X(11, shade_sh_irradiance, 1e-5f, 1e-6f)                                                                           \
	X(12, shade_sh_window, 1e-5f, 1e-6f)                                                                               \
	X(13, shade_sh_rotate, 1e-5f, 1e-6f)                                                                               \
	X(14, shade_sh_dominant_direction, 1e-5f, 1e-6f)                                                                   \
	X(15, shade_sh_dominant_irradiance, 1e-5f, 1e-6f)                                                                  \
	X(16, shade_sh_rgb_add, 1e-5f, 1e-6f)                                                                              \
	X(17, shade_sh_rgb_directional, 1e-5f, 1e-6f)                                                                      \
	X(18, shade_sh_rgb_ambient, 1e-5f, 1e-6f)                                                                          \
	X(19, shade_sh_rgb_evaluate, 1e-5f, 1e-6f)                                                                         \
	X(20, shade_sh_rgb_irradiance, 1e-5f, 1e-6f)                                                                       \
	X(21, shade_sh_rgb_window, 1e-5f, 1e-6f)                                                                           \
	X(22, shade_sh_rgb_rotate, 1e-5f, 1e-6f)                                                                           \
	X(23, shade_sh_dominant_light_irradiance, 1e-5f, 1e-6f)                                                            \
	X(24, shade_sh_dominant_light_ambient, 1e-5f, 1e-6f)                                                               \
	X(25, shade_sh_lobe, 1e-5f, 1e-6f)                                                                                 \
	X(26, shade_color_of_temperature, 1e-4f, 1e-5f)
#define SHADE_CASES_SH_COUNT 27

/* Four numbers that see all nine coefficients of f. */
SHADE_FN vec4 shade_case_sh_seen(shade_sh f)
{
	vec4 low = vec4(f.c[0], f.c[1], f.c[2], f.c[3]);
	return low + 0.5f * vec4(f.c[4], f.c[5], f.c[6], f.c[7]) + 0.25f * vec4(f.c[8]);
}

SHADE_FN vec4 shade_case_sh_rgb_seen(shade_sh_rgb f)
{
	return shade_case_sh_seen(f.r) + 0.5f * shade_case_sh_seen(f.g) + 0.25f * shade_case_sh_seen(f.b);
}

/* A colourful light beside a weaker ambient one. */
SHADE_FN shade_sh_rgb shade_case_sh_light(vec4 a, vec4 b)
{
	shade_sh_rgb sun = shade_sh_rgb_directional(shade_case_direction(a[0], a[1]), vec3(0.2f) + vec3(b));
	return shade_sh_rgb_add(sun, shade_sh_rgb_ambient(vec3(b[3], a[2], a[3]) * 0.1f));
}

SHADE_FN vec4 shade_case_sh_rgb(int row, vec4 a, vec4 b)
{
	vec3 l = shade_case_direction(a[0], a[1]);
	vec3 d = shade_case_direction(a[2], a[3]);
	shade_sh_rgb f = shade_case_sh_light(a, b);
	if (row == 16)
		return shade_case_sh_rgb_seen(shade_sh_rgb_add(f, f));
	if (row == 17)
		return shade_case_sh_rgb_seen(shade_sh_rgb_directional(l, vec3(b)));
	if (row == 18)
		return shade_case_sh_rgb_seen(shade_sh_rgb_ambient(vec3(b)));
	if (row == 19)
		return vec4(shade_sh_rgb_evaluate(f, d), 0.0f);
	if (row == 20)
		return vec4(shade_sh_rgb_irradiance(f, d), 0.0f);
	if (row == 21)
		return shade_case_sh_rgb_seen(shade_sh_rgb_window(f, b[2]));
	if (row == 22)
		return shade_case_sh_rgb_seen(shade_sh_rgb_rotate(f, shade_frame_from_normal(d)));
	shade_sh_light light = shade_sh_dominant_light(f);
	if (row == 23)
		return vec4(light.irradiance, light.direction[0]);
	return vec4(light.ambient, light.direction[1]);
}

SHADE_FN vec4 shade_case_sh(int row, vec4 a, vec4 b)
{
	vec3 l = shade_case_direction(a[0], a[1]);
	vec3 d = shade_case_direction(a[2], a[3]);
	shade_sh basis = shade_sh_basis(l);
	shade_sh f = shade_case_sh_light(a, b).g;
	if (row == 0)
		return vec4(shade_luminance(vec3(a)), shade_luminance(vec3(b)), 0.0f, 0.0f);
	if (row == 26)
		return vec4(shade_color_of_temperature(shade_case_range(a[0], 900.0f, 16000.0f)), 0.0f);
	if (row == 1)
		return vec4(basis.c[0], basis.c[1], basis.c[2], basis.c[3]);
	if (row == 2)
		return vec4(basis.c[4], basis.c[5], basis.c[6], basis.c[7] + basis.c[8]);
	if (row == 3)
		return shade_case_sh_seen(shade_sh_add(f, shade_sh_basis(d)));
	if (row == 4)
		return shade_case_sh_seen(shade_sh_scale(f, b[3]));
	if (row == 5)
		return vec4(shade_sh_dot(f, shade_sh_basis(d)), 0.0f, 0.0f, 0.0f);
	if (row == 6)
		return vec4(shade_sh_evaluate(f, d), 0.0f, 0.0f, 0.0f);
	if (row == 7)
		return shade_case_sh_seen(shade_sh_directional(l, b[0]));
	if (row == 8)
		return shade_case_sh_seen(shade_sh_ambient(b[0]));
	if (row == 9)
		return shade_case_sh_seen(shade_sh_convolve(f, vec3(b)));
	if (row == 10)
		return shade_case_sh_seen(shade_sh_convolve_cosine(f));
	if (row == 11)
		return vec4(shade_sh_irradiance(f, d), 0.0f, 0.0f, 0.0f);
	if (row == 12)
		return shade_case_sh_seen(shade_sh_window(f, b[2]));
	if (row == 13)
		return shade_case_sh_seen(shade_sh_rotate(f, shade_frame_from_normal(d)));
	if (row == 14)
		return vec4(shade_sh_dominant_direction(f), 0.0f);
	if (row == 15)
		return vec4(shade_sh_dominant_irradiance(f, d), 0.0f, 0.0f, 0.0f);
	if (row == 25)
		return vec4(shade_sh_lobe(100.0f * b[0]), shade_sh_lobe(b[1])[1]);
	return shade_case_sh_rgb(row, a, b);
}

#include "shading/glsl_end.h"
#endif
