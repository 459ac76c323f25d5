/* cases_layers: layers of materials as rows: calls in which C and GPU are compared (README.md). [any-thread] */
#ifndef SHADE_CASES_LAYERS_H
#define SHADE_CASES_LAYERS_H

#include "case_inputs.h"
#include "shading/shade_layers.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute). Sheen needs log and exp: its power is of up to 50. */
#define SHADE_CASES_LAYERS(X)                                                                                          \
	X(0, shade_layer_highlight_cos, 2e-4f, 1e-6f)                                                                      \
	X(1, shade_coat_share, 1e-5f, 1e-6f)                                                                               \
	X(2, shade_coat_cos, 2e-4f, 1e-6f)                                                                                 \
	X(3, shade_sheen_albedo_raw, 1e-4f, 1e-6f)                                                                         \
	X(4, shade_sheen_albedo, 1e-4f, 1e-6f)                                                                             \
	X(5, shade_d_sheen, 1e-3f, 1e-6f)                                                                                  \
	X(6, shade_sheen_cos, 1e-3f, 1e-6f)                                                                                \
	X(7, shade_sheen_left, 1e-4f, 1e-5f)                                                                               \
	X(8, shade_facet_left, 1e-5f, 1e-6f)                                                                               \
	X(9, shade_thin_cos, 2e-4f, 1e-5f)                                                                                 \
	X(10, shade_gltf_brushed, 1e-5f, 1e-6f)                                                                            \
	X(11, shade_sheen_direction, 1e-5f, 1e-5f)                                                                         \
	X(12, shade_sheen_most, 1e-4f, 1e-6f)
#define SHADE_CASES_LAYERS_COUNT 13

SHADE_FN float shade_case_layers_of_two(int row, vec3 f0, float roughness, vec3 l, vec3 v)
{
	vec3 n = vec3(0.0f, 0.0f, 1.0f);
	if (row == 0)
		return shade_layer_highlight_cos(roughness, n, l, v);
	if (row == 2)
		return shade_coat_cos(roughness, n, l, v);
	if (row == 6)
		return shade_sheen_cos(roughness, n, l, v);
	return shade_thin_cos(f0, roughness, n, vec3(l[0], l[1], -l[2]), v);
}

SHADE_FN vec4 shade_case_layers(int row, vec4 a, vec4 b)
{
	vec3 color = vec3(b[0], b[1], b[2]);
	float roughness = 0.2f + 0.8f * a[3];
	if (row == 1)
		return vec4(shade_coat_share(a[0], a[1]), 0.0f, 0.0f, 0.0f);
	if (row == 3)
		return vec4(shade_sheen_albedo_raw(a[0], roughness), 0.0f, 0.0f, 0.0f);
	if (row == 12)
		return vec4(shade_sheen_most(a[0], roughness), 0.0f, 0.0f, 0.0f);
	if (row == 4)
		return vec4(shade_sheen_albedo(a[0], roughness), 0.0f, 0.0f, 0.0f);
	if (row == 5)
		return vec4(shade_d_sheen(a[0], roughness), 0.0f, 0.0f, 0.0f);
	if (row == 7)
		return vec4(shade_sheen_left(color, a[0], roughness), 0.0f, 0.0f, 0.0f);
	if (row == 8)
		return vec4(shade_facet_left(color, a[0]), 0.0f, 0.0f, 0.0f);
	if (row == 10) {
		vec2 brushed = shade_gltf_brushed(a[0], a[1]);
		return vec4(brushed[0], brushed[1], 0.0f, 0.0f);
	}
	if (row == 11) {
		vec3 n = vec3(0.0f, 0.0f, 1.0f);
		return vec4(shade_sheen_direction(n, shade_case_above(n, a[0], a[1]), roughness), 0.0f);
	}
	vec3 l = shade_case_above(vec3(0.0f, 0.0f, 1.0f), a[0], a[1]);
	vec3 v = shade_case_above(vec3(0.0f, 0.0f, 1.0f), a[2], b[3]);
	return vec4(shade_case_layers_of_two(row, color, roughness, l, v), 0.0f, 0.0f, 0.0f);
}

#include "shading/glsl_end.h"
#endif
