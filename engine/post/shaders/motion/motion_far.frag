#version 460
// What is far away, blurred by the camera's movement alone: in half the width and height, and, with SHOW, in the place
// of the light there, the more the farther it is.

// As far_push.
layout(push_constant, std430) uniform Push
{
	mat4 to_last;   // from clip space to that of the frame before
	vec4 ahead_row; // 1 / metres ahead of the camera = dot(ahead_row, place in clip space)
	vec2 half_size; // of the picture, pixels
	float half_way; // the share of a frame's movement, to both sides
	float longest;  // pixels
	float far;      // metres, from which on the blur sets in
}
push;

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D depth_of;
#ifdef SHOW
layout(set = 0, binding = 2) uniform sampler2D blurred;
#endif
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

const int SAMPLES = 16;

vec2 clip_at(ivec2 pixel)
{
	return (vec2(pixel) + 0.5) / push.half_size - 1.0;
}

float depth_at(ivec2 pixel)
{
	return texelFetch(depth_of, pixel, 0).r;
}

// From 0 to 1: how far away what a pixel shows is.
float farness(ivec2 pixel)
{
	float ahead = 1.0 / max(dot(push.ahead_row, vec4(clip_at(pixel), depth_at(pixel), 1.0)), 1e-9);
	return smoothstep(push.far, 2.0 * push.far, ahead);
}

#ifndef SHOW
// Half the way of a direction at this depth while the shutter is open, pixels.
vec2 way_of(vec2 clip, float depth)
{
	vec4 was = push.to_last * vec4(clip, depth, 1.0);
	vec2 way = was.w > 0.0 ? (was.xy / was.w - clip) * push.half_size * push.half_way : vec2(0.0);
	float size = length(way);
	return size > push.longest ? way * (push.longest / size) : way;
}

bool is_fine(vec3 c)
{
	return all(lessThanEqual(abs(c), vec3(65504.0)));
}
#endif

void main()
{
	ivec2 last = textureSize(light, 0) - 1;
#ifdef SHOW
	ivec2 pixel = ivec2(gl_FragCoord.xy);
	vec4 own = texelFetch(light, pixel, 0);
	float share = farness(pixel);
	vec4 found = share > 0.0 ? textureLod(blurred, uv, 0.0) : vec4(0.0);
	color = found.a > 0.0 ? vec4(mix(own.rgb, found.rgb / found.a, share), own.a) : own;
#else
	ivec2 pixel = min(2 * ivec2(gl_FragCoord.xy), last);
	bool is_far = farness(pixel) > 0.0;
	vec2 way = way_of(clip_at(pixel), is_far ? depth_at(pixel) : 0.0);
	vec4 sum = vec4(0.0);
	for (int i = 0; i < SAMPLES; i++) {
		vec2 along = way * ((float(i) + 0.5) / float(SAMPLES / 2) - 1.0);
		ivec2 at = clamp(ivec2(floor(vec2(pixel) + 1.0 + along)), ivec2(0), last);
		vec3 found = texelFetch(light, at, 0).rgb;
		sum += is_fine(found) ? vec4(found, 1.0) * farness(at) : vec4(0.0);
	}
	color = sum / float(SAMPLES); // light times how much of it is far away, and that
#endif
}
