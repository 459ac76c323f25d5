// Data that the mesh shaders share with the CPU: buffers by address, laid out as in render_internal.h and
// device/render_device.h.
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

// As render_light_lists: for each cell where its list begins, and one more; then the lists.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer LightLists {
	vec4 depth_plane;
	vec4 slice; // scale, bias
	uint words[];
};

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

// Where vertices were in the frame before, three numbers each.
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer LastVertices { float numbers[]; };

// As render_view_data.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ViewRest {
	mat4 view_projection;
	vec4 sky;
	vec4 ground;
	Extras extras;
	ExtraPlaces extra_places;
	float time; // seconds, for functions of surfaces
	float half_width, half_height; // of what is drawn into, pixels
	float far;                     // the largest w of clip space that surfaces in 8 bits have
	mat4 last_view_projection;     // of the frame before, for velocities alone
	LastVertices last_vertices;
	mat4 from_clip; // clip space to the world
};

// As render_view_push: what pixels read of a view. Software devices load from a buffer lane by lane, from constants at
// once.
struct View {
	vec4 camera_position;
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

// As render_push.
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

// Of render_view_lights.bits: velocities are drawn (velocity.glsl).
#define LIGHTS_VELOCITY 4096u

// What the high bits of a draw's row word mean (render_internal.h, RENDER_DETAIL_SHIFT).
#define DETAIL_NONE 0u
#define DETAIL_FADE 1u
#define DETAIL_MORPH 2u
#define DETAIL_SHOW 3u
layout(constant_id = 7) const uint detail_kind = DETAIL_NONE;
#define DETAIL_SHIFT 26
#define DETAIL_MATERIAL_SHIFT 24 // where they are in the material's index that the fragment shader gets
