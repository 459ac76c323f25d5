/* brdf_combination: one D x G x F out of eight numbers in [0, 1), C and GLSL; for test_shade_brdf_gpu.c.
 * [any-thread] */
#ifndef SHADE_BRDF_COMBINATION_H
#define SHADE_BRDF_COMBINATION_H

#include "case_inputs.h"
#include "shading/shade_brdf.h"

#include "shading/glsl_begin.h"

SHADE_FN vec4 shade_combination(int ndf, int g, int f, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	vec3 l = shade_case_above(n, a[2], a[3]);
	vec3 v = shade_case_above(n, b[0], b[1]);
	shade_brdf_model model = {SHADE_BRDF_MICROFACET, ndf, g, f};
	shade_brdf_parameters p = {vec3(a), b[2], shade_case_range(b[3], -0.9f, 0.9f), 0.0f};
	return vec4(shade_brdf_cos(model, p, shade_frame_from_normal(n), l, v), 0.0f);
}

#include "shading/glsl_end.h"
#endif
