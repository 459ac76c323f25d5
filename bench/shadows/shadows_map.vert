#version 460
#extension GL_EXT_buffer_reference : require
// Depth as lights see it. LAYERED: a draw has an instance for each view that sees it, which says its layer.
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#endif

layout(location = 0) in vec3 position;

struct Row {
	vec4 transform[3]; // the rows of the affine transform
	uvec4 view;        // x: its number
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rows
{
	Row rows[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Matrices
{
	mat4 matrices[];
};

layout(push_constant, std430) uniform Push
{
	Rows rows;
	Matrices matrices;
}
push;

void main()
{
	Row row = push.rows.rows[gl_InstanceIndex];
	vec4 at = vec4(position, 1.0);
	vec4 world = vec4(dot(row.transform[0], at), dot(row.transform[1], at), dot(row.transform[2], at), 1.0);
	gl_Position = push.matrices.matrices[row.view.x] * world;
#ifdef LAYERED
	gl_Layer = int(row.view.x);
#endif
}
