#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "../../shading/shade_impostor.h"

layout(location = 0) in vec3 position;
#ifdef MESH_PACKED
layout(location = 1) in uint normal_code;
#else
layout(location = 1) in vec3 normal;
#endif

// centroid: where a triangle covers some of a pixel's samples alone, values are of a point inside of it.
layout(location = 0) centroid out vec3 world_position;
layout(location = 1) centroid out vec3 world_normal;
layout(location = 2) flat out uint material;

#ifdef MESH_TEXTURE
layout(location = 2) in vec2 uv;
layout(location = 3) centroid out vec2 surface_uv;
#endif

#ifdef MESH_PACKED
vec3 normal_of(uint code)
{
	return shade_direction_from_octahedral(unpackSnorm2x16(code));
}

// Of the second one of a pair.
vec3 morph_normal_of(uint code)
{
	int bits = int(code);
	vec3 steps = vec3(bitfieldExtract(bits, 0, 11), bitfieldExtract(bits, 11, 11), bitfieldExtract(bits, 22, 10));
	return steps / vec3(1023.0, 1023.0, 511.0);
}
#endif

void main()
{
	uint word = uint(gl_InstanceIndex);
	uint detail = detail_kind == DETAIL_NONE ? 0u : word >> DETAIL_SHIFT;
	Row row = row_of(word);
	vec3 place = position;
#ifdef MESH_PACKED
	vec3 n = normal_of(normal_code);
#else
	vec3 n = normal;
#endif
#ifdef MESH_TEXTURE
	vec2 t = uv;
#endif
	if (detail_kind == DETAIL_MORPH && detail > 0u) {
		// The attributes are those of a pair that the index names (render_levels): of its second one if the vertex
		// moves. Its first one is where it comes from.
		float gone = float(detail) / 64.0;
#ifdef MESH_PACKED
		uint first = 3u * (uint(gl_VertexIndex) & ~1u);
		uvec2 a = push.vertices.thirds[first], b = push.vertices.thirds[first + 1u];
		uvec2 c = push.vertices.thirds[first + 2u];
		vec3 from_place = uintBitsToFloat(uvec3(a, b.x)), from_n = normal_of(b.y);
		vec2 from_t = uintBitsToFloat(c);
		n = (gl_VertexIndex & 1) == 1 ? morph_normal_of(normal_code) : n;
#else
		uint first = 2u * (uint(gl_VertexIndex) & ~1u);
		vec4 low = push.vertices.halves[first], high = push.vertices.halves[first + 1u];
		vec3 from_place = low.xyz, from_n = vec3(low.w, high.xy);
		vec2 from_t = high.zw;
#endif
		place = mix(from_place, place, gone);
		n = mix(from_n, n, gone);
#ifdef MESH_TEXTURE
		t = mix(from_t, t, gone);
#endif
	}
	vec4 p = vec4(place, 1.0);
	world_position = vec3(dot(row.transform[0], p), dot(row.transform[1], p), dot(row.transform[2], p));

	// Normals are transformed by the cofactor matrix, which is right also for nonuniform scale.
	vec3 x = row.transform[0].xyz, y = row.transform[1].xyz, z = row.transform[2].xyz;
	world_normal = vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));

	material = row.material;
	if (detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW)
		material |= detail << DETAIL_MATERIAL_SHIFT;
#ifdef MESH_TEXTURE
	surface_uv = t;
#endif
	gl_Position = push.view.view_projection * vec4(world_position, 1.0);
}
