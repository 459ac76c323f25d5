#version 460
// A level of the hierarchy of depth at its place beside the others.
layout(set = 0, binding = 0) uniform sampler2D level;
layout(location = 0) out float nearest;

layout(push_constant, std430) uniform Push
{
	ivec2 corner; // of the place
}
push;

void main()
{
	nearest = texelFetch(level, ivec2(gl_FragCoord.xy) - push.corner, 0).r;
}
