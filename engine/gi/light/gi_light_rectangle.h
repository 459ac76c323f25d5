/*
 * gi_light_rectangle: points of a rectangle that emits, uniform by solid angle. Plain C without branches, for one point
 * (gi_light_shape.c) and for lanes of SIMD (gi_lanes_kernels.h). [any-thread]
 *
 * Source: Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles" (2013).
 */
#ifndef STILB_GI_LIGHT_RECTANGLE_H
#define STILB_GI_LIGHT_RECTANGLE_H

#include "gi/gi_trigonometry.h"

#define GI_LIGHT_NEAR 0.2f       /* area over squared distance, above which sampling by solid angle is worth its time */
#define GI_LIGHT_ANGLE_MIN 0.01f /* sr: below it, rounding errors of the angles would be visible */
#define GI_LIGHT_SQUARE_MIN 1e-14f /* lower bound of divisors */

/* A rectangle as seen from a point above its plane, with that point as the origin, x along edge_1 and y along edge_2:
 * it is [x0, x1] x [y0, y1], `height` below the point. Names of Urena, Fajardo and King: b0, b1 are z of the
 * normals of the planes through the point and the edges at y0 and y1. The sum of the angles between neighbouring planes
 * less 2 pi is the solid angle; rest is 2 pi less the two angles at x0. */
typedef struct gi_rectangle_seen {
	float x0, x1, y0, y1, height;
	float b0, b1, rest, solid_angle;
} gi_rectangle_seen;

GI_LANE gi_rectangle_seen gi_rectangle_see(float x0, float y0, float length_1, float length_2, float height)
{
	gi_rectangle_seen seen = {.x0 = x0, .x1 = x0 + length_1, .y0 = y0, .y1 = y0 + length_2, .height = height};
	float square = height * height;
	float low = -seen.y0 / sqrtf(seen.y0 * seen.y0 + square), right = seen.x1 / sqrtf(seen.x1 * seen.x1 + square);
	float high = seen.y1 / sqrtf(seen.y1 * seen.y1 + square), left = -seen.x0 / sqrtf(seen.x0 * seen.x0 + square);
	seen.b0 = low;
	seen.b1 = high;
	seen.rest = 2.0f * SHADE_PI - gi_arc_cosine(-high * left) - gi_arc_cosine(-left * low);
	seen.solid_angle = gi_arc_cosine(-low * right) + gi_arc_cosine(-right * high) - seen.rest;
	return seen;
}

/* True if the point is so near to the middle of the rectangle that solid angles are worth their time. */
GI_LANE int32_t gi_rectangle_is_near(const gi_rectangle_seen *seen, float area)
{
	float x = 0.5f * (seen->x0 + seen->x1), y = 0.5f * (seen->y0 + seen->y1);
	return area > GI_LIGHT_NEAR * (x * x + y * y + seen->height * seen->height);
}

/* x, or the end of the range that it is beyond; NaN becomes high. */
GI_LANE float gi_rectangle_limited(float x, float low, float high)
{
	float most = gi_select(x < high, x, high);
	return gi_select(most > low, most, low);
}

/* A point, uniform by solid angle, as its distance x along edge_1 and y along edge_2 from the corner: first that x for
 * which the part of the rectangle from x0 to x has the share u of the solid angle, then y, uniform in the sine of its
 * angle as seen from the point. The source has x = cu height / sqrt(1 - cu^2), with cu = +-1 / sqrt(fu^2 + b0^2) and
 * fu = across / sine; here it is rewritten with one square root. */
GI_LANE void gi_rectangle_by_angle(const gi_rectangle_seen *seen, float u, float v, float *x, float *y)
{
	float sine, cosine, height2 = seen->height * seen->height, y0 = seen->y0, y1 = seen->y1;
	gi_sine_and_cosine(gi_rectangle_limited(u * seen->solid_angle + seen->rest, 0.0f, 2.0f * SHADE_PI), &sine, &cosine);
	float across = cosine * seen->b0 - seen->b1;
	/* 1 - b0^2 is height2 / (height2 + y0 * y0) */
	float below = across * across - sine * sine * (height2 / (height2 + y0 * y0));
	float size = seen->height * fabsf(sine) / sqrtf(gi_select(below > GI_LIGHT_SQUARE_MIN, below, GI_LIGHT_SQUARE_MIN));
	float xu = gi_rectangle_limited(gi_select(across * sine < 0.0f, -size, size), seen->x0, seen->x1),
		  d2 = xu * xu + height2;
	float h0 = y0 / sqrtf(d2 + y0 * y0), h1 = y1 / sqrtf(d2 + y1 * y1), hv = h0 + v * (h1 - h0);
	float left = 1.0f - hv * hv;
	float yv =
		gi_rectangle_limited(hv * sqrtf(d2 / gi_select(left > GI_LIGHT_SQUARE_MIN, left, GI_LIGHT_SQUARE_MIN)), y0, y1);
	*x = xu - seen->x0;
	*y = yv - y0;
}

#endif
