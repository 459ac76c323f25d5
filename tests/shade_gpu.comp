#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "shade_cases.h"
#include "shade_vocabulary.h"

// test_shade_gpu.c: one row of shade_cases.h for every pair of inputs.
layout(local_size_x = 64) in;

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Inputs { vec4 v[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) writeonly buffer Results { vec4 v[]; };

layout(push_constant, std430) uniform Push {
	Inputs inputs;
	Results results;
	int row; // SHADE_CASE_COUNT: the vocabulary's fault
	uint count;
	float zero;
} push;

void main()
{
	uint i = gl_GlobalInvocationID[0];
	if (i >= push.count)
		return;
	if (push.row == SHADE_CASE_COUNT)
		push.results.v[i] = vec4(float(shade_vocabulary_fault(push.zero)));
	else
		push.results.v[i] = shade_case(push.row, push.inputs.v[2 * i], push.inputs.v[2 * i + 1]);
}
