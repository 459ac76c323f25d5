/*
 * shade_cases: every shading function as one row with numbers in and out, C and GLSL, so that a GPU's answers can be held
 * against C's. [any-thread]
 *
 * shade_case(row, a, b) maps eight numbers in [0, 1) to the row's arguments and returns up to four results. Beside the
 * row stands how far GPU and C may differ: in units of max(1, |C's answer|), on lavapipe.
 */
#ifndef SHADE_CASES_H
#define SHADE_CASES_H

#include "shading/shade_blinn_phong.h"
#include "shading/shade_diffuse.h"
#include "shading/shade_energy.h"
#include "shading/shade_srgb.h"
#include "shading/shade_surface.h"
#include "shading/shade_tonemap.h"

#include "shading/glsl_begin.h"

/* X(row, name, bound) */
#define SHADE_CASES(X)                                                                                                 \
	X(0, shade_lambert, 1e-7f)                                                                                         \
	X(1, shade_hemisphere_irradiance, 1e-6f)                                                                           \
	X(2, shade_blinn_phong_modified_factor, 1e-6f)                                                                     \
	X(3, shade_blinn_phong_modified, 3e-4f)                                                                            \
	X(4, shade_limit_to_one_diffuse, 1e-6f)                                                                            \
	X(5, shade_limit_to_one_specular, 1e-6f)                                                                           \
	X(6, shade_tonemap, 1e-6f)                                                                                         \
	X(7, shade_tonemap_inverse, 1e-5f)                                                                                 \
	X(8, shade_srgb_from_linear, 2e-6f)                                                                                \
	X(9, shade_srgb_to_linear, 2e-6f)                                                                                  \
	X(10, shade_n_dot_h, 1e-6f)                                                                                        \
	X(11, shade_surface_radiance, 3e-4f)
#define SHADE_CASE_COUNT 12

/* A unit vector from two numbers in [0, 1); +Y is its pole. */
SHADE_FN vec3 shade_case_direction(float u, float v)
{
	float y = 2.0f * u - 1.0f;
	float r = sqrt(max(1.0f - y * y, 0.0f));
	return vec3(r * cos(6.2831853f * v), y, r * sin(6.2831853f * v));
}

SHADE_FN vec3 shade_case_surface(vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 sun_direction = normalize(n + 0.99f * shade_case_direction(a[2], a[3]));
	vec3 v = normalize(n + 0.99f * shade_case_direction(b[0], b[1]));
	shade_reflectance share = shade_limit_to_one(vec3(b[2], a[0], a[1]), vec3(b[3], b[0], a[2]));
	shade_material material = {share.diffuse, share.specular, exp2(10.0f * b[3])};
	shade_sun sun = {sun_direction, vec3(4.0f, 3.0f, 2.0f)};
	shade_sky sky = {vec3(0.3f, 0.5f, 0.9f), vec3(0.2f, 0.1f, 0.05f)};
	return shade_surface_radiance(material, sun, sky, n, v);
}

SHADE_FN vec4 shade_case(int row, vec4 a, vec4 b)
{
	vec3 color = vec3(a) * exp2(16.0f * b[0] - 6.0f);
	shade_reflectance share = shade_limit_to_one(vec3(a) * 2.0f - 0.2f, vec3(b) * 2.0f - 0.2f);
	if (row == 0)
		return vec4(shade_lambert(vec3(a)), 0.0f);
	if (row == 1)
		return vec4(shade_hemisphere_irradiance(2.0f * a[3] - 1.0f, vec3(a), vec3(b)), 0.0f);
	if (row == 2)
		return vec4(shade_blinn_phong_modified_factor(exp2(13.0f * a[0])));
	if (row == 3)
		return vec4(shade_blinn_phong_modified(1.0f - a[1] * a[1], exp2(11.0f * a[0])));
	if (row == 4)
		return vec4(share.diffuse, 0.0f);
	if (row == 5)
		return vec4(share.specular, 0.0f);
	if (row == 6)
		return vec4(shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B), 0.0f);
	if (row == 7)
		return vec4(shade_tonemap_inverse(vec3(a) * 0.95f, SHADE_TONEMAP_A, SHADE_TONEMAP_B), 0.0f);
	if (row == 8)
		return vec4(shade_srgb_from_linear(a[0]), shade_srgb_from_linear(0.01f * a[1]), 0.0f, 0.0f);
	if (row == 9)
		return vec4(shade_srgb_to_linear(a[0]), shade_srgb_to_linear(0.1f * a[1]), 0.0f, 0.0f);
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 l = shade_case_direction(a[2], a[3]);
	if (row == 10)
		return vec4(shade_n_dot_h(n, l, normalize(l + 0.9f * shade_case_direction(b[0], b[1]))), 0.0f, 0.0f, 0.0f);
	return vec4(shade_case_surface(a, b), 0.0f);
}

#include "shading/glsl_end.h"
#endif
