/* cases_bump: bumps and ray differentials as rows: calls in which C and GPU are compared (README.md). [any-thread] */
#ifndef SHADE_CASES_BUMP_H
#define SHADE_CASES_BUMP_H

#include "case_inputs.h"
#include "shading/shade_bump.h"
#include "shading/shade_frame.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_BUMP(X)                                                                                            \
	X(0, shade_bump_gradient, 1e-5f, 1e-6f)                                                                            \
	X(1, shade_bump_normal, 1e-5f, 1e-6f)                                                                              \
	X(2, shade_bump_from_height, 1e-5f, 1e-6f)                                                                         \
	X(3, shade_bump_chain_rule, 1e-5f, 1e-6f)                                                                          \
	X(4, shade_bump_derivatives_per_uv, 1e-5f, 1e-6f)                                                                  \
	X(5, shade_bump_from_derivatives, 1e-5f, 1e-6f)                                                                    \
	X(6, shade_ray_differential_pinhole, 1e-5f, 1e-6f)                                                                 \
	X(7, shade_ray_differential_hit, 1e-5f, 1e-6f)                                                                     \
	X(8, shade_ray_differential_uv, 1e-5f, 1e-6f)
#define SHADE_CASES_BUMP_COUNT 9

SHADE_FN vec4 shade_case_bump_ray(int row, vec4 a, vec4 b, shade_frame frame)
{
	vec3 forward = shade_case_direction(b[0], b[1]) * (0.5f + b[2]);
	shade_ray_differential ray = shade_ray_differential_pinhole(forward, vec3(a) * 0.1f);
	if (row == 6)
		return vec4(ray.direction, ray.origin[0]);
	ray.origin = vec3(b) * 0.1f;
	vec3 down = shade_case_above(-frame.n, b[2], b[3]);
	if (row == 7)
		return vec4(shade_ray_differential_hit(ray, down, 1.0f + a[3], frame.n), 0.0f);
	vec3 dp = frame.t * (b[0] - 0.5f) + frame.b * (b[1] - 0.5f);
	vec3 dp_du = frame.t * (1.0f + a[2]) + frame.b * a[3];
	vec3 dp_dv = frame.b * (1.0f + b[2]) - frame.t * b[3];
	return vec4(vec3(shade_ray_differential_uv(frame.n, dp, dp_du, dp_dv), 0.0f), 0.0f);
}

SHADE_FN vec4 shade_case_bump(int row, vec4 a, vec4 b)
{
	shade_frame frame = shade_frame_from_normal(shade_case_direction(a[0], a[1]));
	vec3 dp_dx = (frame.t * (1.0f + a[2]) + frame.b * a[3]) * 0.01f;
	vec3 dp_dy = (frame.t * a[2] - frame.b * (1.0f + a[3])) * 0.01f;
	vec2 dh = vec2(b[0] - 0.5f, b[1] - 0.5f);
	vec3 gradient = shade_bump_gradient(frame.n, dp_dx, dp_dy, 0.01f * dh[0], 0.01f * dh[1]);
	vec2 duv_dx = vec2(0.5f + a[2], b[2]);
	vec2 duv_dy = vec2(-b[3], 0.5f + a[3]);
	if (row == 0)
		return vec4(gradient, 0.0f);
	if (row == 1)
		return vec4(shade_bump_normal(frame.n, frame.t * dh[0] + frame.b * dh[1], 4.0f * b[2]), 0.0f);
	if (row == 2)
		return vec4(shade_bump_from_height(frame.n, dp_dx, dp_dy, 0.01f * dh[0], 0.01f * dh[1], b[2]), 0.0f);
	if (row == 3)
		return vec4(shade_bump_chain_rule(dh, duv_dx), shade_bump_chain_rule(dh, duv_dy), 0.0f, 0.0f);
	if (row == 4)
		return vec4(vec3(shade_bump_derivatives_per_uv(dh, vec2(512.0f, 256.0f)), 0.0f), 0.0f);
	if (row == 5)
		return vec4(shade_bump_from_derivatives(frame.n, dp_dx, dp_dy, 0.01f * dh, duv_dx, duv_dy, b[2]), 0.0f);
	return shade_case_bump_ray(row, a, b, frame);
}

#include "shading/glsl_end.h"
#endif
