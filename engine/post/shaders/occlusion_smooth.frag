#version 460
// The mean of the sixteen texels that have asked in all directions, of those that lie on the same surface.
layout(set = 0, binding = 0) uniform sampler2D asked;
layout(location = 0) out vec2 visible;

vec2 asked_at(ivec2 at)
{
	return texelFetch(asked, clamp(at, ivec2(0), textureSize(asked, 0) - 1), 0).rg;
}

// By how much distance changes from a texel to the next, on that side on which it changes less.
float slope(ivec2 at, ivec2 step, float here)
{
	float after = asked_at(at + step).y - here, before = here - asked_at(at - step).y;
	return abs(after) < abs(before) ? after : before;
}

void main()
{
	const float OFF = 0.02; // of the distance: what is farther from the surface is another one
	ivec2 at = ivec2(gl_FragCoord.xy);
	float here = asked_at(at).y;
	vec2 slopes = vec2(slope(at, ivec2(1, 0), here), slope(at, ivec2(0, 1), here));
	vec2 sum = vec2(0.0);
	for (int y = -2; y < 2; y++)
		for (int x = -2; x < 2; x++) {
			vec2 there = asked_at(at + ivec2(x, y));
			float rise = dot(slopes, vec2(x, y));
			float off = abs(there.y - here - rise) / (OFF * here + 0.5 * abs(rise));
			float weight = max(1.0 - off, 0.0);
			sum += vec2(there.x, 1.0) * weight;
		}
	visible = vec2(sum.y > 0.0 ? sum.x / sum.y : asked_at(at).x, here);
}
