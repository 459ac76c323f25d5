#version 460
#extension GL_GOOGLE_include_directive : require
// The soft light that reaches a texel from around: of what is nearer than the plane in focus, with the share of the
// texel that it covers, and of the rest, with its weight. Each texel around sends its light evenly over its circle of
// confusion. Of near things those with the largest circles cover the others. What a near texel hides is not known: it
// is as what is nearest to it and not near itself, lamps less.
#include "lens.glsl"
#include "lens_aperture.glsl"

layout(set = 0, binding = 0) uniform sampler2D defocus;
layout(set = 0, binding = 1) uniform sampler2D softness; // of level 1 on
layout(set = 0, binding = 2) uniform sampler2D reach;
layout(location = 0) out vec4 near; // both multiplied by their fourth
layout(location = 1) out vec4 rest;

const float MOST = 12.0; // texels of a level that a circle's radius has at most

void main()
{
	vec4 here = texelFetch(defocus, ivec2(gl_FragCoord.xy), 1); // its size is that of the images written
	float largest = texelFetch(reach, ivec2(gl_FragCoord.xy) / 8, 0).r;
	vec4 nearest = vec4(0.0);
	near = rest = vec4(0.0);
	if (largest < SHARP)
		return;
	int level = clamp(int(ceil(log2(largest / MOST))), 0, int(push.levels) - 1);
	float pixels = float(1 << level); // of a texel
	vec2 center = gl_FragCoord.xy * (2.0 / pixels);
	ivec2 middle = ivec2(center), last = textureSize(defocus, level) - 1;
	int around = int(ceil(largest / pixels + 0.5));
	for (int y = -around; y <= around; y++)
		for (int x = -around; x <= around; x++) {
			ivec2 at = middle + ivec2(x, y), inside = clamp(at, ivec2(0), last);
			vec4 there = texelFetch(defocus, inside, level);
			vec2 way = (center - vec2(at) - 0.5) * vec2(1.0, -1.0);
			bool before = there.a < 0.0;
			float soft = level > 0 ? texelFetch(softness, inside, level - 1).r : lens_softness(there.a);
			float circle = abs(there.a), squared = 1.0 + dot(way, way);
			// What lies farther away spreads over this texel as far as its own circle: around it the light is blocked.
			if (there.a > here.a && here.a >= 0.0)
				circle = min(circle, here.a);
			float away = aperture_radius(before ? -way : way);
			float share = soft * aperture_share(aperture_narrowed(circle, pixels) / pixels, away);
			float first = before ? smoothstep(0.3, 0.6, circle / largest) : 0.0;
			nearest += first * share * vec4(there.rgb, 1.0);
			near += (before ? 1.0 - first : 0.0) * share * vec4(there.rgb, 1.0);
			float unknown = 1.0 / (squared * squared * (1.0 + there[0] + there[1] + there[2]));
			unknown *= 1.0 - smoothstep(0.3, 0.7, there.a / here.a);
			rest += (here.a < 0.0 ? unknown : before ? 0.0 : share) * vec4(there.rgb, 1.0);
		}
	if (here.a < 0.0)
		rest = rest.a > 0.0 ? rest / rest.a : vec4(here.rgb, 1.0);
	nearest /= max(nearest.a, 1.0);
	near = nearest + (1.0 - nearest.a) * near / max(near.a, 1.0);
}
