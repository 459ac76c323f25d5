#version 460
// An old photograph: one hue, and darker towards the corners. Light in, light out; the tone map follows.

layout(push_constant, std430) uniform Push {
	vec4 hue;
	float dark; // how much of the light the corners lose
} push;

layout(set = 0, binding = 0) uniform sampler2D light;
layout(location = 0) in vec2 uv; // 0, 0 at the left upper corner
layout(location = 0) out vec4 color;

void main()
{
	vec4 texel = texture(light, uv);
	float bright = dot(texel.rgb, vec3(0.2126, 0.7152, 0.0722));
	float away = 2.0 * dot(uv - 0.5, uv - 0.5);
	color = vec4(bright * push.hue.rgb * (1.0 - push.dark * away), texel.a);
}
