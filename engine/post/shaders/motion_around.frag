#version 460
// The longest movement of the tiles that reach into one: of its own, those beside it, and of those at its corners, if
// they move towards it.
layout(set = 0, binding = 0) uniform sampler2D tiles;
layout(location = 0) out vec2 movement;

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy), last = textureSize(tiles, 0) - 1;
	movement = vec2(0.0);
	for (int y = -1; y <= 1; y++)
		for (int x = -1; x <= 1; x++) {
			vec2 other = texelFetch(tiles, clamp(at + ivec2(x, y), ivec2(0), last), 0).rg;
			bool corner = x != 0 && y != 0, towards = float(x * y) * other.x * other.y > 0.0;
			if (!corner || towards)
				movement = dot(other, other) > dot(movement, movement) ? other : movement;
		}
}
