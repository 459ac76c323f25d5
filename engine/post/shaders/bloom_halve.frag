#version 460
#extension GL_GOOGLE_include_directive : require
// Half the size: each texel the mean of four times four, which weigh 1, 3, 3, 1 eighths along each side.
#include "bloom.glsl"

layout(constant_id = 1) const bool first = false; // the frame's light, which may hold anything, is read

layout(set = 0, binding = 0) uniform sampler2D from;

// Four texels, of which the one nearest to `corner` weighs 9 sixteenths, the farthest 1.
vec3 some(vec2 corner, vec2 away)
{
	vec2 at = corner + 0.75 * away;
	if (!first)
		return bloom_filtered(from, at);
	vec3 light = textureLod(from, at * push.texel, 0.0).rgb;
	bool finite = !any(isnan(light)) && !any(isinf(light));
	return finite ? max(light, 0.0) : vec3(0.0);
}

void main()
{
	vec2 corner = 2.0 * floor(gl_FragCoord.xy) + 1.0; // between the middle four, in texels
	vec3 sum = some(corner, vec2(-1.0, -1.0)) + some(corner, vec2(1.0, -1.0)) + some(corner, vec2(-1.0, 1.0)) +
		some(corner, vec2(1.0, 1.0));
	color = vec4(bloom_packed(0.25 * sum), 1.0);
}
