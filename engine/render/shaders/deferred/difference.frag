#version 460
// How far the radiance of an image is from that of another of its size, by channel.
layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D reference;
layout(location = 0) out vec4 color;

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	color = vec4(abs(texelFetch(light, at, 0).rgb - texelFetch(reference, at, 0).rgb), 1.0);
}
