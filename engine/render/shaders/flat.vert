#version 460
#extension GL_GOOGLE_include_directive : require
#include "row.glsl"
#include "../../shading/shade_srgb.h"

// As render_push_2d.
layout(push_constant, std430) uniform Push {
	vec2 scale; // pixels to clip space
	Rows rows;
} push;

layout(location = 0) in vec2 position;
layout(location = 1) in vec4 code;

layout(location = 0) out vec4 light;
layout(location = 1) flat out vec4 clip;

#ifdef FLAT_TEXTURE
layout(location = 2) in vec2 uv;
layout(location = 2) out vec2 surface_uv;
#endif

#ifdef FLAT_PICTURE
layout(location = 3) flat out float factor;
layout(location = 4) flat out int tone;
#endif

void main()
{
	vec3 linear = vec3(shade_srgb_to_linear(code.r), shade_srgb_to_linear(code.g), shade_srgb_to_linear(code.b));
	light = vec4(linear * code.a, code.a);
	clip = push.rows.rows[uint(gl_InstanceIndex) & (ROW_FRAME - 1u)].transform[0];
#ifdef FLAT_TEXTURE
	surface_uv = uv;
#endif
#ifdef FLAT_PICTURE
	vec4 shown = push.rows.rows[uint(gl_InstanceIndex) & (ROW_FRAME - 1u)].transform[1];
	factor = shown.x;
	tone = int(shown.y);
#endif
	gl_Position = vec4(position * push.scale - 1.0, 0.0, 1.0);
}
