#version 460
#extension GL_EXT_buffer_reference : require
// Carries the vertices of many figures with their joints: engine/scene/play/scene_play_skin.h, a vertex each, without
// tangents and without the box around them.

layout(local_size_x = 64) in;

struct Vertex {
	vec4 position; // and u
	vec4 normal;   // and v
	vec4 weights;
	uvec4 joints;
};

struct Posed {
	vec4 first;  // position, normal x
	vec4 second; // normal y z, u v
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rest { Vertex vertices[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Joints { vec4 rows[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) writeonly buffer Figures { Posed vertices[]; };

layout(push_constant, std430) uniform Push {
	Rest rest;
	Joints joints;
	Figures figures;
	uint vertex_count, joint_count;
} push;

void main()
{
	uint v = gl_GlobalInvocationID.x, figure = gl_WorkGroupID.y;
	if (v >= push.vertex_count)
		return;
	Vertex from = push.rest.vertices[v];
	vec4 x = vec4(0.0), y = vec4(0.0), z = vec4(0.0);
	for (int i = 0; i < 4; i++) {
		uint joint = 3 * (figure * push.joint_count + from.joints[i]);
		x += from.weights[i] * push.joints.rows[joint];
		y += from.weights[i] * push.joints.rows[joint + 1];
		z += from.weights[i] * push.joints.rows[joint + 2];
	}
	vec4 at = vec4(from.position.xyz, 1.0);
	vec3 position = vec3(dot(x, at), dot(y, at), dot(z, at));
	// The inverse transpose, up to a positive factor: cofactors, with the determinant's sign.
	vec3 a = cross(y.xyz, z.xyz), b = cross(z.xyz, x.xyz), c = cross(x.xyz, y.xyz);
	vec3 normal = vec3(dot(a, from.normal.xyz), dot(b, from.normal.xyz), dot(c, from.normal.xyz));
	float square = dot(normal, normal);
	bool good = square > 1e-36 && square < 1e36;
	normal = good ? normal * ((dot(x.xyz, a) < 0.0 ? -1.0 : 1.0) * inversesqrt(square)) : from.normal.xyz;
	push.figures.vertices[figure * push.vertex_count + v] =
		Posed(vec4(position, normal.x), vec4(normal.yz, from.position.w, from.normal.w));
}
