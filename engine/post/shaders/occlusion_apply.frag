#version 460
#extension GL_GOOGLE_include_directive : require
// Ambient light, darker where less of the surroundings is seen.
#include "occlusion.glsl"

layout(set = 0, binding = 0) uniform sampler2D ambient;
layout(set = 0, binding = 1) uniform sampler2D depth_of;
layout(set = 0, binding = 2) uniform sampler2D occlusion;
layout(location = 0) out vec4 color;

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(occlusion, 0) - 1;
	float depth = texelFetch(depth_of, pixel, 0).r;
	color = texelFetch(ambient, pixel, 0);
	if (depth < push.smallest)
		return;
	float here = length(occlusion_place(vec2(pixel) + 0.5, depth, vec2(textureSize(depth_of, 0))));
	ivec2 first = pixel >> 1, odd = pixel & 1;
	vec2 sum = vec2(0.0);
	for (int i = 0; i < 4; i++) { // of four texels those on the same surface, the nearest most
		ivec2 side = ivec2(i & 1, i >> 1);
		vec2 there = texelFetch(occlusion, min(first + side * odd, last), 0).rg;
		float off = abs(there.y - here) / (0.01 * here);
		sum += vec2(there.x, 1.0) / (0.01 + off * off);
	}
	color.rgb *= mix(1.0, min(sum.x / sum.y, 1.0), push.strength);
}
