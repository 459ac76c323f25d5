#include "fade.glsl"

// Of 32 draws' fades the pixel shows those from a threshold on, and else what gives way to them.
bool is_faded_out(uint word)
{
	uint detail = (word & ~MATERIAL_UNSHADOWED) >> DETAIL_MATERIAL_SHIFT;
	uint shown = detail & 31u;
	bool there = fade_threshold(uvec2(gl_FragCoord.xy)) < 2u * shown;
	return there == (detail >= 32u);
}
