#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "shade_topic.h"

// test_shade_gpu.c: one row of a topic for every pair of inputs.
layout(local_size_x = 64) in;

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Inputs { vec4 v[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) writeonly buffer Results { vec4 v[]; };

layout(push_constant, std430) uniform Push {
	Inputs inputs;
	Results results;
	int row;
	uint count;
} push;

void main()
{
	uint i = gl_GlobalInvocationID[0];
	if (i < push.count)
		push.results.v[i] = shade_topic_case(push.row, push.inputs.v[2 * i], push.inputs.v[2 * i + 1]);
}
