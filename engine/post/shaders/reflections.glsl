// What the passes of reflections have (post_reflections.c). Places are those of the world's directions, around the
// camera; depth is reversed.
#include "../../shading/shade_tonemap.h"

// As reflections_push.
layout(push_constant, std430) uniform Push
{
	vec4 across; // a place is (across x + down y + ahead) / (across.w depth + down.w), x and y in clip space
	vec4 down;
	vec4 ahead;  // and exposure, factor
	vec4 clip_x; // rows of the matrix to clip space; depth is clip_x.w + clip_y.w / dot(place, clip_w.xyz)
	vec4 clip_y;
	vec4 clip_w; // and the pixels of the picture plane at distance 1, a metre
	uint levels; // of the hierarchy, the picture's size included
}
push;

vec3 reflections_place(vec2 pixel, float depth, vec2 size)
{
	vec2 clip = 2.0 * pixel / size - 1.0;
	vec3 direction = push.across.xyz * clip.x + push.down.xyz * clip.y + push.ahead.xyz;
	return direction / (push.across.w * depth + push.down.w);
}

// Pixels and depth of a place before the camera.
vec3 reflections_pixel(vec3 place, vec2 size)
{
	float w = dot(place, push.clip_w.xyz);
	vec2 clip = vec2(dot(place, push.clip_x.xyz), dot(place, push.clip_y.xyz)) / w;
	return vec3((0.5 * clip + 0.5) * size, push.clip_x.w + push.clip_y.w / w);
}

// How far along the view a depth is.
float reflections_away(float depth)
{
	return push.clip_y.w / max(depth - push.clip_x.w, 1e-12);
}

vec3 reflections_packed(vec3 light)
{
	vec3 exposed = light * push.ahead.w;
	return shade_tonemap_simple(exposed, shade_largest(exposed), 1.0);
}

vec3 reflections_unpacked(vec3 stored)
{
	stored = min(stored, vec3(0.999));
	return shade_tonemap_simple_inverse(stored, shade_largest(stored), 1.0) / push.ahead.w;
}
