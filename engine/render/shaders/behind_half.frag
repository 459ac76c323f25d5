#version 460

// Of what behind.frag has written, at half the size: the light of models alone, times the share of them in the fourth
// channel.
layout(set = 0, binding = 0) uniform sampler2D behind;
layout(location = 0) out vec4 color;

void main()
{
	ivec2 last = textureSize(behind, 0) - 1, at = 2 * ivec2(gl_FragCoord.xy);
	color = vec4(0.0);
	for (int i = 0; i < 4; i++) {
		vec4 texel = texelFetch(behind, min(at + ivec2(i & 1, i >> 1), last), 0);
		color += texel.a > 0.0 ? 0.25 * vec4(texel.rgb, 1.0) : vec4(0.0);
	}
}
