#version 460
#extension GL_EXT_buffer_reference : require
// Adds up the brightness of 8 x 8 pixels of the light; each work group writes one sum.

layout(local_size_x = 8, local_size_y = 8) in;

layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Sums { float sums[]; };

layout(push_constant, std430) uniform Push {
	Sums sums;
} push;

layout(set = 0, binding = 0) uniform sampler2D light;

shared float bright[64];

void main()
{
	uint self = gl_LocalInvocationIndex;
	uvec2 pixel = gl_GlobalInvocationID.xy;
	bool inside = all(lessThan(ivec2(pixel), textureSize(light, 0)));
	bright[self] = inside ? dot(texelFetch(light, ivec2(pixel), 0).rgb, vec3(0.2126, 0.7152, 0.0722)) : 0.0;
	for (uint half_count = 32; half_count > 0; half_count /= 2) {
		barrier();
		if (self < half_count)
			bright[self] += bright[self + half_count];
	}
	if (self == 0)
		push.sums.sums[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = bright[0];
}
