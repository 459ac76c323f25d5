#version 460
#extension GL_GOOGLE_include_directive : require
// The lights that each pixel needs, by their places: of those in its cell's list the ones whose ball and cone hold the
// point that it shows. Source: Trebilco, "Light Indexed Deferred Rendering" (2007).
#define MESH_OWN_PUSH
#include "../mesh.glsl"
#include "../../../shading/shade_surface.h"

layout(local_size_x = 8, local_size_y = 8) in;

// As render_tiles_push.
layout(push_constant, std430) uniform Push {
	View view;
	LightIndices indices;
} push;

layout(set = 0, binding = 0) uniform sampler2D depth_image;

#include "place.glsl"
#include "reach.glsl"
#include "lists.glsl"

bool reaches(Reach reach, vec3 place, float room)
{
	vec3 toward = place - reach.center;
	float apart = length(toward);
	if (apart > reach.radius + room)
		return false;
	return reach.cosine <= -1.0 || dot(toward, reach.axis) >= (reach.cosine * apart - room) * length(reach.axis);
}

void main()
{
	uvec2 at = gl_GlobalInvocationID.xy;
	uvec2 size = uvec2(textureSize(depth_image, 0));
	if (any(greaterThanEqual(at, size)))
		return;
	if (at == uvec2(0u))
		push.indices.lists = push.view.lists;
	float depth = texelFetch(depth_image, ivec2(at), 0).x;
	vec4 place = depth > 0.0 ? place_at(vec2(at) + 0.5, depth) : vec4(0.0);
	uvec4 indices = uvec4(LIGHT_INDEX_NONE * 0x10001u);
	uint count = 0u;
	uvec2 list = place.w != 0.0 ? list_of_cell(push.view.lists, vec2(at), place.xyz) : uvec2(0u);
	float room = distance(place.xyz, push.view.camera_position.xyz) * REACH_ROUNDING;
	for (uint i = list.x; i < list.y; i++) {
		uint id = push.view.lists.words[i];
		if (!reaches(reach_of(push.view.light_count + id), place.xyz, room))
			continue;
		if (count == 8u || id >= LIGHT_INDEX_MORE) {
			indices.x = LIGHT_INDEX_MORE;
			break;
		}
		uint shift = (count & 1u) * 16u;
		indices[count / 2u] = indices[count / 2u] & ~(0xffffu << shift) | id << shift;
		count++;
	}
	push.indices.pixels[at.x + size.x * at.y] = indices;
}
