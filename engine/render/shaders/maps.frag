#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes whose material has a surface (scene/scene_surface.h).
#include "mesh.glsl"
#include "maps_color.glsl"
#include "../../shading/shade_gltf.h"

layout(location = 0) centroid in vec3 world_position;
layout(location = 1) centroid in vec3 world_normal;
#ifdef MESH_EXTRAS
layout(location = 6) centroid in vec3 world_tangent;
layout(location = 7) flat in float tangent_sign;
#endif

layout(set = 1, binding = 1) uniform sampler2DArray reflection_map;
layout(set = 1, binding = 2) uniform sampler2DArray normal_map;
layout(set = 1, binding = 3) uniform sampler2DArray occlusion_map;
layout(set = 1, binding = 4) uniform sampler2DArray emission_map;

layout(location = 0) out vec4 color;

#ifdef MAPS_COVERAGE
layout(constant_id = 8) const uint samples = 4u; // of a pixel

// The share of the pixel in which alpha is at least the cutoff, as so many of its samples. raw: alpha without the
// record's factor, which has derivatives.
int covered_samples(float raw, float factor, float cutoff)
{
	float width = fwidth(raw) * factor;
	float share = raw * factor >= cutoff ? 1.0 : 0.0; // of even alpha
	if (width > 1e-5)
		share = clamp((raw * factor - cutoff) / width + 0.5, 0.0, 1.0);
	int count = int(share * float(samples) + 0.5);
	return count == 0 ? 0 : count == 1 ? 1 : count == 2 ? 9 : count == 3 ? 11 : 15;
}
#endif

#include "lit.glsl"
#ifdef MESH_CHANNEL
layout(location = 12) centroid in vec4 channel_uv;
layout(location = 13) centroid in vec3 channel_tangent;
#include "channel.glsl"
#endif

// What the maps hold here. What is missing is 1, but for the normal, which is that of the surface.
struct Texels {
	vec4 reflection;
	vec3 normal;
	float occlusion;
	vec3 emission;
};

Texels texels_here(uint record)
{
	vec4 layers = record_part(record, 14u);
	Texels texels = Texels(vec4(1.0), vec3(0.5, 0.5, 1.0), 1.0, vec3(1.0));
	if (map_reflection)
		texels.reflection =
			clamp(texture(reflection_map, vec3(together ? first_place : reflection_place, layers.y)), 0.0, 1.0);
	if (map_normal) {
		vec4 texel = texture(normal_map, vec3(together ? first_place : normal_place, layers.z));
		texels.normal = texel.xyz;
		if (two_channels) // the second one of two is alpha
			texels.normal = vec3(texel.xw, shade_gltf_normal_z(texel.x, texel.w));
	}
	if (map_occlusion)
		texels.occlusion = texture(occlusion_map, vec3(together ? first_place : occlusion_place, layers.w)).x;
	if (map_emission) {
		float layer = record_part(record, 15u).x;
		texels.emission = texture(emission_map, vec3(together ? first_place : emission_place, layer)).xyz;
	}
	return texels;
}

shade_gltf_base base_here(uint record, vec3 base_color, vec4 reflection)
{
	vec4 specular_roughness = record_part(record, 1u);
	if (specular_workflow)
		return shade_gltf_specular(base_color, specular_roughness.xyz * reflection.xyz,
			(1.0 - specular_roughness.w) * reflection.w);
	float metalness = record_part(record, 2u).w * reflection.z;
	return shade_gltf_metallic(base_color, metalness, specular_roughness.w * reflection.y, specular_roughness.xyz);
}

// The unit normal on the side that is seen. flat_normal: as of is_turned_over.
vec3 normal_here(uint record, vec3 texel, vec3 flat_normal, vec3 to_camera)
{
	vec3 own = normalize(world_normal), n = own;
#ifdef MESH_EXTRAS
	if (map_normal) {
		vec3 local = shade_gltf_normal(texel, record_part(record, 3u).x);
		if (tangent_sign != 0.0)
			n = shade_gltf_turned(local, world_tangent, tangent_sign, world_normal);
	}
#endif
	if (both_sides && is_turned_over(own, flat_normal, to_camera))
		n = -n;
	return both_sides || map_normal ? bent_normal(n, to_camera) : n;
}

#ifdef MESH_CHANNEL
Channels channels_here(uint record, Texels texels, vec4 base_color, vec3 n)
{
	float alpha = masked || blends ? base_color.w : 1.0;
	float square = dot(channel_tangent, channel_tangent);
	vec3 tangent = square > 0.0 ? channel_tangent * inversesqrt(square) : vec3(0.0);
	if (unlit)
		return Channels(base_color.xyz, n, tangent, vec3(0.0), 0.0, 0.0, 1.0, alpha, channel_uv);
	vec3 emission = !both_sides || gl_FrontFacing ? record_part(record, 2u).xyz * texels.emission : vec3(0.0);
	float metalness = specular_workflow ? 0.0 : record_part(record, 2u).w * texels.reflection.z;
	return Channels(base_color.xyz, n, tangent, emission,
		base_here(record, base_color.xyz, texels.reflection).roughness, metalness,
		shade_gltf_occlusion(texels.occlusion, record_part(record, 3u).y), alpha, channel_uv);
}
#endif

void main()
{
	// Derivatives, also those by which textures are filtered, come before pixels are dropped: on GPUs the pixels beside
	// one that was dropped have none.
	vec3 flat_normal = both_sides ? cross(dFdx(world_position), dFdy(world_position)) : vec3(0.0);
	uint index = material_of_word(material_word);
	Material stored = stored_material(index);
	uint record = stored.ids.y;
	vec4 raw = raw_color(record);
	vec4 base_color = raw * record_part(record, 0u);
	Texels texels = texels_here(record);
#ifdef MAPS_COVERAGE
	int covered = covered_samples(raw.w, record_part(record, 0u).w, record_part(record, 3u).z);
#endif
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
#ifdef MAPS_COVERAGE
	if (covered == 0)
		discard;
	gl_SampleMask[0] = covered;
#else
	if (masked && base_color.w < record_part(record, 3u).z)
		discard;
#endif
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
	vec3 n = normal_here(record, texels.normal, flat_normal, to_camera);
	base_color = clamp(base_color, 0.0, 1.0); // what reflects more than it gets would make light
#ifdef MESH_CHANNEL
	color = channel_color(channels_here(record, texels, base_color, n), index);
	return;
#endif
	vec3 radiance = base_color.xyz;
	if (!unlit) {
		shade_gltf_base base = base_here(record, base_color.xyz, texels.reflection);
		shade_material material = material_with(stored, base.diffuse, base.specular, base.roughness);
		bool glows = !both_sides || gl_FrontFacing;
		vec3 emission = glows ? record_part(record, 2u).xyz * texels.emission : vec3(0.0);
		float open = shade_gltf_occlusion(texels.occlusion, record_part(record, 3u).y);
		radiance = lit_radiance_open(material, emission, open, n, to_camera);
	}
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(material_word, n, to_camera);
	color = picture_color(radiance, index);
	if (blends)
		color *= base_color.w;
}
