#version 460
#extension GL_GOOGLE_include_directive : require
// The frame's light, a share of which is scattered.
#include "bloom.glsl"

layout(set = 0, binding = 0) uniform sampler2D bloom;
layout(set = 0, binding = 1) uniform sampler2D light;

void main()
{
	vec4 straight = texelFetch(light, ivec2(gl_FragCoord.xy), 0);
	vec3 scattered = bloom_filtered(bloom, 0.5 * gl_FragCoord.xy);
	color = vec4(mix(straight.rgb, scattered, push.share), straight.a);
}
