#version 460
#extension GL_GOOGLE_include_directive : require
// Between the frame's light, a small blur of it, and a large one, by each pixel's circle of confusion.
#include "lens.glsl"

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D defocus;
layout(set = 0, binding = 2) uniform sampler2D narrow; // of push.radius
layout(set = 0, binding = 3) uniform sampler2D wide;   // of push.largest
layout(location = 0) out vec4 color;

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy);
	vec2 at = 0.5 * gl_FragCoord.xy / vec2(textureSize(narrow, 0));
	vec4 here = texelFetch(defocus, pixel, 0);
	float circle = abs(here.a);
	color = texelFetch(light, pixel, 0);
	vec3 small = textureLod(narrow, at, 0.0).rgb;
	if (circle > push.radius)
		color.rgb =
			mix(small, textureLod(wide, at, 0.0).rgb,
		        min((circle - push.radius) / (push.largest - push.radius), 1.0)); // near things' circles may be larger
	else if (circle > 0.0)
		color.rgb = mix(here.rgb, small, circle / push.radius);
}
