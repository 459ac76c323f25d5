#version 460
#extension GL_ARB_shader_viewport_layer_array : require
layout(location = 0) in vec2 position;
layout(location = 1) in float depth;
layout(location = 0) out flat uint layer;
void main()
{
	gl_Position = vec4(position, depth, 1.0);
	gl_Layer = gl_InstanceIndex;
	layer = gl_InstanceIndex;
}
