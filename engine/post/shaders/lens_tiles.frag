#version 460
// The largest circle of confusion of each tile of 16 x 16 pixels.
layout(set = 0, binding = 0) uniform sampler2D defocus;
layout(location = 0) out float largest;

void main()
{
	ivec2 corner = 16 * ivec2(gl_FragCoord.xy), last = textureSize(defocus, 0) - 1;
	largest = 0.0;
	for (int y = 0; y < 16; y++)
		for (int x = 0; x < 16; x++)
			largest = max(largest, abs(texelFetch(defocus, min(corner + ivec2(x, y), last), 0).a));
}
