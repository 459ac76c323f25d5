/* cases_gltf: materials of glTF as rows: calls in which C and GPU are compared (README.md). [any-thread] */
#ifndef SHADE_CASES_GLTF_H
#define SHADE_CASES_GLTF_H

#include "case_inputs.h"
#include "shading/shade_gltf.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_GLTF(X)                                                                                            \
	X(0, shade_gltf_reflectance, 1e-5f, 1e-6f)                                                                         \
	X(1, shade_gltf_dielectric, 1e-5f, 1e-6f)                                                                          \
	X(2, shade_gltf_metallic_diffuse, 1e-5f, 1e-6f)                                                                    \
	X(3, shade_gltf_metallic, 1e-5f, 1e-6f)                                                                            \
	X(4, shade_gltf_specular_diffuse, 1e-5f, 1e-6f)                                                                    \
	X(5, shade_gltf_specular, 1e-5f, 1e-6f)                                                                            \
	X(6, shade_gltf_normal, 1e-5f, 2e-6f)                                                                              \
	X(7, shade_gltf_normal_z, 1e-5f, 2e-6f)                                                                            \
	X(8, shade_gltf_turned, 1e-5f, 2e-6f)                                                                              \
	X(9, shade_gltf_occlusion, 1e-5f, 1e-6f)                                                                           \
	X(10, shade_gltf_unmixed, 1e-4f, 1e-5f)                                                                            \
	X(11, shade_gltf_widened, 1e-5f, 1e-6f)
#define SHADE_CASES_GLTF_COUNT 12

SHADE_FN vec4 shade_case_gltf_base(shade_gltf_base base, bool of_diffuse)
{
	if (of_diffuse)
		return vec4(base.diffuse, 0.0f);
	return vec4(base.specular, base.roughness);
}

SHADE_FN vec4 shade_case_gltf(int row, vec4 a, vec4 b)
{
	vec3 color = vec3(a[0], a[1], a[2]), other = vec3(b[0], b[1], b[2]);
	if (row == 0)
		return vec4(shade_gltf_reflectance(select(a[0] == 0.0f, 0.0f, 1.0f + 2.0f * a[1])), 0.0f, 0.0f, 0.0f);
	if (row == 1)
		return vec4(shade_gltf_dielectric(1.0f + 2.0f * a[3], other * 40.0f, b[3]), 0.0f);
	if (row == 2 || row == 3)
		return shade_case_gltf_base(shade_gltf_metallic(color, a[3], b[3], other), row == 2);
	if (row == 4 || row == 5)
		return shade_case_gltf_base(shade_gltf_specular(color, other, b[3]), row == 4);
	if (row == 6)
		return vec4(shade_gltf_normal(color, 2.0f * b[0]), 0.0f);
	if (row == 7)
		return vec4(shade_gltf_normal_z(0.25f + 0.5f * a[0], 0.25f + 0.5f * a[1]), 0.0f, 0.0f, 0.0f);
	if (row == 10) {
		shade_gltf_base mixed = shade_gltf_metallic(0.1f + 0.9f * color, a[3], b[3], vec3(SHADE_GLTF_PLASTIC));
		shade_gltf_color found = shade_gltf_unmixed(mixed.diffuse, mixed.specular);
		return vec4(found.color, found.metalness);
	}
	if (row == 11)
		return vec4(shade_gltf_widened(a[0], select(a[1] < 0.1f, 0.0f, a[1])), 0.0f, 0.0f, 0.0f);
	if (row == 9)
		return vec4(shade_gltf_occlusion(a[0], a[1]), 0.0f, 0.0f, 0.0f);
	vec3 normal = shade_case_direction(a[0], a[1]);
	vec3 tangent = shade_frame_from_normal(normal).t * (0.5f + a[2]);
	vec3 local = vec3(b[0] - 0.5f, b[1] - 0.5f, 0.25f + b[2]);
	return vec4(shade_gltf_turned(local, tangent, select(a[3] < 0.5f, -1.0f, 1.0f), normal * (0.5f + b[3])), 0.0f);
}

#include "shading/glsl_end.h"
#endif
