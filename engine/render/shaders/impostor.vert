#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"
#include "impostor.glsl"
#include "../../shading/shade_impostor.h"

// As impostor_mesh_create of render_impostor.c writes them; the same for all four vertices but for the corner. A fifth
// one, which no triangle uses, has the half sides of the box about the model as its position.
layout(location = 0) in vec3 center;
layout(location = 2) in vec2 numbers; // the sphere's radius; (grid * 4096 + side) * 4 + corner

IMPOSTOR_VARYINGS(out)

// The half sides of a rectangle on the plate, in radii, behind which the camera sees the whole box: along t and b of
// the frame, whose n points from the plate to the camera, `far` away. What stands out towards the camera looks larger.
vec2 reach(shade_frame frame, vec3 box, float far)
{
	float height = dot(abs(frame.n), box);
	return vec2(dot(abs(frame.t), box), dot(abs(frame.b), box)) * (far / max(far - height, 0.05));
}

layout(constant_id = 6) const uint formula_lights = 0u; // RENDER_FORMULA_LIGHTS

// Row i of the matrix from where points of the model are to where they were. Needs normal_x, normal_y, normal_z.
vec4 moved_row(Row row, uint i)
{
	vec4 place = vec4(float(i == 0u), float(i == 1u), float(i == 2u), 0.0);
	if (row.last == 0u)
		return place;
	vec4 was = push.frame_rows.rows[row.last - 1u].transform[i];
	vec3 now = vec3(row.transform[0].w, row.transform[1].w, row.transform[2].w);
	vec3 turn = vec3(dot(was.xyz, vec3(normal_x.x, normal_y.x, normal_z.x)),
		dot(was.xyz, vec3(normal_x.y, normal_y.y, normal_z.y)), dot(was.xyz, vec3(normal_x.z, normal_y.z, normal_z.z)));
	return vec4(turn, was.w - dot(turn, now));
}

// A rectangle about the model that faces the camera, in the model's space; lengths are in radii of the sphere. Planes
// and lines stay what they are under any affine transform.
void main()
{
	uint word = uint(gl_InstanceIndex);
	uint detail = detail_kind == DETAIL_NONE ? 0u : word >> DETAIL_SHIFT;
	Row row = row_of(word);
	uint packed = uint(numbers.y);
	float grid = float(packed >> 14u), side = float(packed >> 2u & 4095u), radius = numbers.x;
	vec2 corner = vec2(packed & 1u, packed >> 1u & 1u) * 2.0 - 1.0;
	vec3 x = row.transform[0].xyz, y = row.transform[1].xyz, z = row.transform[2].xyz;
	// Columns of the inverse, and rows of its transposed, by which normals go: of a mirrored space, too, what faces the
	// viewer still does.
	float determinant = dot(x, cross(y, z));
	normal_x = cross(y, z) / determinant;
	normal_y = cross(z, x) / determinant;
	normal_z = cross(x, y) / determinant;
	vec3 world_center = vec3(dot(x, center) + row.transform[0].w, dot(y, center) + row.transform[1].w,
		dot(z, center) + row.transform[2].w);
	vec3 away = push.view.camera_position.xyz - world_center;
	vec3 camera = (normal_x * away.x + normal_y * away.y + normal_z * away.z) / radius;
	float far = length(camera);
	vec3 direction = camera / far;
	uint last = uint(gl_VertexIndex) - (packed & 3u) + 4u;
#ifdef MESH_PACKED
	vec3 half_sides = uintBitsToFloat(uvec3(push.vertices.thirds[3u * last], push.vertices.thirds[3u * last + 1u].x));
#else
	vec3 half_sides = push.vertices.halves[2u * last].xyz;
#endif
	vec3 box = half_sides / radius;
	// Upright along the longest side of the box: most models are long, and the rectangle is narrow.
	float longest = max(box.x, max(box.y, box.z));
	vec3 axis = box.y == longest ? vec3(0.0, 1.0, 0.0) : box.x == longest ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 0.0, 1.0);
	shade_frame frame = shade_frame_from_tangent(direction, cross(axis, direction));
	vec2 sized = corner * reach(frame, box, far);
	vec3 plate = frame.t * sized.x + frame.b * sized.y;
	world_plate = world_center + radius * vec3(dot(x, plate), dot(y, plate), dot(z, plate));

	// Weights are squared: the nearest picture, which is the sharpest one, counts for more, and they stay continuous.
	shade_impostor_views views = shade_impostor_views_of(direction, grid);
	views.weights *= views.weights;
	views.weights /= views.weights.x + views.weights.y + views.weights.z;
#define PICTURE(of, number)                                                              \
	direction_##of = shade_impostor_direction(views.of, grid);                           \
	frame = shade_frame_from_normal(direction_##of);                                     \
	plate_##of = shade_frame_to_local(frame, plate);                                     \
	camera_##of = shade_frame_to_local(frame, camera);                                   \
	tile_##of = vec3(views.of * side, views.weights[number]);
	PICTURE(a, 0)
	PICTURE(b, 1)
	PICTURE(c, 2)
#undef PICTURE
	sides = vec2(side, grid * side);
	material_word = row.material | material_unshadowed(row, formula_lights);
	model_lights = (formula_lights & LIGHTS_COMBINED) != 0u ? model_word(row) : 0u;
	model_id = (beside & BESIDE_ID) != 0u ? row.model & ROW_MODEL : 0u;
	if (detail_kind == DETAIL_FADE || detail_kind == DETAIL_SHOW)
		material_word |= detail << DETAIL_MATERIAL_SHIFT;
	for (uint i = 0u; i < 3u; i++)
		moved[i] = (beside & BESIDE_VELOCITY) != 0u ? moved_row(row, i) : vec4(0.0);
	gl_Position = push.view.rest.view_projection * vec4(world_plate, 1.0);
}
