#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes whose material has a surface (scene/scene_surface.h).
#include "mesh.glsl"
#include "maps_color.glsl"
#include "../../shading/shade_gltf.h"

layout(location = 0) centroid in vec3 world_position;
layout(location = 23) in vec3 middle_position; // has derivatives also where a triangle covers a part of the pixel
layout(location = 1) centroid in vec3 world_normal;
#ifdef MESH_EXTRAS
layout(location = 6) centroid in vec3 world_tangent;
layout(location = 7) flat in float tangent_sign;
#endif

layout(set = 1, binding = 1) uniform sampler2DArray reflection_map;
layout(set = 1, binding = 2) uniform sampler2DArray normal_map;
layout(set = 1, binding = 3) uniform sampler2DArray occlusion_map;
layout(set = 1, binding = 4) uniform sampler2DArray emission_map;

layout(constant_id = 10) const uint max_anisotropy = 1u; // of the samplers

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

#ifdef MAPS_LAYERS
LAYER_PLACES(in)
layout(location = 22) flat in float model_scale;
layout(set = 1, binding = 5) uniform sampler2DArray coat_map;
layout(set = 1, binding = 6) uniform sampler2DArray coat_roughness_map;
layout(set = 1, binding = 7) uniform sampler2DArray coat_normal_map;
layout(set = 1, binding = 8) uniform sampler2DArray specular_map;
layout(set = 1, binding = 9) uniform sampler2DArray specular_color_map;
layout(set = 1, binding = 10) uniform sampler2DArray sheen_color_map;
layout(set = 1, binding = 11) uniform sampler2DArray sheen_roughness_map;
layout(set = 1, binding = 12) uniform sampler2DArray brushed_map;
layout(set = 1, binding = 13) uniform sampler2DArray transmission_map;
layout(set = 1, binding = 14) uniform sampler2DArray thickness_map;
#define LIT_LAYERS
#ifdef MAPS_THROUGH
#define LIT_THROUGH
#endif
#endif

#include "lit.glsl"
#ifdef MESH_CHANNEL
layout(location = 12) centroid in vec4 channel_uv;
layout(location = 13) centroid in vec3 channel_tangent;
#include "channel.glsl"
#endif

// How far the normals spread of which a texel of a map is the mean: where RENDER_MIPS_NORMALS and _TWO have it. A mip
// is chosen by the longer side of the pixel's footprint, and its texels are squares: of a footprint that is narrower,
// variances being about as the squares of sides, (1 + ratio^2) / 2 of the variance is left. Anisotropic filters take
// mips for a side that is shorter by as much. place: in texels.
float spread_of(vec4 texel, bool two, vec2 place)
{
	vec2 right = dFdx(place), down = dFdy(place);
	float one = dot(right, right), other = dot(down, down), most = float(max_anisotropy * max_anisotropy);
	float ratio2 = min(most * min(one, other) / max(max(one, other), 1e-20), 1.0);
	return clamp(1.0 - (two ? texel.y : texel.w), 0.0, 1.0) * sqrt(0.5 + 0.5 * ratio2);
}

// A roughness, widened by that spread under a map's scale of normals, which slopes are multiplied by.
float widened(float roughness, float spread, float scale)
{
	return shade_gltf_widened(roughness, min(spread * abs(scale), 1.0));
}

// What the maps hold here. What is missing is 1, but for the normal, which is that of the surface.
struct Texels {
	vec4 reflection;
	vec3 normal;
	float spread; // of the normals below it
	float occlusion;
	vec3 emission;
};

Texels texels_here(uint record)
{
	Texels texels = Texels(vec4(1.0), vec3(0.5, 0.5, 1.0), 0.0, 1.0, vec3(1.0));
	if (map_reflection)
		texels.reflection = clamp(
			texture(reflection_map, vec3(together ? first_place : reflection_place, map_layer(record, 1u))), 0.0, 1.0);
	if (map_normal) {
		vec2 place = together ? first_place : normal_place;
		vec4 texel = texture(normal_map, vec3(place, map_layer(record, 2u)));
		texels.normal = texel.xyz;
		if (two_channels) // the second one of two is alpha
			texels.normal = vec3(texel.xw, shade_gltf_normal_z(texel.x, texel.w));
		if (widens)
			texels.spread = spread_of(texel, two_channels, place * vec2(textureSize(normal_map, 0).xy));
	}
	if (map_occlusion)
		texels.occlusion =
			texture(occlusion_map, vec3(together ? first_place : occlusion_place, map_layer(record, 3u))).x;
	if (map_emission)
		texels.emission =
			texture(emission_map, vec3(together ? first_place : emission_place, map_layer(record, 4u))).xyz;
	return texels;
}

#ifdef MAPS_LAYERS
// Map number 5 + layer here; 1 where there is none.
#define LAYER_TEXEL(map, layer) \
	(!has_layer_map(layer) ? vec4(1.0) \
		: texture(map, vec3(together ? first_place : layer_places[layer], map_layer(record, MAPS_PLAIN + layer))))

// The maps that layers have.
struct LayerTexels {
	float coat, coat_roughness;
	vec3 coat_normal;
	float coat_spread;
	float specular;
	vec3 specular_color;
	vec3 sheen_color;
	float sheen_roughness;
	vec3 brushed;
	float transmission, thickness;
};

LayerTexels layer_texels_here(uint record)
{
	LayerTexels texels;
	texels.coat = LAYER_TEXEL(coat_map, 0u).x;
	texels.coat_roughness = LAYER_TEXEL(coat_roughness_map, 1u).y;
	vec4 normal = LAYER_TEXEL(coat_normal_map, 2u);
	texels.coat_normal = coat_two_channels ? vec3(normal.xw, shade_gltf_normal_z(normal.x, normal.w)) : normal.xyz;
	vec2 coat_place = (together ? first_place : layer_places[2]) * vec2(textureSize(coat_normal_map, 0).xy);
	texels.coat_spread = coat_widens ? spread_of(normal, coat_two_channels, coat_place) : 0.0;
	texels.specular = LAYER_TEXEL(specular_map, 3u).w;
	texels.specular_color = LAYER_TEXEL(specular_color_map, 4u).xyz;
	texels.sheen_color = LAYER_TEXEL(sheen_color_map, 5u).xyz;
	texels.sheen_roughness = LAYER_TEXEL(sheen_roughness_map, 6u).w;
	texels.brushed = has_layer_map(7u) ? LAYER_TEXEL(brushed_map, 7u).xyz : vec3(1.0, 0.5, 1.0);
	texels.transmission = LAYER_TEXEL(transmission_map, 8u).x;
	texels.thickness = LAYER_TEXEL(thickness_map, 9u).y;
	return texels;
}
#endif

// specular: SPECULAR the highlight's reflectance, else the dielectric's.
shade_gltf_base base_here(uint record, vec3 base_color, vec4 reflection, vec3 specular)
{
	float roughness = record_part(record, 1u).w;
	if (specular_workflow)
		return shade_gltf_specular(base_color, specular * reflection.xyz, (1.0 - roughness) * reflection.w);
	float metalness = record_part(record, 2u).w * reflection.z;
	return shade_gltf_metallic(base_color, metalness, roughness * reflection.y, specular);
}

// The unit normal on the side that is seen. mapped: there is a map of it, whose texel and scale these are. flat_normal:
// as of is_turned_over.
vec3 normal_here(bool mapped, vec3 texel, float scale, vec3 flat_normal, vec3 to_camera)
{
	vec3 own = normalize(world_normal), n = own;
#ifdef MESH_EXTRAS
	if (mapped) {
		vec3 local = shade_gltf_normal(texel, scale);
		if (tangent_sign != 0.0)
			n = shade_gltf_turned(local, world_tangent, tangent_sign, world_normal);
	}
#endif
	if (both_sides && is_turned_over(own, flat_normal, to_camera))
		n = -n;
	n = both_sides || mapped ? bent_normal(n, to_camera) : n;
	return mapped ? lifted_normal(n, flat_normal, to_camera) : n;
}

#ifdef MAPS_LAYERS
// What `layers` are here. tint: of what goes through.
Layers layers_here(uint record, LayerTexels texels, vec3 tint, vec3 flat_normal, vec3 to_camera)
{
	vec4 coat = record_part(record, 4u), sheen = record_part(record, 5u), brushed = record_part(record, 6u);
	vec4 inside = record_part(record, 7u);
	Layers layers;
	layers.coat = clamp(coat.x * texels.coat, 0.0, 1.0);
	layers.coat_roughness = clamp(coat.y * texels.coat_roughness, 0.0, 1.0);
	if (coat_widens)
		layers.coat_roughness = widened(layers.coat_roughness, texels.coat_spread, coat.z);
	layers.coat_n = normal_here(has_layer_map(2u), texels.coat_normal, coat.z, flat_normal, to_camera);
	layers.sheen = clamp(sheen.xyz * texels.sheen_color, 0.0, 1.0);
	layers.sheen_roughness = clamp(sheen.w * texels.sheen_roughness, 0.0, 1.0);
	vec3 normal = normalize(world_normal), tangent = vec3(normal.z, 0.0, -normal.x); // as of frame_here
	float sign = 1.0;
#ifdef MESH_EXTRAS
	if (tangent_sign != 0.0) {
		normal = world_normal;
		tangent = world_tangent;
		sign = tangent_sign;
	}
#endif
	vec2 way = texels.brushed.xy * 2.0 - 1.0;
	way = vec2(way.x * brushed.y - way.y * brushed.z, way.x * brushed.z + way.y * brushed.y);
	layers.along = tangent * way.x + cross(normal, tangent) * (way.y * sign);
	layers.brushed = is_brushed ? clamp(brushed.x * texels.brushed.z, 0.0, 1.0) : 0.0;
	layers.transmission = clamp(brushed.w * texels.transmission, 0.0, 1.0);
	layers.tint = tint;
	layers.absorption = inside.xyz;
	layers.thickness = inside.w * max(texels.thickness, 0.0) * model_scale;
	layers.ior = record_part(record, 3u).w;
	return layers;
}
#endif

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
		base_here(record, base_color.xyz, texels.reflection, vec3(0.0)).roughness, metalness,
		shade_gltf_occlusion(texels.occlusion, record_part(record, 3u).y), alpha, channel_uv);
}
#endif

void main()
{
	// Derivatives, also those by which textures are filtered, come before pixels are dropped: on GPUs the pixels beside
	// one that was dropped have none.
	bool needs_flat = both_sides || map_normal;
#ifdef MAPS_LAYERS
	needs_flat = needs_flat || has_layer_map(2u);
#endif
	vec3 flat_normal = needs_flat ? cross(dFdx(middle_position), dFdy(middle_position)) : vec3(0.0);
	uint index = material_of_word(material_word);
	Material stored = stored_material(index);
	uint record = stored.ids.y;
	vec4 raw = raw_color(record);
	vec4 base_color = raw * record_part(record, 0u);
	Texels texels = texels_here(record);
#ifdef MAPS_LAYERS
	LayerTexels layer_texels = layer_texels_here(record);
#endif
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
	vec3 n = normal_here(map_normal, texels.normal, record_part(record, 3u).x, flat_normal, to_camera);
	base_color = clamp(base_color, 0.0, 1.0); // what reflects more than it gets would make light
#ifdef MESH_CHANNEL
	color = channel_color(channels_here(record, texels, base_color, n), index);
	return;
#endif
	vec3 radiance = base_color.xyz;
	if (!unlit) {
#ifdef MAPS_LAYERS
		vec3 dielectric = record_part(record, 1u).xyz;
		if (has_layer_map(3u) || has_layer_map(4u))
			dielectric = clamp(min(dielectric * layer_texels.specular_color, 1.0) *
				(record_part(record, 4u).w * layer_texels.specular), 0.0, 1.0);
		shade_gltf_base base = base_here(record, base_color.xyz, texels.reflection, dielectric);
#else
		shade_gltf_base base = base_here(record, base_color.xyz, texels.reflection, record_part(record, 1u).xyz);
#endif
		if (widens)
			base.roughness = widened(base.roughness, texels.spread, record_part(record, 3u).x);
		shade_material material = material_with(stored, base.diffuse, base.specular, base.roughness);
		bool glows = !both_sides || gl_FrontFacing;
		vec3 emission = glows ? record_part(record, 2u).xyz * texels.emission : vec3(0.0);
		float open = shade_gltf_occlusion(texels.occlusion, record_part(record, 3u).y);
#ifdef MAPS_LAYERS
		float metalness = specular_workflow ? 0.0 : clamp(record_part(record, 2u).w * texels.reflection.z, 0.0, 1.0);
		layers = layers_here(record, layer_texels, base_color.xyz * (1.0 - metalness), flat_normal, to_camera);
		radiance = layered_radiance(material, emission, open, n, to_camera);
#else
		radiance = lit_radiance_open(material, emission, open, n, to_camera);
#endif
	}
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(material_word, n, to_camera);
	color = picture_color(radiance, index);
	if (blends)
		color *= base_color.w;
}
