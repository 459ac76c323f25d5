#version 460
#extension GL_GOOGLE_include_directive : require
// What a pixel mirrors of the picture, in T(light), times the share of its cone that meets something; and that share.
// Sources: Uludag, "Hi-Z Screen-Space Cone-Traced Reflections" (GPU Pro 5, 2014), for the march over a hierarchy of
// depth; Heitz, "Sampling the GGX Distribution of Visible Normals" (2018), for the directions of rough surfaces.
#include "../../shading/shade_impostor.h"
#include "../../shading/shade_sampling.h"
#include "reflections.glsl"

const int CONES = 1, CRUDE = 2, LINEAR = 3;
layout(constant_id = 0) const int way = CONES;

layout(set = 0, binding = 0) uniform sampler2D depth_of;
layout(set = 0, binding = 1) uniform sampler2D nearest; // the hierarchy from half the size on, side by side
layout(set = 0, binding = 2) uniform sampler2D mirror;
layout(set = 0, binding = 3) uniform sampler2D mirror_normal;
layout(set = 0, binding = 4) uniform sampler2D light;
layout(location = 0) out vec4 mirrored;

const int CELLS = 96;       // of the hierarchy that a ray visits at most
const int RAYS = 2;         // of a rough surface's pixel; sixteen pixels together have all directions
const float SMOOTH = 0.02;  // roughness of what is a mirror
const float ROUGHEST = 0.8; // what is rougher mirrors the surroundings alone
const float THICK = 0.02;   // of the distance: how far things reach behind what is seen of them
const float EDGE = 0.1;     // of the picture's sides: there what is mirrored fades

vec2 size;

// Levels are places of one image and no mips: software devices read one mip for four pixels.
float nearest_at(ivec2 cell, int level)
{
	ivec2 whole = ivec2(size);
	if (level == 0)
		return texelFetch(depth_of, clamp(cell, ivec2(0), whole - 1), 0).r;
	ivec2 corner = level == 1 ? ivec2(0) : ivec2(whole.x >> 1, (whole.y >> 1) - (whole.y >> (level - 1)));
	return texelFetch(nearest, corner + clamp(cell, ivec2(0), (whole >> level) - 1), 0).r;
}

// True if a ray that is at depths `from` and then `to` over a pixel meets what is seen there at depth `seen`.
bool meets(float from, float to, float seen)
{
	if (seen <= 0.0 || min(from, to) > seen)
		return false;
	float surface = reflections_away(seen), entered = reflections_away(from), left = reflections_away(to);
	return from > seen || entered - surface < THICK * surface + 2.0 * abs(left - entered);
}

// Along start + walk * s the first s at which the ray meets something, `end` or more: it does not.
float march(vec3 start, vec3 walk, float first, float end)
{
	float s = first;
	int level = 0;
	vec2 ahead = vec2(greaterThan(walk.xy, vec2(0.0)));
	vec2 slow = mix(walk.xy, vec2(1e-9), lessThan(abs(walk.xy), vec2(1e-9)));
	for (int i = 0; i < CELLS && s < end; i++) {
		float side = float(1 << level);
		ivec2 cell = ivec2(floor((start.xy + walk.xy * s) / side));
		vec2 exits = ((vec2(cell) + ahead) * side + (ahead - 0.5) * 0.02 - start.xy) / slow; // a little beyond
		float leave = max(min(exits.x, exits.y), s);
		float seen = nearest_at(cell, level), from = start.z + walk.z * s, to = start.z + walk.z * leave;
		if (min(from, to) > seen) {
			s = leave;
			level = min(level + 1, int(push.levels) - 1);
		} else if (level > 0) {
			s = from > seen ? clamp((seen - start.z) / walk.z, s, leave) : s;
			level--;
		} else if (meets(from, to, seen)) {
			return from > seen ? clamp((seen - start.z) / walk.z, s, leave) : s;
		} else {
			s = leave;
		}
	}
	return end;
}

// The same in steps of equal length.
float march_steps(vec3 start, vec3 walk, float end, int steps)
{
	float each = end / float(steps);
	for (int i = 1; i <= steps; i++) {
		float s = float(i) * each;
		float seen = nearest_at(ivec2(start.xy + walk.xy * s), 0);
		if (meets(start.z + walk.z * (s - each), start.z + walk.z * s, seen))
			return s;
	}
	return end;
}

// What a ray meets: T(light) and the share of it that counts. wide: radius of its cone at distance 1.
vec4 met(vec3 place, vec3 n, vec3 toward, float roughness, float wide)
{
	float here = dot(place, push.clip_w.xyz), approach = -dot(toward, push.clip_w.xyz);
	vec3 origin = place + n * (here / push.clip_w.w);
	float far = approach > 0.0 ? 0.95 * here / approach : 1000.0 * here;
	vec3 start = reflections_pixel(origin, size), walk = reflections_pixel(origin + toward * far, size) - start;
	float pixels = max(abs(walk.x), abs(walk.y));
	if (pixels < 1.0)
		return vec4(0.0);
	walk /= pixels;
	vec2 borders = (mix(vec2(0.0), size, greaterThan(walk.xy, vec2(0.0))) - start.xy) /
	               mix(walk.xy, vec2(1e-9), lessThan(abs(walk.xy), vec2(1e-9)));
	float most = min(pixels, min(borders.x, borders.y)), end = most;
	if (way == CRUDE)
		end *= 0.5 * (1.0 - roughness);
	float s = way == CONES ? march(start, walk, 1.0, end) : march_steps(start, walk, end, way == CRUDE ? 24 : 64);
	if (s >= end)
		return vec4(0.0);
	vec2 at = start.xy + walk.xy * s;
	ivec2 pixel = clamp(ivec2(at), ivec2(0), ivec2(size) - 1);
	vec3 there = reflections_place(at, nearest_at(pixel, 0), size);
	vec3 facing = shade_direction_from_octahedral(texelFetch(mirror_normal, pixel, 0).rg * 2.0 - 1.0);
	float radius = wide * distance(there, place) * push.clip_w.w / dot(there, push.clip_w.xyz);
	float share = 1.0;
	if (way != LINEAR) {
		vec2 inside = clamp(min(at, size - at) / (EDGE * size), 0.0, 1.0);
		share = inside.x * inside.y;
		// What is met by rays that come back to the camera, or from behind, is not in the picture.
		share *= clamp(-5.0 * dot(facing, toward), 0.0, 1.0) * smoothstep(-0.7, -0.3, dot(toward, normalize(place)));
	}
	if (way == CRUDE)
		share *= 1.0 - s / end;
	return vec4(textureLod(light, at / size, log2(max(radius, 1.0))).rgb, 1.0) * share;
}

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	size = vec2(textureSize(depth_of, 0));
	float depth = texelFetch(depth_of, at, 0).r;
	vec4 surface = texelFetch(mirror, at, 0);
	mirrored = vec4(0.0);
	if (way == LINEAR)
		mirrored.a = 1.0;
	if (depth <= 0.0 || surface.rgb == vec3(0.0) || (way != LINEAR && surface.a >= ROUGHEST))
		return;
	vec3 place = reflections_place(gl_FragCoord.xy, depth, size), v = -normalize(place);
	vec3 n = shade_direction_from_octahedral(texelFetch(mirror_normal, at, 0).rg * 2.0 - 1.0);
	float alpha = shade_alpha_from_roughness(surface.a);
	if (way != CONES || surface.a < SMOOTH) {
		mirrored = met(place, n, reflect(-v, n), surface.a, way == LINEAR ? 0.0 : alpha);
	} else {
		shade_frame frame = shade_frame_from_normal(n);
		vec3 local = shade_frame_to_local(frame, v);
		uint own = uint((at.x & 3) * 4 + (at.y & 3) * 9) & 15u;
		for (uint r = 0u; r < uint(RAYS); r++) {
			uint k = own + 16u * r;
			vec2 u = vec2((float(k) + 0.5) / float(16 * RAYS), float(bitfieldReverse(k)) * (1.0 / 4294967296.0));
			u.x *= 0.95; // the farthest facets are few, and their rays go anywhere
			vec3 toward = shade_sample_ggx_visible(shade_alphas(alpha, alpha), local, u).direction;
			if (toward.z > 0.0)
				mirrored += met(place, n, shade_frame_to_world(frame, toward), surface.a, 0.25 * alpha);
		}
		mirrored /= float(RAYS);
	}
	if (way == LINEAR)
		mirrored.a = 1.0;
	if (way != LINEAR)
		mirrored *= 1.0 - smoothstep(0.75 * ROUGHEST, ROUGHEST, surface.a);
}
