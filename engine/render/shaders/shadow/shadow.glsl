// How much of a light arrives where maps may keep it from a surface: see stilb_render_shadows. Inside of lit.glsl.
#ifdef LIT_SURFACES
#ifdef LIT_APART
#define SHADOW_BINDING 2
#else
#define SHADOW_BINDING 4
#endif
#elif defined(LIT_GLOSS)
#define SHADOW_BINDING 3
#else
#define SHADOW_BINDING 0
#endif
layout(set = 0, binding = SHADOW_BINDING) uniform sampler2DArray shadow_maps; // with shadow_buffered terms of lights
#ifdef LIT_TERMS
layout(set = 0, binding = SHADOW_BINDING + 1) uniform sampler2DArray shadow_mask; // with shadow_masked
#endif

// How shadows are read, and what is shown of them (RENDER_SHADOW_... of render_internal.h).
layout(constant_id = 11) const uint shadow_kind = 0u;
const bool shadow_shows_cascades = (shadow_kind & 1u) != 0u;
const bool shadow_shows_acne = (shadow_kind & 2u) != 0u;
const bool shadow_plane = (shadow_kind & 4u) == 0u; // texels are compared with the point's plane, not with its depth
const bool shadow_way = (shadow_kind & 8u) == 0u;   // the point is moved towards the light
const bool shadow_buffered = (shadow_kind & 32u) != 0u;
const bool shadow_masked = (shadow_kind & 64u) != 0u;
const bool shadow_of_things = (shadow_kind & 256u) != 0u; // maps have some things; the mask says what all others do
const int shadow_taps = int(shadow_kind >> 9);            // comparisons in place of the filter; 0: none

// What is shown in place of the share that arrives: the colour of the cascades that were asked; and of the filter, of a
// light at a time, what lies in front of the point by less than twice what it is moved by, and keeps light from it; and
// what does not, since the point was moved.
vec3 shadow_tint = vec3(0.0);
vec2 shadow_judged = vec2(0.0);
float shadow_moved = 0.0; // of depth

// Takes note of texels whose weights add up to 1 in all. middles: depths that they are compared with.
void shadow_judge(vec4 stored, vec4 middles, vec4 weights)
{
	if (!shadow_shows_acne)
		return;
	vec4 own = middles - (shadow_way ? shadow_moved : 0.0), open = vec4(greaterThanEqual(middles, stored));
	vec4 near = vec4(lessThanEqual(stored, own + 2.0 * shadow_moved)), before = vec4(greaterThan(stored, own + 1e-6));
	shadow_judged += vec2(dot(weights * near, 1.0 - open), dot(weights * before, open));
}

// A cosine and a sine turned on by another angle's.
vec2 shadow_turn(vec2 at, vec2 by)
{
	return vec2(at.x * by.x - at.y * by.y, at.y * by.x + at.x * by.y);
}

// What depth changes by from the corner between four texels to their middles, in the order of textureGather: (0, 1)
// (1, 1) (1, 0) (0, 0).
vec4 shadow_corners(vec2 slope)
{
	return 0.5 * vec4(slope.y - slope.x, slope.x + slope.y, slope.x - slope.y, -slope.x - slope.y);
}

// The four texels around a place, and how far it lies from the first one's middle.
vec4 shadow_around(ShadowMap map, vec2 at, float size, out vec2 beside)
{
	vec2 first = floor(at - 0.5);
	beside = at - 0.5 - first;
	return textureGather(shadow_maps, vec3((first + 1.0) / size, map.rest.x));
}

// The share of the four texels around a place, `away` from the point, that lets the light through, weighted by how near
// they are: what a comparison by a device's sampler gives. share: of all such comparisons together.
float shadow_comparison(ShadowMap map, vec3 at, vec2 slope, vec2 away, float share)
{
	vec2 beside;
	vec4 stored = shadow_around(map, at.xy + away, float(textureSize(shadow_maps, 0).x), beside);
	vec4 middles = at.z + dot(slope, away + 0.5 - beside) + shadow_corners(slope);
	vec2 other = 1.0 - beside;
	vec4 weights = vec4(other.x, beside.x, beside.x, other.x) * vec4(beside.yy, other.yy) * share;
	shadow_judge(stored, middles, weights);
	return dot(weights, vec4(greaterThanEqual(middles, stored)));
}

// The mean of few comparisons, of one in the middle, four around it, and eight farther out, turned by half a step in
// every second pixel, as on a chessboard: neighbours together see twice as many. Source: Karis, "Killzone 2" (2009).
float shadow_compared(ShadowMap map, vec3 at, vec2 slope)
{
	at.xy = clamp(at.xy, map.area.xy + map.rest.w, map.area.zw - map.rest.w);
	if (shadow_taps == 1)
		return shadow_comparison(map, at, slope, vec2(0.0), 1.0);
	float turned = mod(floor(gl_FragCoord.x) + floor(gl_FragCoord.y), 2.0), sum = 0.0;
	for (int i = 0; i < shadow_taps; i++) {
		float step = i < 4 ? 0.5 * SHADE_PI : 0.25 * SHADE_PI, radius = i >= 4 ? 2.0 : shadow_taps > 4 ? 0.8 : 1.0;
		float angle = step * (float(i) + 0.5 * turned);
		sum += shadow_comparison(map, at, slope, radius * vec2(cos(angle), sin(angle)), 1.0 / float(shadow_taps));
	}
	return sum;
}

// The share of the texels around a place that lets the light through. at: texels, depth; slope: of depth by texels.
float shadow_filtered(ShadowMap map, vec3 at, vec2 slope)
{
	if (map.rest.w == 0.0) { // the one texel there
		vec2 texel = clamp(floor(at.xy), map.area.xy, map.area.zw - 1.0);
		float stored = texelFetch(shadow_maps, ivec3(texel, map.rest.x), 0).x;
		float middle = at.z + dot(slope, texel + 0.5 - at.xy);
		shadow_judge(vec4(stored), vec4(middle), vec4(0.25));
		return step(stored, middle);
	}
	if (shadow_taps > 0)
		return shadow_compared(map, at, slope);
	int radius = int(map.rest.w), width = 2 * radius;
	float size = float(textureSize(shadow_maps, 0).x), step = SHADE_PI / map.rest.w;
	at.xy = clamp(at.xy, map.area.xy + map.rest.w, map.area.zw - map.rest.w);
	vec2 first = floor(at.xy - 0.5) - (map.rest.w - 1.0) + 0.5; // the middle of the first texel
	vec2 turn = vec2(cos(step), sin(step)), angle = step * (first - at.xy);
	vec2 down = vec2(cos(angle.y), sin(angle.y)), left = vec2(cos(angle.x), sin(angle.x));
	float sum = 0.0;
	for (int y = 0; y < width; y += 2) {
		vec2 next_down = shadow_turn(down, turn), across = left;
		for (int x = 0; x < width; x += 2) {
			vec2 next_across = shadow_turn(across, turn), corner = first + vec2(x, y) + 0.5;
			vec4 stored = textureGather(shadow_maps, vec3(corner / size, map.rest.x));
			vec2 away = corner - at.xy;
			float middle = at.z + dot(slope, away);
			vec4 open = vec4(greaterThanEqual(middle + shadow_corners(slope), stored));
			vec2 columns = 1.0 + vec2(across.x, next_across.x), rows = 1.0 + vec2(down.x, next_down.x);
			vec4 weights = vec4(columns.xy, columns.yx) * rows.yyxx;
			sum += dot(open, weights);
			shadow_judge(stored, middle + shadow_corners(slope), weights / (4.0 * map.rest.w * map.rest.w));
			across = shadow_turn(next_across, turn);
		}
		down = shadow_turn(next_down, turn);
	}
	return sum / (4.0 * map.rest.w * map.rest.w);
}

// Number `index` of directions, each the golden angle from the one before, turned by an angle of the pixel's own: few
// points show bands, turned ones a fine grain. Sources: Vogel, "A better way to construct the sunflower head" (1979);
// Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare" (2014), for the angle.
vec2 shadow_direction(int index)
{
	const float GOLDEN = 2.3999632;
	float turned = 2.0 * SHADE_PI * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
	float angle = turned + GOLDEN * float(index);
	return vec2(cos(angle), sin(angle));
}

// Number `index` of points that lie evenly in a disc of the radius 1.
vec2 shadow_disc(int index, float count)
{
	return sqrt((float(index) + 0.5) / count) * shadow_direction(index);
}

// The share of a lamp with a size that is seen: what is in front of it, on average, says how wide its shadow's edge is.
// Asked for are places at distances that grow by equal factors: what is close to the lamp may lie far away in the map,
// what is close to the point lies next to it. Of both what is not on the way to the lamp, as a ceiling around it, is
// left out, in the search with some room, so that none is missed. What is averaged is the distance from the lamp,
// 1 / depth but for a factor. Where nothing is in front, all is seen. Source: Fernando, "Percentage-Closer Soft
// Shadows" (2005), but for the places.
float shadow_soft(ShadowMap map, vec3 at, vec2 slope)
{
	const int SEARCHED = 24, ASKED = 32;
	const float ROOM = 1.5;
	float size = float(textureSize(shadow_maps, 0).x);
	vec2 sides = min(at.xy - map.area.xy, map.area.zw - at.xy) - 1.0, beside;
	float least = max(map.rest.w, 1.0), most = max(min(sides.x, sides.y), least);
	float radius = clamp(map.error.z * (1.0 - at.z), least, most), sum = 0.0, count = 0.0;
	for (int i = 0; i < SEARCHED; i++) {
		float far = least * pow(radius / least, (float(i) + 0.5) / float(SEARCHED));
		vec2 away = far * shadow_direction(i);
		vec4 stored = shadow_around(map, at.xy + away, size, beside);
		vec4 middles = at.z + dot(slope, away + 0.5 - beside) + shadow_corners(slope);
		vec4 wide = ROOM * map.error.z * (stored - at.z) + least;
		vec4 before = vec4(lessThan(middles, stored)) * vec4(greaterThanEqual(wide, vec4(far)));
		sum += dot(before, 1.0 / max(stored, 1e-9));
		count += dot(before, vec4(1.0));
	}
	if (count == 0.0)
		return 1.0;
	radius = clamp(map.error.z * (count / sum - at.z), least, most);
	sum = 0.0;
	for (int i = 0; i < ASKED; i++) {
		vec2 away = radius * shadow_disc(i, float(ASKED));
		vec4 stored = shadow_around(map, at.xy + away, size, beside);
		vec4 middles = at.z + dot(slope, away + 0.5 - beside) + shadow_corners(slope);
		vec2 other = 1.0 - beside;
		vec4 shares = vec4(other.x, beside.x, beside.x, other.x) * vec4(beside.yy, other.yy);
		vec4 wide = map.error.z * (stored - at.z) + least;
		vec4 beyond = vec4(lessThan(wide, vec4(length(away))));
		sum += dot(shares, max(vec4(greaterThanEqual(middles, stored)), beyond));
		shadow_judge(stored, middles, shares / float(ASKED));
	}
	return sum / float(ASKED);
}

// What depth changes by for each texel to the right and down, on a plane. a, b: what two steps on it change.
vec2 shadow_slope(vec3 a, vec3 b)
{
	float square = a.x * b.y - a.y * b.x;
	if (!shadow_plane)
		return vec2(0.0);
	return vec2(a.z * b.y - b.z * a.y, a.x * b.z - b.x * a.z) / (square != 0.0 ? square : 1.0);
}

// Metres from the camera to the point that is lit.
float shadow_away()
{
	return distance(world_position, push.view.camera_position.xyz);
}

// By what lengths in the picture shrink there: a parallel view shows all alike.
float shadow_shrinks()
{
	float parallel = push.view.camera_position.w;
	return parallel > 0.0 ? parallel : shadow_away();
}

// The point that is lit, moved to the light by as much as surfaces may be off. w: of clip space, of the map.
vec3 shadow_point(vec4 error, float w, vec3 toward)
{
	return world_position + (error.x * w + error.y * shadow_shrinks()) * toward;
}

// Takes note of what depth changes by for the point when it is moved; and leaves it where it was without that.
float shadow_depth(float moved, float before)
{
	shadow_moved = moved - before;
	return shadow_way ? moved : before;
}

// The share of a lamp that is seen from the point. one, other: two steps on its plane.
float shadow_of_lamp(ShadowMap map, vec3 toward, vec3 one, vec3 other)
{
	float w = dot(map.rows[3], vec4(world_position, 1.0));
	if (w <= 0.0)
		return 1.0;
	vec4 point = vec4(shadow_point(map.error, w, toward), 1.0);
	float before = dot(map.rows[2], vec4(world_position, 1.0)) / w;
	w = dot(map.rows[3], point);
	vec3 at = vec3(dot(map.rows[0], point), dot(map.rows[1], point), dot(map.rows[2], point)) / w, a, b;
	at.z = shadow_depth(at.z, before);
	for (int i = 0; i < 3; i++) { // over w: what at changes by
		vec3 row = map.rows[i].xyz - at[i] * map.rows[3].xyz;
		a[i] = dot(row, one);
		b[i] = dot(row, other);
	}
	if (any(lessThan(at.xy, map.area.xy)) || any(greaterThan(at.xy, map.area.zw)))
		return 1.0;
	vec2 slope = shadow_slope(a, b);
	shadow_tint = vec3(0.7);
	float open = map.error.z > 0.0 ? shadow_soft(map, at, slope) : shadow_filtered(map, at, slope);
	return mix(1.0, open, map.error.w);
}

// What a directional light is without maps: what the mask of its number says. Others than the first ones of the image
// have none.
float shadow_beyond()
{
#ifdef LIT_TERMS
	if (shadow_masked) {
		uint layer = (light_shadow >> 9) - 1u; // directional lights come first
		bool there = layer < uint(textureSize(shadow_mask, 0).z);
		return there ? texelFetch(shadow_mask, ivec3(gl_FragCoord.xy, layer), 0).x : 1.0;
	}
#endif
	return 1.0;
}

// A colour for each cascade: red, green, blue, yellow, violet, cyan, orange, grey.
vec3 shadow_color_of(uint cascade)
{
	vec3 first = cascade == 0u ? vec3(1.0, 0.25, 0.2) : cascade == 1u ? vec3(0.3, 0.9, 0.25) : vec3(0.3, 0.45, 1.0);
	vec3 next = cascade == 3u ? vec3(0.95, 0.85, 0.2) : cascade == 4u ? vec3(0.9, 0.3, 0.9) : vec3(0.25, 0.85, 0.9);
	vec3 last = cascade == 6u ? vec3(1.0, 0.55, 0.15) : vec3(0.9);
	return cascade < 3u ? first : cascade < 6u ? next : last;
}

// The same of a light far away, whose maps fill their layers.
float shadow_of_sun(uint first, vec3 toward, vec3 one, vec3 other)
{
	float open = 0.0, left = 1.0, away = shadow_away();
	vec3 tint = vec3(0.0);
	vec2 judged = vec2(0.0);
	vec4 area = vec4(vec2(0.0), vec2(textureSize(shadow_maps, 0).xy));
	for (uint i = first;; i++) {
		ShadowMap map = push.view.rest.shadows.maps[i];
		float before = map.area.z - map.area.x * away; // the map's end, half texels
		map.area = area;
		vec4 point = vec4(shadow_point(map.error, 1.0, toward), 1.0);
		vec3 at, a, b;
		for (int r = 0; r < 3; r++) {
			at[r] = dot(map.rows[r], point);
			a[r] = dot(map.rows[r].xyz, one);
			b[r] = dot(map.rows[r].xyz, other);
		}
		vec2 edge = min(at.xy, area.zw - at.xy) - map.rest.w;
		float inner = min(min(edge.x, edge.y), before), blend = map.rest.y;
		float here = blend > 0.0 ? clamp(inner / blend, 0.0, 1.0) : step(0.0, inner);
		at.z = shadow_depth(at.z, dot(map.rows[2], vec4(world_position, 1.0)));
		shadow_judged = vec2(0.0);
		if (here > 0.0) { // outside of it Mesa's lavapipe (22.3) loses sums of pixels that have left the loop
			open += left * here * shadow_filtered(map, at, shadow_slope(a, b));
			tint += left * here * shadow_color_of(i - first);
			judged += left * here * shadow_judged;
		}
		left *= 1.0 - here;
		if (map.rest.z <= 1.0 || left <= 0.0)
			break;
	}
	shadow_tint = tint + left * vec3(0.7);
	shadow_judged = judged;
	if (shadow_masked && shadow_of_things) // who is in shadow already does not get darker
		return min(open + left, shadow_beyond());
	return open + left * shadow_beyond();
}

// The share of a light that arrives. shadow: light_shadow; toward: unit, to the light.
float shadow_open(uint shadow, bool directional, vec3 position, vec3 toward, vec3 n)
{
	const float FLATTEST = 0.05; // cosine: the plane is not taken to be more slanted to the light
	float along = dot(n, toward);
	vec3 plane = along < FLATTEST ? normalize(n + toward * (FLATTEST - along)) : n;
	vec3 one = abs(plane.x) < 0.7 ? vec3(0.0, plane.z, -plane.y) : vec3(-plane.z, 0.0, plane.x);
	vec3 other = cross(plane, one);
	uint first = (shadow >> 1) - 1u;
	shadow_tint = vec3(0.0);
	shadow_judged = vec2(0.0);
	if (directional)
		return shadow_of_sun(first, toward, one, other);
	if ((shadow & 1u) != 0u) { // a cube's sides
		vec3 from = world_position - position, size = abs(from);
		uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
		first += 2u * axis + (from[axis] < 0.0 ? 1u : 0u);
	}
	return shadow_of_lamp(push.view.rest.shadows.maps[first], toward, one, other);
}

// By what a light of the view is multiplied, which light_of was asked for last: the share that arrives, or what is
// shown in its place. directional, ...: as shadow_open has them.
vec3 shadow_factor(bool directional, vec3 position, vec3 toward, vec3 n)
{
	if (shadow_buffered) {
		uint place = (light_shadow >> 9) - 1u;
		float root = texelFetch(shadow_maps, ivec3(gl_FragCoord.xy, place >> 2), 0)[place & 3u];
		return vec3(root * root);
	}
	float open = shadow_open(light_shadow & 511u, directional, position, toward, n);
	if (shadow_shows_cascades)
		return shadow_tint * (0.25 + 0.75 * open);
	if (shadow_shows_acne) {
		vec3 base = vec3(0.1 + 0.35 * open) * (1.0 - shadow_judged.x) * (1.0 - shadow_judged.y);
		return base + vec3(1.0, 0.05, 0.0) * shadow_judged.x + vec3(0.0, 0.3, 1.0) * shadow_judged.y;
	}
	return vec3(open);
}
