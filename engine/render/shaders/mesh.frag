#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "../../shading/shade_energy.h"
#include "../../shading/shade_surface.h"
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool tone_map = true;
// The materials that the pipeline draws: 0 all, 1 those with an even index, 2 those with an odd one. Others are black.
layout(constant_id = 1) const uint drawn = 0;
// The formulas, in the order of vulkan_formula. They are compile-time constants: code of other formulas is removed.
layout(constant_id = 2) const int brdf = SHADE_BRDF_BLINN_PHONG_MODIFIED;
layout(constant_id = 3) const int ndf = SHADE_NDF_GGX;
layout(constant_id = 4) const int g = SHADE_G_SMITH_GGX;
layout(constant_id = 5) const int f = SHADE_F_SCHLICK;
layout(constant_id = 6) const int light = SHADE_LIGHT_SUN;

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) flat in uint material_index;

#ifdef MESH_TEXTURE
layout(location = 3) in vec2 surface_uv;
layout(set = 0, binding = 0) uniform sampler2D diffuse_texture;
#endif

#ifdef MESH_BIND
layout(set = 1, binding = 0, std430) readonly buffer Bound { Material material; } bound;
#endif

layout(location = 0) out vec4 color;

// The draw's material plus the view's additions.
shade_material material_here()
{
#ifdef MESH_BIND
	Material m = bound.material;
#else
	Material m = push.materials.materials[material_index];
#endif
	vec3 diffuse = m.diffuse_roughness.xyz;
#ifdef MESH_TEXTURE
	diffuse *= texture(diffuse_texture, surface_uv).rgb;
#endif
	vec4 added = push.view.added;
	shade_reflectance reflectance = {diffuse, m.specular_anisotropy.xyz};
	if (added.w != 0.0)
		reflectance = shade_limit_to_one(diffuse, reflectance.specular + added.w);
	return shade_material(reflectance.diffuse, reflectance.specular,
		clamp(m.diffuse_roughness.w + added.x, 0.0, 1.0),
		clamp(m.specular_anisotropy.w + added.y, -1.0, 1.0),
		clamp(m.wrap.x + added.z, 0.0, 1.0));
}

// The light at this point, as the view's light model has it: the sun, or the lamp seen from here.
shade_sun light_here()
{
	shade_sun sun = {push.view.sun_direction.xyz, push.view.sun_irradiance.xyz};
	// Load whole vec4s: if .xyz and .w are loaded separately, lavapipe (Mesa 22.3) reads .w as 0.
	vec4 position_radius = push.view.lamp_position_radius;
	vec4 axis_reach = push.view.lamp_axis_reach;
	shade_lamp lamp = {position_radius.xyz, axis_reach.xyz, push.view.lamp_intensity.xyz, position_radius.w,
		axis_reach.w};
	return shade_light_at(light, sun, lamp, world_position);
}

// Meshes have no tangents: anisotropic materials are brushed around the vertical axis, as if turned on a lathe.
shade_frame frame_here(vec3 n)
{
	return shade_frame_from_tangent(n, vec3(n.z, 0.0, -n.x)); // cross(up, n)
}

// What the lights of the view's list send to v.
vec3 from_lights(shade_brdf_model model, shade_material material, shade_frame frame, vec3 v)
{
	vec3 radiance = vec3(0.0);
	for (uint i = 0; i < push.view.light_count; i++) {
		Light from = push.view.lights.lights[i];
		shade_point_light light = {int(from.position_kind.w), from.position_kind.xyz, from.direction_outer.xyz,
			from.intensity_inner.xyz, from.intensity_inner.w, from.direction_outer.w};
		shade_sun seen = shade_point_light_at(light, world_position);
		radiance += shade_surface_brdf_cos(model, material, frame, seen.direction, v) * seen.irradiance;
	}
	return radiance;
}

// The sky's reflection, for SHADE_LIGHT_HEMISPHERE, where the sky is the only light.
vec3 sky_highlight(shade_material material, shade_sky sky, vec3 n, vec3 v)
{
	float exponent = shade_exponent_from_alpha(shade_alpha_from_roughness(material.roughness));
	return material.specular *
		shade_hemisphere_radiance(reflect(-v, n).y, shade_exponent_about_r(exponent), sky.sky, sky.ground);
}

void main()
{
	shade_brdf_model model = {brdf, ndf, g, f};
	shade_material material = material_here();
	shade_sky sky = {push.view.sky.xyz, push.view.ground.xyz};
	vec3 n = normalize(world_normal);
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	shade_frame frame = frame_here(n);
	vec3 radiance = shade_surface_radiance(model, material, light_here(), sky, frame, to_camera);
	radiance += from_lights(model, material, frame, to_camera);
	if (light == SHADE_LIGHT_HEMISPHERE && brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED)
		radiance += sky_highlight(material, sky, n, to_camera);
	if (drawn != 0 && (material_index & 1) != drawn - 1)
		radiance = vec3(0.0);
	color = vec4(tone_map ? shade_tonemap(radiance, SHADE_TONEMAP_A, SHADE_TONEMAP_B) : radiance, 1.0);
}
