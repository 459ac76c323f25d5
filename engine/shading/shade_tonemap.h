/*
 * shade_tonemap: brings radiance of any height into a display's range and keeps its hue. [any-thread]
 *
 * One curve, linear up to a and bent into the range's end b, is applied to the largest channel, and the colour is scaled by
 * the same number. Karis offers luminance or the largest channel; here it is the latter, because an 8-bit target holds
 * each channel in [0, b]: with luminance a saturated blue (weight 0.07) would leave the range and be clipped.
 * Below a the picture is untouched, so measured values can be read off it.
 * Source: Karis, "Tone mapping" (2013), the piecewise pair of formulas.
 */
#ifndef SHADE_TONEMAP_H
#define SHADE_TONEMAP_H

#include "glsl_begin.h"

/* What the renderer uses: linear to 0.6 (sRGB code 203 of 255), everything below 1. */
#define SHADE_TONEMAP_A 0.6f
#define SHADE_TONEMAP_B 1.0f

/* T(x) = x up to a, then (a^2 - b x) / (2 a - b - x); value and slope continue at a, and b is the limit.
 * Computed as b - (b - a)^2 / (x + b - 2 a), the same number without inf / inf. x >= 0, 0 <= a < b. */
SHADE_FN float shade_tonemap_curve(float x, float a, float b)
{
	float bent = b - (b - a) * (b - a) / (max(x, a) + b - 2.0f * a);
	return select(x <= a, x, bent);
}

/* The inverse: y = T(x) in [0, b), computed as (b - a)^2 / (b - y) + 2 a - b above a. Steep near b: a float step of y
 * there stands for ((b - a) / (b - y))^2 steps of x. */
SHADE_FN float shade_tonemap_curve_inverse(float y, float a, float b)
{
	float unbent = (b - a) * (b - a) / (b - max(y, a)) + 2.0f * a - b;
	return select(y <= a, y, unbent);
}

/* color: radiance per channel, [0, 1e30]. Each channel of the result is in [0, b]. */
SHADE_FN vec3 shade_tonemap(vec3 color, float a, float b)
{
	float largest = max(color[0], max(color[1], color[2]));
	float scale = select(largest <= a, 1.0f, shade_tonemap_curve(largest, a, b) / max(largest, a));
	return min(color * scale, b);
}

/* color: a result of shade_tonemap with its largest channel below b. */
SHADE_FN vec3 shade_tonemap_inverse(vec3 color, float a, float b)
{
	float largest = max(color[0], max(color[1], color[2]));
	float scale = select(largest <= a, 1.0f, shade_tonemap_curve_inverse(largest, a, b) / max(largest, a));
	return color * scale;
}

#include "glsl_end.h"
#endif
