#version 460
#include "random.glsl"
#ifdef COLOR
layout(location = 0) out vec4 color;
#else
layout(location = 0) out uint color;
#ifdef TWO
layout(location = 1) out uint second;
#endif
#endif
void main()
{
	uint value = mix_inputs(ivec2(gl_FragCoord.xy), 0u);
#ifdef COLOR
	color = unpacked_bytes(value);
#else
	color = value;
#ifdef TWO
	second = mix_step(value, 1u);
#endif
#endif
}
