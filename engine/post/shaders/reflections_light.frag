#version 460
#extension GL_GOOGLE_include_directive : require
// What surfaces may mirror: all light of the scene so far, as T(light) = light / (1 + its largest channel), by which
// bright texels do not outshine the mean of many. Source: Karis, "Tone mapping" (2013).
#include "reflections.glsl"

layout(set = 0, binding = 0) uniform sampler2D color;
layout(set = 0, binding = 1) uniform sampler2D ambient;
layout(set = 0, binding = 2) uniform sampler2D reflection;
layout(location = 0) out vec4 light;

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	vec3 sum = texelFetch(color, at, 0).rgb + texelFetch(ambient, at, 0).rgb + texelFetch(reflection, at, 0).rgb;
	bool finite = !any(isnan(sum)) && !any(isinf(sum));
	light = vec4(finite ? reflections_packed(max(sum, 0.0)) : vec3(0.0), 1.0);
}
