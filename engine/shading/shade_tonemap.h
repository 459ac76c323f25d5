/*
 * shade_tonemap: brings radiance of any height into a range and keeps its hue. [any-thread]
 *
 * A curve is applied to one number of the colour, its luma, and the colour is scaled by the same number: a curve for
 * each channel would wash bright colours out. Karis offers two lumas.
 *   Largest channel   every channel ends in the range: what a display or an 8-bit encoding needs. With luminance a
 *                     saturated blue (weight 0.07) would leave the range and be clipped.
 *   Luminance         equally bright colours are dimmed alike, and it is linear: what averages need (shade_firefly.h).
 *                     A channel may end above the range, blue at up to 14 times its end.
 * Two curves: the simple one bends everywhere; the other is linear up to a, so that measured values can be read off the
 * picture, and bends above a towards the range's end b, which it never passes; with a = 0 and b = range it is the
 * simple one. All have inverses.
 *
 * Colours are linear, each channel in [0, 1e30].
 * Source: Karis, "Tone mapping" (2013).
 */
#ifndef SHADE_TONEMAP_H
#define SHADE_TONEMAP_H

#include "shade_luminance.h"

#include "glsl_begin.h"

/* What the renderer uses: linear to 0.6 (sRGB code 203 of 255), everything below 1. */
#define SHADE_TONEMAP_A 0.6f
#define SHADE_TONEMAP_B 1.0f

/* For an inverse, a mapped value counts as lying below the range's end by at least this share of it (a float step): so
 * the result is finite for a colour that was rounded, or filtered, onto the end. */
#define SHADE_TONEMAP_EPSILON 6e-8f

#define SHADE_TONEMAP_ABOVE_MAX 1e30f /* infinite light ends at b too, not at inf / inf */

SHADE_FN float shade_largest(vec3 color)
{
	return max(color[0], max(color[1], color[2]));
}

/* ---- the simple curve -------------------------------------------------------------------------------------------- */

/* color / (1 + luma / range): luma becomes luma range / (range + luma), in [0, range). luma is shade_luminance or
 * shade_largest of the colour; range > 0. */
SHADE_FN vec3 shade_tonemap_simple(vec3 color, float luma, float range)
{
	return color * (range / (range + luma));
}

/* The inverse, color / (1 - luma / range), luma of the mapped colour in [0, range). A float step of it there stands for
 * (range / (range - luma))^2 steps of the result. */
SHADE_FN vec3 shade_tonemap_simple_inverse(vec3 color, float luma, float range)
{
	return color * (range / max(range - luma, SHADE_TONEMAP_EPSILON * range));
}

/* ---- linear to a, then bent -------------------------------------------------------------------------------------- */

/* T(x) = x up to a, then (a^2 - b x) / (2 a - b - x); value and slope continue at a, and b is the limit. x >= 0,
 * 0 <= a < b. Computed as a + the simple curve of the part above a, with the range b - a: the same number, without
 * differences of large numbers. */
SHADE_FN float shade_tonemap_curve(float x, float a, float b)
{
	float above = clamp(x - a, 0.0f, SHADE_TONEMAP_ABOVE_MAX);
	return select(x <= a, x, min(a + (b - a) * (above / (above + (b - a))), b));
}

/* The inverse, y = T(x) in [0, b): a + (b - a) (y - a) / (b - y) above a. Steep near b: a float step of y there stands
 * for ((b - a) / (b - y))^2 steps of x. */
SHADE_FN float shade_tonemap_curve_inverse(float y, float a, float b)
{
	float unbent = a + (b - a) * (y - a) / max(b - y, SHADE_TONEMAP_EPSILON * b);
	return select(y <= a, y, unbent);
}

/* color scaled by T(luma) / luma. */
SHADE_FN vec3 shade_tonemap_scaled(vec3 color, float luma, float a, float b)
{
	return color * select(luma <= a, 1.0f, shade_tonemap_curve(luma, a, b) / max(luma, a));
}

/* color scaled by x / luma, where T(x) = luma. */
SHADE_FN vec3 shade_tonemap_unscaled(vec3 color, float luma, float a, float b)
{
	return color * select(luma <= a, 1.0f, shade_tonemap_curve_inverse(luma, a, b) / max(luma, a));
}

/* Tone maps a color by its largest channel, scaling all channels alike: each channel of the result is in [0, b]. */
SHADE_FN vec3 shade_tonemap(vec3 color, float a, float b)
{
	return min(shade_tonemap_scaled(color, shade_largest(color), a, b), b);
}

/* The inverse of shade_tonemap. color: a result of it with its largest channel below b. */
SHADE_FN vec3 shade_tonemap_inverse(vec3 color, float a, float b)
{
	return shade_tonemap_unscaled(color, shade_largest(color), a, b);
}

/* Tone maps a color by its luminance, scaling all channels alike: the luminance of the result is in [0, b], up to
 * rounding; a channel may be above b. */
SHADE_FN vec3 shade_tonemap_luminance(vec3 color, float a, float b)
{
	return shade_tonemap_scaled(color, shade_luminance(color), a, b);
}

/* The inverse of shade_tonemap_luminance. color: a result of it with its luminance below b. */
SHADE_FN vec3 shade_tonemap_luminance_inverse(vec3 color, float a, float b)
{
	return shade_tonemap_unscaled(color, shade_luminance(color), a, b);
}

#include "glsl_end.h"
#endif
