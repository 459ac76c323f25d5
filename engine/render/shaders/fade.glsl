// The threshold of a pixel, 0..63, each once in every tile of 8 x 8 pixels: blue noise, so that any number of the
// lowest ones is spread evenly. tests/render/test_render_fade.c makes the numbers.
const uint fade_thresholds[64] = uint[64](
#include "fade_thresholds.inc"
);

uint fade_threshold(uvec2 pixel)
{
	return fade_thresholds[(pixel.y & 7u) * 8u + (pixel.x & 7u)];
}
