#version 460
#extension GL_GOOGLE_include_directive : require
// The mean of the light around, as far as one radius, whatever its depth.
#include "lens.glsl"
#include "lens_aperture.glsl"

layout(set = 0, binding = 0) uniform sampler2D defocus;
layout(location = 0) out vec4 blurred;

const float MOST = 12.0; // texels of a level that the radius has at most

void main()
{
	int level = clamp(int(ceil(log2(push.radius / MOST))), 0, int(push.levels) - 1);
	float pixels = float(1 << level); // of a texel
	vec2 center = gl_FragCoord.xy * (2.0 / pixels);
	ivec2 middle = ivec2(center), last = textureSize(defocus, level) - 1;
	int around = int(ceil(push.radius / pixels + 0.5));
	vec4 sum = vec4(0.0);
	for (int y = -around; y <= around; y++)
		for (int x = -around; x <= around; x++) {
			ivec2 at = middle + ivec2(x, y);
			vec2 way = (center - vec2(at) - 0.5) * vec2(1.0, -1.0);
			float share = aperture_share(aperture_narrowed(push.radius, pixels) / pixels, aperture_radius(way));
			sum += share * vec4(texelFetch(defocus, clamp(at, ivec2(0), last), level).rgb, 1.0);
		}
	vec3 own = texelFetch(defocus, clamp(middle, ivec2(0), last), level).rgb; // corners may leave out all middles
	blurred = vec4(sum.a > 0.0 ? sum.rgb / sum.a : own, 1.0);
}
