/*
 * shade_impostor: impostors, pictures of a model from grid x grid directions over the whole sphere: which of them a
 * viewer needs, and where a point of the model lies in one. [any-thread]
 *
 * The directions are the vertices of a square grid on the octahedral map, (0, 0) to (grid - 1, grid - 1); the map folds
 * the square's border onto itself, so a direction on it stands there twice. A picture is a plate of side x side texels
 * through the middle of the model's sphere, seen from its direction, the n of shade_frame_from_normal; t points to the
 * right and b up. Lengths are in radii of that sphere, which fills the plate up to a margin of one texel.
 */
#ifndef SHADE_IMPOSTOR_H
#define SHADE_IMPOSTOR_H

#include "shade_frame.h"

#include "glsl_begin.h"

/* A unit vector to the square [-1, 1]^2: the octahedron |x| + |y| + |z| = 1, whose lower half z < 0 is folded outwards
 * over the corners. Source: Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
 * Journal of Computer Graphics Techniques 3 (2014), section 3. */
SHADE_FN vec2 shade_octahedral_from_direction(vec3 n)
{
	float across = 1.0f / (abs(n[0]) + abs(n[1]) + abs(n[2]));
	float x = n[0] * across;
	float y = n[1] * across;
	float fold = max(-n[2] * across, 0.0f);
	return vec2(x + select(x < 0.0f, -fold, fold), y + select(y < 0.0f, -fold, fold));
}

/* The inverse: a unit vector. */
SHADE_FN vec3 shade_direction_from_octahedral(vec2 e)
{
	float z = 1.0f - abs(e[0]) - abs(e[1]);
	float fold = max(-z, 0.0f);
	float x = e[0] - select(e[0] < 0.0f, -fold, fold);
	float y = e[1] - select(e[1] < 0.0f, -fold, fold);
	return normalize(vec3(x, y, z));
}

/* The direction of picture `place` of a grid, from the model to the viewer. */
SHADE_FN vec3 shade_impostor_direction(vec2 place, float grid)
{
	float scale = 2.0f / (grid - 1.0f);
	return shade_direction_from_octahedral(vec2(place[0] * scale - 1.0f, place[1] * scale - 1.0f));
}

/* The places of three pictures, and their weights: each in [0, 1], together 1. */
SHADE_STRUCT(shade_impostor_views)
{
	vec2 a;
	vec2 b;
	vec2 c;
	vec3 weights;
};

/* The corners of the triangle of the grid that the unit vector `direction`, from the model to the viewer, lies in, with
 * its barycentric coordinates: continuous over the whole sphere. Each cell is cut along the diagonal that is
 * parallel to the octahedron's fold |x| + |y| = 1. grid >= 3 and odd, so that the middle of the square is a corner. */
SHADE_FN shade_impostor_views shade_impostor_views_of(vec3 direction, float grid)
{
	float last = grid - 1.0f;
	vec2 e = shade_octahedral_from_direction(direction);
	float gx = clamp((e[0] * 0.5f + 0.5f) * last, 0.0f, last);
	float gy = clamp((e[1] * 0.5f + 0.5f) * last, 0.0f, last);
	float cx = min(floor(gx), last - 1.0f);
	float cy = min(floor(gy), last - 1.0f);
	/* Where e[0] and e[1] have opposite signs the cell is mirrored in x, from its right corners to its left ones. */
	float step_x = select(e[0] * e[1] < 0.0f, -1.0f, 1.0f);
	float base_x = select(step_x < 0.0f, cx + 1.0f, cx);
	float x = (gx - base_x) * step_x;
	float y = gy - cy;
	shade_impostor_views views = {vec2(base_x, cy), vec2(base_x + step_x, cy), vec2(base_x, cy + 1.0f),
	                              vec3(1.0f - x - y, x, y)};
	if (x + y > 1.0f) { /* the corner at (1, 1) in place of that at (0, 0) */
		views.a = vec2(base_x + step_x, cy + 1.0f);
		views.weights = vec3(x + y - 1.0f, 1.0f - y, 1.0f - x);
	}
	return views;
}

/* From the plate's coordinates, radii to the right and up, to texels from a picture's top left corner. */
SHADE_FN vec2 shade_impostor_texel(vec2 plate, float side)
{
	float scale = side * 0.5f - 1.0f;
	return vec2(side * 0.5f + plate[0] * scale, side * 0.5f - plate[1] * scale);
}

/* The inverse. */
SHADE_FN vec2 shade_impostor_plate(vec2 texel, float side)
{
	float scale = 1.0f / (side * 0.5f - 1.0f);
	return vec2((texel[0] - side * 0.5f) * scale, (side * 0.5f - texel[1]) * scale);
}

#include "glsl_end.h"
#endif
