#version 460
#extension GL_GOOGLE_include_directive : require
#include "textured.glsl"
#ifdef TEXTURED_EXTRAS
#include "../../engine/shading/shade_impostor.h"
layout(location = 9) out vec4 surface_color;
#endif
#ifdef TEXTURED_HANDED
layout(location = 5) flat out vec4 parts[4];
#endif

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 tangent;

layout(location = 0) out vec3 world_position;
layout(location = 1) out vec3 world_normal;
layout(location = 2) out vec3 world_tangent;
layout(location = 3) flat out float tangent_sign;
layout(location = 4) out vec2 place;

void main()
{
#ifdef TEXTURED_VIEW
	Parts view = Parts(material.view);
	mat4 view_projection = mat4(view.at[0], view.at[1], view.at[2], view.at[3]);
	vec4 transform[3] = vec4[3](view.at[4], view.at[5], view.at[6]);
#else
	mat4 view_projection = push.view_projection;
	vec4 transform[3] = push.transform;
#endif
	vec4 p = vec4(position, 1.0);
	world_position = vec3(dot(transform[0], p), dot(transform[1], p), dot(transform[2], p));
	vec3 x = transform[0].xyz, y = transform[1].xyz, z = transform[2].xyz;
	world_normal = normalize(vec3(dot(cross(y, z), normal), dot(cross(z, x), normal), dot(cross(x, y), normal)));
#ifdef TEXTURED_EXTRAS
	Pairs extras = Pairs(material.extras);
	uint first = 3u * uint(gl_VertexIndex);
	uvec2 halves = extras.at[first + 2u];
	vec4 t = vec4(shade_direction_from_octahedral(unpackSnorm2x16(extras.at[first].x)),
		uintBitsToFloat(extras.at[first].y));
	surface_color = vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
#else
	vec4 t = tangent;
#endif
	world_tangent = normalize(vec3(dot(x, t.xyz), dot(y, t.xyz), dot(z, t.xyz)));
	tangent_sign = t.w;
#ifdef TEXTURED_HANDED
	for (int i = 0; i < 4; i++)
		parts[i] = Parts(material.record).at[i];
#endif
	place = uv;
	gl_Position = view_projection * vec4(world_position, 1.0);
}
