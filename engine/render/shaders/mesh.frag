#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"

layout(location = 0) centroid in vec3 world_position;
layout(location = 23) in vec3 middle_position; // has derivatives also where a triangle covers a part of the pixel
layout(location = 1) centroid in vec3 world_normal;
layout(location = 24) centroid in vec3 vertex_even;
layout(location = 25) centroid in vec3 vertex_odd;
layout(location = 2) flat in uint material_word; // the material's index, and above it how the draw fades
layout(location = 2, component = 1) flat in uint model_lights;
layout(location = 2, component = 2) flat in uint model_id;

#ifdef MESH_TEXTURE
layout(location = 3) centroid in vec2 surface_uv;
layout(set = 1, binding = 0) uniform sampler2D diffuse_texture;
#endif

#ifndef MESH_SEEN
layout(location = 0) out vec4 color;
#endif
#ifdef LIT_BESIDE
#include "velocity/beside.glsl"
layout(location = 4) in vec3 last_clip;
#endif

#define LIT_VERTEX
#include "lit.glsl"
#ifdef MESH_CHANNEL
layout(location = 12) centroid in vec4 channel_uv;
#include "channel.glsl"
#endif

// The interpolated normal on the side of the triangle that is seen, and bent towards the viewer.
vec3 turned_normal(vec3 n, vec3 flat_normal, vec3 to_camera)
{
	return bent_normal(is_turned_over(n, flat_normal, to_camera) ? -n : n, to_camera);
}

void main()
{
	// Derivatives, also those by which the texture is filtered, come before pixels are dropped: on GPUs the pixels
	// beside one that was dropped have none.
	vec3 flat_normal = both_sides ? cross(dFdx(middle_position), dFdy(middle_position)) : vec3(0.0);
#ifdef MESH_TEXTURE
	vec3 texel = texture(diffuse_texture, surface_uv).rgb;
#endif
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
#ifndef MESH_SEEN
	uint index = material_of_word(material_word);
	Material stored = stored_material(index);
	vec3 diffuse = stored.diffuse_roughness.xyz;
#ifdef MESH_TEXTURE
	diffuse *= texel;
#endif
	shade_material material = material_here(stored, diffuse, stored.diffuse_roughness.w);
#endif
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	vec3 n = normalize(world_normal);
	if (both_sides)
		n = turned_normal(n, flat_normal, to_camera);
#ifdef LIT_BESIDE
	beside_write(last_clip, n, model_id);
#endif
#ifndef MESH_SEEN
	vec3 emission = !both_sides || gl_FrontFacing ? stored.emission_wrap.xyz : vec3(0.0);
#ifdef MESH_CHANNEL
	material = shade_material(diffuse, stored.specular_anisotropy.xyz, stored.diffuse_roughness.w, 0.0, 0.0);
	color = channel_color(channels_of(material, emission, n, channel_uv), index);
	return;
#endif
	vec3 radiance = lit_radiance(material, emission, n, to_camera);
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(material_word, n, to_camera);
	color = picture_color(radiance, index);
#endif
}
