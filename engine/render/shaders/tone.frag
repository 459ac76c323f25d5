#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../shading/shade_srgb.h"
#include "../../shading/shade_tonemap.h"
#include "fade.glsl"

layout(constant_id = 0) const int tone = SHADE_TONE_KNEE;
layout(constant_id = 1) const bool display = true; // else the picture holds radiance, too
layout(constant_id = 2) const bool placed = false; // light is shown in a rectangle of the picture, of any size

// As render_tone_push.
layout(push_constant, std430) uniform Push
{
	float exposure; // factor of radiance
	uint dither;    // stilb_render_dither
	ivec2 corner;   // of the rectangle
	ivec2 size;
	int border; // pixels at its edges that are black
	int grade_size;
	vec4 grade_low; // codes to entries: (code - low) scale
	vec4 grade_scale;
}
push;

layout(set = 0, binding = 0) uniform sampler2D light;
#ifdef TONE_GRADE
layout(constant_id = 3) const bool curves = false;
layout(set = 0, binding = 1) uniform sampler3D grade;
#endif
layout(location = 0) in vec2 uv; // of the rectangle, 0..1
layout(location = 0) out vec4 color;

// Half a code up or down at most, by the pixel: what lies between two codes becomes the share of pixels that have the
// upper one. A code's height in linear light is the slope of sRGB's curve, 2.275 L^(7/12), over 255; here up to a tenth
// less, so that light that is a code stays it, but for the rounding of half floats.
vec3 dithered(vec3 shown)
{
	float noise = (float(fade_threshold(uvec2(gl_FragCoord.xy))) + 0.5) / 64.0 - 0.5;
	vec3 root = sqrt(max(shown, 0.0));
	vec3 slope = max(2.275 * root * (0.5 + 0.5 * sqrt(root)), 0.0774);
	return max(shown + slope * (noise / 255.0), 0.0);
}

// The code with up to one more or less, evenly about itself: -1 .. 1, of which x comes with the weight 1 - |x|.
float dithered_evenly(float light, float noise)
{
	float code = 255.0 * shade_srgb_from_linear(clamp(light, 0.0, 1.0));
	float room = min(min(code, 255.0 - code) + 0.5, 1.0);
	float away = 2.0 * noise - 1.0, share = sign(away) * (1.0 - sqrt(1.0 - abs(away)));
	return shade_srgb_to_linear(clamp(code + room * share, 0.0, 255.0) / 255.0);
}

vec3 dithered_by_triangle(vec3 shown)
{
	vec2 pixel = floor(gl_FragCoord.xy);
	float noise = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
	return vec3(dithered_evenly(shown.r, noise), dithered_evenly(shown.g, noise), dithered_evenly(shown.b, noise));
}

// RENDER_TONE_DATA and RENDER_TONE_COUNT, of channels in the place of light (scene_channel.h).
const int TONE_DATA = SHADE_TONE_COUNT;
const int TONE_COUNTED = SHADE_TONE_COUNT + 1;
const int TONE_LIGHTS = SHADE_TONE_COUNT + 2; // by powers of two
const int TONE_ERROR = SHADE_TONE_COUNT + 3;  // likewise; 1 is a 16th of 1/255 of display white

// The light whose sRGB code is the value.
vec3 light_of_data(vec3 value)
{
	vec3 code = clamp(value, 0.0, 1.0);
	return vec3(shade_srgb_to_linear(code.r), shade_srgb_to_linear(code.g), shade_srgb_to_linear(code.b));
}

// A colour for how often a pixel was drawn.
vec3 light_of_count(float count)
{
	const vec3 colors[9] =
		vec3[9](vec3(0.0), vec3(0.01, 0.02, 0.15), vec3(0.02, 0.08, 0.5), vec3(0.02, 0.35, 0.25), vec3(0.1, 0.5, 0.03),
	            vec3(0.55, 0.55, 0.02), vec3(0.8, 0.25, 0.02), vec3(0.8, 0.03, 0.02), vec3(1.0));
	float at = clamp(count, 0.0, 8.0);
	int below = min(int(at), 7);
	return mix(colors[below], colors[below + 1], at - float(below));
}

#ifdef TONE_GRADE
vec3 graded_by_curves(ivec3 first, vec3 beside)
{
	vec3 from, to;
	for (int c = 0; c < 3; c++) {
		int entry = first[c];
		from[c] = texelFetch(grade, ivec3(entry & 255, entry >> 8, 0), 0)[c];
		to[c] = texelFetch(grade, ivec3((entry + 1) & 255, (entry + 1) >> 8, 0), 0)[c];
	}
	return mix(from, to, beside);
}

// Linear in the tetrahedron of the cell's corners that are reached by going along the axes, the longest way first.
vec3 graded_by_cells(ivec3 first, vec3 beside)
{
	float most = max(beside.r, max(beside.g, beside.b)), least = min(beside.r, min(beside.g, beside.b));
	float middle = beside.r + beside.g + beside.b - most - least;
	ivec3 longest = beside.r == most ? ivec3(1, 0, 0) : beside.g == most ? ivec3(0, 1, 0) : ivec3(0, 0, 1);
	ivec3 shortest = beside.b == least ? ivec3(0, 0, 1) : beside.g == least ? ivec3(0, 1, 0) : ivec3(1, 0, 0);
	return texelFetch(grade, first, 0).rgb * (1.0 - most) +
	       texelFetch(grade, first + longest, 0).rgb * (most - middle) +
	       texelFetch(grade, first + 1 - shortest, 0).rgb * (middle - least) +
	       texelFetch(grade, first + 1, 0).rgb * least;
}

// What the table has for this light, through its codes.
vec3 graded(vec3 shown)
{
	vec3 code = vec3(shade_srgb_from_linear(shown.r), shade_srgb_from_linear(shown.g), shade_srgb_from_linear(shown.b));
	vec3 at = clamp((code - push.grade_low.rgb) * push.grade_scale.rgb, 0.0, float(push.grade_size - 1));
	ivec3 first = min(ivec3(at), push.grade_size - 2);
	vec3 beside = at - vec3(first);
	code = clamp(curves ? graded_by_curves(first, beside) : graded_by_cells(first, beside), 0.0, 1.0);
	return vec3(shade_srgb_to_linear(code.r), shade_srgb_to_linear(code.g), shade_srgb_to_linear(code.b));
}
#endif

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	vec4 texel;
	if (placed) {
		at -= push.corner;
		texel = textureSize(light, 0) == push.size ? texelFetch(light, at, 0) : textureLod(light, uv, 0.0);
		ivec2 inside = min(at, push.size - 1 - at);
		if (min(inside.x, inside.y) < push.border)
			texel = vec4(0.0, 0.0, 0.0, 1.0);
	} else {
		texel = texelFetch(light, at, 0);
	}
	if (!display) {
		color = texel;
		return;
	}
	vec3 straight = texel.rgb * (push.exposure / max(texel.a, 1e-6));
	float count = tone == TONE_ERROR ? max(straight.r, max(straight.g, straight.b)) * (16.0 * 255.0) : straight.r;
	vec3 shown = tone == TONE_DATA      ? light_of_data(straight)
	             : tone == TONE_COUNTED ? light_of_count(straight.r)
	             : tone >= TONE_LIGHTS  ? light_of_count(count < 1.0 ? count : 1.0 + log2(count))
	                                    : shade_tone(tone, straight);
#ifdef TONE_GRADE
	shown = graded(shown);
#endif
	if (push.dither == 1u)
		shown = dithered(shown);
	if (push.dither == 2u)
		shown = dithered_by_triangle(shown);
	color = vec4(shown * texel.a, texel.a); // premultiplied
}
