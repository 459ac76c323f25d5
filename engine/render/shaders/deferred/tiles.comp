#version 460
#extension GL_GOOGLE_include_directive : require
// The lists of tiles, shortened by what the tiles show: of the lights that reach a tile at some depth (light/light.h,
// one slice) those are kept, in their order, that may reach a point that is seen there and that faces them.
// Sources: Karis, "Tiled Light Culling" (2012), the tile's nearest and farthest depth and the cone of its normals;
// Andersson, "DirectX 11 Rendering in Battlefield 3" (2011), by compute. TILES_NORMALS: there is an image of normals.
// TILES_GLOSS: with it, lights are left out that may send a little: see gloss.glsl.
#define MESH_OWN_PUSH
#include "../mesh.glsl"
#include "../../../shading/shade_surface.h"

layout(local_size_x = 64) in; // one group a tile
const uint GROUP = 64u;

// As render_tiles_push.
layout(push_constant, std430) uniform Push {
	View view;
	TileLists tiles;
	float tolerance; // of TILES_GLOSS: W sr^-1 m^-2
} push;

layout(constant_id = 6) const uint lights = 0u;
layout(set = 0, binding = 0) uniform sampler2D depth_image;

#include "place.glsl"
#include "lists.glsl"
#include "reach.glsl"
#ifdef TILES_NORMALS
layout(set = 0, binding = 1) uniform sampler2D normal_image;
#include "gbuffer.glsl"
#endif
#ifdef TILES_GLOSS
layout(set = 0, binding = 2) uniform sampler2D diffuse_image;
#include "gloss.glsl"
#endif

shared vec3 lows[GROUP], highs[GROUP], sums[GROUP]; // sums: of normals
shared float nears[GROUP], fars[GROUP], cosines[GROUP];
shared uint kept[2]; // a bit for each light of the last GROUP

// The points that a tile shows: within a box of the world, between two depths, with normals within a cone.
struct Shown {
	vec3 low, high, axis;
	float near, far;
	float cosine; // of half the angle of the normals' cone; -1: they may look anywhere
};

float depth_along(vec3 place)
{
	vec4 plane = push.view.lists.depth_plane;
	return dot(plane.xyz, place) + plane.w;
}

// Joins what the threads of the group have found of their pixels.
void join(uint self)
{
	for (uint count = GROUP / 2u; count > 0u; count /= 2u) {
		barrier();
		if (self < count) {
			lows[self] = min(lows[self], lows[self + count]);
			highs[self] = max(highs[self], highs[self + count]);
			nears[self] = min(nears[self], nears[self + count]);
			fars[self] = max(fars[self], fars[self + count]);
			sums[self] += sums[self + count];
		}
	}
	barrier();
}

#ifdef TILES_NORMALS
GbufferSurface surface_at(ivec2 at, vec3 place)
{
	return gbuffer_surface(texelFetch(normal_image, at, 0), vec4(0.0), vec4(0.0), gbuffer_ahead(place));
}
#endif

Shown shown_by(uint self, uvec2 first, uint side)
{
	const float FAR = 3e38;
	vec3 low = vec3(FAR), high = vec3(-FAR), sum = vec3(0.0), camera = push.view.camera_position.xyz;
	float near = FAR, far = -FAR, cosine = 1.0;
	ivec2 size = textureSize(depth_image, 0);
	for (uint i = self; i < side * side; i += GROUP) {
		ivec2 at = ivec2(first + uvec2(i % side, i / side));
		float depth = all(lessThan(at, size)) ? texelFetch(depth_image, at, 0).x : 0.0;
		vec4 place = depth > 0.0 ? place_at(vec2(at) + 0.5, depth) : vec4(0.0);
		if (place.w == 0.0)
			continue;
		float along = depth_along(place.xyz), room = distance(place.xyz, camera) * REACH_ROUNDING;
		low = min(low, place.xyz - room);
		high = max(high, place.xyz + room);
		near = min(near, along - room);
		far = max(far, along + room);
#ifdef TILES_NORMALS
		GbufferSurface surface = surface_at(at, place.xyz);
		sum += surface.normal;
		if (surface.material.wrap > 0.0) // it is lit from behind, too
			cosine = -1.0;
#endif
	}
	lows[self] = low;
	highs[self] = high;
	nears[self] = near;
	fars[self] = far;
	sums[self] = sum;
	join(self);
	Shown shown = Shown(lows[0], highs[0], vec3(0.0), nears[0], fars[0], -1.0);
#ifdef TILES_NORMALS
	float length2 = dot(sums[0], sums[0]);
	shown.axis = length2 > 0.0 ? sums[0] * inversesqrt(length2) : vec3(0.0);
	for (uint i = self; i < side * side && cosine > -1.0; i += GROUP) {
		ivec2 at = ivec2(first + uvec2(i % side, i / side));
		float depth = all(lessThan(at, size)) ? texelFetch(depth_image, at, 0).x : 0.0;
		if (depth > 0.0)
			cosine = min(cosine, dot(surface_at(at, place_at(vec2(at) + 0.5, depth).xyz).normal, shown.axis));
	}
	cosines[self] = cosine;
	for (uint count = GROUP / 2u; count > 0u; count /= 2u) {
		barrier();
		if (self < count)
			cosines[self] = min(cosines[self], cosines[self + count]);
	}
	barrier();
	shown.cosine = length2 > 0.0 ? max(cosines[0] - REACH_ROUNDING, -1.0) : -1.0;
#endif
	return shown;
}

// True if the light may reach a point that is shown.
bool reaches(Reach reach, Shown shown)
{
	float along = depth_along(reach.center);
	if (along + reach.radius < shown.near || along - reach.radius > shown.far)
		return false;
	vec3 away = max(max(shown.low - reach.center, reach.center - shown.high), 0.0);
	if (dot(away, away) > reach.radius * reach.radius)
		return false;
	vec3 middle = 0.5 * (shown.low + shown.high), toward = middle - reach.center;
	float around = 0.5 * length(shown.high - shown.low), apart = length(toward);
	if (apart <= around + reach.size)
		return true;
	// Within the cone of a spot: the ball around the box, as seen from the lamp.
	float sine_ball = around / apart, cosine_ball = sqrt(max(1.0 - sine_ball * sine_ball, 0.0));
	float cosine = dot(toward, reach.axis) / (apart * max(length(reach.axis), 1e-20));
	float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
	bool beside = reach.cosine > -1.0 && cosine < cosine_ball && cosine * cosine_ball + sine * sine_ball < reach.cosine;
	// In front of some normal: the light's distance along the one of the cone that is nearest to its direction.
	float cosine_n = -dot(toward, shown.axis) / apart, sine_n = sqrt(max(1.0 - cosine_n * cosine_n, 0.0));
	float sine_cone = sqrt(max(1.0 - shown.cosine * shown.cosine, 0.0));
	bool behind = shown.cosine > -1.0 && cosine_n < shown.cosine &&
		apart * (cosine_n * shown.cosine + sine_n * sine_cone) < -(around + reach.size);
	return !(beside || behind);
}

void main()
{
	uint self = gl_LocalInvocationIndex, side = 1u << (push.view.grid.y & 0xffu);
	uint tiles = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
	uint tile = gl_WorkGroupID.x + gl_NumWorkGroups.x * gl_WorkGroupID.y;
	uvec2 list = list_of(push.view.lists, tile, tiles);
	uint all = push.view.lists.all, none = tiles + 1u + all; // where the first list begins
	if (list.x < none && list.y > list.x) { // there was no room for it: a list of all, behind the others
		uint at = 2u * tiles + push.view.lists.room;
		for (uint i = self; i < all; i += GROUP)
			push.tiles.words[at + i] = i;
		push.tiles.words[tile] = at;
		push.tiles.words[tiles + tile] = at + all;
		return;
	}
	uint begin = 2u * tiles + list.x - none, to = begin; // the place of a list is that of all that it is made of
	Shown shown = shown_by(self, gl_WorkGroupID.xy * side, side);
#ifdef TILES_GLOSS
	Gloss gloss = gloss_of_tile(self, gl_WorkGroupID.xy * side, side);
#endif
	for (uint i = list.x; i < list.y; i += GROUP) {
		uint id = i + self < list.y ? push.view.lists.words[i + self] : 0u, light = push.view.light_count + id;
		bool keep = i + self < list.y && shown.near <= shown.far && reaches(reach_of(light), shown);
#ifdef TILES_GLOSS
		keep = keep && gloss_counts(light, gloss, shown.low, shown.high, push.tolerance / float(list.y - list.x));
#endif
		barrier();
		if (self < 2u)
			kept[self] = 0u;
		barrier();
		if (keep)
			atomicOr(kept[self / 32u], 1u << self % 32u);
		barrier();
		uint before = bitCount(kept[self / 32u] & (1u << self % 32u) - 1u) + (self < 32u ? 0u : bitCount(kept[0]));
		if (keep)
			push.tiles.words[to + before] = id;
		to += bitCount(kept[0]) + bitCount(kept[1]);
	}
	if (self == 0u) {
		push.tiles.words[tile] = begin;
		push.tiles.words[tiles + tile] = to;
	}
}
