#version 460
#extension GL_GOOGLE_include_directive : require
// Light and its circle of confusion in half the size, and how much of the texel is soft. Soft texels stay apart from
// sharp ones, near from far: the light is the mean of near soft ones, else of far soft ones, else of all. Circles weigh
// by how bright each is, as a lamp's is seen best.
#include "lens.glsl"

layout(constant_id = 1) const bool first = false; // the picture's size is halved: each pixel is soft by its circle

layout(set = 0, binding = 0) uniform sampler2D from;
layout(set = 0, binding = 1) uniform sampler2D soft_from; // first: also `from`
layout(location = 0) out vec4 halved;
layout(location = 1) out float soft;

void main()
{
	ivec2 corner = 2 * ivec2(gl_FragCoord.xy), last = textureSize(from, 0) - 1;
	vec4 texels[4];
	float weights[4];
	vec2 sides = vec2(0.0); // how soft each side is
	for (int i = 0; i < 4; i++) {
		ivec2 at = min(corner + ivec2(i & 1, i >> 1), last);
		texels[i] = texelFetch(from, at, 0);
		weights[i] = first ? lens_softness(texels[i].a) : texelFetch(soft_from, at, 0).r;
		sides[texels[i].a < 0.0 ? 0 : 1] += weights[i];
	}
	bool near = sides[0] > 0.0, sharp = sides[0] + sides[1] == 0.0;
	vec3 sum = vec3(0.0);
	vec2 circles = vec2(0.0);
	float count = 0.0;
	for (int i = 0; i < 4; i++) {
		float weight = sharp ? 1.0 : texels[i].a < 0.0 == near ? weights[i] : 0.0;
		float brightness = 1e-3 + texels[i][0] + texels[i][1] + texels[i][2];
		sum += weight * texels[i].rgb;
		count += weight;
		circles += weight * brightness * vec2(texels[i].a, 1.0);
	}
	halved = vec4(sum / count, circles[0] / circles[1]);
	soft = sharp ? 0.0 : 0.25 * count;
}
