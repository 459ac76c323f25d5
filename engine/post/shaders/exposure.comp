#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
// Counts the light's pixels by luminance. Each work group counts for itself and writes a row of its own, so that what
// is counted depends on nothing but the light.
#include "../../shading/shade_luminance.h"

const uint CLASSES = 512u;            // POST_EXPOSURE_CLASSES
const uint FIRST = (127u - 16u) << 4; // the class of 2^-16 among those of all floats

layout(local_size_x = 256) in;

layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Counts
{
	uint counts[];
};

layout(push_constant, std430) uniform Push
{
	Counts counts; // [work groups][CLASSES]
}
push;

layout(set = 0, binding = 0) uniform sampler2D light;

shared uint counted[CLASSES];

void main()
{
	uint self = gl_LocalInvocationIndex, row = gl_WorkGroupID.x * CLASSES;
	for (uint c = self; c < CLASSES; c += gl_WorkGroupSize.x)
		counted[c] = 0u;
	barrier();
	uvec2 size = uvec2(textureSize(light, 0));
	for (uint p = gl_GlobalInvocationID.x; p < size.x * size.y; p += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
		vec3 texel = texelFetch(light, ivec2(p % size.x, p / size.x), 0).rgb;
		// A float's exponent and the first four bits behind it. NaN, infinite, negative and small numbers lie outside.
		uint at = (floatBitsToUint(shade_luminance(texel)) >> 19) - FIRST;
		if (at < CLASSES)
			atomicAdd(counted[at], 1u);
	}
	barrier();
	for (uint c = self; c < CLASSES; c += gl_WorkGroupSize.x)
		push.counts.counts[row + c] = counted[c];
}
