// How much of a pixel a line or a letter covers, and what the scene leaves of that. What includes this defines the two
// functions that are declared here.

layout(location = 0) flat in vec4 light; // see debug.vert
layout(location = 1) flat in vec4 place;
layout(location = 2) flat in vec4 depth;
layout(location = 3) flat in uint word;

layout(set = 1, binding = 0) uniform sampler2D glyphs;
layout(location = 0) out vec4 color;

// The scene's depth image, one of its samples. texel: need not be in it.
float scene_depth(ivec2 texel);
ivec2 scene_size();
// The share of a texel's samples that are not nearer than this depth.
float scene_share(ivec2 texel, float depth);

// Depth is in inverse proportion to the distance, nearly: what is drawn is tested as if it were a thousandth of its
// distance nearer, so that what lies on a surface is seen. The surface's depth is known elsewhere in the texel, so it
// may be nearer by what it rises over RISE texels besides, as far as that is so on one side at least: else it is
// another surface.
#define NEARER 1.001
#define NEARER_AT_MOST 1.12

float seen(vec2 pixel, float depth)
{
	ivec2 size = scene_size(), texel = clamp(ivec2(floor(pixel / push.size * vec2(size))), ivec2(0), size - 1);
	float here = scene_depth(texel);
	vec2 before = vec2(scene_depth(texel - ivec2(1, 0)), scene_depth(texel - ivec2(0, 1)));
	vec2 behind = vec2(scene_depth(texel + ivec2(1, 0)), scene_depth(texel + ivec2(0, 1)));
	vec2 rise = min(abs(before - here), abs(behind - here));
	return scene_share(texel, min(depth * NEARER + RISE * (rise.x + rise.y), depth * NEARER_AT_MOST));
}

// How much of a texel of the letter's glyph is covered; texels are counted from the glyph's.
float glyph_share(ivec2 texel, ivec2 size)
{
	if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size)))
		return 0.0;
	return texelFetch(glyphs, texel + ivec2(place.zw), 0).r;
}

// The letter, or a halo of one pixel around it.
float letter_share()
{
	ivec2 texel = ivec2(floor(gl_FragCoord.xy - push.origin) - place.xy);
	ivec2 size = ivec2(int(depth.w) & 1023, int(depth.w) >> 10);
	if ((word & HALO) == 0u)
		return glyph_share(texel, size);
	float most = 0.0;
	for (int y = -1; y <= 1; y++)
		for (int x = -1; x <= 1; x++)
			most = max(most, glyph_share(texel + ivec2(x, y), size));
	return most;
}

bool lies_in(uvec2 pixel, uvec4 place)
{
	return all(greaterThanEqual(pixel, place.xy)) && all(lessThan(pixel, place.zw));
}

// The picture shows the view in this pixel, and none that lies over it.
bool shows_view()
{
	uvec2 pixel = uvec2(gl_FragCoord.xy);
	bool shows = lies_in(pixel, push.places.places[push.view].inner);
	for (uint v = push.view + 1; v < push.views; v++)
		shows = shows && !lies_in(pixel, push.places.places[v].place);
	return shows;
}

void main()
{
	if (!shows_view())
		discard;
	float share, far;
	vec2 pixel;
	if ((word & LETTER) != 0u) {
		share = letter_share();
		pixel = depth.xy;
		far = depth.z;
	} else {
		vec2 along = place.zw - place.xy, from = gl_FragCoord.xy - push.origin - place.xy;
		float t = clamp(dot(from, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
		share = clamp(depth.z + 0.5 - length(from - t * along), 0.0, min(2.0 * depth.z, 1.0));
		pixel = place.xy + t * along; // the line's middle
		far = mix(depth.x, depth.y, t);
	}
	if (share <= 0.0)
		discard;
	if ((word & ON_TOP) == 0u)
		share *= seen(pixel, far);
	color = light * share;
}
