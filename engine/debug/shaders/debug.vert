#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#include "push.glsl"
#include "../../shading/shade_srgb.h"

layout(location = 0) flat out vec4 light; // premultiplied
layout(location = 1) flat out vec4 place; // pixels: a line's ends; a letter's left upper corner, and that of its glyph
layout(location = 2) flat out vec4 depth; // of a line's ends, then half its width; of a text's place, behind its pixel,
                                          // then the glyph's width + 1024 height
layout(location = 3) flat out uint word;

// The part of a line, from part.x to part.y of its length, where a plane's distance is not negative, which is a at its
// begin and b at its end.
vec2 cut(vec2 part, float a, float b)
{
	if (a < 0.0 && b < 0.0)
		return vec2(1.0, 0.0);
	if (a < 0.0)
		part.x = max(part.x, a / (a - b));
	if (b < 0.0)
		part.y = min(part.y, a / (a - b));
	return part;
}

vec2 pixel_of(vec4 clip)
{
	return (clip.xy / clip.w * 0.5 + 0.5) * push.size;
}

void put(vec2 pixel)
{
	gl_Position = vec4(pixel / push.size * 2.0 - 1.0, 0.5, 1.0);
}

// Cuts the line off at the camera's planes, those at the sides so far outside that its ends are not seen: then numbers
// stay small.
void line(Record record, uint corner)
{
	float half_width = float(word & 0xffffu) / 512.0, around = half_width + 1.0;
	vec4 a = push.view_projection * vec4(uintBitsToFloat(record.from.xyz), 1.0);
	vec4 b = push.view_projection * vec4(uintBitsToFloat(record.to.xyz), 1.0);
	vec2 side = 1.0 + 2.0 * (around + 1.0) / push.size;
	vec2 part = cut(vec2(0.0, 1.0), a.w - a.z, b.w - b.z); // reversed depth: near is 1, far 0
	part = cut(part, a.z, b.z);
	part = cut(part, side.x * a.w - a.x, side.x * b.w - b.x);
	part = cut(part, side.x * a.w + a.x, side.x * b.w + b.x);
	part = cut(part, side.y * a.w - a.y, side.y * b.w - b.y);
	part = cut(part, side.y * a.w + a.y, side.y * b.w + b.y);
	vec4 from = part.x > 0.0 ? mix(a, b, part.x) : a, to = part.y < 1.0 ? mix(a, b, part.y) : b;
	if (!(part.x <= part.y && from.w > 0.0 && to.w > 0.0))
		return;
	place = vec4(pixel_of(from), pixel_of(to));
	depth = vec4(from.z / from.w, to.z / to.w, half_width, 0.0);
	vec2 along = place.zw - place.xy;
	float far = length(along);
	along = far > 1e-6 ? along / far : vec2(1.0, 0.0);
	vec2 across = vec2(-along.y, along.x);
	vec2 end = (corner & 1u) == 0u ? place.xy - around * along : place.zw + around * along;
	put(end + ((corner & 2u) == 0u ? across : -across) * around);
}

void letter(Record record, uint corner)
{
	vec4 clip = push.view_projection * vec4(uintBitsToFloat(record.from.xyz), 1.0);
	if (!(clip.w > 0.0 && clip.z <= clip.w && clip.z >= 0.0))
		return;
	vec2 pixel = floor(pixel_of(clip)), size = vec2(record.to.z & 0xffffu, record.to.z >> 16);
	ivec2 offset = ivec2(int(record.to.x << 16) >> 16, int(record.to.x) >> 16);
	place = vec4(pixel + vec2(offset), vec2(record.to.y & 0xffffu, record.to.y >> 16));
	depth = vec4(pixel + 0.5, clip.z / clip.w, size.x + 1024.0 * size.y);
	float more = (word & HALO) != 0u ? 1.0 : 0.0;
	put(place.xy - more + (size + 2.0 * more) * vec2(corner & 1u, corner >> 1));
}

void main()
{
	Record record = push.records.records[gl_VertexIndex >> 2];
	uint corner = uint(gl_VertexIndex) & 3u;
	vec4 code = unpackUnorm4x8(record.from.w).wzyx;
	vec3 linear = vec3(shade_srgb_to_linear(code.r), shade_srgb_to_linear(code.g), shade_srgb_to_linear(code.b));
	light = vec4(linear * code.a, code.a);
	word = record.to.w;
	place = depth = vec4(0.0);
	gl_Position = vec4(2.0, 2.0, 0.5, 1.0); // all four corners outside: not seen
	if ((word & LETTER) != 0u)
		letter(record, corner);
	else
		line(record, corner);
}
