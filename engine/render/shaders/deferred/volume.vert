#version 460
#extension GL_GOOGLE_include_directive : require
// A body around what a light reaches: an icosahedron that a ball touches from within. Its light is the view's first.
#include "../mesh.glsl"

void main()
{
	const float A = 0.5257311121, B = 0.8506508084; // corners of length 1: A^2 + B^2 = 1, B / A the golden ratio
	const vec3 corners[12] = vec3[12](vec3(-A, B, 0.0), vec3(A, B, 0.0), vec3(-A, -B, 0.0), vec3(A, -B, 0.0),
		vec3(0.0, -A, B), vec3(0.0, A, B), vec3(0.0, -A, -B), vec3(0.0, A, -B), vec3(B, 0.0, -A), vec3(B, 0.0, A),
		vec3(-B, 0.0, -A), vec3(-B, 0.0, A));
	const float AROUND = 1.2585; // the corners' distance where the faces' is 1: 1.25841, and room for rounding
	vec4 position_kind = push.view.lights.lights[0].position_kind;
	vec4 direction_reach = push.view.lights.lights[0].direction_reach;
	vec3 corner = position_kind.xyz + corners[gl_VertexIndex] * (direction_reach.w * AROUND);
	gl_Position = push.view.rest.view_projection * vec4(corner, 1.0);
}
