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
layout(set = 0, binding = SHADOW_BINDING) uniform sampler2DArray shadow_maps;

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

// The share of the texels around a place that lets the light through. at: texels, depth; slope: of depth by texels.
float shadow_filtered(ShadowMap map, vec3 at, vec2 slope)
{
	if (map.rest.w == 0.0) { // the one texel there
		vec2 texel = clamp(floor(at.xy), map.area.xy, map.area.zw - 1.0);
		float stored = texelFetch(shadow_maps, ivec3(texel, map.rest.x), 0).x;
		return step(stored, at.z + dot(slope, texel + 0.5 - at.xy));
	}
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
			sum += dot(open, vec4(columns.xy, columns.yx) * rows.yyxx);
			across = shadow_turn(next_across, turn);
		}
		down = shadow_turn(next_down, turn);
	}
	return sum / (4.0 * map.rest.w * map.rest.w);
}

// Number `index` of points that lie evenly in a disc of the radius 1, turned by an angle of the pixel's own: few points
// show bands, turned ones a fine grain. Sources: Vogel, "A better way to construct the sunflower head" (1979); Jimenez,
// "Next Generation Post Processing in Call of Duty: Advanced Warfare" (2014), for the angle.
vec2 shadow_disc(int index, float count)
{
	const float GOLDEN = 2.3999632;
	float turned = 2.0 * SHADE_PI * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
	float angle = turned + GOLDEN * float(index);
	return sqrt((float(index) + 0.5) / count) * vec2(cos(angle), sin(angle));
}

// The four texels around a place, and how far it lies from the first one's middle.
vec4 shadow_around(ShadowMap map, vec2 at, float size, out vec2 beside)
{
	vec2 first = floor(at - 0.5);
	beside = at - 0.5 - first;
	return textureGather(shadow_maps, vec3((first + 1.0) / size, map.rest.x));
}

// The share of a lamp with a size that is seen: what is in front of it, on average, says how wide its shadow's edge is.
// Where nothing is near, the filter stays as it is. Source: Fernando, "Percentage-Closer Soft Shadows" (2005).
float shadow_soft(ShadowMap map, vec3 at, vec2 slope)
{
	const int SEARCHED = 16, ASKED = 32;
	float size = float(textureSize(shadow_maps, 0).x);
	vec2 sides = min(at.xy - map.area.xy, map.area.zw - at.xy) - 1.0, beside;
	float most = max(min(sides.x, sides.y), 1.0), least = max(map.rest.w, 1.0);
	float radius = clamp(map.error.z * (1.0 - at.z), least, most), sum = 0.0, count = 0.0;
	for (int i = 0; i < SEARCHED; i++) {
		vec2 away = radius * shadow_disc(i, float(SEARCHED));
		vec4 stored = shadow_around(map, at.xy + away, size, beside);
		vec4 middles = at.z + dot(slope, away + 0.5 - beside) + shadow_corners(slope);
		vec4 before = vec4(lessThan(middles, stored));
		sum += dot(before, stored);
		count += dot(before, vec4(1.0));
	}
	if (count == 0.0)
		return 1.0;
	radius = clamp(map.error.z * (sum / count - at.z), least, most);
	sum = 0.0;
	for (int i = 0; i < ASKED; i++) {
		vec2 away = radius * shadow_disc(i, float(ASKED));
		vec4 stored = shadow_around(map, at.xy + away, size, beside);
		vec4 middles = at.z + dot(slope, away + 0.5 - beside) + shadow_corners(slope);
		vec2 other = 1.0 - beside;
		vec4 shares = vec4(other.x, beside.x, beside.x, other.x) * vec4(beside.yy, other.yy);
		sum += dot(shares, vec4(greaterThanEqual(middles, stored)));
	}
	return sum / float(ASKED);
}

// What depth changes by for each texel to the right and down, on a plane. a, b: what two steps on it change.
vec2 shadow_slope(vec3 a, vec3 b)
{
	float square = a.x * b.y - a.y * b.x;
	return vec2(a.z * b.y - b.z * a.y, a.x * b.z - b.x * a.z) / (square != 0.0 ? square : 1.0);
}

// The point that is lit, moved to the light by as much as surfaces may be off. w: of clip space, of the map.
vec3 shadow_point(vec4 error, float w, vec3 toward)
{
	return world_position + (error.x * w + error.y * distance(world_position, push.view.camera_position.xyz)) * toward;
}

// The share of a lamp that is seen from the point. one, other: two steps on its plane.
float shadow_of_lamp(ShadowMap map, vec3 toward, vec3 one, vec3 other)
{
	float w = dot(map.rows[3], vec4(world_position, 1.0));
	if (w <= 0.0)
		return 1.0;
	vec4 point = vec4(shadow_point(map.error, w, toward), 1.0);
	w = dot(map.rows[3], point);
	vec3 at = vec3(dot(map.rows[0], point), dot(map.rows[1], point), dot(map.rows[2], point)) / w, a, b;
	for (int i = 0; i < 3; i++) { // over w: what at changes by
		vec3 row = map.rows[i].xyz - at[i] * map.rows[3].xyz;
		a[i] = dot(row, one);
		b[i] = dot(row, other);
	}
	if (any(lessThan(at.xy, map.area.xy)) || any(greaterThan(at.xy, map.area.zw)))
		return 1.0;
	vec2 slope = shadow_slope(a, b);
	float open = map.error.z > 0.0 ? shadow_soft(map, at, slope) : shadow_filtered(map, at, slope);
	return mix(1.0, open, map.error.w);
}

// The same of a light far away, whose maps fill their layers.
float shadow_of_sun(uint first, vec3 toward, vec3 one, vec3 other)
{
	float open = 0.0, left = 1.0, away = distance(world_position, push.view.camera_position.xyz);
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
		if (here > 0.0)
			open += left * here * shadow_filtered(map, at, shadow_slope(a, b));
		left *= 1.0 - here;
		if (map.rest.z <= 1.0 || left <= 0.0)
			break;
	}
	return open + left;
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
	if (directional)
		return shadow_of_sun(first, toward, one, other);
	if ((shadow & 1u) != 0u) { // a cube's sides
		vec3 from = world_position - position, size = abs(from);
		uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
		first += 2u * axis + (from[axis] < 0.0 ? 1u : 0u);
	}
	return shadow_of_lamp(push.view.rest.shadows.maps[first], toward, one, other);
}
