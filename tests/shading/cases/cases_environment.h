/* cases_environment: gloss under a prefiltered environment as rows: calls in which C and GPU are compared (README.md).
 * [any-thread] */
#ifndef SHADE_CASES_ENVIRONMENT_H
#define SHADE_CASES_ENVIRONMENT_H

#include "case_inputs.h"
#include "shading/shade_environment.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_ENVIRONMENT(X)                                                                                     \
	X(0, shade_cube_place_of, 1e-5f, 1e-6f)                                                                            \
	X(1, shade_cube_direction, 1e-5f, 1e-6f)                                                                           \
	X(2, shade_environment_mip, 1e-5f, 1e-6f)                                                                          \
	X(3, shade_environment_direction, 1e-5f, 1e-6f)                                                                    \
	X(4, shade_dfg_place, 1e-5f, 1e-6f)                                                                                \
	X(5, shade_dfg_from_place, 1e-5f, 1e-6f)                                                                           \
	X(6, shade_energy_compensation, 1e-5f, 1e-6f)                                                                      \
	X(7, shade_environment_reflectance, 1e-5f, 1e-6f)                                                                  \
	X(8, shade_environment_look_of, 1e-5f, 1e-5f)
#define SHADE_CASES_ENVIRONMENT_COUNT 9

SHADE_FN vec4 shade_case_cubes(int row, vec4 a)
{
	if (row == 0) {
		/* Signs of 0 differ. */
		shade_cube_place place = shade_cube_place_of(shade_case_direction(a[0], a[1]) * (0.1f + a[2]));
		return vec4(float(place.face), place.s, place.t, 0.0f);
	}
	return vec4(shade_cube_direction(int(a[2] * 5.999f), 2.0f * a[0] - 1.0f, 2.0f * a[1] - 1.0f), 0.0f);
}

SHADE_FN vec4 shade_case_environment(int row, vec4 a, vec4 b)
{
	if (row < 2)
		return shade_case_cubes(row, a);
	float mips = 2.0f + floor(b[0] * 10.0f);
	if (row == 2)
		return vec4(shade_environment_mip(a[0], mips), shade_environment_roughness(a[1] * (mips - 1.0f), mips), 0.0f,
		            0.0f);
	vec3 n = shade_case_direction(a[0], a[1]);
	if (row == 3)
		return vec4(shade_environment_direction(n, shade_case_above(n, a[2], a[3]), b[0]), 0.0f);
	if (row == 8) {
		shade_environment_look look = shade_environment_look_of(n, shade_case_above(n, a[2], a[3]), b[0]);
		return vec4(look.toward, look.roughness);
	}
	vec2 place = shade_dfg_place(a[0] * a[0], a[1]);
	if (row == 4) {
		vec2 texel = shade_dfg_texel(place, 2.0f + floor(b[0] * 62.0f));
		return vec4(place[0], place[1], texel[0], texel[1]);
	}
	if (row == 5) {
		vec2 back = shade_dfg_from_place(vec2(b[0], b[1]));
		return vec4(back[0], back[1], 0.0f, 0.0f);
	}
	vec2 dfg = vec2(0.2f + 0.7f * b[0], 0.1f * b[1]);
	if (row == 6)
		return vec4(shade_energy_compensation(vec3(a), dfg), 0.0f);
	return vec4(shade_environment_reflectance(vec3(a), dfg), 0.0f);
}

#include "shading/glsl_end.h"
#endif
