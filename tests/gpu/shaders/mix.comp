#version 460
#extension GL_GOOGLE_include_directive : require
#include "mix.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform usampler2D first;
layout(set = 0, binding = 1) uniform usampler2D second;
layout(set = 0, binding = 2, r32ui) uniform uimage2D target;
layout(push_constant) uniform constants { uint number; };
void main()
{
	ivec2 at = ivec2(gl_GlobalInvocationID.xy);
	if (any(greaterThanEqual(at, imageSize(target))))
		return;
	uint hash = mix_step(number, texelFetch(first, at, 0).r);
	hash = mix_step(hash, texelFetch(second, at, 0).r);
	imageStore(target, at, uvec4(mix_step(hash, uint(at.x + 97 * at.y))));
}
