#version 460
#extension GL_GOOGLE_include_directive : require
// What surfaces mirror: the picture, and where a ray met nothing of it the surroundings, as before. Rough surfaces have
// the mean of the sixteen pixels that have asked in all directions, of those that lie on the same surface.
#include "../../shading/shade_impostor.h"
#include "reflections.glsl"

layout(constant_id = 0) const bool alone = false; // each pixel has what it found itself

layout(set = 0, binding = 0) uniform sampler2D reflection;
layout(set = 0, binding = 1) uniform sampler2D traced;
layout(set = 0, binding = 2) uniform sampler2D mirror;
layout(set = 0, binding = 3) uniform sampler2D mirror_normal;
layout(set = 0, binding = 4) uniform sampler2D depth_of;
layout(location = 0) out vec4 color;

const float SMOOTH = 0.02; // as reflections_trace.frag

vec4 mean_around(ivec2 at, float roughness)
{
	ivec2 last = textureSize(traced, 0) - 1;
	vec2 normal = texelFetch(mirror_normal, at, 0).rg;
	float away = reflections_away(texelFetch(depth_of, at, 0).r), weights = 0.0;
	vec4 sum = vec4(0.0);
	for (int y = -2; y < 2; y++)
		for (int x = -2; x < 2; x++) {
			ivec2 there = clamp(at + ivec2(x, y), ivec2(0), last);
			float off = abs(reflections_away(texelFetch(depth_of, there, 0).r) - away) / (0.05 * away);
			off += distance(texelFetch(mirror_normal, there, 0).rg, normal) / 0.05;
			off += abs(texelFetch(mirror, there, 0).a - roughness) / 0.1;
			float weight = max(1.0 - off, 0.0);
			sum += weight * texelFetch(traced, there, 0);
			weights += weight;
		}
	return sum / max(weights, 1e-6);
}

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	vec4 surface = texelFetch(mirror, at, 0);
	vec4 found = alone || surface.a < SMOOTH ? texelFetch(traced, at, 0) : mean_around(at, surface.a);
	color = texelFetch(reflection, at, 0);
	if (found.a > 0.0)
		color.rgb = mix(color.rgb, surface.rgb * reflections_unpacked(found.rgb / found.a), found.a);
}
