#version 460
#extension GL_GOOGLE_include_directive : require
// Meshes whose material has a surface (scene/scene_surface.h). MAPS_FUNCTION: that has a function of the program's, too
// (surface.glsl); MAPS_DEPTH: where depth alone is drawn, of these; with MESH_VELOCITY: where velocities are, too; with
// MESH_SEEN: and models and normals, of all.
#include "surface.glsl"
#ifdef MAPS_FUNCTION
#define discard surface_functions_must_not_discard_but_return_alpha_0
#include "surface_function.glsl" // the program's, which stilb_surface() puts there
#undef discard
#endif
#include "mesh.glsl"
#include "maps_color.glsl"
#include "../../shading/shade_gltf.h"

layout(location = 0) centroid in vec3 world_position;
layout(location = 23) in vec3 middle_position; // has derivatives also where a triangle covers a part of the pixel
layout(location = 1) centroid in vec3 world_normal;
#ifndef MAPS_FUNCTION
layout(location = 24) centroid in vec3 vertex_even;
layout(location = 25) centroid in vec3 vertex_odd;
#define LIT_VERTEX
#endif
#ifdef MESH_EXTRAS
layout(location = 6) centroid in vec3 world_tangent;
layout(location = 7) flat in float tangent_sign;
#endif

layout(set = 1, binding = 1) uniform sampler2DArray reflection_map;
layout(set = 1, binding = 2) uniform sampler2DArray normal_map;
layout(set = 1, binding = 3) uniform sampler2DArray occlusion_map;
layout(set = 1, binding = 4) uniform sampler2DArray emission_map;

layout(constant_id = 10) const uint max_anisotropy = 1u; // of the samplers

#ifndef MAPS_DEPTH
layout(location = 0) out vec4 color;
#endif
#ifdef LIT_BESIDE
#include "velocity/beside.glsl"
#elif defined(MESH_VELOCITY)
#include "velocity.glsl"
#endif
#if defined(LIT_BESIDE) || defined(MESH_VELOCITY)
layout(location = 4) in vec3 last_clip;
#endif
#ifdef MAPS_FUNCTION
FUNCTION_INPUTS(in)
#endif

#ifdef MAPS_COVERAGE
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

// The reflectance of the dielectric, or of SPECULAR the highlight's factor.
#ifdef MAPS_LAYERS
vec3 specular_here(uint record, LayerTexels texels)
{
	vec3 specular = record_part(record, 1u).xyz;
	if (has_layer_map(3u) || has_layer_map(4u))
		specular = clamp(min(specular * texels.specular_color, 1.0) *
			(record_part(record, 4u).w * texels.specular), 0.0, 1.0);
	return specular;
}
#else
vec3 specular_here(uint record)
{
	return record_part(record, 1u).xyz;
}
#endif

// The surface by factors and texels. base_color: as it stands, which masks are compared with. specular: specular_here.
Surface surface_here(uint record, vec4 base_color, Texels texels, vec3 specular, vec3 n)
{
	Surface surface;
	float roughness = record_part(record, 1u).w;
	bool glows = !both_sides || gl_FrontFacing;
	surface.color = clamp(base_color.xyz, 0.0, 1.0); // what reflects more than it gets would make light
	surface.alpha = base_color.w;
	surface.specular = specular_workflow ? specular * texels.reflection.xyz : specular;
	surface.metalness = specular_workflow ? 0.0 : record_part(record, 2u).w * texels.reflection.z;
	surface.roughness =
		specular_workflow ? 1.0 - (1.0 - roughness) * texels.reflection.w : roughness * texels.reflection.y;
	surface.occlusion = shade_gltf_occlusion(texels.occlusion, record_part(record, 3u).y);
	surface.normal = n;
	surface.emission = glows ? record_part(record, 2u).xyz * texels.emission : vec3(0.0);
	return surface;
}

#ifdef MAPS_FUNCTION
float share_or_none(float share)
{
	return share > 0.0 ? min(share, 1.0) : 0.0; // also of NaN
}

vec3 shares_or_none(vec3 shares)
{
	return vec3(share_or_none(shares.x), share_or_none(shares.y), share_or_none(shares.z));
}

float radiance_or_none(float radiance)
{
	return radiance > 0.0 ? min(radiance, 1e30) : 0.0;
}

vec4 surface_parameter(int number)
{
	return function_parameters[clamp(number, 0, 3)];
}

// What the program's function makes of the surface; a surface that it leaves alone keeps its bits.
Surface surface_by_function(Surface before, vec3 flat_normal, vec3 to_camera)
{
	SurfacePoint point;
	point.position = world_position;
	point.local = function_local;
	point.normal = normal_here(false, vec3(0.5, 0.5, 1.0), 1.0, flat_normal, to_camera);
	point.to_viewer = to_camera;
	point.uv = function_uv.xy;
	point.uv1 = function_uv.zw;
	point.color = surface_color;
	point.time = function_view.w;
	point.front = gl_FrontFacing;
	Surface after = surface_function(before, point);
	after.color = shares_or_none(after.color);
	after.alpha = after.alpha > 0.0 ? after.alpha : 0.0;
	after.specular = shares_or_none(after.specular);
	after.metalness = share_or_none(after.metalness);
	after.roughness = share_or_none(after.roughness);
	after.occlusion = share_or_none(after.occlusion);
	after.emission = vec3(
		radiance_or_none(after.emission.x), radiance_or_none(after.emission.y), radiance_or_none(after.emission.z));
	if (after.normal != before.normal) {
		float square = dot(after.normal, after.normal);
		bool sound = square > 1e-30 && square < 1e30;
		after.normal = sound ? bent_normal(after.normal * inversesqrt(square), to_camera) : before.normal;
	}
	return after;
}
#endif

shade_gltf_base base_of(Surface surface)
{
	if (!specular_workflow)
		return shade_gltf_metallic(surface.color, surface.metalness, surface.roughness, surface.specular);
	shade_gltf_base base = shade_gltf_specular(surface.color, surface.specular, 0.0);
	base.roughness = surface.roughness;
	return base;
}

#ifdef MESH_CHANNEL
Channels channels_here(Surface surface)
{
	float alpha = masked || blends ? clamp(surface.alpha, 0.0, 1.0) : 1.0;
	float square = dot(channel_tangent, channel_tangent);
	vec3 tangent = square > 0.0 ? channel_tangent * inversesqrt(square) : vec3(0.0);
	if (unlit)
		return Channels(
			surface.color, surface.normal, tangent, vec3(0.0), 0.0, 0.0, 1.0, alpha, channel_uv);
	float metalness = specular_workflow ? 0.0 : surface.metalness;
	return Channels(surface.color, surface.normal, tangent, surface.emission, surface.roughness, metalness,
		surface.occlusion, alpha, channel_uv);
}
#endif

#ifndef MAPS_DEPTH
// What the surface sends to the viewer. spread: of the normals that its own is the mean of.
#ifdef MAPS_LAYERS
vec3 radiance_here(Surface surface, float spread, Material stored, LayerTexels texels, vec3 flat_normal,
	vec3 to_camera)
#else
vec3 radiance_here(Surface surface, float spread, Material stored, vec3 to_camera)
#endif
{
	if (unlit)
		return adds_lights ? vec3(0.0) : surface.color;
	shade_gltf_base base = base_of(surface);
	if (widens)
		base.roughness = widened(base.roughness, spread, record_part(stored.ids.y, 3u).x);
	shade_material material = material_with(stored, base.diffuse, base.specular, base.roughness);
#ifdef MAPS_LAYERS
	float metalness = specular_workflow ? 0.0 : clamp(surface.metalness, 0.0, 1.0);
	layers = layers_here(stored.ids.y, texels, surface.color * (1.0 - metalness), flat_normal, to_camera);
	return layered_radiance(material, surface.emission, surface.occlusion, surface.normal, to_camera);
#else
	return lit_radiance_open(material, surface.emission, surface.occlusion, surface.normal, to_camera);
#endif
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
#ifdef MAPS_FUNCTION
	vec4 base_color = raw * function_color;
	vec3 to_camera = normalize(function_view.xyz - world_position);
#else
	vec4 base_color = raw * record_part(record, 0u);
	vec3 to_camera = normalize(push.view.camera_position.xyz - world_position);
#endif
	Texels texels = texels_here(record);
	vec3 n = normal_here(map_normal, texels.normal, record_part(record, 3u).x, flat_normal, to_camera);
#ifdef MAPS_LAYERS
	LayerTexels layer_texels = layer_texels_here(record);
	Surface surface = surface_here(record, base_color, texels, specular_here(record, layer_texels), n);
#else
	Surface surface = surface_here(record, base_color, texels, specular_here(record), n);
#endif
#ifdef MAPS_FUNCTION
	surface = surface_by_function(surface, flat_normal, to_camera);
#endif
#if defined(MAPS_COVERAGE) && defined(MAPS_FUNCTION)
	int covered = covered_samples(surface.alpha, 1.0, record_part(record, 3u).z);
#elif defined(MAPS_COVERAGE)
	int covered = covered_samples(raw.w, record_part(record, 0u).w, record_part(record, 3u).z);
#endif
	if (detail_kind == DETAIL_FADE && is_faded_out(material_word))
		discard;
#ifdef MAPS_COVERAGE
	if (covered == 0)
		discard;
	gl_SampleMask[0] = covered;
#else
	if (masked && surface.alpha < record_part(record, 3u).z)
		discard;
#endif
#ifndef MAPS_DEPTH
#ifdef MESH_CHANNEL
	color = channel_color(channels_here(surface), index);
#else
#ifdef MAPS_LAYERS
	vec3 radiance = radiance_here(surface, texels.spread, stored, layer_texels, flat_normal, to_camera);
#else
	vec3 radiance = radiance_here(surface, texels.spread, stored, to_camera);
#endif
	if (detail_kind == DETAIL_SHOW)
		radiance = level_color(material_word, surface.normal, to_camera);
	color = picture_color(radiance, index);
	if (blends && !lights_counted)
		color *= clamp(surface.alpha, 0.0, 1.0);
#endif
#endif
#ifdef LIT_BESIDE
	beside_write(last_clip, surface.normal, model_id);
#elif defined(MESH_VELOCITY)
	velocity = velocity_from(last_clip, vec2(push.view.rest.half_width, push.view.rest.half_height));
#endif
}
