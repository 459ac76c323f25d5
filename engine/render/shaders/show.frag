#version 460
// Shows an image of the plan in the place of the picture: its values from low to high as black to white.

layout(constant_id = 0) const int channels = 4; // of the image; 1 is shown grey, 2 red and green

layout(push_constant, std430) uniform Push
{
	float low, high;
	float columns, rows; // of SHOW_LAYERS: squares in the picture, and a square's sides as shares of it
	float side_x, side_y;
}
push;

#ifdef SHOW_SAMPLES
layout(set = 0, binding = 0) uniform sampler2DMS shown;
#elif defined(SHOW_INTEGERS)
layout(set = 0, binding = 0) uniform usampler2D shown;
#elif defined(SHOW_LAYERS)
layout(set = 0, binding = 0) uniform sampler2DArray shown; // depth; SHOW_LAYERS: all layers side by side
#else
layout(set = 0, binding = 0) uniform sampler2D shown;
#endif
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

#ifdef SHOW_INTEGERS
// A colour for a number: neighbours differ, 0 is black.
vec3 color_of(uint number)
{
	uint hash = number * 0x9e3779b9u;
	hash = (hash ^ hash >> 15) * 0x85ebca6bu;
	return number == 0u ? vec3(0.0) : 0.1 + 0.9 * vec3(hash >> 24, hash >> 16 & 0xffu, hash >> 8 & 0xffu) / 255.0;
}
#endif

void main()
{
#ifdef SHOW_SAMPLES
	vec4 texel = texelFetch(shown, ivec2(uv * vec2(textureSize(shown))), 0);
#elif defined(SHOW_INTEGERS)
	uint number = texelFetch(shown, ivec2(uv * vec2(textureSize(shown, 0))), 0).r;
	color = vec4(color_of(number), 1.0);
	return;
#elif defined(SHOW_LAYERS)
	vec2 at = (uv - 0.5) / vec2(push.side_x, push.side_y) + 0.5 * vec2(push.columns, push.rows);
	vec2 square = floor(at), within = (fract(at) - 0.5) * 1.02 + 0.5; // with a gap
	float layer = square.x + push.columns * square.y;
	bool none = any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(push.columns, push.rows))) ||
	            layer >= float(textureSize(shown, 0).z) || any(notEqual(clamp(within, 0.0, 1.0), within));
	float depth = none ? 0.0 : textureLod(shown, vec3(within, layer), 0.0).r;
	color = vec4(none ? vec3(0.01, 0.02, 0.06) : vec3(sqrt(sqrt(depth))), 1.0);
	return;
#else
	vec4 texel = textureLod(shown, uv, 0.0);
#endif
#if !defined(SHOW_INTEGERS) && !defined(SHOW_LAYERS)
	vec3 value = channels == 1 ? texel.rrr : channels == 2 ? vec3(texel.rg, 0.0) : texel.rgb;
	color = vec4(clamp((value - push.low) / (push.high - push.low), 0.0, 1.0), 1.0);
#endif
}
