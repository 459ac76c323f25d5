/*
 * shade_frame: an orthonormal frame about a surface's normal, and vectors into it and out of it. [any-thread]
 *
 * In the frame's own coordinates element 0 is along t, 1 along b, and 2 along n: the height above the surface.
 */
#ifndef SHADE_FRAME_H
#define SHADE_FRAME_H

#include "glsl_begin.h"

/* sin^2 of the least angle between normal and tangent (0.06 degrees); below it the tangent is too close to the normal
 * to give a direction along the surface. */
#define SHADE_TANGENT_SINE2_MIN 1e-6f

/* Unit vectors, right-handed: n = cross(t, b). */
SHADE_STRUCT(shade_frame)
{
	vec3 t;
	vec3 b;
	vec3 n;
};

/* Some frame about the unit normal n, without a branch and without a normal that has none. t and b jump where n[2]
 * changes its sign: what shows their direction, brushed metal, wants shade_frame_from_tangent. Source: Duff et al.,
 * "Building an Orthonormal Basis, Revisited" (2017), listing 3. */
SHADE_FN shade_frame shade_frame_from_normal(vec3 n)
{
	float s = select(n[2] < 0.0f, -1.0f, 1.0f);
	float a = -1.0f / (s + n[2]);
	float c = n[0] * n[1] * a;
	shade_frame frame = {vec3(1.0f + s * n[0] * n[0] * a, s * c, -s * n[0]), vec3(c, s + n[1] * n[1] * a, -n[1]), n};
	return frame;
}

/* t is the part of tangent, of any length, that lies across the unit normal n; orthogonal to 1e-7 / sin of the angle
 * between the two. Where they are parallel, or the tangent is 0, the frame is shade_frame_from_normal's. */
SHADE_FN shade_frame shade_frame_from_tangent(vec3 n, vec3 tangent)
{
	vec3 across = tangent - n * dot(n, tangent);
	float length2 = dot(across, across);
	if (length2 <= SHADE_TANGENT_SINE2_MIN * dot(tangent, tangent))
		return shade_frame_from_normal(n);
	vec3 t = across * inversesqrt(length2);
	shade_frame frame = {t, cross(n, t), n};
	return frame;
}

SHADE_FN vec3 shade_frame_to_world(shade_frame frame, vec3 local)
{
	return frame.t * local[0] + frame.b * local[1] + frame.n * local[2];
}

SHADE_FN vec3 shade_frame_to_local(shade_frame frame, vec3 world)
{
	return vec3(dot(frame.t, world), dot(frame.b, world), dot(frame.n, world));
}

#include "glsl_end.h"
#endif
