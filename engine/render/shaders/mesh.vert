#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

layout(location = 0) out vec3 world_position;
layout(location = 1) out vec3 world_normal;
layout(location = 2) flat out uint material;

#ifdef MESH_TEXTURE
layout(location = 2) in vec2 uv;
layout(location = 3) out vec2 surface_uv;
#endif

void main()
{
	// gl_InstanceIndex is the draw's firstInstance, the index of its row.
	Row row = push.rows.rows[gl_InstanceIndex];
	vec4 p = vec4(position, 1.0);
	world_position = vec3(dot(row.transform[0], p), dot(row.transform[1], p), dot(row.transform[2], p));

	// Normals are transformed by the cofactor matrix, which is right also for nonuniform scale.
	vec3 x = row.transform[0].xyz, y = row.transform[1].xyz, z = row.transform[2].xyz;
	world_normal = vec3(dot(cross(y, z), normal), dot(cross(z, x), normal), dot(cross(x, y), normal));

	material = row.material;
#ifdef MESH_TEXTURE
	surface_uv = uv;
#endif
	gl_Position = push.view.view_projection * vec4(world_position, 1.0);
}
