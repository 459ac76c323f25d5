#version 460
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 4) in;
layout(constant_id = 0) const uint room = 1u;
layout(set = 0, binding = 0, std140) uniform First { uvec4 first; };
layout(set = 0, binding = 1, std140) uniform Second { uvec4 second[room]; };
layout(buffer_reference, std430) writeonly buffer words { uint values[8]; };
layout(push_constant) uniform constants { words result; };
void main()
{
	uint i = gl_LocalInvocationIndex;
	result.values[i] = first[i];
	result.values[4u + i] = second[room - 1u][i];
}
