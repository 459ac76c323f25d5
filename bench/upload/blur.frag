#version 460
layout(set = 0, binding = 0) uniform sampler2D before;
layout(location = 0) out vec4 color;
/* The mean of nine texels, and a little of the place. */
void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy), most = textureSize(before, 0) - 1;
	vec4 sum = vec4(0.0);
	for (int y = -1; y <= 1; y++)
		for (int x = -1; x <= 1; x++)
			sum += texelFetch(before, clamp(at + ivec2(x, y), ivec2(0), most), 0);
	color = sum / 9.1 + vec4(fract(vec2(at) * 0.01), 0.1, 0.0);
}
