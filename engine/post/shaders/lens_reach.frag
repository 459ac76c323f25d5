#version 460
#extension GL_GOOGLE_include_directive : require
// The largest circle of confusion of all tiles whose light gets to this one.
#include "lens.glsl"

layout(set = 0, binding = 0) uniform sampler2D tiles;
layout(location = 0) out float largest;

const float TILE = 16.0; // pixels

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(tiles, 0);
	int around = int(ceil(push.largest / TILE));
	ivec2 from = max(at - around, ivec2(0)), to = min(at + around, size - 1);
	largest = 0.0;
	for (int y = from.y; y <= to.y; y++)
		for (int x = from.x; x <= to.x; x++) {
			vec2 between = max(vec2(abs(ivec2(x, y) - at) - 1), 0.0) * TILE;
			float there = texelFetch(tiles, ivec2(x, y), 0).r;
			largest = there >= length(between) ? max(largest, there) : largest;
		}
}
