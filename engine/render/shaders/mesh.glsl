// Data that the mesh shaders share with the CPU: buffers by address, laid out as in render_internal.h and
// device/render_device.h.
#extension GL_ARB_gpu_shader_int64 : require
#include "row.glsl"

// As render_material.
struct Material {
	vec4 diffuse_roughness;
	vec4 specular_anisotropy;
	vec4 emission_wrap;
	uvec4 ids; // the second: index of its maps
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Materials { Material materials[]; };

// As render_light.
struct Light {
	vec4 position_kind;
	vec4 direction_reach;
	vec4 intensity_inner;
	vec4 half_x_outer;
	vec4 half_y_radius;
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Lights { Light lights[]; };

// Numbers of a buffer by twos. Software devices load from an address number by number, one of 64 bits as fast as one of
// 32: what pixels load one after the other, their lights, they load so.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Pairs { uint64_t pairs[]; };
#define LIGHT_PAIRS 10u // of a light

vec2 pair_at(Pairs from, uint index)
{
	return uintBitsToFloat(unpackUint2x32(from.pairs[index]));
}

vec4 two_pairs_at(Pairs from, uint index)
{
	return vec4(pair_at(from, index), pair_at(from, index + 1u));
}

// As render_light_lists: for each cell where its list begins, and one more; then all places of lights, if there are
// some; then the lists, as far as there is room.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer LightLists {
	vec4 depth_plane;
	vec2 slice; // scale, bias
	uint room, all;
	uint words[];
};

// Of tiles (deferred/tiles.comp): for each where its list begins, and for each where it ends; then the lists.
layout(buffer_reference, std430, buffer_reference_align = 16) buffer TileLists {
	vec4 unused[2]; // as LightLists
	uint words[];
};

// Of pixels (deferred/indices.comp): the lists of the view; for each pixel eight places of lights, 16 bits each, those
// that it needs in their order, then LIGHT_INDEX_NONE; LIGHT_INDEX_MORE first: there are more, and its list has them.
#define LIGHT_INDEX_NONE 0xffffu
#define LIGHT_INDEX_MORE 0xfffeu
layout(buffer_reference, std430, buffer_reference_align = 16) buffer LightIndices {
	LightLists lists;
	uvec2 padding;
	uvec4 pixels[];
};

// Of views whose models have lights of their own (render_combined.h): for each model its word; and the
// records, of which each has nine parts: four lights; their shares; of the sum's coefficients the first eight of red,
// green and blue, then the three ninth ones.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ModelWords { uint words[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ModelLights { uvec4 parts[]; };

// Irradiance by the normal, in latitude and longitude, as render_panorama.table.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Panorama { vec4 table[]; };

// As render_maps_stored, of which each has 46: color; specular, roughness; emission, metalness; scale of normals,
// occlusion, cutoff, ior; coat, its roughness, scale of its normals, weight of specular; sheen, its roughness; brushed,
// cosine and sine of its turn, transmission; absorption, thickness; for each map two rows of its transform, behind the
// first which uv it lies on; for each map its layer; four parameters of a function.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Maps { vec4 parts[]; };
#define MAPS_PARTS 46u

// As render_extra, of which each has three: tangent, sign; uv; colour. As render_extra_place.
layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer Extras { uvec2 parts[]; };
layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer ExtraPlaces { uvec2 places[]; };

// As render_shadow_map.
struct ShadowMap {
	vec4 rows[4]; // the world to x and y in texels, depth, w
	vec4 area;    // left, top, right, bottom, texels; of a directional light where it ends: see shadow_end
	vec4 rest;    // layer, blend, maps of its light from this one on, half the filter's width
	// Metres by which surfaces are off: in the map at w = 1; those seen at a distance of 1 from the camera. Texels by
	// which a lamp's size widens an edge, over the difference of depth between what casts and what gets it. How dark
	// its shadow is, 1: black.
	vec4 error;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ShadowMaps { ShadowMap maps[]; };

// Where vertices were in the frame before, three numbers each.
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer LastVertices { float numbers[]; };

// As render_view_data.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ViewRest {
	mat4 view_projection;
	vec4 sky; // these two, harmonics and mirrored: of render_ambient
	vec4 ground;
	Extras extras;
	ExtraPlaces extra_places;
	float time; // seconds, for functions of surfaces
	float half_width, half_height; // of what is drawn into, pixels
	float far;                     // the largest w of clip space that surfaces in 8 bits have
	mat4 last_view_projection;     // of the frame before, for velocities alone
	LastVertices last_vertices;
	ShadowMaps shadows;
	mat4 from_clip; // clip space to the world
	vec4 harmonics[9];
	vec4 mirrored; // the share of their bands that highlights have at most
	vec2 jitter;   // of clip space: by which view_projection moves what is drawn
	float exposure; // factor of radiance, where it is kept as exposed (hdr/hdr.glsl)
	float unused;
};

// As render_view_push: what pixels read of a view. Software devices load from a buffer lane by lane, from constants at
// once.
struct View {
	vec4 camera_position; // w: of a parallel view w of clip space, of others 0
	vec4 added; // to every material's roughness, anisotropy, wrap, specular
	vec2 turn;  // sine and cosine of the panorama's rotation
	uint light_count;
	float pixels; // of the picture's height that a length of 1 at a distance of 1 has
	Lights lights;
	Maps maps;
	Panorama panorama;
	ViewRest rest;
	LightLists lists;
	uvec2 grid; // of cells: columns | rows << 16; log2 of a tile's pixels | slices << 8
};

// The heap of vertices (render_vertex.h). Packed, three of these for each: position's x and y; its z, the normal; uv.
// As floats two: position and normal's x; normal's y and z, uv.
#ifdef MESH_PACKED
layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer Vertices { uvec2 thirds[]; };
#else
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Vertices { vec4 halves[]; };
#endif

// As render_push. MESH_OWN_PUSH: of programs with constants of their own.
#ifndef MESH_OWN_PUSH
layout(push_constant, std430) uniform Push {
	View view;
	Rows rows;
	Materials materials;
	Vertices vertices;
	Rows frame_rows;
} push;

Row row_of(uint word)
{
	Rows rows = (word & ROW_FRAME) != 0u ? push.frame_rows : push.rows;
	return rows.rows[word & (ROW_FRAME - 1u)];
}

// The word of the model that a row draws; 0: it has none.
uint model_word(Row row)
{
	uint model = row.model & ROW_MODEL;
	return model != 0u ? ModelWords(push.view.lists).words[model - 1u] : 0u;
}
#endif

// RENDER_BESIDE_...: what the program draws beside the picture, or beside depth (velocity/beside.glsl).
layout(constant_id = 12) const uint beside = 0u;
#define BESIDE_VELOCITY 1u
#define BESIDE_ID 2u
#define BESIDE_NORMAL 4u
#define BESIDE_AROUND 8u
#define BESIDE_MIRROR 16u
// LIT_BESIDE: fragment shaders that can.
#if !defined(MESH_CHANNEL) && !defined(LIT_TERMS) && !defined(LIT_ALONE) && !defined(GBUFFER_SLIM) && \
	(!defined(MAPS_DEPTH) || defined(MESH_SEEN))
#define LIT_BESIDE
#endif

// Of render_view_lights.bits: what lights in place of sky, ground and panorama.
#define LIGHTS_AMBIENT (3u << 21)
#define LIGHTS_DARK (1u << 21)
#define LIGHTS_SH_VERTEX (2u << 21)
#define LIGHTS_SH_PIXEL (3u << 21)

// Likewise: models have lights of their own.
#define LIGHTS_COMBINED 8388608u

// Likewise: maps keep lights from surfaces; besides LIGHTS_DEPTH: such a map is drawn.
#define LIGHTS_SHADOWS (1u << 30)
#define LIGHTS_DEPTH 2048u

// What the high bits of a draw's row word mean (render_internal.h, RENDER_DETAIL_SHIFT).
#define DETAIL_NONE 0u
#define DETAIL_FADE 1u
#define DETAIL_MORPH 2u
#define DETAIL_SHOW 3u
layout(constant_id = 7) const uint detail_kind = DETAIL_NONE;
layout(constant_id = 8) const uint samples = 1u; // of a pixel: 1 or 4
#define DETAIL_SHIFT 26
#define DETAIL_MATERIAL_SHIFT 24 // where they are in the material's index that the fragment shader gets
#define MATERIAL_INDEX ((1u << DETAIL_MATERIAL_SHIFT) - 1u)
#define MATERIAL_UNSHADOWED (1u << 31) // above both: the model receives no shadow

// That bit for a draw's row, where the view's lights have shadows.
uint material_unshadowed(Row row, uint lights_of_view)
{
	bool shadows = (lights_of_view & (LIGHTS_SHADOWS | LIGHTS_DEPTH)) == LIGHTS_SHADOWS;
	return shadows && (row.model & ROW_UNSHADOWED) != 0u ? MATERIAL_UNSHADOWED : 0u;
}
