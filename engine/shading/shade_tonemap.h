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

/* ---- tone maps of pictures -------------------------------------------------------------------------------------
 * By number, as a picture can be shown: linear radiance times the exposure in, linear light of the display out, each
 * channel in [0, 1]. Each has an inverse.
 *
 *   KNEE      linear to 0.6, bent above by the largest channel (shade_tonemap): values can be read off the picture.
 *   NONE      what is above 1 is cut off.
 *   NEUTRAL   Khronos' PBR neutral: base colours in plain white light look as their sRGB codes say; linear below
 *             0.76, highlights lose their colour slowly.
 *   FILMIC    Narkowicz's fit of ACES: an S in each channel, which adds contrast and takes colour from bright light.
 *
 * Sources: Khronos, "PBR neutral tone mapper specification" (2024); Narkowicz, "ACES filmic tone mapping curve" (2015).
 */

#define SHADE_TONE_KNEE 0
#define SHADE_TONE_NONE 1
#define SHADE_TONE_NEUTRAL 2
#define SHADE_TONE_FILMIC 3
#define SHADE_TONE_COUNT 4

#define SHADE_NEUTRAL_FRESNEL 0.04f /* what a dielectric mirrors straight ahead: taken from colours again */
#define SHADE_NEUTRAL_START 0.76f   /* the largest channel from which on it is compressed: 0.8 - 0.04 */
#define SHADE_NEUTRAL_DESATURATION 0.15f

/* ---- neutral ---------------------------------------------------------------------------------------------------- */

SHADE_FN vec3 shade_neutral(vec3 color)
{
	float least = min(color[0], min(color[1], color[2]));
	float offset = select(least < SHADE_NEUTRAL_FRESNEL + SHADE_NEUTRAL_FRESNEL, least - 6.25f * least * least,
	                      SHADE_NEUTRAL_FRESNEL);
	vec3 base = color - offset;
	float peak = shade_largest(base), room = 1.0f - SHADE_NEUTRAL_START;
	float bent = 1.0f - room * room / (max(peak, SHADE_NEUTRAL_START) + (room - SHADE_NEUTRAL_START));
	float white = 1.0f - 1.0f / (SHADE_NEUTRAL_DESATURATION * max(peak - bent, 0.0f) + 1.0f);
	vec3 scaled = mix(base * (bent / max(peak, SHADE_NEUTRAL_START)), vec3(bent), white);
	return select(peak < SHADE_NEUTRAL_START, base, scaled);
}

/* color: a result of shade_neutral with its largest channel below 1; near it a float step stands for
 * (0.24 / (1 - largest))^2 steps of the result. */
SHADE_FN vec3 shade_neutral_inverse(vec3 color)
{
	float bent = shade_largest(color), room = 1.0f - SHADE_NEUTRAL_START;
	float peak = room * room / max(1.0f - bent, SHADE_TONEMAP_EPSILON) - (room - SHADE_NEUTRAL_START);
	float unwhite = SHADE_NEUTRAL_DESATURATION * (peak - bent) + 1.0f;
	vec3 unscaled = ((color - bent) * unwhite + bent) * (peak / max(bent, SHADE_NEUTRAL_START));
	vec3 base = select(bent < SHADE_NEUTRAL_START, color, max(unscaled, 0.0f));
	float least = min(base[0], min(base[1], base[2]));
	float offset = select(least < SHADE_NEUTRAL_FRESNEL, sqrt(least * (1.0f / 6.25f)) - least, SHADE_NEUTRAL_FRESNEL);
	return base + offset;
}

/* ---- filmic ----------------------------------------------------------------------------------------------------- */

#define SHADE_FILMIC_MAX 1e3f      /* above it the curve has long been 1; its square is finite */
#define SHADE_FILMIC_EPSILON 1e-9f /* 0 / 0 at 0 is 0 */

/* x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), at most 1, which it reaches at 7.24. x: a channel. */
SHADE_FN float shade_filmic_curve(float x)
{
	x = min(x, SHADE_FILMIC_MAX);
	return min(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 1.0f);
}

/* The inverse; 1 gives 7.24. y: [0, 1]. */
SHADE_FN float shade_filmic_curve_inverse(float y)
{
	float p = 0.03f - 0.59f * y;
	return 0.28f * y / max(p + sqrt(p * p + 0.56f * y * (2.51f - 2.43f * y)), SHADE_FILMIC_EPSILON);
}

SHADE_FN vec3 shade_filmic(vec3 color)
{
	return vec3(shade_filmic_curve(color[0]), shade_filmic_curve(color[1]), shade_filmic_curve(color[2]));
}

SHADE_FN vec3 shade_filmic_inverse(vec3 color)
{
	return vec3(shade_filmic_curve_inverse(color[0]), shade_filmic_curve_inverse(color[1]),
	            shade_filmic_curve_inverse(color[2]));
}

/* ---- by number -------------------------------------------------------------------------------------------------- */

/* tone: SHADE_TONE_... */
SHADE_FN vec3 shade_tone(int tone, vec3 color)
{
	color = min(color, SHADE_TONEMAP_ABOVE_MAX);
	if (tone == SHADE_TONE_NONE)
		return min(color, 1.0f);
	if (tone == SHADE_TONE_NEUTRAL)
		return shade_neutral(color);
	if (tone == SHADE_TONE_FILMIC)
		return shade_filmic(color);
	return shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

/* color: a result of shade_tone with its largest channel below 1. */
SHADE_FN vec3 shade_tone_inverse(int tone, vec3 color)
{
	if (tone == SHADE_TONE_NONE)
		return color;
	if (tone == SHADE_TONE_NEUTRAL)
		return shade_neutral_inverse(color);
	if (tone == SHADE_TONE_FILMIC)
		return shade_filmic_inverse(color);
	return shade_tonemap_inverse(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B);
}

#include "glsl_end.h"
#endif
