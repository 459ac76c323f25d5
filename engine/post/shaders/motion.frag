#version 460
#extension GL_GOOGLE_include_directive : require
// Motion blur: a pixel gathers along the longest movement around it what passes it while the shutter is open, by what
// lies in front. Sources: McGuire, Hennessy, Bukowski, Osman, "A Reconstruction Filter for Plausible Motion Blur"
// (2012), for tiles and what a sample weighs by depth and distance; Jimenez, "Next Generation Post Processing in Call
// of Duty: Advanced Warfare" (2014), for shares of time, which leave the rest to what lies behind.
#include "motion.glsl"

layout(constant_id = 0) const int SAMPLES = 12; // to each side

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D velocity;
layout(set = 0, binding = 2) uniform sampler2D depth_of;
layout(set = 0, binding = 3) uniform sampler2D around;
layout(location = 0) out vec4 color;

const float NEARER = 0.02; // of the distance, at which one thing is in front of another

ivec2 last;

float ahead_at(ivec2 at)
{
	vec2 clip = (vec2(at) + 0.5) / vec2(last + 1) * 2.0 - 1.0;
	return 1.0 / max(dot(push.ahead_row, vec4(clip, texelFetch(depth_of, at, 0).r, 1.0)), 1e-9);
}

// From 0 to 1: how much a lies in front of b.
float in_front(float a, float b)
{
	return clamp((b - a) / (NEARER * min(a, b)), 0.0, 1.0);
}

// The share of the time at which what moves so far is at a distance.
float passes(float away, float movement)
{
	return clamp(movement - away + 0.5, 0.0, 1.0) / max(2.0 * movement, 1.0);
}

vec4 light_at(ivec2 at)
{
	return texelFetch(light, at, 0);
}

bool is_fine(vec4 c)
{
	return all(lessThanEqual(abs(c), vec4(65504.0)));
}

// What passes the pixel in front of what it shows, the same surface, and what lies behind: light times share of time,
// and that share. Of what lies behind the shares say alone how near it is.
vec4 front = vec4(0.0), same = vec4(0.0), behind = vec4(0.0);
float front_share = 0.0, same_share = 0.0, behind_share = 0.0;

// Gathers along a line from -way to way: of things in front, or of the pixel's own surface.
void gather(ivec2 pixel, float own_ahead, vec2 way, bool own)
{
	float step = 1.0 / float(SAMPLES), each = max(length(way) * step, 1e-3); // pixels
	for (int i = -SAMPLES; i < SAMPLES; i++) {
		vec2 offset = way * ((float(i) + 0.5) * step);
		ivec2 at = ivec2(floor(vec2(pixel) + 0.5 + offset));
		if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last)))
			continue;
		vec4 there = light_at(at);
		float ahead = ahead_at(at), away = length(offset);
		if (!is_fine(there))
			continue;
		float nearer = in_front(ahead, own_ahead), farther = in_front(own_ahead, ahead);
		float share = each * passes(away, length(motion_of(texelFetch(velocity, at, 0).rg)));
		float back = farther / (1.0 + away);
		if (own) {
			same += there * (share * (1.0 - nearer - farther));
			same_share += share * (1.0 - nearer - farther);
		} else {
			front += there * (share * nearer);
			front_share += share * nearer;
		}
		behind += there * back;
		behind_share += back;
	}
}

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy);
	last = textureSize(light, 0) - 1;
	color = light_at(pixel);
	vec2 longest = texelFetch(around, min(pixel / push.tile, textureSize(around, 0) - 1), 0).rg;
	if (length(longest) <= 0.5 || !is_fine(color))
		return;
	float own_ahead = ahead_at(pixel);
	vec2 moves = motion_of(texelFetch(velocity, pixel, 0).rg);
	gather(pixel, own_ahead, longest, false);
	same = color;
	same_share = 1.0;
	if (length(moves) > 0.5) {
		same = vec4(0.0);
		same_share = 0.0;
		gather(pixel, own_ahead, moves, true);
	}
	same = same_share > 0.0 ? same / same_share : color;
	behind = behind_share > 0.0 ? behind / behind_share : same;
	front = front_share > 0.0 ? front / front_share : vec4(0.0);
	float over = min(front_share, 1.0), left = 1.0 - over, by_own = min(same_share, left);
	color = front * over + same * by_own + behind * (left - by_own);
}
