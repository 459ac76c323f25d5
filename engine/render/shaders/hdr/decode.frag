#version 460
#extension GL_GOOGLE_include_directive : require
#define HDR_CONSTANT 0
#include "hdr.glsl"

// As render_tone_push.
layout(push_constant, std430) uniform Push
{
	float exposure;
}
push;

layout(set = 0, binding = 0) uniform sampler2D light;
layout(location = 0) out vec4 color;

// Radiance of light that is kept in 8 bits.
void main()
{
	color = vec4(hdr_decoded(texelFetch(light, ivec2(gl_FragCoord.xy), 0)) / push.exposure, 1.0);
}
