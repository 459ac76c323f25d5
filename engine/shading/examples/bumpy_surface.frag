#version 450
#extension GL_GOOGLE_include_directive : require
// A bumpy surface in sunlight: the shading headers used from GLSL.
//
//   glslc --target-env=vulkan1.3 -I STILB/engine bumpy_surface.frag -o bumpy_surface.spv
//
// The models are specialization constants, so a pipeline contains the code of the chosen ones only.
#include "shading/shade_bump.h"
#include "shading/shade_surface.h"
#include "shading/shade_tonemap.h"

layout(constant_id = 0) const int kind = SHADE_BRDF_MICROFACET;
layout(constant_id = 1) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 2) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 3) const int f = SHADE_F_SCHLICK;

layout(set = 0, binding = 0) uniform sampler2D height_map; // metres
layout(push_constant) uniform Push { vec4 camera, sun_direction, sun_irradiance; } push;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 0) out vec4 color;

void main()
{
	float height = texture(height_map, uv).r;
	vec3 n = shade_bump_from_height(normalize(normal), dFdx(position), dFdy(position), dFdx(height), dFdy(height), 1.0);
	shade_brdf_model model = {kind, ndf, g, f};
	shade_material material = {vec3(0.4, 0.1, 0.05), vec3(0.04), 0.4, 0.0, 0.0};
	shade_sun sun = {push.sun_direction.xyz, push.sun_irradiance.xyz};
	shade_sky sky = {vec3(0.3, 0.5, 0.9), vec3(0.2, 0.15, 0.1)};
	vec3 v = normalize(push.camera.xyz - position);
	vec3 radiance = shade_surface_radiance(model, material, sun, sky, shade_frame_from_normal(n), v);
	color = vec4(shade_tonemap(radiance, SHADE_TONEMAP_A, SHADE_TONEMAP_B), 1.0);
}
