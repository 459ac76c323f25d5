#version 460
// The nearest depth of four texels; of the last ones of an odd side up to nine.
layout(set = 0, binding = 0) uniform sampler2D from;
layout(location = 0) out float nearest;

void main()
{
	ivec2 corner = 2 * ivec2(gl_FragCoord.xy), size = textureSize(from, 0);
	ivec2 last = min(corner + 1 + ivec2(equal(corner + 3, size)), size - 1); // of an odd side the last texel, too
	nearest = 0.0;
	for (int y = 0; y < 3; y++)
		for (int x = 0; x < 3; x++)
			nearest = max(nearest, texelFetch(from, min(corner + ivec2(x, y), last), 0).r);
}
