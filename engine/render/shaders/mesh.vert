#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "../../shading/shade_impostor.h"
#include "../../shading/shade_sh.h"

layout(location = 0) in vec3 position;
#ifdef MESH_PACKED
layout(location = 1) in uint normal_code;
#else
layout(location = 1) in vec3 normal;
#endif

// centroid: where a triangle covers some of a pixel's samples alone, values are of a point inside of it.
layout(location = 0) centroid out vec3 world_position;
layout(location = 23) out vec3 middle_position; // in the pixel's middle, also where that is beside the triangle
layout(location = 1) centroid out vec3 world_normal;
layout(location = 2) flat out uint material;
layout(location = 2, component = 1) flat out uint model_lights; // the model's word
layout(location = 2, component = 2) flat out uint model_id;     // 1 + the model; for BESIDE_ID alone
layout(location = 4) out vec3 last_clip; // x, y, w of where the point was in the frame before; for velocities alone
#ifndef MESH_FUNCTION // which may return any normal
// Irradiance at the vertex is the sum of both, from behind their difference; for LIGHTS_SH_VERTEX alone.
layout(location = 24) centroid out vec3 vertex_even;
layout(location = 25) centroid out vec3 vertex_odd;
#endif

layout(constant_id = 6) const uint formula_lights = 0u; // RENDER_FORMULA_LIGHTS

#ifdef MESH_TEXTURE
layout(location = 2) in vec2 uv;
#ifndef MESH_MAPS
layout(location = 3) centroid out vec2 surface_uv;
#endif
#endif

#ifdef MESH_MAPS
#include "maps.glsl"
layout(constant_id = 1) const uint drawn = 0;
MAPS_PLACES(out)
#ifndef MAPS_LAYERS
MAPS_RECORD(out)
#endif
#ifdef MAPS_LAYERS
LAYER_PLACES(out)
layout(location = 22) flat out float model_scale; // metres for a metre of the mesh's space
#endif

// Where map number `map` lies. second: the other uv.
vec2 map_place(uint record, uint map, vec2 uv, vec2 second)
{
	vec4 u = record_part(record, 8u + 2u * map), v = record_part(record, 9u + 2u * map);
	vec3 place = vec3(u.w != 0.0 ? second : uv, 1.0);
	return vec2(dot(u.xyz, place), dot(v.xyz, place));
}

void write_places(uint index, vec2 uv, vec2 second)
{
	uint material = drawn == 3u ? 0u : index, record = push.materials.materials[material].ids.y;
#ifndef MAPS_LAYERS
	for (uint i = 0u; i < 4u; i++)
		record_first[i] = record_part(record, i);
	record_layers = record_part(record, 38u);
	record_rest = vec3(map_layer(record, 4u), push.materials.materials[material].specular_anisotropy.w,
		push.materials.materials[material].emission_wrap.w);
#endif
#ifdef MAPS_LAYERS
	uint first = uint(max(findLSB(maps & 0x7fffu), 0));
	for (uint i = 0u; i < LAYER_MAPS; i++)
		layer_places[i] = !together && has_layer_map(i) ? map_place(record, MAPS_PLAIN + i, uv, second) : vec2(0.0);
#else
	uint first = map_color ? 0u : map_reflection ? 1u : map_normal ? 2u : map_occlusion ? 3u : 4u;
#endif
	first_place = map_place(record, together ? first : 0u, uv, second);
	reflection_place = !together && map_reflection ? map_place(record, 1u, uv, second) : vec2(0.0);
	normal_place = !together && map_normal ? map_place(record, 2u, uv, second) : vec2(0.0);
	occlusion_place = !together && map_occlusion ? map_place(record, 3u, uv, second) : vec2(0.0);
	emission_place = !together && map_emission ? map_place(record, 4u, uv, second) : vec2(0.0);
}
#endif

#ifdef MESH_CHANNEL
layout(location = 12) centroid out vec4 channel_uv;      // both
layout(location = 13) centroid out vec3 channel_tangent; // as the transform leaves it; 0: there is none
#endif

#ifdef MESH_FUNCTION
FUNCTION_INPUTS(out)
#endif

vec3 unit_or_zero(vec3 v)
{
	float square = dot(v, v);
	return square > 0.0 ? v * inversesqrt(square) : vec3(0.0);
}

#ifdef MESH_EXTRAS
layout(location = 5) centroid out vec4 surface_color;
layout(location = 6) centroid out vec3 world_tangent; // on the side of the normal that winding makes, as world_normal
layout(location = 7) flat out float tangent_sign;     // of the bitangent; 0: there is no tangent

// Hands on the vertex's extra, which does not morph, but for the second uv, which it returns. x, y, z: rows of the
// matrix of the model.
vec2 write_extra(uint mesh, vec3 x, vec3 y, vec3 z)
{
	uvec2 place = push.view.rest.extra_places.places[mesh];
	uint at = (place.y & 0x7fffffffu) + ((uint(gl_VertexIndex) - place.x) >> (place.y >> 31));
	uvec2 tangent = push.view.rest.extras.parts[3u * at], uv_bits = push.view.rest.extras.parts[3u * at + 1u];
	uvec2 halves = push.view.rest.extras.parts[3u * at + 2u];
	vec3 t = shade_direction_from_octahedral(unpackSnorm2x16(tangent.x));
	// Where the transform mirrors, the normal below points to the other side: so does what is beside it.
	float side = dot(cross(x, y), z) < 0.0 ? -1.0 : 1.0;
	world_tangent = unit_or_zero(vec3(dot(x, t), dot(y, t), dot(z, t))) * side;
	tangent_sign = uintBitsToFloat(tangent.y);
#ifdef MESH_CHANNEL
	channel_tangent = tangent_sign != 0.0 ? world_tangent * side : vec3(0.0);
#endif
	surface_color = vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
	return uintBitsToFloat(uv_bits);
}
#endif

#ifndef MESH_FUNCTION
// Sums the nine harmonics at this unit normal: bands 0 and 2, which are the same from behind, and band 1.
void write_irradiance(vec3 n)
{
	shade_sh weights = shade_sh_convolve_cosine(shade_sh_basis(n));
	vertex_even = push.view.rest.harmonics[0].xyz * weights.c[0];
	for (int i = 4; i < 9; i++)
		vertex_even += push.view.rest.harmonics[i].xyz * weights.c[i];
	vertex_odd = vec3(0.0);
	for (int i = 1; i < 4; i++)
		vertex_odd += push.view.rest.harmonics[i].xyz * weights.c[i];
}
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

// Where the point `now`, which lies at `local` in the mesh's space, was in the world in the frame before.
vec3 last_position(Row row, vec3 local, vec3 now)
{
	if (row.last == 0u)
		return now;
	Row was = push.frame_rows.rows[row.last - 1u];
	uint at = 3u * (uint(gl_VertexIndex) + was.material);
	LastVertices vertices = push.view.rest.last_vertices;
	if (was.mesh != 0u) /* its vertices have moved, too */
		local = vec3(vertices.numbers[at], vertices.numbers[at + 1u], vertices.numbers[at + 2u]);
	vec4 p = vec4(local, 1.0);
	return vec3(dot(was.transform[0], p), dot(was.transform[1], p), dot(was.transform[2], p));
}

precise gl_Position; // further lights are drawn by other programs, at the same depth

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
	middle_position = world_position;

	// Normals are transformed by the cofactor matrix, which is right also for nonuniform scale.
	vec3 x = row.transform[0].xyz, y = row.transform[1].xyz, z = row.transform[2].xyz;
	world_normal = vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));
#ifdef MESH_EXTRAS
	world_normal = unit_or_zero(world_normal); // of the length of the tangent, as MikkTSpace interpolates them
	vec2 second = write_extra(row.mesh, x, y, z);
#elif defined(MESH_MAPS)
	vec2 second = vec2(0.0);
#endif

	material = row.material | material_unshadowed(row, formula_lights);
	model_lights = (formula_lights & LIGHTS_COMBINED) != 0u ? model_word(row) : 0u;
	model_id = (beside & BESIDE_ID) != 0u ? row.model & ROW_MODEL : 0u;
	if (detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW)
		material |= detail << DETAIL_MATERIAL_SHIFT;
#ifdef MESH_MAPS
	write_places(row.material, t, second);
#ifdef MAPS_LAYERS
	model_scale = pow(abs(dot(cross(x, y), z)), 1.0 / 3.0);
#endif
#elif defined(MESH_TEXTURE)
	surface_uv = t;
#endif
#ifdef MESH_CHANNEL
#ifdef MESH_MAPS
	channel_uv = vec4(t, second);
#else
	channel_uv = vec4(t, 0.0, 0.0);
#endif
#ifndef MESH_EXTRAS
	channel_tangent = vec3(0.0);
#endif
#endif
#ifdef MESH_FUNCTION
	function_uv = vec4(t, second);
	function_local = place;
	uint record = push.materials.materials[drawn == 3u ? 0u : row.material].ids.y;
	for (uint i = 0u; i < 4u; i++)
		function_parameters[i] = record_part(record, 42u + i);
	function_color = record_part(record, 0u);
	function_view = vec4(push.view.camera_position.xyz, push.view.rest.time);
#endif
#ifndef MESH_FUNCTION
	if ((formula_lights & LIGHTS_AMBIENT) == LIGHTS_SH_VERTEX)
		write_irradiance(unit_or_zero(world_normal));
#endif
	gl_Position = push.view.rest.view_projection * vec4(world_position, 1.0);
	if ((beside & BESIDE_VELOCITY) != 0u)
		last_clip = (push.view.rest.last_view_projection * vec4(last_position(row, place, world_position), 1.0)).xyw;
}
