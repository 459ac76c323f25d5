#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "../../shading/shade_surface.h"
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool tone_map = true;

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) flat in uint material_index;

layout(location = 0) out vec4 color;

void main()
{
	Material m = push.materials.materials[material_index];
	shade_material material = {m.diffuse_shininess.xyz, m.specular.xyz, m.diffuse_shininess.w};
	shade_sun sun = {push.view.sun_direction.xyz, push.view.sun_irradiance.xyz};
	shade_sky sky = {push.view.sky.xyz, push.view.ground.xyz};
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	vec3 radiance = shade_surface_radiance(material, sun, sky, normalize(world_normal), to_camera);
	color = vec4(tone_map ? shade_tonemap(radiance, SHADE_TONEMAP_A, SHADE_TONEMAP_B) : radiance, 1.0);
}
