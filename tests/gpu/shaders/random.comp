#version 460
#include "random.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef ARRAY
layout(set = 0, binding = 5, r32ui) uniform writeonly uimage2DArray target;
#else
layout(set = 0, binding = 5, r32ui) uniform writeonly uimage2D target;
#endif
void main()
{
	ivec3 at = ivec3(gl_GlobalInvocationID);
	if (any(greaterThanEqual(at.xy, imageSize(target).xy)))
		return;
	uint value = mix_inputs(at.xy, uint(at.z));
#ifdef ARRAY
	imageStore(target, at, uvec4(value));
#else
	imageStore(target, at.xy, uvec4(value));
#endif
	if (at == ivec3(0))
		for (int i = 0; i < 64; i++)
			to.word[i] = mix_step(value, uint(i));
}
