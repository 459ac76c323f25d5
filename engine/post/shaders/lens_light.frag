#version 460
#extension GL_GOOGLE_include_directive : require
// The frame's light, and behind it the circle of confusion. Where light is not finite it is that of the pixels beside.
#include "lens.glsl"

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D depth;
layout(set = 0, binding = 2) uniform sampler2D blended; // depth of what blends; 0: nothing does
layout(location = 0) out vec4 defocus;

bool is_finite(vec3 found)
{
	return !any(isnan(found)) && !any(isinf(found));
}

vec3 mean_beside(ivec2 pixel)
{
	vec4 sum = vec4(0.0);
	for (int y = -1; y <= 1; y++)
		for (int x = -1; x <= 1; x++) {
			vec3 found = texelFetch(light, clamp(pixel + ivec2(x, y), ivec2(0), textureSize(light, 0) - 1), 0).rgb;
			sum += is_finite(found) ? vec4(found, 1.0) : vec4(0.0);
		}
	return sum.rgb / max(sum.a, 1.0);
}

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy);
	vec3 found = texelFetch(light, pixel, 0).rgb;
	float nearest = max(texelFetch(depth, pixel, 0).r, texelFetch(blended, pixel, 0).r); // 1 is near
	float circle = push.at_infinity + push.slope * nearest;
	if (!is_finite(found))
		found = mean_beside(pixel);
	defocus = vec4(max(found, 0.0), clamp(circle, -push.largest, push.largest));
}
