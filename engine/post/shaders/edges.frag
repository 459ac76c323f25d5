#version 460
// Antialiasing of a picture: a pixel at an edge takes as much of the one across it as a straight edge would cover,
// whose slope is that between the edge's two ends. By luma, nearly of display codes. Sources: Lottes, "FXAA" (2009),
// for the choice of edges by contrast and the search for their ends; Reshetov, "Morphological Antialiasing" (2009), for
// what an edge covers.
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 color;

const float CONTRAST = 0.04; // of luma, at least, and of the brighter side's a share of
const float SHARE = 0.1;
const int STEPS = 24; // pixels along an edge at most, each way

ivec2 last;

float luma(ivec2 at)
{
	vec3 c = texelFetch(picture, clamp(at, ivec2(0), last), 0).rgb;
	return sqrt(dot(c, vec3(0.2126, 0.7152, 0.0722)));
}

// The luma in the middle of a pixel and the one across the edge.
float between(ivec2 at, ivec2 across)
{
	return 0.5 * (luma(at) + luma(at + across));
}

// How many pixels away the edge ends, and above: by how much it is then brighter.
vec2 find_end(ivec2 at, ivec2 along, ivec2 across, float middle, float enough)
{
	float off = 0.0;
	for (int i = 1; i <= STEPS; i++) {
		off = between(at + i * along, across) - middle;
		if (abs(off) >= enough)
			return vec2(float(i), off);
	}
	return vec2(float(STEPS + 1), 0.0);
}

void main()
{
	ivec2 at = ivec2(gl_FragCoord.xy);
	last = textureSize(picture, 0) - 1;
	color = texelFetch(picture, at, 0);
	float own = luma(at), n = luma(at + ivec2(0, -1)), s = luma(at + ivec2(0, 1)), w = luma(at + ivec2(-1, 0)),
		  e = luma(at + ivec2(1, 0));
	float high = max(own, max(max(n, s), max(w, e))), low = min(own, min(min(n, s), min(w, e)));
	if (!(high - low >= max(CONTRAST, SHARE * high)))
		return;
	float nw = luma(at + ivec2(-1, -1)), ne = luma(at + ivec2(1, -1)), sw = luma(at + ivec2(-1, 1)),
		  se = luma(at + ivec2(1, 1));
	float across_rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * own) + abs(ne + se - 2.0 * e);
	float across_columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * own) + abs(sw + se - 2.0 * s);
	bool rows = across_rows >= across_columns; // the edge lies between two rows
	vec2 sides = rows ? vec2(n, s) : vec2(w, e);
	ivec2 along = rows ? ivec2(1, 0) : ivec2(0, 1), across = rows ? ivec2(0, 1) : ivec2(1, 0);
	bool before = abs(sides.x - own) >= abs(sides.y - own);
	across = before ? -across : across;
	float middle = between(at, across), enough = 0.25 * abs((before ? sides.x : sides.y) - own);
	vec2 left = find_end(at, -along, across, middle, enough), right = find_end(at, along, across, middle, enough);
	// At the nearer end the edge goes to the other side of this pixel or of the one across. It covers this one alone.
	vec2 end = left.x < right.x ? left : right;
	bool covers = (end.y < 0.0) != (own < middle);
	float share = end.y == 0.0 || !covers ? 0.0 : 0.5 - (end.x - 0.5) / (left.x + right.x - 1.0);
	color = mix(color, texelFetch(picture, clamp(at + across, ivec2(0), last), 0), max(share, 0.0));
}
