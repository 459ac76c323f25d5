#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "../../shading/shade_surface.h"
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool tone_map = true;
// Which materials the pipeline is for: all (0), those with an even (1) or with an odd index (2). Others come out black.
layout(constant_id = 1) const uint drawn = 0;

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

void main()
{
#ifdef MESH_BIND
	Material m = bound.material;
#else
	Material m = push.materials.materials[material_index];
#endif
	vec3 diffuse = m.diffuse_shininess.xyz;
#ifdef MESH_TEXTURE
	diffuse *= texture(diffuse_texture, surface_uv).rgb;
#endif
	shade_material material = {diffuse, m.specular.xyz, m.diffuse_shininess.w};
	shade_sun sun = {push.view.sun_direction.xyz, push.view.sun_irradiance.xyz};
	shade_sky sky = {push.view.sky.xyz, push.view.ground.xyz};
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	vec3 radiance = shade_surface_radiance(material, sun, sky, normalize(world_normal), to_camera);
	if (drawn != 0 && (material_index & 1) != drawn - 1)
		radiance = vec3(0.0);
	color = vec4(tone_map ? shade_tonemap(radiance, SHADE_TONEMAP_A, SHADE_TONEMAP_B) : radiance, 1.0);
}
