/*
 * shade_light_area: what spheres, disks and rectangles of one radiance send to a surface: irradiance, exact, also where
 * the surface's plane cuts the light. For a Lambertian surface; for highlights see shade_roughness_under. [any-thread]
 *
 * E / L, in [0, pi]: irradiance on a surface with the unit normal n, in a point from which the light's centre is at
 * `center`, m, over the light's radiance. Nothing hides the light.
 *
 * A disk or a rectangle is integrated along its border: E / L is half the integral of n . (r x dr) / r^2 along the
 * border of what is above the horizon, counter-clockwise as the point sees it (Stokes's theorem). A straight piece
 * gives its angle times n . (r x dr) / |r x dr|, Lambert's formula; a piece of the horizon its angle alone; an arc of a
 * circle has the closed form below.
 * Sources: Lambert, "Photometria" (1760), through Arvo, "Analytic Methods for Simulated Light Transport" (1995), 4.2;
 * sphere: Snyder, "Area Light Sources for Real-Time Graphics" (1996), as Lagarde and de Rousiers give it, "Moving
 * Frostbite to PBR" (2014); whole disk: Foote, "Illumination from Circular Disk Source" (1915); arc: derived here.
 */
#ifndef SHADE_LIGHT_AREA_H
#define SHADE_LIGHT_AREA_H

#include "shade_frame.h"
#include "shade_light.h"

#include "glsl_begin.h"

/* Keeps quotients finite: no product of two sines or lengths that is used is below it. */
#define SHADE_AREA_EPSILON 1e-20f

/* Squared size over squared distance below which a disk that the horizon cuts, and any rectangle, is integrated with
 * one distance to all of its points. The exact forms are differences of angles there, which leave few digits. The size
 * is a disk's radius or half a rectangle's diagonal: the error is below 4e-4 of what the light sends to a surface that
 * faces it. */
#define SHADE_AREA_FAR_LIMIT 2e-4f

/* Least distance of a disk's centre from the point's axis, as a share of the other lengths: below it the disk is seen
 * as if it were there. */
#define SHADE_AREA_ACROSS_MIN 1e-6f

/* Least share of the longer side that the shorter one has in shade_rectangle_ramp, where it divides. */
#define SHADE_AREA_SIDE_MIN 0.02f

/* Half of the sum of a sphere's values at the ends of the range in which the horizon cuts it. */
#define SHADE_AREA_CHORD_MAX 0.5f

/* Arc cosine of x in [-1, 1] by the arc tangent, which GPUs compute more precisely than acos: lavapipe's acos is off by
 * 2e-4. */
SHADE_FN float shade_area_acos(float x)
{
	return atan(sqrt(max(1.0f - x * x, 0.0f)), x);
}

/* E / L of a sphere. cosine: of the angle between n and the direction to its centre, in [-1, 1]; sin2: squared sine of
 * the angle at which its radius is seen, (0, 1]; 1: half of it is seen, from its surface or inside. */
SHADE_FN float shade_sphere_irradiance(float cosine, float sin2)
{
	if (cosine * cosine > sin2)
		return SHADE_PI * sin2 * max(cosine, 0.0f);
	float sine = sqrt(max(1.0f - cosine * cosine, SHADE_AREA_EPSILON));
	float cot = sqrt(max(1.0f / sin2 - 1.0f, 0.0f));
	float y = clamp(-cot * cosine / sine, -1.0f, 1.0f);
	float side = sine * sqrt(max(1.0f - y * y, 0.0f));
	float form = (cosine * shade_area_acos(y) - cot * side) * sin2 + atan(side, cot);
	return clamp(form, 0.0f,
	             SHADE_AREA_CHORD_MAX * SHADE_PI * sin2 * (cosine + sqrt(sin2))); /* between its ends it is convex */
}

/* A disk as the lit point sees it: axis_n, across_n and side_n are n along the axis from the point to the disk's plane,
 * along the way from the foot of that axis to the disk's centre, and perpendicular to both. height: of the point over
 * the plane, > 0; across: from the foot to the centre, >= 0; radius; all m. */
SHADE_STRUCT(shade_disk_seen)
{
	float axis_n;
	float across_n;
	float side_n;
	float height;
	float across;
	float radius;
};

/* The whole disk, all of it above the horizon. root: of (h^2 + x^2 + r0^2)^2 - 4 r0^2 x^2, h being the height and x
 * across. */
SHADE_FN float shade_disk_irradiance_whole(shade_disk_seen d, float root)
{
	float square = d.radius * d.radius;
	float left = d.height * d.height + d.across * d.across - square;
	float facing =
		select(left > 0.0f, 2.0f * square * d.height * d.height / (root * (root + left)), 0.5f * (1.0f - left / root));
	float beside = 2.0f * square * d.height * d.across / ((left + 2.0f * square + root) * root);
	return SHADE_PI * (d.axis_n * facing + d.across_n * beside);
}

/* Twice E / L of the arc of the disk's border from angle `from` to angle `to`, measured from the direction across. With
 * D0 = h^2 + x^2 + r0^2 and D1 = 2 r0 x, r^2 is D0 + D1 cos; the integrals of 1, cos and sin over it are elementary, in
 * a form that stays exact for D1 -> 0. */
SHADE_FN float shade_disk_arc(shade_disk_seen d, float root, float from, float to)
{
	float d0 = d.height * d.height + d.across * d.across + d.radius * d.radius;
	float d1 = max(2.0f * d.radius * d.across, SHADE_AREA_ACROSS_MIN * d0);
	float e = d1 / (d0 + root);
	float turn = atan(e * sin(to), 1.0f + e * cos(to)) - atan(e * sin(from), 1.0f + e * cos(from));
	float of_one = ((to - from) - 2.0f * turn) / root;
	float of_cos = 2.0f * d0 * turn / (root * d1) - d1 * (to - from) / (root * (root + d0));
	float of_sin = -shade_log1p(d1 * (cos(to) - cos(from)) / (d0 + d1 * cos(from))) / d1;
	return d.radius *
	       (d.axis_n * (d.radius * of_one + d.across * of_cos) - d.height * (d.across_n * of_cos + d.side_n * of_sin));
}

/* The integral of max(z + x, 0) over the disk x^2 + y^2 < 1, z in [-1, 1]. */
SHADE_FN float shade_disk_ramp(float z)
{
	float chord = sqrt(max(1.0f - z * z, 0.0f));
	return z * (SHADE_PI - shade_area_acos(z) + z * chord) + 2.0f / 3.0f * chord * chord * chord;
}

/* The mean of max(z + a u + b v, 0) for u and v in [-1, 1]; a >= b > 0, z in [-a - b, a + b]. */
SHADE_FN float shade_rectangle_ramp(float z, float a, float b)
{
	float outer = max(z + a + b, 0.0f);
	float upper = max(z + a - b, 0.0f);
	float lower = max(z - a + b, 0.0f);
	return max(outer * outer * outer - upper * upper * upper - lower * lower * lower, 0.0f) / (24.0f * a * b);
}

/* The share, [0, 1], of the irradiance across its beam that a distant rectangle of small angles gives to a surface with
 * the unit normal n. direction: to its middle; half_x, half_y: from there to the middles of two neighbouring sides,
 * radians across the beam, at most 0.1 long; both 0: the light has no size, and this is the cosine. Exact to the square
 * of the angles, where the horizon cuts it to their cube. */
SHADE_FN float shade_distant_share(vec3 direction, vec3 half_x, vec3 half_y, vec3 n)
{
	float middle = dot(n, direction);
	float x = abs(dot(n, half_x));
	float y = abs(dot(n, half_y));
	float a = max(x, y);
	float b = max(min(x, y), SHADE_AREA_SIDE_MIN * a);
	if (abs(middle) >= a + b)
		return max(middle, 0.0f);
	return shade_rectangle_ramp(middle, a, b);
}

/* E / L of a disk. direction: its unit normal, where it shines to; radius > 0. */
SHADE_FN float shade_disk_irradiance(vec3 center, vec3 direction, float radius, vec3 n)
{
	float height = -dot(center, direction);
	if (height <= 0.0f)
		return 0.0f;
	vec3 beside = center + direction * height;
	float across = sqrt(dot(beside, beside));
	shade_frame frame = shade_frame_from_normal(direction);
	vec3 u = select(across > SHADE_AREA_ACROSS_MIN * (height + radius), beside, frame.t);
	u = u * inversesqrt(dot(u, u));
	vec3 v = cross(u, direction);
	shade_disk_seen d = {-dot(n, direction), dot(n, u), dot(n, v), height, across, radius};
	float left = height * height + across * across - radius * radius;
	float root = sqrt(left * left + 4.0f * radius * radius * height * height);
	float middle = dot(n, center); // height of the centre above the horizon
	float swing = radius * sqrt(d.across_n * d.across_n + d.side_n * d.side_n);
	if (middle >= swing)
		return shade_disk_irradiance_whole(d, root);
	if (middle <= -swing)
		return 0.0f;
	float square = height * height + across * across;
	if (radius * radius < SHADE_AREA_FAR_LIMIT * square)
		return radius * radius * height * swing * shade_disk_ramp(middle / swing) / (square * square);
	float highest = atan(d.side_n, d.across_n);
	float half_arc = shade_area_acos(clamp(-middle / swing, -1.0f, 1.0f));
	float from = highest - half_arc;
	float to = highest + half_arc;
	vec3 rise = center + (u * cos(from) + v * sin(from)) * radius;
	vec3 set = center + (u * cos(to) + v * sin(to)) * radius;
	float horizon = atan(dot(n, cross(set, rise)), dot(set, rise));
	return max(0.5f * (shade_disk_arc(d, root, from, to) + horizon), 0.0f);
}

/* Twice the E / L of the edges so far, and where the border went below the horizon and came up again. */
SHADE_STRUCT(shade_border)
{
	float sum;
	vec3 set;
	vec3 rise;
};

/* Adds the edge from `a`, seen from the point, along `edge`, as far as it is above the horizon. */
SHADE_FN shade_border shade_border_edge(shade_border border, vec3 a, vec3 edge, vec3 n)
{
	float height_a = dot(n, a);
	float height_b = height_a + dot(n, edge);
	float drop = height_a - height_b;
	float cut = height_a / select(abs(drop) > SHADE_AREA_EPSILON, drop, height_a); /* only used where it divides */
	float from = select(height_a < 0.0f, cut, 0.0f);
	float to = select(height_b < 0.0f, cut, 1.0f);
	vec3 start = a + edge * from;
	vec3 part = edge * (to - from);
	vec3 across = cross(start, part);
	float sine = sqrt(dot(across, across));
	float angle = atan(sine, dot(start, start) + dot(start, part));
	bool above = height_a >= 0.0f || height_b >= 0.0f;
	border.sum +=
		select(above && sine > SHADE_AREA_EPSILON, dot(n, across) * angle / max(sine, SHADE_AREA_EPSILON), 0.0f);
	border.set = select(height_a >= 0.0f && height_b < 0.0f, start + part, border.set);
	border.rise = select(height_a < 0.0f && height_b >= 0.0f, start, border.rise);
	return border;
}

/* E / L of a rectangle. direction: its unit normal, where it shines to; half_x, half_y: from its centre to the middles
 * of two neighbouring sides, perpendicular to each other and to direction. */
SHADE_FN float shade_rectangle_irradiance(vec3 center, vec3 direction, vec3 half_x, vec3 half_y, vec3 n)
{
	float height = -dot(center, direction);
	if (height <= 0.0f)
		return 0.0f;
	float square = dot(center, center);
	float a = max(abs(dot(n, half_x)), abs(dot(n, half_y)));
	float b = min(abs(dot(n, half_x)), abs(dot(n, half_y)));
	float middle = dot(n, center); // height of the centre above the horizon
	bool far = dot(half_x, half_x) + dot(half_y, half_y) < SHADE_AREA_FAR_LIMIT * square;
	if (middle <= -a - b)
		return 0.0f;
	if (far) {
		float mean = select(middle < a + b, shade_rectangle_ramp(middle, a, max(b, SHADE_AREA_SIDE_MIN * a)), middle);
		return mean * shade_rectangle_area(half_x, half_y) * height / (square * square);
	}
	float winding = select(dot(cross(half_x, half_y), direction) < 0.0f, 1.0f, -1.0f);
	vec3 x = half_x * winding;
	shade_border border = {0.0f, vec3(0.0f), vec3(0.0f)};
	border = shade_border_edge(border, center - x - half_y, 2.0f * x, n);
	border = shade_border_edge(border, center + x - half_y, 2.0f * half_y, n);
	border = shade_border_edge(border, center + x + half_y, -2.0f * x, n);
	border = shade_border_edge(border, center - x + half_y, -2.0f * half_y, n);
	float horizon = atan(dot(n, cross(border.set, border.rise)), dot(border.set, border.rise));
	float chord = dot(border.set, border.set) * dot(border.rise, border.rise);
	return max(0.5f * (border.sum + select(chord > SHADE_AREA_EPSILON, horizon, 0.0f)), 0.0f);
}

/* True for a sphere, a disk and a rectangle. */
SHADE_FN bool shade_light_is_sized(int kind)
{
	return kind == SHADE_LIGHT_SPHERE || kind == SHADE_LIGHT_DISK || kind == SHADE_LIGHT_RECTANGLE;
}

/* Irradiance of a sphere, a disk or a rectangle, with its falloff, on a surface at position with the unit normal n. */
SHADE_FN vec3 shade_area_irradiance(shade_light light, vec3 position, vec3 n)
{
	vec3 center = light.position - position;
	float square = max(dot(center, center), SHADE_LIGHT_SQUARE_MIN);
	float share = shade_falloff_share(light.falloff, square, light.radius, light.reach);
	if (light.kind == SHADE_LIGHT_RECTANGLE) {
		float form = shade_rectangle_irradiance(center, light.direction, light.half_x, light.half_y, n);
		return light.intensity * (share * form / shade_rectangle_area(light.half_x, light.half_y));
	}
	float round = max(light.radius * light.radius, SHADE_LIGHT_SQUARE_MIN);
	float form = 0.0f;
	if (light.kind == SHADE_LIGHT_DISK)
		form = shade_disk_irradiance(center, light.direction, sqrt(round), n);
	else
		form = shade_sphere_irradiance(clamp(dot(n, center) * inversesqrt(square), -1.0f, 1.0f),
		                               min(round / square, 1.0f));
	return light.intensity * (share * form / (SHADE_PI * round));
}

#include "glsl_end.h"
#endif
