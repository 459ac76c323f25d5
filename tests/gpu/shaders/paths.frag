#version 460
#extension GL_GOOGLE_include_directive : require
#define PATHS_FUNCTION
#include "paths.glsl"
layout(constant_id = 3) const uint kind = 0u;
layout(constant_id = 7) const uint bits = 0u;
layout(constant_id = 1) const bool asked = false;
layout(constant_id = 2) const bool gone = false;
layout(location = 0) out uint color;
void main()
{
	uint x = uint(gl_FragCoord.x) + 8u * uint(gl_FragCoord.y);
	if (asked)
		color = paths(x, kind, bits);
	else
		color = x;
	// If both sides end here, nothing reaches what is behind them.
	if (x > 5u) {
		if (gone)
			discard;
		color += 1u;
	} else {
		if (gone)
			discard;
		color += 2u;
	}
}
