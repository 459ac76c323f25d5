#version 460
#extension GL_GOOGLE_include_directive : require
#define HDR_CONSTANT 1
#include "hdr/hdr.glsl"

layout(constant_id = 0) const int samples = 4;

// As render_tone_push.
layout(push_constant, std430) uniform Push {
	float exposure;
} push;

layout(set = 0, binding = 0) uniform sampler2DMS light;
layout(location = 0) out vec4 color;

// The mean of a pixel's samples, each weighted by 1 / (1 + its largest channel as exposed): so that a pixel at the edge
// of a lamp is not nearly as bright as the lamp (Karis, "Tone mapping", 2013). Radiance is premultiplied by alpha.
void main()
{
	vec3 sum = vec3(0.0);
	float weights = 0.0, covered = 0.0;
	for (int i = 0; i < samples; i++) {
		vec4 texel = texelFetch(light, ivec2(gl_FragCoord.xy), i);
		if (hdr != HDR_HALF)
			texel = vec4(hdr_decoded(texel) / push.exposure, 1.0);
		texel = min(texel, 65504.0); // not infinite
		float weight = 1.0 / (1.0 + push.exposure * max(texel.r, max(texel.g, texel.b)));
		sum += weight * texel.rgb;
		weights += weight * texel.a;
		covered += texel.a;
	}
	float alpha = covered / float(samples);
	color = vec4(weights > 0.0 ? sum * (alpha / weights) : vec3(0.0), alpha);
}
