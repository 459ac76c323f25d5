#version 460

// What draws with transmission show: the light so far, with the depth of models in the fourth channel: near is 1. Where
// there is no model, it is 0 if the surroundings are seen, which rough surfaces know better, else about 0.
#ifdef BEHIND_SAMPLES
layout(constant_id = 0) const int samples = 4;
layout(set = 0, binding = 0) uniform sampler2DMS light;
layout(set = 0, binding = 1) uniform sampler2DMS depth;
#else
layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D depth;
#endif

const float FAR = 6.2e-5; // half floats have all their digits from here on

// As through_push of render_through.c.
layout(push_constant, std430) uniform Push {
	float exposure;
	uint surroundings;
} push;

layout(location = 0) out vec4 color;

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
#ifdef BEHIND_SAMPLES
	// Weighted as in resolve.frag.
	vec3 sum = vec3(0.0);
	float weights = 0.0, nearest = 0.0;
	for (int i = 0; i < samples; i++) {
		vec3 texel = min(texelFetch(light, at, i).rgb, 65504.0);
		float weight = 1.0 / (1.0 + push.exposure * max(texel.r, max(texel.g, texel.b)));
		sum += weight * texel;
		weights += weight;
		nearest = max(nearest, texelFetch(depth, at, i).x);
	}
	color.rgb = sum / weights;
#else
	color.rgb = min(texelFetch(light, at, 0).rgb, 65504.0);
	float nearest = texelFetch(depth, at, 0).x;
#endif
	color.a = nearest > 0.0 || push.surroundings == 0u ? max(nearest, FAR) : 0.0;
}
