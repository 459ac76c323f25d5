#version 460
#extension GL_GOOGLE_include_directive : require
#include "mix.glsl"
layout(set = 0, binding = 0) uniform usampler2D first;
layout(set = 0, binding = 1) uniform usampler2D second;
layout(push_constant) uniform constants { uint number; };
layout(location = 0) out uint color;
void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	uint hash = mix_step(number, texelFetch(first, at, 0).r);
	hash = mix_step(hash, texelFetch(second, at, 0).r);
	color = mix_step(hash, uint(at.x + 97 * at.y));
}
