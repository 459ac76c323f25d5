#version 460
#extension GL_GOOGLE_include_directive : require
// What is scattered from a level on: a share of what wider ones scatter, in twice the size, and the rest of its own.
#include "bloom.glsl"

layout(set = 0, binding = 0) uniform sampler2D wider;
layout(set = 0, binding = 1) uniform sampler2D here;

void main()
{
	vec3 wide = bloom_filtered(wider, 0.5 * gl_FragCoord.xy);
	vec3 own = bloom_fetched(here, ivec2(gl_FragCoord.xy));
	color = vec4(bloom_packed(mix(own, wide, push.share)), 1.0);
}
