/* cases_impostor: the pictures of impostors as rows: calls in which C and GPU are compared (README.md).
 * [any-thread] */
#ifndef SHADE_CASES_IMPOSTOR_H
#define SHADE_CASES_IMPOSTOR_H

#include "case_inputs.h"
#include "shading/shade_impostor.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute)
 * shade_impostor_views_of: a grid of 33 makes 16 times the rounding of a map's coordinate. */
#define SHADE_CASES_IMPOSTOR(X)                                                                                        \
	X(0, shade_octahedral_from_direction, 1e-5f, 1e-6f)                                                                \
	X(1, shade_direction_from_octahedral, 1e-5f, 1e-6f)                                                                \
	X(2, shade_impostor_direction, 1e-5f, 1e-6f)                                                                       \
	X(3, shade_impostor_views_of, 1e-5f, 2e-5f)                                                                        \
	X(4, shade_impostor_texel, 1e-5f, 1e-6f)                                                                           \
	X(5, shade_impostor_plate, 1e-5f, 1e-6f)
#define SHADE_CASES_IMPOSTOR_COUNT 6

SHADE_FN vec4 shade_case_impostor(int row, vec4 a, vec4 b)
{
	vec3 n = shade_case_direction(a[0], a[1]);
	float grid = 3.0f + 2.0f * floor(b[0] * 15.0f);
	float side = 4.0f + floor(b[1] * 60.0f);
	vec2 plate = vec2(2.0f * a[2] - 1.0f, 2.0f * a[3] - 1.0f);
	if (row == 0) {
		vec2 e = shade_octahedral_from_direction(n);
		return vec4(e[0], e[1], 0.0f, 0.0f);
	}
	if (row == 1)
		return vec4(shade_direction_from_octahedral(plate), 0.0f);
	if (row == 2)
		return vec4(shade_impostor_direction(vec2(floor(a[0] * grid), floor(a[1] * grid)), grid), 0.0f);
	if (row == 3) {
		/* Sums over the three: which three they are jumps where a weight is 0. */
		shade_impostor_views views = shade_impostor_views_of(n, grid);
		vec2 place = views.a * views.weights[0] + views.b * views.weights[1] + views.c * views.weights[2];
		return vec4(place[0], place[1], dot(views.weights, views.weights), 0.0f);
	}
	vec2 mapped = shade_impostor_plate(plate * side, side);
	if (row == 4)
		mapped = shade_impostor_texel(plate, side);
	return vec4(mapped[0], mapped[1], 0.0f, 0.0f);
}

#include "shading/glsl_end.h"
#endif
