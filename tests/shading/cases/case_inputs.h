/*
 * case_inputs: arguments for the rows of cases_*.h out of numbers in [0, 1), C and GLSL. [any-thread]
 *
 * Only + - * / sqrt, which C and lavapipe round alike: what a row compares is then its function and not the arguments.
 */
#ifndef SHADE_CASE_INPUTS_H
#define SHADE_CASE_INPUTS_H

#include "shading/glsl_begin.h"

/* A unit vector: the octahedron |x| + |y| + |z| = 1 blown up to the sphere. */
SHADE_FN vec3 shade_case_direction(float u, float v)
{
	float x = 2.0f * u - 1.0f;
	float y = 2.0f * v - 1.0f;
	float z = 1.0f - abs(x) - abs(y);
	float fold = max(-z, 0.0f);
	vec3 p = vec3(select(x < 0.0f, x + fold, x - fold), select(y < 0.0f, y + fold, y - fold), z);
	return p / sqrt(dot(p, p));
}

/* A unit vector above the surface with the normal n: denser towards n, down to an angle of about 8 degrees. */
SHADE_FN vec3 shade_case_above(vec3 n, float u, float v)
{
	vec3 p = n + 0.99f * shade_case_direction(u, v);
	return p / sqrt(dot(p, p));
}

/* [low, high] */
SHADE_FN float shade_case_range(float u, float low, float high)
{
	return low + (high - low) * u;
}

/* [low, high], denser towards low: for ranges of several orders of magnitude. */
SHADE_FN float shade_case_skewed(float u, float low, float high)
{
	return low + (high - low) * (u * u * u * u);
}

#include "shading/glsl_end.h"
#endif
