// What the shaders of meshes with maps share. Who includes it has included mesh.glsl.

// RENDER_MAPS_...: what there is. What is not there is no code, since software devices compute every branch.
layout(constant_id = 9) const uint maps = 0u;
const bool map_color = (maps & 1u) != 0;
const bool map_reflection = (maps & 2u) != 0;
const bool map_normal = (maps & 4u) != 0;
const bool map_occlusion = (maps & 8u) != 0;
const bool map_emission = (maps & 16u) != 0;
const bool masked = (maps >> 15 & 1u) != 0;
const bool blends = (maps >> 16 & 1u) != 0;
const bool unlit = (maps >> 18 & 1u) != 0;
const bool specular_workflow = (maps >> 19 & 1u) != 0;
const bool two_channels = (maps >> 20 & 1u) != 0;
const bool widens = (maps >> 29 & 1u) != 0; // mips of normals hold their spread
const bool together = (maps >> 21 & 1u) != 0; // all lie at the first one's place

// Of materials without layers the vertices hand on what pixels read of the record and of the material, because software
// devices load from a buffer lane by lane.
#ifndef MAPS_LAYERS
#define MAPS_RECORD(way) \
	layout(location = 14) flat way vec4 record_first[4]; /* its first parts */ \
	layout(location = 18) flat way vec4 record_layers;   /* of the first maps */ \
	layout(location = 19) flat way vec3 record_rest;     /* the fifth map's; the material's anisotropy and wrap */
#ifndef MESH_MAPS
MAPS_RECORD(in)
#define MAPS_HANDED_ON
#endif
#endif

// Part `part` of a record.
vec4 record_part(uint record, uint part)
{
#ifdef MAPS_HANDED_ON
	if (part < 4u)
		return record_first[part];
#endif
	return push.view.maps.parts[record * MAPS_PARTS + part];
}

// The layer of its image that map number `map` is.
float map_layer(uint record, uint map)
{
#ifdef MAPS_HANDED_ON
	if (map < 5u)
		return map < 4u ? record_layers[map] : record_rest.x;
#endif
	return record_part(record, 38u + map / 4u)[map % 4u];
}

// Where the maps lie here; as MAPS_PLACES(out) of a vertex and MAPS_PLACES(in) of a pixel. The vertex shader makes
// them: the transform is affine, and what a pixel's shader reads from memory has no derivatives, because software
// devices read nothing for the pixels beside a triangle. Not centroid: derivatives would jump at edges.
#define MAPS_PLACES(way) \
	layout(location = 3) way vec2 first_place; \
	layout(location = 8) way vec2 reflection_place; \
	layout(location = 9) way vec2 normal_place; \
	layout(location = 10) way vec2 occlusion_place; \
	layout(location = 11) way vec2 emission_place;

// MESH_FUNCTION of a vertex shader, MAPS_FUNCTION of a fragment shader: materials with a function (surface.glsl). What
// the function is given of the material and of the view comes by the vertices, too, so that it has derivatives.
#define FUNCTION_INPUTS(way) \
	layout(location = 24) way vec4 function_uv; /* both */ \
	layout(location = 25) way vec3 function_local; \
	layout(location = 26) flat way vec4 function_parameters[4]; \
	layout(location = 30) flat way vec4 function_color; /* the factor of color and alpha */ \
	layout(location = 31) flat way vec4 function_view;  /* the viewer's place, time */

// MAPS_LAYERS: programs of materials with RENDER_MAPS_LAYERS, and the places of the maps that they alone have: number i
// is that of map 5 + i.
#ifdef MAPS_LAYERS
#define MAPS_PLAIN 5u
#define LAYER_MAPS 10
const bool has_coat = (maps >> 23 & 1u) != 0;
const bool has_sheen = (maps >> 24 & 1u) != 0;
const bool is_brushed = (maps >> 25 & 1u) != 0;
const bool lets_through = (maps >> 26 & 1u) != 0;
const bool is_solid = (maps >> 27 & 1u) != 0;
const bool coat_two_channels = (maps >> 28 & 1u) != 0;
const bool coat_widens = (maps >> 30 & 1u) != 0;

// True if there is map 5 + layer.
bool has_layer_map(uint layer)
{
	return (maps >> (MAPS_PLAIN + layer) & 1u) != 0;
}

#define LAYER_PLACES(way) \
	layout(location = 12) way vec2 layer_places[LAYER_MAPS];
#endif
