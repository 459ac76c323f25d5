#version 460
#extension GL_GOOGLE_include_directive : require
// The longest movement of a tile's texels, of a row or of a column of them.
#include "motion.glsl"

layout(constant_id = 0) const bool first = true; // velocities are read, else movements

layout(set = 0, binding = 0) uniform sampler2D from;
layout(location = 0) out vec2 movement;

void main()
{
	ivec2 start = ivec2(gl_FragCoord.xy) * push.tile, end = min(start + push.tile, textureSize(from, 0));
	movement = vec2(0.0);
	for (int y = start.y; y < end.y; y++)
		for (int x = start.x; x < end.x; x++) {
			vec2 texel = texelFetch(from, ivec2(x, y), 0).rg;
			movement = motion_longer(movement, first ? motion_of(texel) : texel);
		}
}
