// What the fragment shaders of meshes with maps share: colour and alpha.
#include "maps.glsl"

layout(location = 2) flat in uint material_word; // the material's index, and above it how the draw fades
layout(location = 2, component = 1) flat in uint model_lights;
layout(location = 2, component = 2) flat in uint model_id;
MAPS_PLACES(in)
#ifdef MESH_EXTRAS
layout(location = 5) centroid in vec4 surface_color;
#else
const vec4 surface_color = vec4(1.0);
#endif

layout(set = 1, binding = 0) uniform sampler2DArray color_map;

// Colour and alpha, before any light and without the record's factor.
vec4 raw_color(uint record)
{
	if (!map_color)
		return surface_color;
	return surface_color * texture(color_map, vec3(first_place, map_layer(record, 0u)));
}
