#version 460
#extension GL_GOOGLE_include_directive : require
// The frame's light through the lens: what is sharp gathered here, what is soft from the smaller images, and over both
// what is nearer than the plane in focus.
#include "lens.glsl"
#include "lens_aperture.glsl"

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D defocus;
layout(set = 0, binding = 2) uniform sampler2D reach;
layout(set = 0, binding = 3) uniform sampler2D near;
layout(set = 0, binding = 4) uniform sampler2D rest;
layout(location = 0) out vec4 color;

// The light that reaches a pixel from the few around it, of circles that are not soft, and its weight.
vec4 gathered(ivec2 pixel, float circle)
{
	ivec2 last = textureSize(defocus, 0) - 1;
	vec4 sum = vec4(0.0);
	for (int y = -2; y <= 2; y++)
		for (int x = -2; x <= 2; x++) {
			vec4 there = texelFetch(defocus, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
			bool behind = there.a > circle && circle >= 0.0;
			float radius = behind ? min(there.a, circle) : abs(there.a);
			vec2 way = there.a < 0.0 ? vec2(x, -y) : vec2(-x, y);
			float share = aperture_share(max(radius, 0.5), aperture_radius(way));
			sum += (1.0 - lens_softness(there.a)) * share * vec4(there.rgb, 1.0);
		}
	return sum;
}

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(near, 0) - 1;
	color = texelFetch(light, pixel, 0);
	if (texelFetch(reach, min(pixel / 16, textureSize(reach, 0) - 1), 0).r < 0.5)
		return;
	vec4 here = texelFetch(defocus, pixel, 0);
	vec2 at = 0.5 * gl_FragCoord.xy - 0.5, first = floor(at), beside = at - first;
	vec4 before = vec4(0.0), behind = vec4(0.0);
	for (int i = 0; i < 4; i++) {
		ivec2 side = ivec2(i & 1, i >> 1), there = clamp(ivec2(first) + side, ivec2(0), last);
		vec2 along = mix(1.0 - beside, beside, vec2(side));
		float weight = along[0] * along[1];
		before += weight * texelFetch(near, there, 0);
		weight /= 0.5 + abs(texelFetch(defocus, there, 1).a - here.a); // of the same surface most
		behind += weight * texelFetch(rest, there, 0);
	}
	vec4 sum = gathered(pixel, here.a);
	float left = lens_softness(here.a) * max(1.0 - sum.a, 0.0); // that nothing sharp covers
	sum += behind.a > 0.0 ? vec4(behind.rgb / behind.a, 1.0) * left : vec4(0.0);
	color.rgb = sum.a > 0.0 ? sum.rgb / sum.a : here.rgb;
	color.rgb = color.rgb * (1.0 - before.a) + before.rgb;
}
