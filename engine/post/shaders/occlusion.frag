#version 460
#extension GL_GOOGLE_include_directive : require
// How much of the hemisphere over a pixel is open: its visibility weighted by the cosine, as far as depth knows it.
// Out: visibility, and distance from the camera. Sources: Bavoil, Sainz, Dimitrov, "Image-Space Horizon-Based Ambient
// Occlusion" (2008); Jimenez, Wu, Pesce, Jarabo, "Practical Real-Time Strategies for Accurate Indirect Occlusion"
// (2016), for the cosine and the normal in each slice.
#include "../../shading/shade_constants.h"
#include "occlusion.glsl"

layout(set = 0, binding = 0) uniform sampler2D depth_of;
layout(location = 0) out vec2 visible;

const int SLICES = 2; // half planes through the view's direction, two each
const int STEPS = 6;  // in each
const int LOOKS = 2;  // between two steps
const float MOST = 0.25; // of the picture's height that a step looks away

ivec2 whole;
vec2 size;

float depth_at(ivec2 pixel)
{
	return texelFetch(depth_of, clamp(pixel, ivec2(0), whole - 1), 0).r;
}

vec3 place_at(ivec2 pixel)
{
	return occlusion_place(vec2(pixel) + 0.5, depth_at(pixel), size);
}

// From the pixel to the one beside it, on that side on which depth changes less.
vec3 along(ivec2 pixel, vec3 place, ivec2 step)
{
	vec3 after = place_at(pixel + step) - place, before = place - place_at(pixel - step);
	return dot(after, after) < dot(before, before) ? after : before;
}

// Of a slice, the part of the integral of visibility and cosine from the view's direction to an angle on one side of
// it; bent: the angle of the normal to that side.
float arc(float angle, float bent)
{
	return 0.25 * (cos(bent) + 2.0 * angle * sin(bent) - cos(2.0 * angle - bent));
}

// The pixel that is asked.
struct Asked {
	ivec2 pixel;
	vec3 place, view, normal;
	float first, reach;
};

// A slice of it, on one side of the view's direction. share: of the normal that lies in it.
struct Slice {
	vec2 step;
	float share, bent;
};

// What lies so many pixels away along the slice: its distance, and the angle at which it rises; inside: of the picture.
struct Seen {
	float far, angle;
	bool inside;
};

Seen look(Asked asked, Slice slice, float away)
{
	ivec2 at = asked.pixel + ivec2(round(slice.step * away));
	bool inside = !any(lessThan(at, ivec2(0))) && !any(greaterThanEqual(at, whole));
	vec3 there = occlusion_place(vec2(at) + 0.5, max(depth_at(at), push.smallest), size) - asked.place;
	float far = max(length(there), 1e-9), angle = acos(clamp(dot(there, asked.view) / far, -1.0, 1.0));
	// The pixel lies beside the slice. So the angle is measured from the normal: the surface itself is at right
	// angles to that, wherever it is asked.
	if (angle > slice.bent)
		angle = slice.bent + acos(clamp(dot(there, asked.normal) / (far * slice.share), -1.0, 1.0));
	return Seen(far, angle, inside);
}

// What is hidden of a slice so far, the lowest angle that is, and the integral up to there.
struct Hidden {
	float sum, highest, open;
};

// The higher things farther away hide what the nearer leave open, with the weight of their own distance.
Hidden hide(Hidden hidden, Seen seen, float bent)
{
	if (seen.angle >= hidden.highest)
		return hidden;
	float left = arc(seen.angle, bent);
	float weight = clamp(1.0 - seen.far / push.radius, 0.0, 1.0);
	return Hidden(hidden.sum + weight * (hidden.open - left), seen.angle, left);
}

// What things hide of the slice. A step that meets something higher has passed over what is nearer and hides more, most
// of it where a floor is seen at a slant: there it looks between, towards the last that lies within the radius.
float hidden_of(Asked asked, Slice slice)
{
	float highest = slice.bent + 0.5 * SHADE_PI, before = 0.0;
	Hidden hidden = Hidden(0.0, highest, arc(highest, slice.bent));
	for (int i = 0; i < STEPS; i++) {
		float part = (float(i) + asked.first) / float(STEPS), away = max(part * part * asked.reach, float(i + 1));
		Seen seen = look(asked, slice, away);
		if (!seen.inside)
			break;
		float low = before, high = away;
		for (int k = 0; k < LOOKS && seen.angle < hidden.highest && high - low > 1.0; k++) {
			float middle = 0.5 * (low + high);
			Seen between = look(asked, slice, middle);
			hidden = hide(hidden, between, slice.bent);
			if (between.far < push.radius)
				low = middle;
			else
				high = middle;
		}
		hidden = hide(hidden, seen, slice.bent);
		before = away;
	}
	return hidden.sum;
}

void main()
{
	whole = textureSize(depth_of, 0);
	size = vec2(whole);
	ivec2 texel = ivec2(gl_FragCoord.xy), pixel = min(2 * texel, whole - 1);
	vec2 middle = vec2(pixel) + 0.5;
	float depth = depth_at(pixel);
	visible = vec2(1.0, 65504.0);
	if (depth < push.smallest)
		return;
	vec3 place = occlusion_place(middle, depth, size);
	vec3 view = normalize(occlusion_place(middle, 1.0, size) - place);
	float metres = length(occlusion_place(middle + vec2(1.0, 0.0), depth, size) - place); // of a pixel
	float reach = min(push.radius / metres, MOST * size.y);
	visible.y = min(length(place), 65504.0);
	if (reach < 1.0)
		return;
	vec3 normal = normalize(cross(along(pixel, place, ivec2(0, 1)), along(pixel, place, ivec2(1, 0))));
	normal = dot(normal, view) < 0.0 ? -normal : normal;
	// Sixteen texels that lie together ask sixteen directions, four of them each distance.
	ivec2 cell = texel & 3;
	float turn = float((cell.x * 4 + cell.y * 9) & 15) / 16.0, first = (float((cell.x + 2 * cell.y) & 3) + 0.5) / 4.0;
	Asked asked = Asked(pixel, place, view, normal, first, reach);
	float sum = 0.0;
	for (int s = 0; s < SLICES; s++) {
		float angle = SHADE_PI * (float(s) + turn) / float(SLICES);
		vec2 step = vec2(cos(angle), sin(angle));
		vec3 tangent = occlusion_place(middle + step, depth, size) - place;
		tangent = normalize(tangent - view * dot(tangent, view));
		vec3 axis = cross(tangent, view), projected = normal - axis * dot(normal, axis);
		float share = max(length(projected), 1e-6);
		float bent = acos(clamp(dot(projected, view) / share, 0.0, 1.0));
		bent = dot(projected, tangent) < 0.0 ? -bent : bent;
		sum += share * (arc(bent + 0.5 * SHADE_PI, bent) + arc(0.5 * SHADE_PI - bent, -bent) -
			hidden_of(asked, Slice(step, share, bent)) - hidden_of(asked, Slice(-step, share, -bent)));
	}
	visible.x = sum / float(SLICES); // of slices along a slant above 1: their mean over all directions is at most that
}
