/* cases_brdf: whole reflection models, and what stands around them, as rows: calls in which C and GPU are compared
 * (README.md). test_shade_brdf_gpu.c has all combinations of D, G and F. [any-thread] */
#ifndef SHADE_CASES_BRDF_H
#define SHADE_CASES_BRDF_H

#include "case_inputs.h"
#include "shading/shade_brdf.h"
#include "shading/shade_diffuse.h"
#include "shading/shade_energy.h"
#include "shading/shade_frame.h"
#include "shading/shade_surface.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_BRDF(X)                                                                                            \
	X(0, shade_lambert, 1e-5f, 1e-6f)                                                                                  \
	X(1, shade_wrapped, 1e-5f, 1e-6f)                                                                                  \
	X(2, shade_limit_to_one_diffuse, 1e-5f, 1e-6f)                                                                     \
	X(3, shade_limit_to_one_specular, 1e-5f, 1e-6f)                                                                    \
	X(4, shade_frame_from_normal, 1e-5f, 1e-6f)                                                                        \
	X(5, shade_frame_from_tangent, 1e-5f, 1e-6f)                                                                       \
	X(6, shade_brdf_cos, 1e-5f, 1e-6f)                                                                                 \
	X(7, shade_microfacet_cos, 1e-5f, 1e-6f)                                                                           \
	X(8, shade_surface_brdf_cos, 1e-5f, 1e-6f)                                                                         \
	X(9, shade_surface_radiance, 1e-5f, 1e-6f)                                                                         \
	X(10, shade_surface_diffuse_cos, 1e-5f, 1e-6f)                                                                     \
	X(11, shade_surface_highlight_cos, 1e-5f, 1e-6f)                                                                   \
	X(12, shade_surface_sky, 1e-5f, 1e-6f)                                                                             \
	X(13, shade_surface_lit, 1e-5f, 1e-6f)                                                                             \
	X(14, shade_surface_light, 1e-4f, 1e-4f)                                                                           \
	X(15, shade_diffuse_left, 1e-4f, 1e-5f)                                                                            \
	X(16, shade_brdf_diffuse_left, 1e-4f, 1e-5f)                                                                       \
	X(17, shade_surface_seen, 1e-4f, 1e-5f)                                                                            \
	X(18, shade_d_peak, 1e-4f, 1e-5f)                                                                                  \
	X(19, shade_v_peak, 1e-4f, 1e-5f)                                                                                  \
	X(20, shade_brdf_peak, 1e-4f, 1e-5f)                                                                               \
	X(21, shade_light_share, 1e-5f, 1e-6f)                                                                             \
	X(22, shade_roughness_under, 1e-5f, 1e-6f)
#define SHADE_CASES_BRDF_COUNT 23

/* A light of any kind, 2 away in direction l. kind: [0, 1) */
SHADE_FN shade_light shade_case_lamp(float kind, vec3 l)
{
	shade_frame around = shade_frame_from_normal(l);
	shade_light light = {SHADE_LIGHT_POINT + int(kind * 5.999f),
	                     SHADE_FALLOFF_PHYSICAL,
	                     l * 2.0f,
	                     -l,
	                     vec3(3.0f, 2.0f, 1.0f),
	                     0.9f,
	                     0.5f,
	                     0.5f,
	                     around.t,
	                     around.b,
	                     9.0f};
	return light;
}

/* A surface under one light, by parts. */
SHADE_FN vec4 shade_case_surface(int row, shade_brdf_model model, shade_material material, shade_frame frame, vec3 l,
                                 vec3 v)
{
	shade_sun sun = {l, vec3(4.0f, 3.0f, 2.0f)};
	shade_sky sky = {vec3(0.3f, 0.5f, 0.9f), vec3(0.2f, 0.1f, 0.05f)};
	if (row == 9)
		return vec4(shade_surface_radiance(model, material, sun, sky, frame, v), 0.0f);
	if (row == 10)
		return vec4(shade_surface_diffuse_cos(model, material, frame.n, l), 0.0f);
	if (row == 11)
		return vec4(shade_surface_highlight_cos(model, material, frame, l, v), 0.0f);
	if (row == 12)
		return vec4(shade_surface_sky(material, sky, frame.n), 0.0f);
	if (row == 13)
		return vec4(shade_surface_lit(model, material, frame, sun, material.roughness > 0.5f, sky.sky, v), 0.0f);
	shade_light light = shade_case_lamp(material.roughness, l);
	return vec4(shade_surface_light(model, material, frame, light, vec3(0.0f), v), 0.0f);
}

/* Any model about any normal. */
SHADE_FN vec4 shade_case_brdf_model(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 l = shade_case_above(n, a[2], a[3]);
	vec3 v = shade_case_above(n, b[0], b[1]);
	shade_frame frame = shade_frame_from_tangent(n, l);
	int choice = int(b[2] * 63.999f);
	shade_brdf_model model = {choice / 8, choice / 16, choice - choice / 8 * 8, choice / 24};
	shade_brdf_parameters p = {vec3(b), b[3], shade_case_range(a[0], -0.7f, 0.7f), a[1]};
	if (row == 6)
		return vec4(shade_brdf_cos(model, p, frame, l, v), 0.0f);
	if (row == 7)
		return vec4(shade_microfacet_cos(model, p, frame, shade_angles_of(n, l, v), l, v), 0.0f);
	shade_reflectance share = shade_limit_to_one(vec3(a), vec3(b));
	shade_material material = {share.diffuse, share.specular, p.roughness, p.anisotropy, p.wrap};
	float roughness = shade_case_range(b[3], 0.1f, 1.0f);
	shade_alphas alphas = shade_alphas_from_anisotropy(shade_alpha_from_roughness(roughness), p.anisotropy);
	if (row == 18)
		return vec4(shade_d_peak(model.ndf, alphas), 0.0f, 0.0f, 0.0f);
	if (row == 19)
		return vec4(shade_v_peak(model.g, alphas), 0.0f, 0.0f, 0.0f);
	if (row == 20)
		return vec4(shade_brdf_peak(model, roughness, p.anisotropy), 0.0f, 0.0f, 0.0f);
	if (row == 16)
		return vec4(shade_brdf_diffuse_left(model, a[2], b[3]), 0.0f, 0.0f, 0.0f);
	if (row == 17)
		return vec4(shade_surface_seen(model, material, a[2]).diffuse, 0.0f);
	if (row == 8)
		return vec4(shade_surface_brdf_cos(model, material, frame, l, v), 0.0f);
	return shade_case_surface(row, model, material, frame, l, v);
}

SHADE_FN vec4 shade_case_brdf(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 w = shade_case_direction(a[2], a[3]);
	shade_reflectance share = shade_limit_to_one(vec3(a) * 2.0f - 0.2f, vec3(b) * 2.0f - 0.2f);
	if (row == 0)
		return vec4(shade_lambert(vec3(a)), 0.0f);
	if (row == 1)
		return vec4(shade_wrapped(shade_case_range(a[0], -1.0f, 1.0f), a[1]), 0.0f, 0.0f, 0.0f);
	if (row == 2)
		return vec4(share.diffuse, 0.0f);
	if (row == 3)
		return vec4(share.specular, 0.0f);
	if (row == 4)
		return vec4(shade_frame_to_local(shade_frame_from_normal(n), w), 0.0f);
	if (row == 15)
		return vec4(shade_diffuse_left(a[0], b[0]), 0.0f, 0.0f, 0.0f);
	if (row == 5)
		return vec4(shade_frame_to_world(shade_frame_from_tangent(n, w), vec3(b)), 0.0f);
	if (row == 21)
		return vec4(shade_light_share(shade_case_lamp(b[0], w), vec3(b[1], b[2], b[3]) - 0.5f), 0.0f, 0.0f, 0.0f);
	if (row == 22)
		return vec4(shade_roughness_under(a[0], b[0]), 0.0f, 0.0f, 0.0f);
	return shade_case_brdf_model(row, a, b);
}

#include "shading/glsl_end.h"
#endif
