#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "case_inputs.h"
#include "brdf_combination.h"

// test_shade_brdf_gpu.c: any D x G x F, chosen by three specialisation constants.
layout(local_size_x = 64) in;

layout(constant_id = 0) const int ndf = 0;
layout(constant_id = 1) const int g = 0;
layout(constant_id = 2) const int f = 0;

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
		push.results.v[i] = shade_combination(ndf, g, f, push.inputs.v[2 * i], push.inputs.v[2 * i + 1]);
}
