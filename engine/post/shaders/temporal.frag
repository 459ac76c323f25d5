#version 460
// Temporal antialiasing: each frame samples the scene at another place of the pixel, and the pixel is the mean of what
// was seen there, followed back by velocity. History counts only while it holds nothing but surfaces that are still
// seen around the pixel: of the same models, as far away, and that move alike. What is left, such as a shadow that
// passes, is kept within the colours around the pixel. Sources: Karis, "High-Quality Temporal Supersampling" (2014),
// for the jitter, the box and the weight of bright samples; Yang, Liu, Salvi, "A Survey of Temporal Antialiasing
// Techniques" (2020), for means by number of frames and rejection by surface; Keys, "Cubic Convolution Interpolation
// for Digital Image Processing" (1981), for the reading of history.
layout(constant_id = 0) const int most_still = 64;
layout(constant_id = 1) const int most_moving = 9;

// As temporal_push.
layout(push_constant, std430) uniform Push
{
	mat4 to_last;   // from this frame's clip space to that of the last one, both with the same jitter
	vec4 ahead_row; // 1 / metres ahead of the camera = dot(ahead_row, place in clip space)
	float exposure; // factor
	float history;  // 0: there is none, 1: there is
}
push;

layout(set = 0, binding = 0) uniform sampler2D light;
layout(set = 0, binding = 1) uniform sampler2D velocity;
layout(set = 0, binding = 2) uniform sampler2D depth_of;
layout(set = 0, binding = 3) uniform usampler2D id_of;
layout(set = 0, binding = 4) uniform sampler2D last_light;
layout(set = 0, binding = 5) uniform usampler2D last_models;
layout(set = 0, binding = 6) uniform sampler2D last_places;

layout(location = 0) out vec4 color;
layout(location = 1) out uvec2 models; // what the light is of, a bit for each id % 32 and id / 32 % 24; then frames
layout(location = 2) out vec4 places;  // the nearest and the farthest of it, metres ahead; its own movement, pixels

const float MOST = 65504.0; // of half floats
const float STILL = 0.02;   // pixels and, of the camera's way, thousandths: rounding of velocities
const float NEARER = 0.03;  // of the distance, by which history's surfaces may be off
const float SHARP = -0.75;  // slope of Keys' kernel at 1: with -0.5, Catmull-Rom's, what moves becomes more blurred
const uint FRAMES = 255u;   // bits of the second number

// What is seen around the pixel.
ivec2 last_pixel;
vec2 size;
uvec2 around_models = uvec2(0u);
vec2 around_ahead = vec2(MOST, 0.0);
vec2 slowest = vec2(MOST), fastest = vec2(-MOST); // own movement
vec3 low = vec3(MOST), high = vec3(-MOST);        // luma and chroma of squeezed light
vec2 low_alpha_high = vec2(1.0, 0.0);

float luma(vec3 c)
{
	return 0.25 * c.r + 0.5 * c.g + 0.25 * c.b;
}

// Light squeezed until its luma is below 1, so that a lamp does not outweigh all else of the pixels at its edge.
vec4 squeezed(vec4 c)
{
	return vec4(c.rgb / (1.0 + push.exposure * luma(c.rgb)), c.a);
}

vec4 stretched(vec4 c)
{
	vec3 rgb = max(c.rgb, 0.0);
	return vec4(rgb / max(1.0 - push.exposure * luma(rgb), 1e-5), clamp(c.a, 0.0, 1.0));
}

bool is_fine(vec4 c)
{
	return all(lessThanEqual(abs(c), vec4(MOST)));
}

vec3 chroma_from(vec3 c)
{
	return vec3(luma(c), 0.5 * (c.r - c.b), 0.5 * c.g - 0.25 * (c.r + c.b));
}

vec3 chroma_to(vec3 c)
{
	return vec3(c.x - c.z + c.y, c.x + c.z, c.x - c.z - c.y);
}

// The bits of a model.
uvec2 bits_of(uint id)
{
	return uvec2(1u << (id & 31u), 256u << (id / 32u % 24u));
}

// What a pixel shows.
struct Surface {
	uint id;
	float ahead;   // metres ahead of the camera
	float ratio;   // of that in the frame before
	vec2 way;      // pixels to where it was
	vec2 movement; // the part of this that is not by the camera's movement
};

Surface surface_at(ivec2 at)
{
	vec4 clip = vec4((vec2(at) + 0.5) / size * 2.0 - 1.0, texelFetch(depth_of, at, 0).r, 1.0);
	vec4 last = push.to_last * clip;
	Surface s;
	s.id = texelFetch(id_of, at, 0).r;
	s.ahead = clamp(1.0 / max(dot(push.ahead_row, clip), 1e-9), 0.0, MOST);
	s.ratio = last.w;
	vec2 camera = (last.xy / max(last.w, 1e-6) - clip.xy) * 0.5 * size;
	s.movement = texelFetch(velocity, at, 0).rg - camera;
	if (length(s.movement) <= STILL + 0.001 * length(camera))
		s.movement = vec2(0.0);
	s.way = camera + s.movement;
	return s;
}

// Adds a pixel's surface to what is around.
void surround(Surface s)
{
	around_models |= bits_of(s.id);
	around_ahead = vec2(min(around_ahead.x, s.ahead), max(around_ahead.y, s.ahead));
	slowest = min(slowest, s.movement);
	fastest = max(fastest, s.movement);
}

// Likewise its light. False if that is none.
bool light_at(ivec2 at, out vec4 seen)
{
	seen = texelFetch(light, at, 0);
	if (!is_fine(seen))
		return false;
	seen = squeezed(vec4(max(seen.rgb, 0.0), seen.a));
	vec3 c = chroma_from(seen.rgb);
	low = min(low, c);
	high = max(high, c);
	low_alpha_high = vec2(min(low_alpha_high.x, seen.a), max(low_alpha_high.y, seen.a));
	return true;
}

// A texel of history: whether all that is in it is still seen. ratio: of distances in the frame before to this one's.
bool is_seen(ivec2 at, float ratio)
{
	if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last_pixel)))
		return false;
	uvec2 of = texelFetch(last_models, at, 0).xy;
	vec4 place = texelFetch(last_places, at, 0);
	bool same = (of.x & ~around_models.x) == 0u && (of.y & ~(around_models.y | FRAMES)) == 0u;
	bool near =
		place.x >= around_ahead.x * ratio * (1.0 - NEARER) && place.y <= around_ahead.y * ratio * (1.0 + NEARER);
	vec2 off = max(max(slowest - place.zw, place.zw - fastest), 0.0);
	bool alike = length(off) <= 0.25 + 0.5 * length(place.zw);
	return (of.y & FRAMES) != 0u && same && near && alike;
}

vec4 spline(float t)
{
	float s = 1.0 - t;
	return vec4(SHARP * t * s * s, 1.0 + t * t * ((SHARP + 2.0) * t - SHARP - 3.0),
	            1.0 + s * s * ((SHARP + 2.0) * s - SHARP - 3.0), SHARP * s * t * t);
}

vec4 last_at(ivec2 at)
{
	return squeezed(texelFetch(last_light, clamp(at, ivec2(0), last_pixel), 0));
}

vec4 last_spline(ivec2 first, vec2 part)
{
	vec4 x = spline(part.x), y = spline(part.y), sum = vec4(0.0);
	for (int j = 0; j < 4; j++)
		for (int i = 0; i < 4; i++)
			sum += x[i] * y[j] * last_at(first + ivec2(i - 1, j - 1));
	return sum;
}

void main()
{
	ivec2 pixel = ivec2(gl_FragCoord.xy);
	ivec2 whole = textureSize(light, 0);
	last_pixel = whole - 1;
	size = vec2(whole);
	Surface own = surface_at(pixel), moves = own;
	vec4 seen, mean = vec4(0.0);
	bool fine = light_at(pixel, seen);
	surround(own);
	for (int t = 0; t < 9; t++) {
		ivec2 at = clamp(pixel + ivec2(t % 3, t / 3) - 1, ivec2(0), last_pixel);
		if (t == 4)
			continue;
		Surface s = surface_at(at);
		vec4 beside;
		surround(s);
		if (light_at(at, beside))
			mean += vec4(beside.rgb, 1.0);
		// Edges go with what is in front. Of that the farthest is next to the edge.
		bool before = s.ahead < own.ahead * (s.id == own.id ? 0.9 : 1.0);
		if (before && (moves.ahead == own.ahead || s.ahead > moves.ahead))
			moves = s;
	}
	if (!fine) // what is no light counts as if it were not there
		seen = vec4(mean.rgb / max(mean.a, 1.0), is_fine(vec4(seen.a)) ? seen.a : 0.0);

	vec2 way = moves.way;
	way = mix(vec2(0.0), way, greaterThan(abs(way), vec2(1.0 / 256.0)));
	vec2 from = clamp(vec2(pixel) + way, vec2(-4.0), size + 4.0), part = fract(from);
	ivec2 first = ivec2(floor(from));

	float weights = 0.0, frames = 0.0;
	vec4 history = vec4(0.0);
	uvec2 of = bits_of(own.id);
	vec2 reach = vec2(own.ahead);
	bool all_seen = push.history > 0.0;
	for (int t = 0; t < 4; t++) {
		ivec2 side = ivec2(t & 1, t >> 1), at = first + side;
		vec2 share = mix(1.0 - part, part, vec2(side));
		float weight = share.x * share.y * push.history;
		if (weight <= 0.0)
			continue;
		if (!is_seen(at, moves.ratio)) {
			all_seen = false;
			continue;
		}
		uvec2 texel = texelFetch(last_models, at, 0).xy;
		vec2 ahead = texelFetch(last_places, at, 0).xy / max(moves.ratio, 1e-6);
		history += weight * last_at(at);
		weights += weight;
		frames += weight * float(texel.y & FRAMES);
		if (weight >= 0.25) { // less does not count: what is seen around a pixel would spread by a pixel each frame
			of |= uvec2(texel.x, texel.y & ~FRAMES);
			reach = vec2(min(reach.x, ahead.x), max(reach.y, ahead.y));
		}
	}
	frames = weights > 0.0 ? frames / weights : 0.0;
	bool between = part != vec2(0.0);
	if (all_seen && between)
		history = last_spline(first, part);
	else if (weights > 0.0)
		history /= weights;
	if (low.x <= high.x) { // else there is no light around
		vec3 kept = clamp(chroma_from(history.rgb), low, high);
		history = vec4(chroma_to(kept), clamp(history.a, low_alpha_high.x, low_alpha_high.y));
	}

	float count = min(frames + 1.0, float(between ? most_moving : most_still));
	if (!fine && frames > 0.0)
		seen = history;
	vec4 result = frames > 0.0 ? mix(history, seen, 1.0 / count) : seen;
	color = min(stretched(result), MOST);
	models = uvec2(of.x, of.y | uint(count + 0.5));
	places = vec4(max(reach.x, around_ahead.x), min(reach.y, around_ahead.y), moves.movement);
}
