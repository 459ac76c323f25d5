// What all passes of bloom have (post_bloom.c).
#include "../../shading/shade_tonemap.h"

layout(constant_id = 0) const bool fixed_point = false; // images between hold T(light) in 8 bits

// As bloom_push.
layout(push_constant, std430) uniform Push {
	vec2 texel;     // 1 / the texels of the image that is filtered
	float share;    // of that image in what is written
	float exposure; // factor
} push;

layout(location = 0) out vec4 color;

vec3 bloom_unpacked(vec3 stored)
{
	if (!fixed_point)
		return stored;
	return shade_tonemap_simple_inverse(stored, shade_largest(stored), 1.0) / push.exposure;
}

vec3 bloom_packed(vec3 light)
{
	if (!fixed_point)
		return light;
	vec3 exposed = light * push.exposure;
	return shade_tonemap_simple(exposed, shade_largest(exposed), 1.0);
}

vec3 bloom_fetched(sampler2D from, ivec2 at)
{
	return bloom_unpacked(texelFetch(from, clamp(at, ivec2(0), textureSize(from, 0) - 1), 0).rgb);
}

// The light between four texels, `at` texels from the image's corner. The device can filter light, but not T(light).
vec3 bloom_filtered(sampler2D from, vec2 at)
{
	if (!fixed_point)
		return textureLod(from, at * push.texel, 0.0).rgb;
	vec2 base = floor(at - 0.5), beside = at - 0.5 - base;
	ivec2 first = ivec2(base);
	return mix(mix(bloom_fetched(from, first), bloom_fetched(from, first + ivec2(1, 0)), beside.x),
		mix(bloom_fetched(from, first + ivec2(0, 1)), bloom_fetched(from, first + ivec2(1)), beside.x), beside.y);
}
